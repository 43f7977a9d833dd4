"""Wrong usage of the command line: one line with value, place and remedy; and what a script is given of a failure."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from membrane_rs.cli import app
from membrane_rs.cli.application import FAILED, USAGE
from test_commands import COMMANDS, document, has_json
from typer.testing import CliRunner


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["fly"], "COMMAND = 'fly': no such command; known are: ablate, "),
        (["chek"], "COMMAND = 'chek': no such command; did you mean 'check'?"),
        (["--versoin"], "'--versoin': no such option of membrane-rs; did you mean '--version'?"),
        (["-x"], "'-x': no such option of membrane-rs; 'membrane-rs --help' lists what it takes"),
        (["run"], "SCENE: is missing; such as: membrane-rs run spinning-tether"),
        (["calibrate", "spinning-tether"], "--data: is missing; such as: membrane-rs calibrate "),
        (["run", "fly", "--unti", "3"], "'--unti': no such option of membrane-rs run; did you mean '--until'?"),
        (["run", "fly", "-z"], "'-z': no such option of membrane-rs run; 'membrane-rs run --help' lists what it takes"),
        (["run", "fly", "--laws.spin.frequency=3"], "is set by '--set laws.spin.frequency=VALUE'"),
        (["run", "fly", "--\x1b[31m.x=3"], "'membrane-rs run --help' lists what it takes"),
        (["run", "fly", "--laws.$(rm x)=3"], "'membrane-rs run --help' lists what it takes"),
        (["run", "fly", "--until"], "--until: needs a value: Simulated time at the end [s], or as 20ms."),
        (["run", "fly", "--json=3"], "--json: takes no value; write it alone"),
        (["run", "fly", "--frames", "1.5"], "--frames = '1.5': must be a whole number, such as 10"),
        (["run", "fly", "--short-steps", "x"], "--short-steps = 'x': must be a whole number, such as 10"),
        (["run", "fly", "--until", "soon"], "--until = 'soon': must be a number (s), or a text with its unit such as "),
        (["run", "fly", "--out", " "], "--out = ' ': must be a path; name a file or a folder"),
        (["run", "fly", "--set", "run.dt=1", "us"], "'us': one argument too many; membrane-rs run takes SCENE and "),
        (["scenes", "all"], "'all': one argument too many; membrane-rs scenes takes none and options; a value with"),
    ],
)
def test_one_line_with_value_place_and_remedy(words: list[str], said: str) -> None:
    for width in ("20", "200"):
        result = CliRunner(env={"COLUMNS": width}).invoke(app, words)
        (line,) = result.stderr.splitlines()
        assert (result.exit_code, result.stdout) == (USAGE, "")
        assert line.startswith("Error: ")
        assert said in line
        assert line.isascii()
        assert line.isprintable()


def test_no_words_show_the_help() -> None:
    for words in ([], ["-q"]):
        result = CliRunner().invoke(app, words)
        assert (result.exit_code, "Usage: membrane-rs [OPTIONS] COMMAND" in result.stdout) == (USAGE, True)


def test_old_names_are_not_proposed() -> None:
    hidden = [name for name, command in COMMANDS.items() if command.hidden]
    text = CliRunner().invoke(app, ["nothing-like-it"]).stderr
    assert not [name for name in hidden if f" {name}," in text]
    assert "--short-steps" not in CliRunner().invoke(app, ["run", "fly", "--short-step", "3"]).stderr


@pytest.mark.parametrize("name", [name for name in COMMANDS if has_json(name)])
def test_a_failure_is_a_document_too(name: str) -> None:
    result = CliRunner().invoke(app, [name, "--json", "--nowhere"])
    found = document(result.stdout)
    assert (result.exit_code, found["exit_code"]) == (USAGE, USAGE)
    assert result.stderr == f"Error: {found['error']}\n"
    assert found["error"].startswith("'--nowhere': no such option")


def test_errors_of_every_kind_are_documents(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("file").write_text("")
    for words, code, said in (
        (["check", "fly"], USAGE, "scene 'fly': is not built in"),
        (["check", "spinning-tether", "-v", "--set", "run.dt=0"], USAGE, "run.dt = 0: must be greater than 0"),
        (["run", "spinning-tether", "--out", "file/run"], FAILED, "file/run"),
        (["resume", "nowhere"], USAGE, "no such saved state"),
        (["compare", "nowhere", "elsewhere"], USAGE, "nowhere"),
    ):
        result = CliRunner().invoke(app, [*words, "--json"])
        found = document(result.stdout)
        assert (result.exit_code, found["exit_code"], set(found)) == (code, code, {"error", "exit_code"}), found
        assert said in found["error"]
        assert result.stderr.endswith(f"Error: {found['error']}\n")
    # A later command of the same process knows nothing of these.
    assert isinstance(document(CliRunner().invoke(app, ["scenes", "--json"]).stdout), list)


def program(*words: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """The program in a process of its own."""
    command = [sys.executable, "-m", "membrane_rs", *words]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, timeout=300)


def test_exit_codes_of_processes(tmp_path: Path) -> None:
    bad = ["--set", "run.watch=10", "--dt", "3.3e-5", "--until", "0.05", "--no-pictures", "--out", "bad"]
    for words, code in (
        (["scenes"], 0),
        (["run", "spinning-tether", *bad], FAILED),
        (["run", "spinning-tether", *bad], FAILED),  # the folder is there
        (["check", "spinning-tether", "--set", "laws.spring_damping=false", "--set", "laws.spin=false"], 0),
        (["check", "fly"], USAGE),
        (["fly"], USAGE),
        ([], USAGE),
    ):
        done = program(*words, folder=tmp_path)
        assert done.returncode == code, (words, done)
        assert "Traceback" not in done.stderr


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
@pytest.mark.parametrize(("name", "code"), [("SIGINT", 130), ("SIGTERM", 143), ("SIGHUP", 129)])
def test_a_signal_before_any_result(name: str, code: int) -> None:
    # The signal is sent by the process itself, while it reads the scene.
    words = "import os, signal; from membrane_rs import scenes; from membrane_rs.cli import main; import sys\n"
    words += f"scenes.scene_of = lambda name: os.kill(os.getpid(), signal.{name}) or __import__('time').sleep(60)\n"
    words += "sys.argv = ['membrane-rs', 'check', 'spinning-tether', '--json']; main()"
    done = subprocess.run([sys.executable, "-c", words], capture_output=True, text=True, check=False, timeout=300)
    assert (done.returncode, done.stderr) == (code, "Stopped.\n")
    assert document(done.stdout) == {"error": f"ended by {name}", "exit_code": code}
