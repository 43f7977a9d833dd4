"""Relaxation of a stowed sail: at one instant, held by its guide bars, it is damped until it is at rest."""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs.errors import InputError
from membrane_rs.scene import Scene
from membrane_rs.scene.laws import MassDamping
from membrane_rs.scene.parts import Fixed
from membrane_rs.simulation.core_input import Settings
from membrane_rs.simulation.motion import Motion
from membrane_rs.simulation.stepper import Stepper

GUIDE_BARS = "guide_bars"
AT_REST = 0.01
"""Net force on a node, relative to the largest force of a law on a node, below which a scene counts as at rest."""


class FrozenStepper(Stepper):
    """A scene in which all that depends on time stays as it is at one instant."""

    def __init__(self, scene: Scene, integrator: str, instant: float) -> None:
        self._instant = instant
        super().__init__(scene, integrator)

    def _settings(self) -> Settings:
        return replace(super()._settings(), frozen_at=self._instant)


def held_scene(scene: Scene, rate: float) -> Scene:
    """The scene with its guide bars closed, friction added, and without the laws that vanish at rest."""
    laws = [law for law in scene.laws if law.acts_while_relaxing]
    held = [Fixed(nodes=GUIDE_BARS)] if GUIDE_BARS in scene.assemble().node_sets else []
    return replace(scene, laws=[*laws, MassDamping(rate=rate)], parts=[*scene.parts, *held])


def relaxed(start: Motion, duration: float | None, rate: float | None) -> tuple[Floats, float]:
    """Positions (N, 3) [m] after `duration` of damped motion at the instant of `start`, and the largest speed left
    [m/s]. Warns where that is not rest.
    """
    scene = start.scene
    time = scene.run.relax if duration is None else float(duration)
    rate = scene.run.relax_rate if rate is None else float(rate)
    for name, value, unit in (("duration", time, "s"), ("rate", rate, "1/s")):
        if not (np.isfinite(value) and value > 0):
            raise InputError(f"relax: {name} = {value}: must be greater than 0 ({unit})")
    held = FrozenStepper(held_scene(scene, rate), start.integrator, start.time)
    held.positions = start.positions
    held.reach(time)
    positions, speeds = held.positions, np.linalg.norm(held.velocities, axis=1)
    held.velocities = np.zeros_like(positions)
    _warn_of_motion(held, speeds, rate, time)
    return positions, float(speeds.max())


def _warn_of_motion(held: Stepper, speeds: Floats, rate: float, time: float) -> None:
    """Warn where a node is left with a net force, or with a speed whose friction is as large."""
    is_free = np.ones(held.node_count, dtype=np.bool_)
    is_free[held.assembly.fixed] = False
    net = np.where(is_free, np.linalg.norm(held.forces(), axis=1), 0.0)
    rest = np.maximum(net, rate * held.masses * speeds)
    by_law = [np.linalg.norm(held.forces(law), axis=1)[is_free] for law in held._core.law_names]
    largest = max((float(forces.max(initial=0.0)) for forces in by_law), default=0.0)
    node = int(np.argmax(rest))
    if rest[node] > AT_REST * largest:
        warnings.warn(
            f"relax: not at rest after {time:g} s at rate = {rate:g} 1/s: node {node} has a net force of "
            f"{net[node]:.3g} N, where the largest force on a node is {largest:.3g} N, and a speed of "
            f"{speeds[node]:.3g} m/s; relax longer, or at a rate near the lowest angular frequency (rad/s)",
            stacklevel=4,
        )
