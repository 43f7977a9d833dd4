"""Staged scenes whose motion is known: a mass that hangs on a spring without mass."""

from __future__ import annotations

import math
from typing import Any

from membrane_rs import Fixed, Gravity, MassDamping, RunSettings, Scene, Simulation, Stage, Tether, TipMasses

STIFFNESS, PULL, AMPLITUDE = 100.0, 50.0, 0.1
"""k [N/m] of a spring of 1 m with a mass of 1 kg, which gravity [m/s2] along x keeps taut, and which starts so much
longer than at rest [m].
"""


def oscillator(*stages: Stage, **run: Any) -> Scene:
    """The mass on the spring from node 0, which "hold" holds, to node 1."""
    spring = Tether(
        (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), 1, STIFFNESS, 0.0, tip_mass=1.0, fixed=False, strain_limit=1e6, name="spring"
    )
    settings = RunSettings(**{"frames": 5, "samples": 21, "snapshots": (), **run})
    laws = [Gravity((PULL, 0.0, 0.0)), MassDamping(2.0)]
    parts = [spring, TipMasses(3.0, (0,)), Fixed((0,), name="hold")]
    return Scene(None, None, laws, parts, stages=stages, run=settings, name="oscillator")


def started(scene: Scene, integrator: str | None = None, dt: float | None = None) -> Simulation:
    """A simulation whose mass starts at rest, `AMPLITUDE` below its equilibrium."""
    sim = Simulation(scene, integrator, dt)
    positions = sim.positions.copy()
    positions[1, 0] = 1.0 + PULL / STIFFNESS + AMPLITUDE
    sim.positions = positions
    return sim


def free(name: str, duration: float, **changes: Any) -> Stage:
    """A stage without friction."""
    return Stage(name, duration, without=("mass_damping", *changes.pop("without", ())), **changes)


def extension(
    time: float, stiffness: float = STIFFNESS, start: tuple[float, float] | None = None
) -> tuple[float, float]:
    """Extension [m] and its rate [m/s] after a time [s] of free oscillation from those at the start."""
    first, rate = start or (PULL / STIFFNESS + AMPLITUDE, 0.0)
    omega, rest = math.sqrt(stiffness), PULL / stiffness
    cosine, sine = math.cos(omega * time), math.sin(omega * time)
    return (
        rest + (first - rest) * cosine + rate / omega * sine,
        -(first - rest) * omega * sine + rate * cosine,
    )
