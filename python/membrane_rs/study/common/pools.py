"""Where tasks are carried out: pools, each an executor that holds a number of them at a time.

Threads share one pool. Each process has a pool of its own, so that one that dies ends its own task alone, and which one
is known: the task is tried once more, in a new process. An executor of the caller is one pool.
"""

from __future__ import annotations

import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    ProcessPoolExecutor,
    ThreadPoolExecutor,
    wait,
)
from contextlib import contextmanager
from multiprocessing import get_context
from multiprocessing.connection import Connection
from typing import TypeVar

from membrane_rs.errors import ExecutorError

Task = TypeVar("Task")
Result = TypeVar("Result")
GIVEN_CAPACITY = 1000
"""Tasks that wait at a time in an executor of the caller, whose number of workers is not known."""


class Pool:
    """An executor of the caller, or of threads, and how many tasks it holds at a time."""

    def __init__(self, executor: Executor, capacity: int) -> None:
        self.executor, self.capacity, self.held = executor, capacity, 0

    def submit(self, function: Callable[[Task], Result], task: Task) -> Future[Result]:
        """Give it a task. Raises ExecutorError where it takes none."""
        try:
            future = self.executor.submit(function, task)
        except RuntimeError as error:  # shut down, or broken
            raise self.broken(error) from error
        self.held += 1
        return future

    def broken(self, error: BaseException) -> ExecutorError:
        """The error of an executor that cannot be made anew."""
        reason = "its tasks were cancelled" if isinstance(error, CancelledError) else " ".join(str(error).split())
        name = type(self.executor).__name__
        find = ', or with executor="processes", which names a run that ends its process'
        return ExecutorError(
            f"executor {name}: takes no more runs ({reason}); those that are done are in the folder, if there is one: "
            f"go on with a new executor{find if isinstance(error, BrokenExecutor) else ''}"
        )

    def renew(self, error: BaseException) -> None:
        """Replace a broken executor. Raises ExecutorError where the caller has made it."""
        raise self.broken(error) from error


class ProcessPool(Pool):
    """One process of this machine, which holds one task."""

    def __init__(self, stopper: Connection) -> None:
        self._stopper = stopper
        super().__init__(self._made(), 1)

    def _made(self) -> ProcessPoolExecutor:
        """A process that imports this package anew: a fork of a process with threads may wait for ever."""
        executor = ProcessPoolExecutor(1, get_context("spawn"), _begin, (self._stopper,))
        try:
            self._started: Future[None] = executor.submit(_nothing)
        except OSError as error:
            executor.shutdown(wait=False, cancel_futures=True)
            raise ExecutorError(f"no further process can be started ({error.strerror}); give fewer jobs") from error
        return executor

    def submit(self, function: Callable[[Task], Result], task: Task) -> Future[Result]:
        """Give it a task, in a new process where the last one has died meanwhile."""
        try:
            future = self.executor.submit(function, task)
        except BrokenExecutor as error:
            self.renew(error)
            future = self.executor.submit(function, task)
        self.held += 1
        return future

    def renew(self, error: BaseException) -> None:
        """Start a new process. Raises ExecutorError where the last one has not come as far as a task."""
        if self._started.exception() is not None:
            raise ExecutorError(
                "a process of this program cannot be started; a script that starts some must do its work below "
                "`if __name__ == '__main__':`, or take executor=\"threads\""
            ) from error
        self.executor.shutdown(wait=False)
        self.executor = self._made()


@contextmanager
def thread_pools(count: int, stop: Callable[[], None]) -> Iterator[list[Pool]]:
    """A pool of so many threads. `stop` is called on any error, and makes tasks end soon."""
    with ThreadPoolExecutor(count) as executor:
        try:
            yield [Pool(executor, count)]
        except BaseException:
            stop()
            executor.shutdown(wait=True, cancel_futures=True)
            raise


@contextmanager
def process_pools(count: int) -> Iterator[list[Pool]]:
    """Pools of so many processes, which end with this block, and with this process."""
    reader, writer = get_context("spawn").Pipe(duplex=False)
    pools: list[Pool] = []
    try:
        pools += [ProcessPool(reader) for _ in range(count)]
        yield pools
    finally:
        writer.close()
        for pool in pools:
            pool.executor.shutdown(wait=True, cancel_futures=True)
        reader.close()


def completed(
    pools: Sequence[Pool], function: Callable[[Task], Result], tasks: Sequence[Task]
) -> Generator[tuple[int, Result | Exception], None, None]:
    """Yield the index of each task with its result, or with the error that it raised or its process died of, in the
    order in which they end.

    When the iterator is closed, tasks that have not begun are cancelled.

    Raises
    ------
    ExecutorError
        An executor of the caller that broke, was shut down or cancelled tasks.
    """
    left = deque((k, False) for k in range(len(tasks)))
    waiting: dict[Future[Result], tuple[int, bool, Pool]] = {}
    try:
        while left or waiting:
            for pool in pools:
                while left and pool.held < pool.capacity:
                    k, was_tried = left.popleft()
                    waiting[pool.submit(function, tasks[k])] = k, was_tried, pool
            done = wait(waiting, return_when=FIRST_COMPLETED)[0]
            for future in sorted(done, key=lambda one: waiting[one][0]):
                k, was_tried, pool = waiting.pop(future)
                pool.held -= 1
                try:
                    result: Result | Exception = future.result()
                except CancelledError as error:
                    raise pool.broken(error) from error
                except BrokenExecutor as error:
                    pool.renew(error)
                    if not was_tried:
                        left.appendleft((k, True))
                        continue
                    result = ExecutorError("the process ended without a result, twice; was it out of memory?")
                except Exception as error:  # noqa: BLE001 - the task's own, which its caller judges
                    result = error
                yield k, result
    finally:
        for future in waiting:
            future.cancel()


def _begin(stopper: Connection) -> None:
    """In a new process: leave Ctrl-C, which reaches all processes of a terminal, to the one that has started it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with, args=(stopper,), daemon=True).start()


def _end_with(stopper: Connection) -> None:
    """End this process at once when the other end of the pipe is closed, or the process that holds it has died."""
    try:
        stopper.poll(None)
    finally:
        os._exit(1)


def _nothing() -> None:
    """The first task of a process."""
