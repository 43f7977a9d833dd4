"""A thread that writes files while the core steps: one at a time, in the order in which they were given."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor

MOST_WAITING = 2
"""Files that may wait: so many copies of a shape are in memory, and one more that is being written."""


class Background:
    """Does tasks in a thread of its own, and raises the errors of that thread in the caller's.

    A task must work on copies: what the caller changes meanwhile is not its own. `check` is called before each; what
    it raises keeps the task from being done.
    """

    def __init__(self, check: Callable[[], None] = lambda: None) -> None:
        self._check = check
        self.has_failed = False
        """Whether a task has raised: what those before it wrote may be incomplete."""
        self._pool = ThreadPoolExecutor(1, "membrane_rs-output")
        self._begun: deque[Future[None]] = deque()

    def add(self, task: Callable[[], None]) -> None:
        """Have `task` done after those before it; waits while too many wait. Raises what an earlier task raised."""
        self._settle(MOST_WAITING)
        self._begun.append(self._pool.submit(self._do, task))

    @property
    def is_idle(self) -> bool:
        """Whether all tasks are done."""
        return not self._begun or self._begun[-1].done()

    def look(self) -> None:
        """Raise what a task has raised, without waiting."""
        while self._begun and self._begun[0].done():
            self._settle(len(self._begun) - 1)

    def close(self) -> BaseException | None:
        """Wait for every task, then end the thread. Returns the first error that was not raised yet."""
        self._pool.shutdown(wait=True)
        errors = [task.exception() for task in self._begun]
        return next((error for error in errors if error is not None), None)

    def _do(self, task: Callable[[], None]) -> None:
        try:
            self._check()
            task()
        except BaseException:
            self.has_failed = True
            raise

    def _settle(self, left: int) -> None:
        """Wait until no more than `left` tasks are under way, and raise the first error among those done."""
        while len(self._begun) > left:
            # Taken off once it is done: Ctrl-C while waiting then loses no error.
            try:
                self._begun[0].result()
            finally:
                if self._begun[0].done():
                    self._begun.popleft()
