"""The window of the viewer on a display: what a user does, and what is then seen."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import membrane_rs
import numpy as np
import pytest
from child_processes import SECONDS, started, wait_until
from displays import display
from membrane_rs.cli import app
from membrane_rs.errors import MissingFileError
from PIL import Image
from typer.testing import CliRunner

TESTS = Path(__file__).parent


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("window")


@pytest.fixture(scope="module")
def screen() -> Iterator[str]:
    with display() as name:
        yield name


@pytest.fixture(scope="module")
def found(folder: Path, screen: str) -> dict[str, Any]:
    """What a session in a process of its own has found; it ends without a crash."""
    command = [sys.executable, str(TESTS / "viewer_session.py"), str(folder)]
    done = subprocess.run(
        command,
        check=False,
        capture_output=True,
        text=True,
        timeout=300,
        cwd=folder,
        env={**os.environ, "DISPLAY": screen},
    )
    assert done.returncode == 0, done.stderr
    facts: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return facts


def test_a_window_opens_and_closes(found: dict[str, Any]) -> None:
    assert found["window"] not in ("vtkEGLRenderWindow", "vtkOSOpenGLRenderWindow")
    assert found["colours_of_the_picture"] > 20
    assert found["closed"]


def test_the_slider_moves_the_shape(found: dict[str, Any]) -> None:
    assert found["slid_to"] == pytest.approx([0.12, 0.12])
    assert found["slider_moved_the_shape"] > 0.005


def test_the_mouse_turns_the_picture_and_a_key_turns_it_back(found: dict[str, Any]) -> None:
    assert found["mouse_turned"] > 0.01
    assert found["v_turned_back"] < 1e-9


def test_colours_are_chosen_by_keys_and_in_the_list(found: dict[str, Any]) -> None:
    assert found["c"] == "largest_principal_stress"
    assert found["c_changed"] > 0.005
    assert (found["C"], found["C_left"]) == ("film", 0.0)
    assert found["pressed_colour"] == "speed"


def test_each_key_does_what_the_list_says(found: dict[str, Any]) -> None:
    switched = {key: found[key] for key in ("r", "t", "h")}
    assert switched == {"r": False, "t": False, "h": True}
    assert [found[key] for key in ("Home", "Right", "End", "Left")] == [0, 1, 24, 23]
    assert [found[key] for key in ("plus", "minus")] == [2.0, 1.0]
    assert found["keys_of_vtk_changed"] == 0.0


def test_it_plays_to_the_end(found: dict[str, Any]) -> None:
    assert found["played_to"] == 24
    assert found["button_plays"]
    assert found["stopped"]


def test_pictures_are_saved_without_controls_and_never_replaced(found: dict[str, Any], folder: Path) -> None:
    first, second = (np.asarray(Image.open(folder / f"strip-0.005-s{end}.png")) for end in ("", "-2"))
    assert first.shape == (1720, 2400, 3)
    assert (first == second).all()
    assert (first[-160:, 700:] == 255).all()  # white where the window has its slider
    assert found["message"].startswith("saved ")
    assert found["message"].endswith("strip-0.005-s-2.png")


def test_the_command_opens_a_window_of_a_scene(screen: str, tmp_path: Path) -> None:
    code = (
        "from membrane_rs.plotting.viewer.window import Window\n"
        "Window._tick = lambda self, *_: self.close()\n"
        "from membrane_rs.cli import app\n"
        "app(['view', 'spinning-tether', '--color', 'tension', '--camera', 'fixed'])"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], check=False, capture_output=True, text=True, timeout=300, cwd=tmp_path,
        env={**os.environ, "DISPLAY": screen},
    )  # fmt: skip
    assert (done.returncode, done.stdout) == (0, ""), done.stderr


def test_the_command_saves_a_picture_of_a_run_or_a_scene(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)

    def view(*words: str) -> Any:
        return CliRunner().invoke(app, ["view", "--picture", "a.png", *words], env={"COLUMNS": "200"})

    assert view("spinning-tether", "--set", "parts.0.segments=4", "--color", "tension").exit_code == 0
    assert Image.open("a.png").size == (960, 600)
    again = view("spinning-tether")
    assert (again.exit_code, "a.png: is there already" in again.stderr) == (1, True)
    Path("a.png").unlink()
    membrane_rs.run("spinning-tether", 0.01, frames=3, out="run", pictures=False)
    assert view("run", "--time", "0.004").exit_code == 0
    Path("a.png").unlink()
    assert view("run/summary.json", "--time", "0.004").exit_code == 0
    Path("a.png").unlink()
    for words, error in (
        (("nowhere/summary.json",), "no summary at nowhere; name a run's folder"),
        (("run/summary.json", "--set", "parts.0.segments=4"), "run/summary.json is a run"),
        (("run", "--set", "parts.0.segments=4"), "--set parts.0.segments=4: run is a run"),
        (("run", "--color", "blue"), "color = 'blue': must be one of film, "),
        (("ru",), "'ru': is neither the folder of a run nor a scene; did you mean 'run'?"),
        (("runs/nothing",), "'runs/nothing': is neither the folder of a run nor a scene"),
        (("run", "--time", "nan"), "time = nan: must be finite"),
        (("run", "--picture", "a.jpg"), "a.jpg: a picture is PNG, and this name says image/jpeg"),
        (("run", "--browser"), "--picture and --browser: a picture is saved, or a page served"),
    ):
        refused = view(*words)
        assert (refused.exit_code, error in refused.stderr) == (2, True), refused.stderr
    assert not Path("a.png").exists()


@pytest.mark.filterwarnings("ignore:.*frames are not there")
def test_a_frame_that_a_run_has_lost_is_named_with_what_to_do(tmp_path: Path) -> None:
    membrane_rs.run("spinning-tether", 0.01, frames=3, out=tmp_path, pictures=False)
    (tmp_path / "frames/frame-0001.vtu").unlink()
    with pytest.raises(MissingFileError, match=r"frame-0001.vtu; .* put it back, or run the scene again"):
        membrane_rs.view(tmp_path, where="picture")


def test_real_keys_save_a_picture_and_close_the_window(screen: str, tmp_path: Path) -> None:
    program = shutil.which("xdotool")
    if program is None:
        pytest.skip("xdotool is not installed")
    membrane_rs.run("spinning-tether", 0.01, frames=3, out=tmp_path / "run", pictures=False)
    environment = {**os.environ, "DISPLAY": screen}
    command = [sys.executable, "-m", "membrane_rs", "view", "run/summary.json"]
    with started(command, cwd=tmp_path, env=environment) as window:
        found = [program, "search", "--sync", "--name", "membrane_rs: spinning-tether"]
        subprocess.run(found, check=True, env=environment, timeout=SECONDS, stdout=subprocess.DEVNULL)

        def saved(key: str, end: str) -> bool:
            subprocess.run([program, "key", key, "p"], check=True, env=environment)
            time.sleep(0.5)
            return (tmp_path / f"spinning-tether-{end}").exists()

        # A window that is new may take no keys yet.
        wait_until(lambda: saved("Home", "0.000-s.png"), "a picture of the start is saved", window)
        for end in ("0.005-s.png", "0.010-s.png"):
            saved("Right", end)
            wait_until((tmp_path / f"spinning-tether-{end}").exists, f"a picture ends in {end}", window)
        subprocess.run([program, "key", "q"], check=True, env=environment)
        assert window.wait(SECONDS) == 0


def test_without_a_display_the_error_says_what_to_do(tmp_path: Path) -> None:
    environment = {key: value for key, value in os.environ.items() if key not in ("DISPLAY", "WAYLAND_DISPLAY")}
    if sys.platform in ("win32", "darwin"):
        pytest.skip("there is always a display here")
    for wrong in ({}, {"DISPLAY": ":987"}):
        done = subprocess.run(
            [sys.executable, "-m", "membrane_rs", "view", "spinning-tether"], check=False, capture_output=True,
            text=True, timeout=300, cwd=tmp_path, env=environment | wrong,
        )  # fmt: skip
        assert done.returncode == 1
        for words in (
            "no display",
            "--picture FILE",
            "--browser",
            "membrane-rs report RUN",
            "run.view() in a notebook",
            "ssh -X",
        ):
            assert words in done.stderr
        assert len(done.stderr.splitlines()) == 1
