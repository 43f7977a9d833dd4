"""Many runs of one scene, each with values and a start of its own, made in parallel and kept in a folder.

    with ManyRuns(scene, RunSetup(until=0.2), executor="processes", folder="runs/mine") as runs:
        for k, result in runs.results([RunPoint({"laws.creases.stiffness": 3.0}), ...]):
            ...

A run depends on scene, setup and point alone: neither executor, nor order, nor number of workers change its bits. A
run that is in the folder is read, not made again, so that what was stopped goes on.
"""

from __future__ import annotations

import pickle
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import Any, Literal
from uuid import uuid4

from typing_extensions import Self

from membrane_rs._validation import number_of, show
from membrane_rs.errors import ExecutorError, InputError, InputTypeError
from membrane_rs.results.history_table import FIRST_COLUMNS, RENAMED
from membrane_rs.results.recorded import Measures, record_table
from membrane_rs.scene import Scene
from membrane_rs.scene.run_settings import MOST_INSTANTS, check_duration
from membrane_rs.study.common.executor import workers_of
from membrane_rs.study.common.kept_runs import KeptRuns
from membrane_rs.study.common.one_run import (
    CRASHED,
    TIME_LIMIT,
    RunPoint,
    RunResult,
    RunSetup,
    RunStopped,
    RunTask,
    make_run,
    packed,
    stop_runs,
)
from membrane_rs.study.common.perturbation import SHIFT, check_shift, shift_of
from membrane_rs.study.common.pools import GIVEN_CAPACITY, Pool, completed, process_pools, thread_pools

MOST_RUNS = 100_000
"""More runs at once are taken as an input error: as many files in a folder, and rows of a table."""
TAKEN = ("rate", "phase_deg", "error")
"""Names of measures whose final and extreme values would stand for others of a row, of `results.features`."""
AGAIN = (CRASHED, TIME_LIMIT)
"""Outcomes that depend on the machine: these runs may be made again."""
Where = Executor | Literal["threads", "processes"]
"""Where runs are made: an executor of `concurrent.futures`, or threads or processes of this machine."""
Progress = Callable[[int, int, RunResult], None]
"""Called after each run with the number of those that are done, the number of all, and the run."""


