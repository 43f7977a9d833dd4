"""Many runs at once, one on each core.

Threads do: the core lets go of the interpreter while it steps, so two of them step on two cores. Unlike processes
they need no guard in the caller's script, no second import and no copy of the scene.
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
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def together(
    jobs: Sequence[Callable[[], Result]],
    names: Sequence[str],
    stop: Event,
    *,
    workers: int | None = None,
    tell: Tell | None = None,
    outcome: Callable[[Result], str] = lambda _: "",
) -> list[Result]:
    """Do all jobs, several at once, and give their results in the order of the jobs.

    Parameters
    ----------
    jobs : sequence of callable
        Each looks at `stop` now and then.
    names : sequence of str
        What each is, for `tell`.
    stop : Event
        Set where the user interrupts or a job fails; the rest then ends soon.
    workers : int, optional
        How many at once. Default: one on each core. Results do not depend on it.
    tell : callable, optional
        Told in words whenever a job is done.
    outcome : callable
        What a result is, for `tell`.

    Raises
    ------
    InputError
        Less than one worker.
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
