"""Bodies: film that starts inside one, and bodies that move too fast for their penalty."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np

from membrane_rs.errors import MembraneError, UnstableError
from membrane_rs.mesh.findings import Finding
from membrane_rs.scene import Scene
from membrane_rs.scene.bodies import Body
from membrane_rs.scene.scales import node_masses
from membrane_rs.scene.schedule import Schedule
from membrane_rs.simulation.motion import Motion
from membrane_rs.simulation.stepper import Stepper

DEEPEST = 0.5
"""Depth at which a run stops, as a share of the radius of a cylinder."""
INSTANTS = 1000
"""Times at which the speed of a body is evaluated, of all its schedules."""
ROUNDING = 1e-9
"""Depth by rounding, as a share of the reach of the scene."""
SHORTEST = 1e-300
"""A step for which a simulation is built whatever its limit [s]."""


def inside_bodies(scene: Scene) -> Iterator[Finding]:
    """Film and cords that start inside a body, by the law of the body itself: the contact throws them out.

    It is an error where a run would stop at once, since they might come out on the other side. With the energy U of the
    contact the deepest one has a depth of sqrt(2 U/k) at most. Other laws have no part in it, and are left out: most of
    the time to build a simulation is that of their stiffness.
    """
    if not scene.bodies:
        return
    try:
        sim = Motion(replace(scene, laws=(), run=replace(scene.run, dt=None)), dt=SHORTEST)
    except MembraneError:
        return  # what is wrong is found by other checks
    remedy = "move the body away, or what starts inside it; bodies are placed in metres, in the frame of the hub"
    try:
        sim._core.check(False)
    except UnstableError as error:
        if error.law in {body.name for body in scene.bodies}:
            message = f"at the start, {str(error).partition(': ')[2].partition('. ')[0]}"
            yield Finding("error", "start_inside", 1, message, remedy)
    energies, reach = sim.energies(), _reach(sim)
    for body in scene.bodies:
        depth = _depth(body, energies)
        if depth > ROUNDING * reach:
            yield _inside(sim, body, depth, "start", remedy)


def inside_at_stage_start(sim: Stepper) -> Iterator[Finding]:
    """The same for a stage after the first one that has just begun: film and cords that lie deeper in a body than at
    the end of the stage before, since the body was not at work or elsewhere. A run stops where they are too deep.
    """
    record, before = sim.stages[-1], sim.scene.staged(sim.stage - 1, [stage.start for stage in sim.stages[:-1]])
    stiffness = {body.name: body.stiffness for body in before.bodies}
    energies, reach = sim.energies(), _reach(sim)
    for body in sim.stage_scene.bodies:
        depth, change = _depth(body, energies), record.changes.get(body.name, 0.0)
        earlier = math.sqrt(2.0 * max(energies[body.name] - change, 0.0) / stiffness.get(body.name, body.stiffness))
        if depth > earlier + ROUNDING * reach:
            begins = f"start the stage {record.name!r}, at {record.start:.6g} s,"
            remedy = "put the body where nothing is when the stage begins, or let the stage before end elsewhere"
            yield _inside(sim, body, depth, begins, remedy)


def fast_bodies(scene: Scene) -> Iterator[Finding]:
    """Cylinders that move faster than their penalty can push what they meet out of the way.

    A mass m that a penalty k meets at the speed v sinks in by v sqrt(m/k). A run stops at half of the radius; so the
    median mass of the free nodes, which is no tip's, may not sink as deep. A plane has no such bound.
    """
    fast = [(body, speed, time) for body in scene.bodies for speed, time in [_fastest(body)] if speed > 0.0]
    sizes = {body.name: getattr(body, "radius", None) for body, *_ in fast}
    if not any(sizes.values()):
        return
    assembly, masses = scene.assemble(), node_masses(scene)
    free = np.setdiff1d(np.arange(assembly.node_count), assembly.fixed)
    mass = float(np.median(masses[free])) if len(free) else 0.0
    for body, speed, time in fast:
        radius, depth = sizes[body.name], speed * math.sqrt(mass / body.stiffness)
        if radius is not None and depth > DEEPEST * radius:
            stiffness = (speed / (DEEPEST * radius)) ** 2 * mass
            yield Finding(
                "warning",
                "fast_body",
                1,
                f"the body {body.name} moves at {speed:.3g} m/s at {time:.4g} s of its schedules: a node of the median "
                f"mass, {mass:.3g} kg, sinks {depth:.3g} m into its radius of {radius:g} m, and the run stops at "
                f"{DEEPEST:.0%} of that",
                f"move it more slowly, or give it a stiffness of {stiffness:.3g} N/m or more",
            )


def _fastest(body: Body) -> tuple[float, float]:
    """The largest speed of the centre of a body [m/s], and when [s]; jumps have none."""
    schedules = [schedule for schedule in vars(body).values() if isinstance(schedule, Schedule)]
    knots = sorted({time for schedule in schedules for time in schedule.times})
    one, most, when = replace(body, copies=1), 0.0, 0.0  # all copies move alike
    pieces = max(2, INSTANTS // max(1, len(knots)))
    for first, last in pairwise(knots):
        times = np.linspace(first, last, pieces + 1)
        times[-1] = math.nextafter(last, first)
        centres = np.array([one.solids(float(time))[0].centre for time in times])
        speeds = np.linalg.norm(np.diff(centres, axis=0), axis=1) / np.diff(times)
        k = int((speeds > (1.0 - ROUNDING) * speeds.max()).argmax())
        if speeds[k] > most:
            most, when = float(speeds[k]), float(times[k])
    return most, when


def _depth(body: Body, energies: dict[str, float]) -> float:
    """That of the deepest contact, by the energy of all [m]."""
    return math.sqrt(2.0 * max(energies[body.name], 0.0) / body.stiffness)


def _reach(sim: Motion) -> float:
    return float(np.abs(sim.positions).max())


def _inside(sim: Motion, body: Body, depth: float, begins: str, remedy: str) -> Finding:
    nodes = np.flatnonzero(np.abs(sim.forces(body.name)).max(axis=1))
    return Finding(
        "warning",
        "start_inside",
        len(nodes),
        f"{len(nodes)} nodes {begins} inside the body {body.name}, or belong to edges that do, by {depth:.3g} m "
        "at most, and are thrown out",
        remedy,
        tuple(nodes[:10].tolist()),
    )
