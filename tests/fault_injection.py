"""Two hundred poisoned scenes, and how a run of each ends, by each method.

`python tests/poisoned.py` writes docs/poisoned.md.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from math import ceil, inf
from pathlib import Path

import numpy as np
from membrane_rs import MembraneError, Scene, Simulation, UnstableError
from membrane_rs._markdown import table
from membrane_rs.simulation import integrators
from numpy.typing import NDArray
from poisons import POISONS, Dice, Poisoned

STEPS = 1500
EACH = 8
BOUND = 0.05
"""Energy error up to which a balance counts as intact."""
FAR = 0.5
"""Difference from the energy of a fine run at which a run is wrong, however well its own books balance."""
OUTCOMES = ("refused", "caught", "intact", "quietly wrong", "wrong words")


@dataclass(frozen=True)
class Ending:
    """How it ended: "refused", "caught" or "intact"; "quietly wrong" and "wrong words" must not be.

    missing : energy missing (below 0) or created, as a share of the energy turned over. apart : the energy's
    difference from that of a fine run, as such a share. Both are of runs that came to their end.
    """

    kind: str
    method: str
    seed: int
    outcome: str
    words: str = ""
    missing: float = 0.0
    apart: float = 0.0


@cache
def ending(poison: Callable[[Dice], Poisoned], seed: int, method: str) -> Ending:
    """Run one poisoned scene for some steps; one that ends quietly is judged by a fine run that nobody watches."""
    kind = poison.__name__.replace("_", " ")
    poisoned = poison(np.random.default_rng([POISONS.index(poison), seed]))
    try:
        scene = poisoned.scene()
        sim = Simulation(scene, method, poisoned.dt)
        dt = 0.4 * sim.stable_dt() if sim.is_adaptive else sim.dt
        if poisoned.start is not None:
            poisoned.start(sim)
        motion = sim.positions, sim.velocities
        sim.run(until=STEPS * dt, frames=2, samples=11)
    except MembraneError as error:
        outcome = "caught" if isinstance(error, UnstableError) else "refused"
        text = str(error)
        if not re.search(poisoned.cause, text) or (outcome == "caught" and not _is_told(error)):
            outcome = "wrong words"
        return Ending(kind, method, seed, outcome, text)
    balance, energies = sim.ledger(), sim.energies()
    fine = _fine_run(scene, sim.time, dt, *motion)
    turned_over = fine.ledger()["turned_over"]
    rounding = 1e-5 * max(map(abs, energies.values()))
    # In books that turn over no more than rounding there is nothing to miss.
    surplus = _beyond(balance["error"] * balance["turned_over"], rounding) / max(balance["turned_over"], 1e-300)
    apart = _beyond(sum(energies.values()) - sum(fine.energies().values()), rounding) / max(turned_over, 1e-300)
    # Leapfrog's energy swings about what it keeps, so that a violent start leaves a gap in its books; the energy tells.
    is_intact = bool(np.isfinite(sim.positions).all()) and min(abs(surplus), abs(apart)) <= BOUND and abs(apart) <= FAR
    return Ending(kind, method, seed, "intact" if is_intact else "quietly wrong", "", surplus, apart)


def _fine_run(
    scene: Scene, end: float, dt: float, positions: NDArray[np.float64], velocities: NDArray[np.float64]
) -> Simulation:
    """The same motion by rk4 at a tenth of its limit and a fifth of `dt`, unwatched."""
    calm = replace(scene, run=replace(scene.run, watch=10**9, energy_loss=1e9))
    steps = ceil(end / min(dt / 5, 0.1 * Simulation(calm, "rk4").stable_dt()))
    fine = Simulation(calm, "rk4", end / steps)
    fine.positions, fine.velocities = positions, velocities
    fine.step(steps)
    return fine


def _beyond(energy: float, rounding: float) -> float:
    return energy if abs(energy) > rounding else 0.0


def _is_told(error: MembraneError) -> bool:
    """Time, place, law and remedy."""
    return isinstance(error, UnstableError) and all([error.place, error.law, error.step >= 0, "t = " in str(error)])


METHODS = [name for name, facts in integrators().items() if facts.imaginary_limit < inf]
"""The explicit methods. A method without a limit takes steps so long that no fine run can follow."""


def endings() -> list[Ending]:
    """All of them: by each explicit method 25 poisons, 8 seeds each."""
    return [ending(poison, seed, method) for method in METHODS for poison in POISONS for seed in range(EACH)]


def page(found: list[Ending]) -> str:
    """docs/poisoned.md."""
    lines = [
        "# Two hundred poisoned runs",
        "",
        "Each is a small scene with one thing made wrong at random (fixed seeds), run by each explicit method for",
        f"{STEPS} steps, or as long as that many steps of 0.4 of the limit. It is refused before the run, or caught",
        "in it by an error that names the true cause, or it ends with its energy balance intact: at most",
        f"{100 * BOUND:g} % of the energy turned over is missing or created, by the run's own books or by the energy",
        "of a fine run of the same motion (rk4 at a tenth of its limit, unwatched). The last column is the largest",
        "difference from that energy: where a crease is far too stiff the balance holds, and yet a step near the",
        "limit loses energy sooner; folds that spring open are chaotic. Made by",
        "`python tests/poisoned.py`, asserted by `tests/test_poisons.py`.",
    ]
    for method in METHODS:
        body = []
        runs = [e for e in found if e.method == method]
        for kind in dict.fromkeys(e.kind for e in runs):
            rows = [e for e in runs if e.kind == kind]
            intact = [e for e in rows if e.outcome == "intact"]
            cells = [str(sum(e.outcome == name for e in rows) or "") for name in OUTCOMES]
            for values in ([e.missing for e in intact], [e.apart for e in intact]):
                cells.append(format(100 * max(values, key=abs), "+.2g") if values else "")
            body.append((kind, *cells))
        count = [str(sum(e.outcome == name for e in runs)) for name in OUTCOMES]
        body.append((f"**all {len(runs)}**", *count, "", ""))
        head = ("poison", *OUTCOMES, "largest gap in the books [%]", "from the fine run [%]")
        lines += ["", f"## {method}", "", table(head, body).rstrip()]
    lines += ["", "## What the errors say, one of each kind", ""]
    for kind in dict.fromkeys(e.kind for e in found):
        told = next((e for e in found if e.kind == kind and e.words), None)
        if told is not None:
            lines.append(f"- {kind}: {' '.join(told.words.split())}")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    Path(__file__).parents[1].joinpath("docs", "poisoned.md").write_text(page(endings()), encoding="utf-8")
