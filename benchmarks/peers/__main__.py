"""python -m peers [--write]: measure all programs, print the tables, and write docs/peers.md and docs/peers.png."""

from __future__ import annotations

import argparse
import importlib.metadata
import os
import sys
from pathlib import Path

DOCS = Path(__file__).resolve().parent.parent.parent / "docs"
PACKAGES = ("mujoco", "newton", "warp-lang")


def main() -> int:
    """Measure, print, and write if asked; 1 where the other programs are missing."""
    parser = argparse.ArgumentParser(prog="peers", description=__doc__)
    parser.add_argument("--write", action="store_true", help="write docs/peers.md and docs/peers.png")
    parser.add_argument(
        "--brief", action="store_true", help="a small mesh and few repeats: to see it work, not to measure"
    )
    options = parser.parse_args()
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    try:
        from peers import every
    except (ImportError, OSError) as error:  # OSError: a library that does not load on this platform
        print(
            f"MuJoCo and Newton are needed for this comparison, and are not usable here: {error}.\n"
            "`make peers` installs them (a network, Python 3.11 or later, and a platform that both have wheels for); "
            "or `pip install --group peers`. Nothing else in membrane_rs needs them.",
            file=sys.stderr,
        )
        return 1
    from peers import deployment, picture, report, speed, work_precision
    from peers.problem import sail, square

    brief = options.brief
    problem, flat = square(8 if brief else 32), sail()
    drawn = work_precision.measure(problem, every.programs(problem), levels=2 if brief else work_precision.LEVELS)
    timed = speed.measure(
        flat,
        every.programs(flat),
        every.plain(flat),
        repeats=3 if brief else 31,
        slice_seconds=1e-3 if brief else 2e-2,
        deploy_until=1e-3 if brief else deployment.UNTIL,
    )
    versions = {name: importlib.metadata.version(name) for name in PACKAGES}
    page = report.text(drawn, timed, versions)
    print(page)
    if options.write:
        picture.draw(drawn, DOCS / "peers.png")
        (DOCS / "peers.md").write_text(page, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
