"""What all tests share."""

from __future__ import annotations

import signal


def pytest_configure() -> None:
    """Take Ctrl-C for what it is: in the background of a shell it is ignored, and tests of it would hang."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
