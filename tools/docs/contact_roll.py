"""The wound sail at rest, with contact between its layers and without it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from contact_followed import followed
from membrane_rs import Scene, SelfContact, Simulation, scenes
from membrane_rs._arrays import Floats
from membrane_rs._markdown import table

WHOLE = "okuizumi-whole"
DURATION = 1.0
"""At rest [s]."""
READINGS = (0.05, 0.2, 1.0)
"""Instants that are listed [s]."""
INTERVAL = 0.05
"""Between counts of crossings [s]."""


def roll(*, with_contact: bool) -> Scene:
    """The first stage of the whole deployment, in which bars stand still, with mass damping, and without substeps."""
    scene = scenes.load(WHOLE).staged(0, [0.0])
    scene = replace(scene, run=replace(scene.run, substeps=1))
    return replace(scene, laws=[*scene.laws, SelfContact()]) if with_contact else scene


def at_rest(*, with_contact: bool) -> dict[str, Floats]:
    """Crossings, residual of the energy balance and processor time [s] at instants [s]; fewer where it is stopped."""
    sim = Simulation(roll(with_contact=with_contact))

    def read() -> tuple[float, ...]:
        ledger = sim.ledger()
        return sim.time, sim.crossings(limit=0).count, ledger["error"], ledger["kinetic"]

    instants = (k * INTERVAL for k in range(1, round(DURATION / INTERVAL) + 1))
    return followed(sim, WHOLE, instants, read, ("time", "crossings", "residual", "kinetic"))


def roll_table(without: Mapping[str, Floats], run: Mapping[str, Floats]) -> str:
    """Both at some instants, and the time of steps up to them with contact over that without."""
    body = []
    for instant in READINGS:
        cells: list[str] = []
        for one in (without, run):
            found = np.flatnonzero(np.abs(one["time"] - instant) < 0.5 * INTERVAL)
            if not len(found):
                cells += ["stopped", "-"]
                continue
            k = found[0]
            cells += [f"{one['crossings'][: k + 1].max():,.0f}", f"{100.0 * one['residual'][k]:+.2f}"]
        both = all((np.abs(one["time"] - instant) < 0.5 * INTERVAL).any() for one in (without, run))
        k = round(instant / INTERVAL) - 1
        ratio = f"{run['seconds'][k] / without['seconds'][k]:.0f}" if both else "-"
        body.append((f"{instant:g}", *cells, ratio))
    heads = (
        "up to [s]", "most crossings without", "energy residual [%]", "most crossings with contact",
        "energy residual [%]", "time of a step, over that without",
    )  # fmt: skip
    return table(heads, body, words=())
