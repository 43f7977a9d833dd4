"""The whole deployment from the roll, with contact between layers and without it, as far as it goes in a given time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from contact_followed import followed
from membrane_rs import SelfContact, Simulation, scenes
from membrane_rs._arrays import Floats
from membrane_rs._markdown import table

WHOLE = "okuizumi-whole"
BUDGET = 3600.0
"""Processor time of a run [s]."""
INTERVAL = 0.001
"""Between counts of crossings [s]."""
ROWS = 8
"""Instants that are listed."""


def deployed(*, with_contact: bool, budget: float = BUDGET) -> dict[str, Floats]:
    """Crossings, residual of the balance, outermost radius [m] and processor time [s] at instants [s]."""
    scene = scenes.load(WHOLE)
    if with_contact:
        # Substeps save nothing where contact takes the time, and have a residual of first order with it.
        scene = replace(scene, laws=[*scene.laws, SelfContact()], run=replace(scene.run, substeps=1))
    sim = Simulation(scene)

    def read() -> tuple[float, ...]:
        radius = float(np.hypot(*sim.positions[:, :2].T).max())
        return sim.time, sim.crossings(limit=0).count, sim.ledger()["error"], radius

    instants = (k * INTERVAL for k in range(1, round(scene.run.until / INTERVAL) + 1))
    return followed(sim, WHOLE, instants, read, ("time", "crossings", "residual", "radius"), budget=budget)


def whole_table(without: Mapping[str, Floats], run: Mapping[str, Floats]) -> str:
    """Both at some instants of the one with contact: what is counted is the most in any frame so far."""
    body = []
    count = len(run["time"])
    for k in sorted({-(-count * row // ROWS) - 1 for row in range(1, ROWS + 1)}):
        other = int(np.searchsorted(without["time"], run["time"][k] - 0.5 * INTERVAL))
        body.append((
            f"{run['time'][k]:.3f}",
            f"{without['crossings'][: other + 1].max():,.0f}",
            f"{run['crossings'][: k + 1].max():,.0f}",
            f"{100.0 * run['residual'][k]:+.2f}",
            f"{without['radius'][other]:.3f}",
            f"{run['radius'][k]:.3f}",
            f"{run['seconds'][k]:,.0f}",
        ))  # fmt: skip
    heads = (
        "up to [s]", "most crossings without", "with contact", "energy residual [%]",
        "outermost node without [m]", "with contact [m]", "processor time with contact [s]",
    )  # fmt: skip
    return table(heads, body, words=())
