"""Signals that end a run: SIGINT (Ctrl-C), SIGTERM (batch systems, `kill`), SIGHUP (a terminal that closes), and those
that batch systems send before a time limit: SIGXCPU, SIGUSR1, SIGUSR2. SIGKILL cannot be caught; SIGQUIT is not.

The first one raises `Interrupted`: at once, or, while a run keeps its results, between two chunks of steps, where all
outputs are whole. Further ones change nothing while the run ends. A signal that the process ignores (`nohup`, the
background of a shell) or for which the program has a handler of its own is left alone. Only the main thread can be
interrupted; in others nothing here has an effect.
"""

from __future__ import annotations

import _thread
import signal
import threading
import time
import weakref
from collections.abc import Iterator
from contextlib import contextmanager
from queue import SimpleQueue
from types import FrameType

from membrane_rs.errors import Interrupted

_NAMES = ("SIGINT", "SIGTERM", "SIGHUP", "SIGXCPU", "SIGUSR1", "SIGUSR2")
ENDING = tuple(getattr(signal, name) for name in _NAMES if hasattr(signal, name))
"""The signals that end a run, where the system has them."""
DEFAULTS = (signal.SIG_DFL, signal.default_int_handler)
"""Handlers that are replaced for as long as a run goes on."""
AGAIN = 0.01
"""Time after which a signal is sent again that came where nothing can be raised [s]."""


class _Signals:
    """The state of this process: signals are the process's, so there is one."""

    def __init__(self) -> None:
        self.is_handled = False
        """Whether `handle` is in place."""
        self.reset()

    def reset(self) -> None:
        """Before a run."""
        self.depth = 0
        """Signals wait where this is above 0."""
        self.waiting: int | None = None
        """The signal that waits."""
        self.again: SimpleQueue[int | None] = SimpleQueue()
        """Signals to be sent again; its `put` may be called anywhere."""
        self.is_raised = False
        """Whether `Interrupted` was raised: the run is ending, and further signals change nothing."""

    def handle(self, signum: int, frame: FrameType | None) -> None:
        """The handler."""
        if self.is_raised:
            return
        if _is_ignoring_errors(frame):
            self.again.put(signum)
            return
        # Ctrl-C a second time is for an observer that does not return.
        if self.depth == 0 or (self.depth == 1 and self.waiting is not None):
            self.raise_(signum)
        self.waiting = signum

    def raise_(self, signum: int) -> None:
        """Raise `Interrupted`, the only time."""
        self.is_raised, self.waiting = True, None
        raise Interrupted(signum)

    def look(self) -> None:
        """Raise the signal that waits."""
        if self.waiting is not None:
            self.raise_(self.waiting)


_signals = _Signals()


@contextmanager
def interruptible() -> Iterator[None]:
    """Signals that end a run raise `Interrupted` here; the handlers of before are put back afterwards.

    Inside of another one, and in a thread that is not the main one, it has no effect.
    """
    if not _is_main() or _signals.is_handled:
        yield
        return
    _signals.reset()
    before = {number: signal.getsignal(number) for number in ENDING}
    replaced = {number: handler for number, handler in before.items() if handler in DEFAULTS}
    _signals.is_handled = True
    again = _signals.again
    threading.Thread(target=_send_again, args=(again,), daemon=True).start()
    try:
        for number in replaced:
            signal.signal(number, _signals.handle)
        yield
    finally:
        _signals.depth += 1
        for number, handler in replaced.items():
            signal.signal(number, handler)
        _signals.is_handled = False
        again.put(None)
    _signals.look()


@contextmanager
def held() -> Iterator[None]:
    """Signals wait here, until `look` is called or the outermost `held` ends."""
    yield from _shifted(1)


@contextmanager
def released() -> Iterator[None]:
    """Signals raise at once here, inside of `held`, and the one that waits."""
    yield from _shifted(-_signals.depth if _is_main() else 0)


def look() -> None:
    """Raise the signal that waits, if any."""
    if _is_main():
        _signals.look()


def _shifted(change: int) -> Iterator[None]:
    if not _is_main():
        yield
        return
    _signals.depth += change
    try:
        if _signals.depth == 0:
            _signals.look()
        yield
    finally:
        _signals.depth -= change
    if _signals.depth == 0:
        _signals.look()


def _send_again(numbers: SimpleQueue[int | None]) -> None:
    """Send signals to the main thread, which has left by then where it was."""
    while (number := numbers.get()) is not None:
        time.sleep(AGAIN)
        _thread.interrupt_main(signal.Signals(number))


def _is_ignoring_errors(frame: FrameType | None) -> bool:
    """Whether Python would ignore what is raised here: in finalizers, and in callbacks of weak references."""
    while frame is not None:
        if frame.f_code.co_name == "__del__" or frame.f_code.co_filename == weakref.__file__:
            return True
        frame = frame.f_back
    return False


def _is_main() -> bool:
    return threading.current_thread() is threading.main_thread()
