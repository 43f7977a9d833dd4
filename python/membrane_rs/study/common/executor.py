"""Parallel execution of many runs, one on each core.

Threads suffice: the core releases the interpreter's lock while it steps, so two of them step on two cores. Unlike
processes they need no guard in the caller's script, no second import and no copy of the scene.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from threading import Event
from typing import TypeVar

from membrane_rs.errors import InputError

Result = TypeVar("Result")
Tell = Callable[[str], None]


def cores() -> int:
    """Number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def run_parallel(
    jobs: Sequence[Callable[[], Result]],
    names: Sequence[str],
    stop: Event,
    *,
    workers: int | None = None,
    tell: Tell | None = None,
    outcome: Callable[[Result], str] = lambda _: "",
) -> list[Result]:
    """Run jobs in parallel and return their results in the order of the jobs.

    Parameters
    ----------
    jobs : sequence of callable
        Each polls `stop` and ends soon once it is set.
    names : sequence of str
        Descriptions of the jobs, for `tell`.
    stop : Event
        Set when the user interrupts or a job fails, so that the other jobs end.
    workers : int, optional
        Number of threads. Default: one for each core. Results do not depend on it.
    tell : callable, optional
        Called with a line of text after each job.
    outcome : callable
        Description of a result, for `tell`.

    Raises
    ------
    InputError
        Fewer than one worker.
    """
    count = cores() if workers is None else workers
    if count < 1:
        raise InputError(f"jobs = {count}: must be 1 or above")
    with ThreadPoolExecutor(max_workers=count) as pool:
        waiting = {pool.submit(job): k for k, job in enumerate(jobs)}
        try:
            for done, future in enumerate(as_completed(waiting), start=1):
                words = outcome(future.result())
                if tell is not None:
                    tell(f"[{done}/{len(jobs)}] {names[waiting[future]]}{words and ': ' + words}")
        except BaseException:
            stop.set()
            pool.shutdown(wait=True, cancel_futures=True)
            raise
    return [future.result() for future in waiting]
