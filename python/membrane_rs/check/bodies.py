"""Bodies: film that starts inside one."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from membrane_rs.errors import MembraneError, UnstableError
from membrane_rs.mesh.findings import Finding
from membrane_rs.scene import Scene
from membrane_rs.simulation.motion import Motion

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
    reach, energies = float(np.abs(sim.positions).max()), sim.energies()
    for body in scene.bodies:
        depth = math.sqrt(2.0 * max(energies[body.name], 0.0) / body.stiffness)
        if depth > ROUNDING * reach:
            nodes = np.flatnonzero(np.abs(sim.forces(body.name)).max(axis=1))
            yield Finding(
                "warning",
                "start_inside",
                len(nodes),
                f"{len(nodes)} nodes start inside the body {body.name}, or belong to edges that do, by {depth:.3g} m "
                "at most, and are thrown out at the start",
                remedy,
                tuple(nodes[:10].tolist()),
            )
