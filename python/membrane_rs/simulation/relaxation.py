"""Relaxation of a stowed sail: at one instant, held by its guide bars, it is damped until it is at rest.

First by friction, for a given time. What is not at rest then goes on by kinetic damping: without that friction, and
stopped at each maximum of its kinetic energy, near which the net forces vanish. So no rate has to be near critical.
M. R. Barnes, Form finding and analysis of tension structures by dynamic relaxation, Int. J. Space Structures 14 (1999)
89-104. Barnes chooses the masses; here they are the scene's.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from membrane_rs._arrays import Floats, Ints
from membrane_rs._warning import warn
from membrane_rs.errors import InputError, UnstableError
from membrane_rs.scene import Scene
from membrane_rs.scene.laws import MassDamping
from membrane_rs.scene.parts import Fixed
from membrane_rs.simulation.core_input import Settings
from membrane_rs.simulation.motion import Motion
from membrane_rs.simulation.stepper import Stepper

GUIDE_BARS = "guide_bars"
AT_REST = 0.01
"""Net force on a node, relative to the largest force of a law on a node, below which a scene counts as at rest."""
CLOSER = 0.1 * AT_REST
"""What kinetic damping goes on to where that takes it ..."""
CLOSER_STEPS = 3
"""... no more than so many times the steps to `AT_REST`; the error of a method may forbid it."""
NO_FORCE = 1e-4
"""Largest force of a law on a node, relative to that at the start, below which a scene counts as free of forces: where
nothing is left but rounding, no share of it tells rest."""
FURTHER = 20.0
"""Bound of the kinetic damping, over the duration of the friction ..."""
FURTHER_STEPS = 20_000
"""... and in steps, whichever is more."""
ANY_LOSS = 1e9
"""Loss of energy by the method that is allowed there: what is lost brings it nearer to rest."""
RESOLUTION = 20
"""Parts of the time since the last stop by which the maximum of the kinetic energy is found."""


class FrozenStepper(Stepper):
    """A scene in which all that depends on time stays as it is at one instant."""

    def __init__(self, scene: Scene, integrator: str, instant: float) -> None:
        self._instant = instant
        super().__init__(scene, integrator)

    def _settings(self, scene: Scene) -> Settings:
        return replace(super()._settings(scene), frozen_at=self._instant)


def held_scene(scene: Scene, rate: float, hub_rate: float = 0.0) -> Scene:
    """The scene with its guide bars closed, friction added, and without the laws that vanish at rest. A free hub is
    driven at the rate that it has [rad/s].
    """
    laws = [law.while_held(hub_rate) for law in scene.laws if law.acts_while_relaxing]
    held = [Fixed(nodes=GUIDE_BARS)] if GUIDE_BARS in scene.assemble().node_sets else []
    return replace(scene, laws=[*laws, MassDamping(rate=rate)], parts=[*scene.parts, *held])


@dataclass(frozen=True)
class Remainder:
    """What is left of forces and motion at the node that is furthest from rest."""

    positions: Floats
    """(N, 3) of all nodes [m]."""
    speed: float
    """Largest speed of any node [m/s]."""
    node: int
    net: float
    """Net force on that node [N]."""
    node_speed: float
    """Its speed [m/s]."""
    largest: float
    """Largest force of a law on a free node [N]."""
    share: float
    """Net force, or the friction at that speed if larger, over the largest force."""


def relaxed(start: Motion, duration: float | None, rate: float | None) -> tuple[Floats, float]:
    """Positions (N, 3) [m] of rest at the instant of `start`, after `duration` of friction and as much kinetic damping
    as it takes, and the largest speed before the last stop [m/s]. Warns where that is not rest.
    """
    scene = start.stage_scene
    time = scene.run.relax if duration is None else float(duration)
    rate = scene.run.relax_rate if rate is None else float(rate)
    for name, value, unit in (("duration", time, "s"), ("rate", rate, "1/s")):
        if not (np.isfinite(value) and value > 0):
            raise InputError(f"relax: {name} = {value}: must be greater than 0 ({unit})")
    held = FrozenStepper(held_scene(scene, rate, start.hub_rate), start.integrator, start.time)
    held.positions = start.positions
    floor = NO_FORCE * largest_force(held)
    left, further = _stopped(held, rate, floor), ""
    try:
        held.reach(time)
        left = _stopped(held, rate, floor)
    except UnstableError:  # vibrations that the friction hardly damps; kinetic damping has none
        held.positions = start.positions
    if left.share > AT_REST:
        free_scene = replace(held_scene(scene, 0.0, start.hub_rate), run=replace(scene.run, energy_loss=ANY_LOSS))
        freely = FrozenStepper(free_scene, start.integrator, start.time)
        freely.positions = left.positions
        try:
            enough = np.inf
            for found in kinetic_damping(freely, FURTHER * time, floor):
                left = min(left, found, key=lambda remainder: remainder.share)
                if left.share <= AT_REST:
                    enough = min(enough, CLOSER_STEPS * freely.step_count)
                if left.share <= CLOSER or freely.step_count > enough:
                    break
        except UnstableError as error:
            further = f", where kinetic damping {error}"
        further = further or f" and {freely.time:.3g} s of kinetic damping"
    if left.share > AT_REST:
        warn(
            f"relax: not at rest after {time:g} s at rate = {rate:g} 1/s{further}: node {left.node} has a net force of "
            f"{left.net:.3g} N, where rest is judged by the largest force on a node, {left.largest:.3g} N, and a speed "
            f"of {left.node_speed:.3g} m/s; relax longer, or at a rate near the lowest angular frequency (rad/s)",
        )
    return left.positions, left.speed


def kinetic_damping(held: Stepper, end: float, floor: float) -> Iterator[Remainder]:
    """Kinetic damping up to a time [s]: what is left at each maximum of the kinetic energy, where all is stopped.

    Vibrations that the steps hardly resolve have maxima at every other step. Where stops bring nothing, the next one
    waits for twice as many steps, in which the slow motion comes to outweigh them.
    """
    kinetic, share = 0.0, np.inf
    since, wait = 0, 1
    while held.time < end or held.step_count < FURTHER_STEPS:
        count = max(1, since // RESOLUTION)
        held.step(count)
        since += count
        now = float(held.masses @ np.square(held.velocities).sum(axis=1))
        if now >= kinetic or since < wait:
            kinetic = now
            continue
        found = _stopped(held, 0.0, floor)
        wait = max(1, wait // 2) if found.share < share else 2 * wait
        kinetic, share, since = 0.0, found.share, 0
        yield found


def _stopped(held: Stepper, rate: float, floor: float) -> Remainder:
    """Stop all nodes; what was left of motion, relative to friction at a rate [1/s], and what is left of forces."""
    positions, speeds = held.positions, np.linalg.norm(held.velocities, axis=1)
    held.velocities = np.zeros_like(positions)
    net = np.zeros(held.node_count)
    free = _free_nodes(held)
    net[free] = np.linalg.norm(held.forces()[free], axis=1)
    rest = np.maximum(net, rate * held.masses * speeds)
    largest = max(largest_force(held), floor)
    node = int(np.argmax(rest))
    share = float(rest[node]) / max(largest, float(np.finfo(float).tiny))
    return Remainder(positions, float(speeds.max()), node, float(net[node]), float(speeds[node]), largest, share)


def largest_force(held: Stepper) -> float:
    """Largest force of a law on a free node [N]."""
    free = _free_nodes(held)
    by_law = [np.linalg.norm(held.forces(law)[free], axis=1) for law in held._core.law_names]
    return max((float(forces.max(initial=0.0)) for forces in by_law), default=0.0)


def _free_nodes(held: Stepper) -> Ints:
    return np.setdiff1d(np.arange(held.node_count), held.assembly.fixed)
