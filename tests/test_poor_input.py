"""Poor input at the command line: messages that name value and remedy, exit codes, terminals of all kinds."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import pytest
from membrane_rs.cli import app
from membrane_rs.cli.application import FAILED, USAGE
from typer.testing import CliRunner


def said(*words: str, code: int) -> str:
    """All that is printed, in one line."""
    result = CliRunner(env={"COLUMNS": "300"}).invoke(app, list(words))
    assert result.exit_code == code, result.output
    return " ".join(result.output.split())


@pytest.mark.parametrize(
    ("words", "why"),
    [
        ("fly", "COMMAND = 'fly': no such command; known are: .*resume, run, scenes"),
        ("chek", "COMMAND = 'chek': no such command; did you mean 'check'"),
        ("run folder", "scene 'folder': is a folder; name a scene file, such as folder/scene.toml"),
        ("run fly", "scene 'fly': is not built in; known are: .*; a file is named by its path, with .toml"),
        ("run okuizumi-model-3", "did you mean 'okuizumi-model-2'? A file is named by its path, with .toml"),
        ("run ./folder", "scene 'folder': is a folder; name a scene file, such as folder/scene.toml"),
        ("report ../data.csv", "is no folder of a run; measured curves are given as data (data=, --data)"),
        ("check spinning-tether --set laws.spn=3", "did you mean 'laws.spin' or "),
        ("check spinning-tether --set material.thickness=7um", "no value of that name; it has no material"),
        ("run spinning-tether --out=", "Error: --out = '': must be a path; name a file or a folder"),
        ("resume nowhere", "no such saved state; name a run's folder"),
        ("stability spinning-tether --integrators=", "--integrators = '': must be names separated by commas"),
        ("stability spinning-tether --steps 0,1", "steps = [0.0, 1.0]: must be above 0"),
        ("work-precision spinning-tether --integrators rk4,", "--integrators = 'rk4,': must be names separated"),
        ("mesh-study --ensemble -1", "--ensemble = -1: must be 0 or above"),
        ("mesh-study --forms=", "--forms = '': must be names separated by commas"),
    ],
)
def test_usage(words: str, why: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("folder").mkdir()
    tmp_path.with_name("data.csv").write_text("time,hub_force\n0,1\n", encoding="utf-8")
    text = said(*words.split(), code=USAGE)
    for part in why.split(".*"):
        assert part in text
    assert [path.name for path in tmp_path.iterdir()] == ["folder"]


def test_a_run_that_stops_itself_prints_its_summary(tmp_path: Path) -> None:
    # Above the limit of the step, but not so far that it is refused.
    words = ["--set", "run.watch=10", "--dt", "3.3e-5", "--until", "0.05", "--no-pictures", "--integrator", "rk4"]
    words += ["--out", str(tmp_path / "run"), "--json"]
    result = CliRunner().invoke(app, ["run", "spinning-tether", *words])
    assert result.exit_code == FAILED, result.output
    document = json.loads(result.stdout)
    assert document["outcome"].startswith("unstable: ")
    assert document["folder"] == str(tmp_path / "run")
    assert "Error: " in result.stderr


def test_verbose_shows_the_traceback_of_an_error() -> None:
    assert "Traceback" not in said("run", "fly", code=USAGE)
    for words in (["run", "fly", "--verbose"], ["-v", "run", "fly"]):
        assert "Traceback (most recent call last)" in said(*words, code=USAGE)
    assert "Traceback" not in said("run", "fly", code=USAGE)


def test_quiet_leaves_out_remarks_alone(tmp_path: Path) -> None:
    words = ["--until", "0.001", "--steps", "1", "--repeats", "1", "--integrators", "leapfrog"]
    for k, option in enumerate(([], ["-q"])):
        result = CliRunner().invoke(app, ["work-precision", "spinning-tether", *words, *option, "--out", str(tmp_path)])
        assert (bool(result.stderr), "Least force evaluations" in result.stdout) == (k == 0, True)


def program(*words: str, **environment: str) -> subprocess.CompletedProcess[bytes]:
    """The program in a process of its own."""
    command = [sys.executable, "-m", "membrane_rs", *words]
    return subprocess.run(command, env=os.environ | environment, capture_output=True, check=False, timeout=300)


@pytest.mark.parametrize("columns", ["0", "1", "20"])
def test_help_in_a_terminal_of_no_width_can_be_read(columns: str) -> None:
    shown = program("fly", COLUMNS=columns).stderr.decode()
    assert "COMMAND = 'fly': no such command; known are:" in shown


def test_another_encoding() -> None:
    found = program("run", "fäh", PYTHONIOENCODING="ascii", PYTHONUTF8="0", LC_ALL="C")
    assert (found.returncode, b"is not built in" in found.stderr) == (USAGE, True)
    assert program("run", "--help", PYTHONIOENCODING="ascii").returncode == 0


@pytest.mark.skipif(os.name != "posix", reason="a pseudo-terminal of POSIX")
@pytest.mark.parametrize(("environment", "is_red"), [({}, True), ({"NO_COLOR": "1"}, False), ({"TERM": "dumb"}, False)])
def test_colours(environment: dict[str, str], is_red: bool) -> None:
    import pty

    ours, theirs = pty.openpty()
    plain = {key: value for key, value in os.environ.items() if key not in ("NO_COLOR", "FORCE_COLOR")}
    command = [sys.executable, "-m", "membrane_rs", "run", "fly"]
    done = subprocess.run(command, env=plain | {"TERM": "xterm"} | environment, stderr=theirs, check=False, timeout=300)
    os.close(theirs)
    shown = b""
    with suppress(OSError):  # how Linux says the end
        while part := os.read(ours, 4096):
            shown += part
    os.close(ours)
    assert (done.returncode, b"\x1b[31mError: " in shown, b"Error: " in shown) == (USAGE, is_red, True)