class ManyRuns:
    """Makes runs of one scene, a number of them at a time.

    Parameters
    ----------
    scene : Scene
        From which all runs depart.
    setup : RunSetup, optional
        What they have in common beside it.
    executor : Executor, "threads" or "processes"
        Where they are made. Threads need nothing; a process that dies ends its own run alone, and a script that starts
        some must do its work below `if __name__ == "__main__":`. An executor of the caller is not shut down.
    jobs : int, optional
        Runs at a time. Default: one for each core; 1000 in an executor of the caller.
    folder : path, optional
        Where runs are kept. Default: nowhere.
    request : mapping, optional
        What else a folder of the same runs must have been asked for: plain values by name.
    outputs : sequence of str
        Patterns of further files that are the folder's own.
    overwrite : bool
        Whether runs of another request in the folder are removed.
    retry : bool
        Whether runs that crashed or ran out of time are made again.

    Raises
    ------
    InputError, InputTypeError
        A setup, an executor or a number of jobs that is none.
    OutputError
        A folder that cannot be used, see `KeptRuns`.
    """

    def __init__(
        self,
        scene: Scene,
        setup: RunSetup | None = None,
        *,
        executor: Where = "threads",
        jobs: int | None = None,
        folder: str | Path | None = None,
        request: Mapping[str, Any] | None = None,
        outputs: Sequence[str] = (),
        overwrite: bool = False,
        retry: bool = False,
    ) -> None:
        self.scene, self.setup = scene, checked_setup(setup or RunSetup())
        if self.setup.shift != SHIFT:  # a scene without its varied values may be none that can be assembled
            check_shift(self.setup.shift, scene)
        self._executor, self._retry, self._ticket = executor, retry, uuid4().hex
        if isinstance(executor, Executor):
            self._jobs = GIVEN_CAPACITY if jobs is None else workers_of(jobs)
        elif executor in ("threads", "processes"):
            self._jobs = workers_of(jobs)
        else:
            raise InputTypeError(
                f"executor = {show(executor)}: must be 'threads', 'processes' or an executor of concurrent.futures, "
                "such as distributed's Client.get_executor()"
            )
        if executor == "processes":
            check_picklable(self.setup)
        self._kept: KeptRuns | None = None
        if folder is not None:
            asked = {**_as_request(self.setup), **(request or {})}
            self._kept = KeptRuns(folder, scene, asked, outputs=outputs, overwrite=overwrite)
        self._scene_packed = packed(scene)
        self._ending = ExitStack()
        self._pools: Sequence[Pool] = ()
        self._running: Generator[tuple[int, RunResult | Exception], None, None] | None = None

    @property
    def path(self) -> Path | None:
        """The folder."""
        return None if self._kept is None else self._kept.path

    def __enter__(self) -> Self:
        """Begin; threads and processes start with the first run."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End threads and processes, at once after an error, and give the folder back."""
        try:
            if error is not None:
                stop_runs(self._ticket)
            if self._running is not None:
                self._running.close()
            self._ending.__exit__(kind, error, trace)
        finally:
            if self._kept is not None:
                self._kept.close()

    def results(self, points: Sequence[RunPoint], progress: Progress | None = None) -> Iterator[tuple[int, RunResult]]:
        """Yield the index of each point and its run: first those that were kept, then the others as they end.

        A run is reported to `progress` once the caller has taken it: at an interrupt, what is reported is not lost.

        Raises
        ------
        InputError
            No runs, more than `MOST_RUNS`, or measures that cannot be sent where runs are made.
        ExecutorError
            An executor that takes no more runs.
        OutputError
            A run cannot be kept.
        """
        if not 1 <= len(points) <= MOST_RUNS:
            raise InputError(f"{len(points):,} runs: must be 1 to {MOST_RUNS:,}; give other values, or fewer starts")
        done, left = 0, []
        for k, point in enumerate(points):
            result = None if self._kept is None else self._kept.get(point)
            if result is None or (self._retry and result.outcome in AGAIN):
                left.append(k)
                continue
            yield k, result
            done += 1
            if progress is not None:
                progress(done, len(points), result)
        for k, result in self._made([points[k] for k in left]):
            if self._kept is not None:
                self._kept.keep(result)
            yield left[k], result
            done += 1
            if progress is not None:
                progress(done, len(points), result)

    def all_results(self, points: Sequence[RunPoint], progress: Progress | None = None) -> list[RunResult]:
        """The runs in the order of their points; see `results`."""
        found = dict(self.results(points, progress))
        return [found[k] for k in range(len(points))]

    def _made(self, points: Sequence[RunPoint]) -> Iterator[tuple[int, RunResult]]:
        tasks = [RunTask(self._scene_packed, self.setup, point, self._ticket) for point in points]
        if not tasks:
            return
        self._running = completed(self._started(len(tasks)), make_run, tasks)
        for k, result in self._running:
            if isinstance(result, RunResult):
                yield k, result
            elif isinstance(result, RunStopped):
                raise ExecutorError("the runs were stopped; make them again")
            elif isinstance(result, pickle.PicklingError | AttributeError | TypeError | ImportError):
                raise InputError(_unsendable(result)) from result
            else:
                kind = "" if isinstance(result, ExecutorError) else f"{type(result).__name__}: "
                yield k, RunResult(points[k], CRASHED, kind + " ".join(str(result).split()))

    def _started(self, count: int) -> Sequence[Pool]:
        """The pools, of which as many as there are tasks are started the first time."""
        if isinstance(self._executor, Executor):
            self._pools = [Pool(self._executor, self._jobs)]
        elif self._executor == "threads" and not self._pools:
            pools = thread_pools(self._jobs, lambda: stop_runs(self._ticket))
            self._pools = self._ending.enter_context(pools)
        elif self._executor == "processes" and len(self._pools) < min(self._jobs, count):
            more = process_pools(min(self._jobs, count) - len(self._pools))
            self._pools = [*self._pools, *self._ending.enter_context(more)]
        return self._pools


def checked_setup(setup: RunSetup) -> RunSetup:
    """The setup with plain numbers. Raises InputError and InputTypeError, which name what is wrong."""
    until = None if setup.until is None else number_of("until", setup.until)
    if until is not None:
        check_duration(until, "until")
    samples = setup.samples
    if samples is not None and (isinstance(samples, bool) or not isinstance(samples, int)):
        raise InputTypeError(f"samples = {show(samples)}: must be a whole number")
    if samples is not None and not 2 <= samples <= MOST_INSTANTS:
        raise InputError(f"samples = {show(samples)}: must be from 2 to {MOST_INSTANTS}")
    limit = None if setup.time_limit is None else number_of("time_limit", setup.time_limit)
    if limit is not None and limit <= 0.0:
        raise InputError(f"time_limit = {limit}: must be above 0 (s of wall time for each run)")
    measures = Measures(setup.record).beside((*FIRST_COLUMNS, *RENAMED))
    if (taken := next((name for name in measures.units if name in TAKEN), None)) is not None:
        raise InputError(
            f"record[{taken!r}]: final_{taken} or highest_{taken} is another number of each row; rename it"
        )
    return RunSetup(until, samples, dict(record_table(setup.record)), shift_of(setup.shift), limit)


def check_picklable(setup: RunSetup) -> None:
    """Refuse measures that no other process can be given. Raises InputError."""
    try:
        pickle.dumps(setup)
    except (pickle.PicklingError, AttributeError, TypeError) as error:
        raise InputError(_unsendable(error)) from error


def _unsendable(error: BaseException) -> str:
    reason = " ".join(str(error).split())
    return (
        f"runs cannot be sent to other processes ({reason}); define measures at the top level of a module that they "
        'have too, or take executor="threads"'
    )


def _as_request(setup: RunSetup) -> dict[str, Any]:
    """What runs in a folder must have in common; not the time limit, which has no effect on a run within it."""
    return {
        "until": setup.until,
        "samples": setup.samples,
        "record": units_of(setup),
        "shift": setup.shift,
    }


def units_of(setup: RunSetup) -> dict[str, str]:
    """The unit of each measure by the name of its column."""
    return Measures(setup.record).units
