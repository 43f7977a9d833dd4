"""What all tests rely on."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from typing import Any

import pytest
from browser import browser  # noqa: F401 - the fixture
from hypothesis import HealthCheck, settings

# The same examples each time, and none that fails since the machine is slow: an example that is the first to load a
# library takes longer than others. Other examples, to search for what fails: pytest --hypothesis-profile=search.
settings.register_profile("search", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.register_profile("same", settings.get_profile("search"), derandomize=True, database=None)
settings.load_profile("same")


@pytest.fixture(scope="session", autouse=True)
def interruptible() -> Iterator[None]:
    """Ctrl-C interrupts, and SIGTERM and SIGHUP end, here and in child processes, also where a shell's background or
    nohup has them ignored.
    """
    handlers: dict[signal.Signals, Any] = {
        signal.SIGINT: signal.default_int_handler,
        signal.SIGTERM: signal.SIG_DFL,
        signal.SIGHUP: signal.SIG_DFL,
    }
    before = {number: signal.signal(number, handler) for number, handler in handlers.items()}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Refuse names of tests that hold an address: another process of the same tests has others, and runs none."""
    named = [item.nodeid for item in items if " at 0x" in item.nodeid]
    if named:
        raise pytest.UsageError(f"{named[0]}: its name holds an address; give it by ids=")
