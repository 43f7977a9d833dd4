"""Two hundred poisoned runs, and how each of them ends.

`python tests/poisoned.py` writes docs/poisoned.md.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from membrane_rs import MembraneError, Simulation, UnstableError
from poisons import POISONS, Dice, Poisoned

STEPS = 1500
EACH = 8
BOUND = 0.05
"""Energy error up to which a balance counts as intact: the bound of the watch."""


@dataclass(frozen=True)
class Ending:
    """How it ended: "refused", "caught" or "intact"; "quietly wrong" and "wrong words" must not be."""

    kind: str
    seed: int
    outcome: str
    words: str
    time: float
    error: float


def ending(poison: Callable[[Dice], Poisoned], seed: int) -> Ending:
    """Run one poisoned scene for some steps."""
    kind = poison.__name__.replace("_", " ")
    dice = np.random.default_rng([POISONS.index(poison), seed])
    poisoned = poison(dice)
    sim = None
    try:
        sim = Simulation(poisoned.scene(), dt=poisoned.dt)
        if poisoned.start is not None:
            poisoned.start(sim)
        sim.run(until=STEPS * sim.dt, frames=2, samples=11)
    except MembraneError as error:
        outcome = "caught" if isinstance(error, UnstableError) else "refused"
        text = str(error)
        if not re.search(poisoned.cause, text) or (outcome == "caught" and not _is_told(error)):
            outcome = "wrong words"
        return Ending(kind, seed, outcome, text, getattr(error, "time", 0.0), 0.0)
    balance = sim.ledger()
    rounding = 1e-5 * max(map(abs, sim.energies().values()))
    surplus = balance["error"] * balance["turned_over"]
    bound = BOUND * balance["turned_over"] + rounding
    intact = bool(np.isfinite(sim.positions).all()) and abs(surplus) <= bound
    left = balance["error"] if abs(surplus) > rounding else 0.0
    return Ending(kind, seed, "intact" if intact else "quietly wrong", "", sim.time, left)


def _is_told(error: MembraneError) -> bool:
    """Time, place, law and remedy."""
    return isinstance(error, UnstableError) and all([error.place, error.law, error.step >= 0, "t = " in str(error)])


def endings() -> list[Ending]:
    """All of them: 25 poisons, 8 seeds each."""
    return [ending(poison, seed) for poison in POISONS for seed in range(EACH)]


def table(found: list[Ending]) -> str:
    """docs/poisoned.md."""
    outcomes = ("refused", "caught", "intact", "quietly wrong", "wrong words")
    count = {name: sum(e.outcome == name for e in found) for name in outcomes}
    lines = [
        "# Two hundred poisoned runs",
        "",
        "Each is a small scene with one thing made wrong at random (fixed seeds), run for "
        f"{STEPS} steps. It is refused before the run, or caught in it by an error that names the true cause, or it",
        f"ends with its energy balance intact (missing or surplus: at most {100 * BOUND:g} % of the energy "
        "turned over). Made by `python tests/poisoned.py`, asserted by `tests/test_poisons.py`.",
        "",
        "| poison | refused | caught | intact | quietly wrong | wrong words | largest error left [%] |",
        "|---|---:|---:|---:|---:|---:|---:|",
    ]
    for kind in dict.fromkeys(e.kind for e in found):
        rows = [e for e in found if e.kind == kind]
        numbers = [sum(e.outcome == name for e in rows) or "" for name in outcomes]
        worst = max((e.error for e in rows if e.outcome == "intact"), key=abs, default=None)
        cells = " | ".join(str(n) for n in numbers)
        lines.append(f"| {kind} | {cells} | {'' if worst is None else format(100 * worst, '+.2g')} |")
    lines.append(f"| **all {len(found)}** | {' | '.join(str(count[name]) for name in outcomes)} | |")
    lines += ["", "What the errors say, one of each kind:", ""]
    for kind in dict.fromkeys(e.kind for e in found):
        told = next((e for e in found if e.kind == kind and e.words), None)
        if told is not None:
            lines.append(f"- {kind}: {' '.join(told.words.split())}")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    Path(__file__).parents[1].joinpath("docs", "poisoned.md").write_text(table(endings()), encoding="utf-8")
