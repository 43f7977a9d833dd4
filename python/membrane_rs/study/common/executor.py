"""Parallel execution of many runs, one on each core.

Threads suffice: the core releases the interpreter's lock while it steps, so two of them step on two cores. Unlike
processes they need no guard in the caller's script, no second import and no copy of the scene.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from threading import Event
from typing import TypeVar

from membrane_rs._validation import count_of, show
from membrane_rs.errors import InputTypeError
from membrane_rs.study.common.pools import completed, thread_pools

Result = TypeVar("Result")
Tell = Callable[[str], None]
MOST_JOBS = 1000
"""More runs at a time are taken as an input error: each has a thread or a process of its own."""


def cores() -> int:
    """Number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def workers_of(jobs: int | None) -> int:
    """The number of runs at a time: as given, or one for each core.

    Raises InputError for fewer than one or more than `MOST_JOBS`, and InputTypeError for no whole number.
    """
    if jobs is None:
        return cores()
    return count_of("jobs", jobs, 1, MOST_JOBS, "runs at a time, --jobs")


def teller(progress: Tell | None, name: str = "progress") -> Tell:
    """A function for lines of text: the caller's, or one that drops them. Raises InputTypeError for no function."""
    if progress is not None and not callable(progress):
        raise InputTypeError(f"{name} = {show(progress)}: must be a function that takes a line of text")
    return progress or (lambda _: None)


def run_parallel(
    jobs: Sequence[Callable[[], Result]],
    names: Sequence[str],
    stop: Event,
    *,
    workers: int | None = None,
    tell: Tell | None = None,
    outcome: Callable[[Result], str] = lambda _: "",
    each: Callable[[Result], None] | None = None,
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
    each : callable, optional
        Called with each result, as its job ends.

    Raises
    ------
    InputError
        Fewer than one worker.
    """
    found: dict[int, Result] = {}
    with thread_pools(workers_of(workers), stop.set) as pools:
        for done, (k, result) in enumerate(completed(pools, _called, jobs), start=1):
            if isinstance(result, BaseException):
                raise result
            found[k] = result
            if each is not None:
                each(result)
            words = outcome(result)
            if tell is not None:
                tell(f"[{done}/{len(jobs)}] {names[k]}{words and ': ' + words}")
    return [found[k] for k in range(len(jobs))]


def _called(job: Callable[[], Result]) -> Result:
    return job()
