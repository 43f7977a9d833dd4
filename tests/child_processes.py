"""Processes that tests start: what they do is waited for, however slow the machine is, and they end with their test."""

from __future__ import annotations

import subprocess
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

SECONDS = 300.0
"""After which a test that waits has failed; on a machine that does nothing else what is waited for takes seconds."""


@contextmanager
def started(words: Sequence[str], **options: Any) -> Iterator[subprocess.Popen[Any]]:
    """A process, which is ended where it still goes on behind the block."""
    with subprocess.Popen(words, **options) as process:
        try:
            yield process
        finally:
            process.kill()


def wait_until(condition: Callable[[], object], what: str, process: subprocess.Popen[Any] | None = None) -> None:
    """Wait until `condition` holds; fail by its name, and where the process has ended without it."""
    end = time.monotonic() + SECONDS
    while True:
        # Asked first: the last that it does counts too.
        is_over = process is not None and process.poll() is not None
        if condition():
            return
        assert not is_over, f"the process has ended before {what}"
        assert time.monotonic() < end, f"waited {SECONDS:g} s until {what}"
        time.sleep(0.005)
