"""A page whose tables and pictures are made of runs that are kept: the runs, and its script's command line."""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from threading import Event
from typing import TypeVar

from kept import kept, slug
from marked import MarkedPart
from membrane_rs._arrays import Floats
from membrane_rs.study.common.executor import run_parallel

SHAPES = "shapes"
"""What `--only` calls contact sheets and the like, which are pictures alone."""


class Runs:
    """Runs by their names, each made once and kept in a folder."""

    def __init__(self, folder: Path, workers: int | None) -> None:
        self.folder, self.workers = folder, workers

    def of(self, jobs: Mapping[str, Callable[[], Mapping[str, Floats]]]) -> dict[str, Mapping[str, Floats]]:
        """The results of jobs, in parallel."""
        calls = [partial(kept, self.folder / f"{slug(name)}.npz", job) for name, job in jobs.items()]
        found = run_parallel(calls, list(jobs), Event(), workers=self.workers, tell=partial(print, flush=True))
        return dict(zip(jobs, found, strict=True))


R = TypeVar("R", bound=Runs)


def make_page(
    name: str,
    doc: str | None,
    *,
    runs_in: Callable[[Path, int | None], R],
    parts: Mapping[str, MarkedPart],
    makers: Mapping[str, Callable[[R, Path], str]],
    write_shapes: Callable[[R], None],
) -> None:
    """Make the tables and pictures of a page, or some of them: the `main` of the script with this docstring.

    A maker gives the text of its part, and may draw the picture at the path that it gets.
    """
    parser = argparse.ArgumentParser(description=doc.splitlines()[0] if doc else None)
    every = [*makers, SHAPES]
    parser.add_argument("--only", nargs="+", choices=every, default=every, help="the tables and pictures to make")
    parser.add_argument("--jobs", type=int, help="number of parallel runs; default: one on each core")
    parser.add_argument("--out", type=Path, default=Path("out") / name, help="folder of the results")
    parser.add_argument("--write", action="store_true", help="write into docs/")
    options = parser.parse_args()
    began = time.perf_counter()
    options.out.mkdir(parents=True, exist_ok=True)
    runs = runs_in(options.out, options.jobs)
    for part in options.only:
        if part in makers:
            picture = options.out / f"{name}-{part}.png"
            parts[part].publish(makers[part](runs, picture), picture, write=options.write)
        elif options.write:
            write_shapes(runs)
    print(f"{time.perf_counter() - began:.0f} s")
