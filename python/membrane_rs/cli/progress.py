"""The progress bar of a run."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from membrane_rs.cli.reporting import tell, verbosity

if TYPE_CHECKING:
    from rich.console import Console

    from membrane_rs.runs import Simulation
    from membrane_rs.study.common.one_run import RunResult


class Bar:
    """The progress bar: simulated time, steps per second, time left; then the pictures."""

    def __init__(self, progress: Any, start: float, end: float) -> None:
        self._progress = progress
        self._start, self._end = start, end
        self._began = self._shown = time.perf_counter()
        self._first_step: int | None = None
        self._task = progress.add_task("", total=end - start, detail="")
        self._pictures_task: Any = None

    def steps(self, sim: Simulation) -> None:
        """Called by the run at intervals."""
        now = time.perf_counter()
        if self._first_step is None:
            self._first_step, self._began = sim.step_count, now
        rate = (sim.step_count - self._first_step) / max(now - self._began, 1e-9)
        stage = f"{sim.stage_name}  " if sim.stage_name else ""
        detail = f"{stage}{sim.time:.4f} of {self._end:g} s  {rate:,.0f} steps/s"
        self._progress.update(self._task, completed=sim.time - self._start, detail=detail)

    def pictures(self, what: str, done: int, total: int) -> None:
        """Called by the run's folder for each picture."""
        if self._pictures_task is None:
            self._pictures_task = self._progress.add_task("", total=total, detail=what)
        self._progress.update(self._pictures_task, completed=done, detail=f"{done} of {total} {what}")

    def relaxing(self) -> None:
        """Show that the start is being relaxed."""
        self._progress.update(self._task, detail="relaxing")

    def stop(self) -> None:
        """End the bar, so that other text can be shown."""
        self._progress.stop()


@contextmanager
def progress_bar(console: Console, start: float, end: float) -> Iterator[Bar]:
    """A bar from `start` to `end` [s] of simulated time; nothing where the console is no terminal."""
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    detail = TextColumn("{task.fields[detail]}")
    columns = (BarColumn(bar_width=24), detail, TimeRemainingColumn(), TextColumn("left"))
    with Progress(*columns, console=console, disable=not console.is_terminal) as progress:
        yield Bar(progress, start, end)


def terminal() -> Console:
    """The console of the bar: the standard error, apart from the results."""
    from rich.console import Console

    return Console(stderr=True)


@contextmanager
def parts_counter(words: str) -> Iterator[Callable[[int, int], None]]:
    """What shows how many parts of something are done: a bar on a terminal, else nothing."""
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    console = terminal()
    columns = (BarColumn(bar_width=24), MofNCompleteColumn(), TextColumn(words), TimeRemainingColumn())
    with Progress(*columns, console=console, disable=not console.is_terminal or verbosity.quiet) as bar:
        task = bar.add_task("", total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total)


@contextmanager
def run_counter() -> Iterator[Callable[[int, int, RunResult], None]]:
    """What shows how many runs are done: on a terminal a bar, and a line for each that fails; else a line for each."""
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    console = terminal()
    is_bar = console.is_terminal and not verbosity.quiet
    columns = (BarColumn(bar_width=24), MofNCompleteColumn(), TextColumn("runs"), TimeRemainingColumn())
    with Progress(*columns, console=console, disable=not is_bar) as bar:
        task = bar.add_task("", total=None)

        def show(done: int, total: int, result: RunResult) -> None:
            bar.update(task, completed=done, total=total)
            if is_bar and result.is_finished:
                return
            values = ", ".join([*(f"{key} = {value}" for key, value in result.point.values.items()), ""])
            seconds = result.facts.get("wall_time")
            end = f": {result.message}" if result.message else f", {seconds:.3g} s" if seconds is not None else ""
            words = f"[{done}/{total}] {values}start {result.point.start}: {result.outcome}{end}"
            if is_bar:
                bar.console.print(words, markup=False, highlight=False, soft_wrap=True)
            else:
                tell(words)

        yield show
