"""The viewer as a page for a browser, served by a program of its own until Ctrl-C."""

from __future__ import annotations

import logging
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import membrane_rs
import pytest
from browser import opened
from membrane_rs.plotting.viewer.launcher import messages_of
from membrane_rs.plotting.viewer.page import _is_of_note

SCRIPT = "import membrane_rs; membrane_rs.view('run', color='speed', where='browser')"
OPTIONS = ("--port", "none", "--host", "0.0.0.0")
"""Of the user's script, not of the server."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    found = tmp_path_factory.mktemp("served")
    membrane_rs.run("hanging-strip", 0.04, frames=9, out=found / "run", pictures=False)
    return found


@pytest.fixture(params=["command", "script"])
def served(request: pytest.FixtureRequest, folder: Path) -> Iterator[subprocess.Popen[str]]:
    """A program that serves the page, and opens no browser by itself."""
    pytest.importorskip("trame")
    pytest.importorskip("pyvista")
    if sys.platform == "win32":
        pytest.skip("Ctrl-C of another process needs a console of its own there")
    words = ["-m", "membrane_rs", "view", "run", "--browser", "--color", "speed", "--time", "20ms"]
    if request.param == "script":
        words = ["-c", SCRIPT, *OPTIONS]
    hidden = ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER")
    environment = {name: value for name, value in os.environ.items() if name not in hidden}
    program = subprocess.Popen(
        [sys.executable, *words], cwd=folder, env=environment, text=True, stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )  # fmt: skip
    yield program
    program.kill()
    program.communicate()


def next_line(program: subprocess.Popen[str]) -> str:
    assert program.stdout is not None
    return program.stdout.readline().strip()


def test_a_browser_shows_it_and_ctrl_c_ends_it(served: subprocess.Popen[str]) -> None:
    address = next_line(served)
    assert address.startswith("http://localhost:")
    assert next_line(served) == "Open it in a browser on this machine. Ctrl-C ends it."
    with opened(width=1100, height=760) as browser:
        browser.let_in()
        browser.open(address)
        browser.wait(lambda: browser.find_all(".v-slider-thumb"), "the page is there")

        def is_at_end() -> bool:
            browser.find(".v-slider-thumb").send_keys("\ue010")  # End; once more, where the page has not taken it yet
            return bool(browser.find(".words").text == "0.040 s")

        browser.wait(is_at_end, "the slider leads to the end")
        browser.wait(lambda: browser.pixels()[100:-220, 200:-160].std() > 5.0, "the picture is drawn")
        assert browser.console() == []
        assert browser.requests() <= {"http", "ws"}
    assert served.poll() is None  # the next browser may come
    served.send_signal(signal.SIGINT)
    _, errors = served.communicate()
    assert (served.returncode, "Traceback" in errors) == (0, False), errors


@pytest.mark.skipif(sys.platform != "linux", reason="reads the sockets of Linux")
def test_only_this_machine_is_served(served: subprocess.Popen[str]) -> None:
    port = f"{int(next_line(served).rstrip('/').rpartition(':')[2]):04X}"
    rows = [line.split() for name in ("tcp", "tcp6") for line in Path("/proc/net", name).read_text().splitlines()[1:]]
    hosts = {row[1].partition(":")[0] for row in rows if row[1].endswith(f":{port}") and row[3] == "0A"}  # listens
    assert hosts
    assert hosts <= {"0100007F", "00000000000000000000000001000000"}  # 127.0.0.1 and ::1


@pytest.mark.parametrize(
    ("page", "messages"),
    [
        ("http://localhost:8080/index.html?ui=main", "ws://localhost:8080/ws"),
        ("http://localhost:8080/", "ws://localhost:8080/ws"),
        ("https://hub.example.org/user/ada/proxy/41/index.html", "wss://hub.example.org/user/ada/proxy/41/ws"),
        ("http://[::1]:80/index.html", "ws://[::1]:80/ws"),
        ("https://hub.example.org/user/Ada/proxy/41/index.html", None),  # the client would write it small
        ("http://[::1/index.html", None),
        ("http:///index.html", None),
        ("file:///index.html", None),
        ("", None),
    ],
)
def test_messages_lie_beside_their_page(page: str, messages: str | None) -> None:
    assert messages_of(page) == messages


def test_a_closed_browser_is_no_error_of_the_server() -> None:
    def record(error: Exception) -> logging.LogRecord:
        return logging.LogRecord("asyncio", logging.ERROR, "", 0, "never retrieved", None, (type(error), error, None))

    assert not _is_of_note(record(ConnectionResetError("Cannot write to closing transport")))
    assert _is_of_note(record(ValueError("anything else")))


def test_what_the_server_reports_without_its_error_is_known_by_it() -> None:
    report = logging.LogRecord("wslink.protocol", logging.ERROR, "", 0, "Exception raised", None, None)
    assert _is_of_note(report)
    for error, is_of_note in ((ConnectionResetError("Cannot write to closing transport"), False), (OSError(), True)):
        try:
            raise error
        except OSError:
            assert _is_of_note(report) is is_of_note
