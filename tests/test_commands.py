"""Every command: its help, its example, its options, its exit codes."""

from __future__ import annotations

import json
import shlex
from pathlib import Path
from typing import Any

import pytest
from membrane_rs.cli import app
from membrane_rs.cli.application import PANELS, literal
from typer.main import get_command
from typer.testing import CliRunner

ROOT: Any = get_command(app)
COMMANDS: dict[str, Any] = ROOT.commands
WIDTH = 80
WINDOWS = {"view"}
"""Commands that wait for a person, whose examples are only parsed."""


def shown(*words: str, code: int = 0, width: int = WIDTH) -> str:
    """What a command prints at the width of a common terminal."""
    result = CliRunner(env={"COLUMNS": str(width)}).invoke(app, list(words))
    assert result.exit_code == code, result.output
    return result.output


def examples(name: str) -> list[list[str]]:
    """The lines of the example in the help of a command, as words behind the program's name."""
    lines = (COMMANDS[name].epilog or "").removeprefix("Example: ").replace(" \\\n", "").splitlines()
    assert all(line.startswith("membrane-rs ") for line in lines), lines
    return [shlex.split(line)[1:] for line in lines]


def has_json(name: str) -> bool:
    """Whether a command gives its result as JSON."""
    return any("--json" in option.opts for option in COMMANDS[name].params)


def document(text: str) -> Any:
    """The one JSON document that a text is, without NaN and infinities, which JSON has not."""

    def refuse(word: str) -> None:
        raise AssertionError(f"{word} is no JSON")

    return json.loads(text, parse_constant=refuse)


@pytest.mark.parametrize("name", COMMANDS)
def test_help_of_a_command(name: str) -> None:
    text = shown(name, "--help")
    assert max(map(len, text.splitlines())) <= WIDTH
    assert not [letter for letter in text if ord(letter) >= 0x1F000], "rich takes ':100:' for a picture"
    shown_example = text[text.index("Example: membrane-rs ") :]
    assert [line.strip() for line in shown_example.splitlines() if line.strip()] == [
        line.strip() for line in COMMANDS[name].epilog.splitlines()
    ], "the terminal wraps a line of the example, so that a copy of it is another command"
    for option in COMMANDS[name].params:
        assert option.help, option.name
        assert option.help.endswith("."), option.help
    assert "<str>" not in text.partition("Options")[2], "a type of Python in place of a word"
    assert COMMANDS[name].rich_help_panel in PANELS
    assert {"verbose", "quiet"} <= {option.name for option in COMMANDS[name].params}


@pytest.mark.parametrize("name", COMMANDS)
def test_the_example_of_a_command_parses(name: str) -> None:
    for command, *words in examples(name):
        COMMANDS[command].make_context(command, words)
    assert examples(name)[-1][0] == name or COMMANDS[name].hidden


@pytest.mark.parametrize("name", COMMANDS)
def test_a_command_accepts_its_default_for_out(name: str) -> None:
    words = examples(name)[-1]
    if "--out" in words:
        at = words.index("--out")
        del words[at : at + 2]
    COMMANDS[words[0]].make_context(words[0], words[1:])


@pytest.mark.parametrize("name", [name for name in COMMANDS if not COMMANDS[name].hidden and name not in WINDOWS])
def test_the_example_of_a_command_runs(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a command that has JSON, with it: one document, and nothing beside it."""
    monkeypatch.chdir(tmp_path)
    *before, last = examples(name)
    for words in before:
        assert shown(*words)
    if not has_json(name):
        assert shown(*last)
        return
    result = CliRunner().invoke(app, [*last, "--json", "--quiet"])
    assert (result.exit_code, result.stderr) == (0, "")
    assert document(result.stdout)


def test_the_help_lists_all_commands_and_exit_codes() -> None:
    text = shown("--help")
    used = {command.rich_help_panel for command in COMMANDS.values()}
    places = [text.index(f" {panel} ─") for panel in PANELS if panel in used]
    assert places == sorted(places)
    for name, command in COMMANDS.items():
        assert (f"│ {name} " in text) != command.hidden
    assert "Exit codes: 0 success" in text


def test_units_in_brackets_are_no_markup() -> None:
    assert "[s]" in shown("run", "--help")
    assert literal("[s] [1/s] [-] [N m]") == r"\[s] [1/s] [-] \[N m]"


def test_versions() -> None:
    words = [line.split()[0] for line in shown("--version").splitlines()]
    assert words == ["membrane-rs", "python", "numpy", "platform", "instructions"]
