"""Relaxation of a stowed sail: it is held by its guide bars and damped until it is at rest."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs.errors import InputError
from membrane_rs.scene import Scene
from membrane_rs.scene.laws import MassDamping
from membrane_rs.scene.parts import Fixed
from membrane_rs.simulation.stepper import Stepper

GUIDE_BARS = "guide_bars"


def held_scene(scene: Scene, rate: float) -> Scene:
    """The scene with its guide bars closed, friction added, and without the laws that vanish at rest."""
    laws = [law for law in scene.laws if law.acts_while_relaxing]
    held = [Fixed(nodes=GUIDE_BARS)] if GUIDE_BARS in scene.assemble().node_sets else []
    return replace(scene, laws=[*laws, MassDamping(rate=rate)], parts=[*scene.parts, *held])


def relaxed(
    scene: Scene, integrator: str, positions: Floats, duration: float | None, rate: float | None
) -> tuple[Floats, float]:
    """Positions (N, 3) after `duration` of damped motion, and the largest speed left [m/s]."""
    time = scene.run.relax if duration is None else float(duration)
    rate = scene.run.relax_rate if rate is None else float(rate)
    for name, value, unit in (("duration", time, "s"), ("rate", rate, "1/s")):
        if not (np.isfinite(value) and value > 0):
            raise InputError(f"relax: {name} = {value}: must be greater than 0 ({unit})")
    held = Stepper(held_scene(scene, rate), integrator)
    held.positions = positions
    held.reach(time)
    return held.positions, float(np.linalg.norm(held.velocities, axis=1).max())
