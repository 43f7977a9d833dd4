"""Fault injection: 200 faulty scenes, and the outcome of a run of each by each method.

`python tests/fault_injection.py` writes docs/fault_injection.md, in less than a minute.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from math import ceil, inf
from pathlib import Path
from textwrap import wrap

import numpy as np
from faults import FAULTS, Faulty, Generator
from membrane_rs import MembraneError, Scene, Simulation, UnstableError
from membrane_rs._markdown import table
from membrane_rs.simulation import integrators
from numpy.typing import NDArray

STEPS = 1500
EACH = 8
BOUND = 0.05
"""Energy error up to which a balance counts as intact."""
FAR = 0.5
"""Difference from the energy of the reference run at which a run is wrong, whatever its own energy balance."""
WIDTH = 118
"""Of the lines of a message."""
OUTCOMES = ("refused", "detected", "intact", "undetected", "misdescribed")


@dataclass(frozen=True)
class Ending:
    """Outcome of a run: "refused", "detected" or "intact"; "undetected" and "misdescribed" must not occur.

    residual : residual of the energy balance over the reference energy. apart : difference of the energy from that of
    the reference run, over the same. Both are of runs that reached their end.
    """

    kind: str
    method: str
    seed: int
    outcome: str
    message: str = ""
    residual: float = 0.0
    apart: float = 0.0


@cache
def ending(fault: Callable[[Generator], Faulty], seed: int, method: str) -> Ending:
    """Run one faulty scene for some steps; without an error it is judged by a fine run without monitor."""
    kind = fault.__name__.replace("_", " ")
    faulty = fault(np.random.default_rng([FAULTS.index(fault), seed]))
    try:
        scene = faulty.scene()
        sim = Simulation(scene, method, faulty.dt)
        dt = 0.4 * sim.stable_dt() if sim.is_adaptive else sim.dt
        if faulty.start is not None:
            faulty.start(sim)
        motion = sim.positions, sim.velocities
        sim.run(until=STEPS * dt, frames=2, samples=11)
    except MembraneError as error:
        outcome = "detected" if isinstance(error, UnstableError) else "refused"
        text = str(error)
        if not re.search(faulty.cause, text) or (outcome == "detected" and not _is_described(error)):
            outcome = "misdescribed"
        return Ending(kind, method, seed, outcome, text)
    balance, energies = sim.ledger(), sim.energies()
    fine = _reference_run(scene, sim.time, dt, *motion)
    reference_energy = fine.ledger()["reference_energy"]
    rounding = 1e-5 * max(map(abs, energies.values()))
    # With a reference energy no larger than rounding the residual means nothing.
    residual = _beyond(balance["error"] * balance["reference_energy"], rounding) / max(
        balance["reference_energy"], 1e-300
    )
    apart = _beyond(sum(energies.values()) - sum(fine.energies().values()), rounding) / max(reference_energy, 1e-300)
    # Leapfrog's energy oscillates about a conserved one, so a violent start leaves a residual; the energy decides.
    is_intact = bool(np.isfinite(sim.positions).all()) and min(abs(residual), abs(apart)) <= BOUND and abs(apart) <= FAR
    return Ending(kind, method, seed, "intact" if is_intact else "undetected", "", residual, apart)


def _reference_run(
    scene: Scene, end: float, dt: float, positions: NDArray[np.float64], velocities: NDArray[np.float64]
) -> Simulation:
    """The same motion by rk4 at a tenth of its limit and a fifth of `dt`, without monitor."""
    calm = replace(scene, run=replace(scene.run, watch=10**9, energy_loss=1e9))
    steps = ceil(end / min(dt / 5, 0.1 * Simulation(calm, "rk4").stable_dt()))
    fine = Simulation(calm, "rk4", end / steps)
    fine.positions, fine.velocities = positions, velocities
    fine.step(steps)
    return fine


def _beyond(energy: float, rounding: float) -> float:
    return energy if abs(energy) > rounding else 0.0


def _is_described(error: MembraneError) -> bool:
    """Time, place, law and remedy."""
    return isinstance(error, UnstableError) and all([error.place, error.law, error.step >= 0, "t = " in str(error)])


METHODS = [name for name, facts in integrators().items() if facts.imaginary_limit < inf]
"""The explicit methods. The steps of a method without limit are too long for a reference run."""


def endings() -> list[Ending]:
    """All outcomes: 25 kinds of faults with 8 seeds each, by each explicit method."""
    return [ending(fault, seed, method) for method in METHODS for fault in FAULTS for seed in range(EACH)]


def page(found: list[Ending]) -> str:
    """docs/fault_injection.md."""
    lines = [
        "# Fault injection: 200 faulty scenes, each with three methods",
        "",
        "Each run is of a small scene with one random fault (fixed seeds), by each explicit method, for",
        f"{STEPS} steps or the duration of that many steps of 0.4 of the limit. A scene is refused before the run, its",
        "fault is detected in the run by an error that names the true cause, or the run ends intact. Intact means a",
        f"residual of at most {100 * BOUND:g} % of the reference energy, in the run's own energy balance or relative",
        "to the energy of a reference run (rk4 at a tenth of its limit, without monitor). An undetected fault would be",
        "none of these; a misdescribed one would be detected by an error that names another cause. The last column is",
        "the largest difference from the energy of the reference run: with a crease that is far too stiff the balance",
        "holds although a step near the limit dissipates energy; folds that spring open are chaotic. Made by",
        "`python tests/fault_injection.py`, asserted by `tests/test_fault_injection.py`.",
    ]
    for method in METHODS:
        body = []
        runs = [e for e in found if e.method == method]
        for kind in dict.fromkeys(e.kind for e in runs):
            rows = [e for e in runs if e.kind == kind]
            intact = [e for e in rows if e.outcome == "intact"]
            cells = [str(sum(e.outcome == name for e in rows) or "") for name in OUTCOMES]
            for values in ([e.residual for e in intact], [e.apart for e in intact]):
                cells.append(format(100 * max(values, key=abs), "+.2g") if values else "")
            body.append((kind, *cells))
        count = [str(sum(e.outcome == name for e in runs)) for name in OUTCOMES]
        body.append((f"**all {len(runs)}**", *count, "", ""))
        head = ("fault", *OUTCOMES, "largest residual [%]", "difference from the reference run [%]")
        lines += ["", f"## {method}", "", table(head, body).rstrip()]
    lines += ["", "## Error messages, one for each kind of fault", ""]
    for kind in dict.fromkeys(e.kind for e in found):
        first = next((e for e in found if e.kind == kind and e.message), None)
        if first is not None:
            message = " ".join(f"- {kind}: {first.message}".split())
            lines += wrap(message, WIDTH, subsequent_indent="  ", break_long_words=False, break_on_hyphens=False)
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    Path(__file__).parents[1].joinpath("docs", "fault_injection.md").write_text(page(endings()), encoding="utf-8")
