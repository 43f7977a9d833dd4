"""A kernel of Jupyter, for tests of what a notebook shows."""

from __future__ import annotations

import queue
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest


class Kernel:
    """A process that runs cells."""

    def __init__(self, client: Any) -> None:
        self._client = client

    def run(self, code: str, until: str = "status", seconds: float = 300.0) -> list[dict[str, Any]]:
        """The messages of a cell: until it is idle, or until one of a kind has come."""
        asked = self._client.execute(code)
        end, messages = time.monotonic() + seconds, []
        while time.monotonic() < end:
            try:
                message = self._client.get_iopub_msg(timeout=1.0)
            except queue.Empty:
                continue
            kind, content = message["msg_type"], message["content"]
            assert kind != "error", "\n".join(content["traceback"])
            messages.append({"kind": kind, **content})
            is_over = kind == "status" and content["execution_state"] == "idle"
            if kind == until if until != "status" else is_over and message["parent_header"].get("msg_id") == asked:
                return messages
        raise AssertionError(f"no {until} after {seconds} s: {[message['kind'] for message in messages]}")


@contextmanager
def kernel(folder: Path) -> Iterator[Kernel]:
    """A kernel that works in a folder. Skips where Jupyter is missing."""
    pytest.importorskip("ipykernel")
    manager = pytest.importorskip("jupyter_client.manager")
    process, client = manager.start_new_kernel(kernel_name="python3", cwd=str(folder), startup_timeout=300)
    try:
        yield Kernel(client)
    finally:
        client.stop_channels()
        process.shutdown_kernel(now=True)
