"""A step of membrane_rs, and of MuJoCo and Newton where they are installed, alternately on the flat sail of model 1.

membrane_rs with springs and with triangles, and model 1 itself with all laws; MuJoCo by its RK4, Newton by its
semi-implicit solver in its fastest and its default configuration. docs/peers.md describes these and all others.
"""

from __future__ import annotations

import os

from machine import cpu
from membrane_rs._markdown import table
from page import README, MarkedPart, options, show
from peers import ours
from peers.problem import Problem, sail
from peers.program import Program
from peers.speed import Steps, steps
from peers.speed_report import AIMED
from peers.speed_report import steps as reached

PART = MarkedPart(README, "steps")
MISSING = (
    "MuJoCo and Newton are not usable here ({}): `make peers` installs them, and `make bench` then times them too."
)


def peers(problem: Problem) -> list[Program]:
    """The other programs. Raises ImportError, or OSError where a library does not load."""
    from peers import every, mujoco_flex, newton_cloth

    rk4 = mujoco_flex.Flex(problem, mujoco_flex.model_of(problem), "RK4", None)
    best = [newton_cloth.Cloth(problem, "semi-implicit", law, None) for law in ("neo-Hookean", "springs")]
    return [rk4, *best, *every.plain(problem)]


def text(found: Steps, missing: str | None) -> str:
    """The table of steps, and the ratios or the reason for their absence."""
    rows = [(f"model 1, all laws: membrane_rs {method}", f"{1e6 * step:.1f}") for method, step in found.model.items()]
    for pace in found.paces:
        name = pace.name + (" (f32)" if pace.bits == 32 else "")
        rows.append((f"flat, {pace.law}: {name}", f"{1e6 * pace.step:.1f}"))
    parts = [table(("one step, measured alternately", f"median [us], {found.width}"), rows)]
    parts.append(MISSING.format(missing) + "\n" if missing else table(AIMED, reached(found), range(3)))
    return "\n".join(parts)


def main() -> None:
    """Measure, print, and write if asked."""
    chosen = options(__doc__).parse_args()
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    problem, missing = sail(), None
    programs: list[Program] = [
        program for law in ("triangles", "springs") for program in ours.programs(problem, law)[:2]
    ]
    try:
        programs += peers(problem)
    except (ImportError, OSError) as error:
        missing = str(error)
    repeats, slice_seconds = (3, 1e-3) if chosen.quick else (31, 2e-2)
    found = steps(problem, programs, repeats=repeats, slice_seconds=slice_seconds)
    show(PART, f"Processor: {cpu()}, one thread, processor time.\n\n{text(found, missing)}", write=chosen.write)


if __name__ == "__main__":
    main()
