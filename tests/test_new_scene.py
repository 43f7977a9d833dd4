"""`membrane-rs new`: commented scene files of one's own."""

from __future__ import annotations

import json
import os
import re
import shlex
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from membrane_rs import Fixed, Scene, scenes
from membrane_rs.cli import app
from membrane_rs.cli.new import SCHEMA_FILE
from membrane_rs.scene.commented import with_comments
from small_scenes import RUBBER, hanging_strip, patch
from test_cli import call
from typer.testing import CliRunner

STRIP = Path(__file__).parents[1] / "examples" / "strip_round_post.toml"


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def comments(text: str) -> list[str]:
    return re.findall(r"#[ \t]*(?:was [^:#\n]*: )?(.*)", text)


@pytest.mark.parametrize("name", scenes.names())
def test_a_copy_of_a_built_in_scene(name: str, folder: Path) -> None:
    code, shown = call("new", "mine", "--from", name)
    assert (code, f"Wrote mine.toml, from {name}" in shown, "membrane-rs run mine.toml" in shown) == (0, True, True)
    text = (folder / "mine.toml").read_text()
    lines = text.splitlines()
    assert lines[:3] == [f"#:schema ./{SCHEMA_FILE}", f"# Made from {name}.", "#"]
    assert comments(scenes.text(name)) == comments(text)[3:]
    for words in (["-q", "new", "quiet"], ["new", "quiet-too", "--quiet"]):
        assert "Numbers are in SI units" not in call(*words, "--from", name)[1]
    assert Scene.from_toml("mine.toml").to_toml() == replace(scenes.load(name), name="mine").to_toml()


def test_values_are_set_in_their_lines_and_their_comments_kept(folder: Path) -> None:
    values = {
        "laws.spin.frequency": "25 rpm",
        "laws.air_drag": "false",
        "laws.mass_damping.rate": "3 1/s",
        "mesh.rows": "8",
        "mesh.fold_lines": "3",
        "parts.1.segments": "5",
        "run.dt": "2us",
        "laws.creases.collapse": "0.1",
    }
    words = [word for key, value in values.items() for word in ("--set", f"{key}={value}")]
    assert call("new", "mine", *words)[0] == 0
    text = (folder / "mine.toml").read_text()
    for line in (
        "rows = 8",
        "fold_lines = 3  # was 7: Table 1: a crease every 22 mm",
        f"frequency = {25 / 60!r}  # was 3.0: Hz, Table 2; held constant, as the experiment's motor does",
        "segments = 5  # was 19: follows from the counts of Table 2",
        "dt = 2e-06",
        "[laws.mass_damping]\nrate = 3.0",
        "                            # without it the force grows without bound as a triangle collapses to a line",
    ):
        assert f"{line}\n" in text, line
    assert "air_drag" not in text
    wanted = scenes.load("okuizumi-model-1").with_values(
        {
            "name": "mine",
            "laws.spin.frequency": 25 / 60,
            "laws.air_drag": False,
            "laws.mass_damping.rate": 3.0,
            "mesh.rows": 8,
            "mesh.fold_lines": 3,
            "parts.1.segments": 5,
            "run.dt": 2e-6,
            "laws.creases.collapse": 0.1,
        }
    )
    assert Scene.from_toml("mine.toml").to_toml() == wanted.to_toml()


def test_stages_bodies_and_values_taken_away(folder: Path) -> None:
    values = ["stages.pull.duration=0.2", "bodies.roller.radius=6 mm", "stages.1.set.run.dt=1e-5", "name=other"]
    words = [word for value in values[:3] for word in ("--set", value)]
    assert call("new", "mine.toml", "--from", STRIP, *words)[0] == 0
    text = (folder / "mine.toml").read_text()
    assert "duration = 0.2  # was 0.5: s, at the most\n" in text
    assert "radius = 0.006  # was 0.005\n" in text
    assert len(comments(text)) >= len(comments(STRIP.read_text()))
    made = Scene.from_toml("mine.toml")
    assert (made.name, made.stages[0].duration, made.stages[1].set["run.dt"]) == ("mine", 0.2, 1e-5)
    code, shown = call("new", "again", "--from", "mine.toml", "--set", values[3])
    assert code == 0, shown
    assert (folder / "again.toml").read_text().count("#:schema") == 1
    assert Scene.from_toml("again.toml").name == "again"


def test_json_names_the_file() -> None:
    result = CliRunner().invoke(app, ["new", "mine", "--from", "spinning-tether", "--json"])
    assert json.loads(result.stdout) == {"file": "mine.toml", "source": "spinning-tether"}


def test_a_file_in_another_style_is_written_anew(folder: Path) -> None:
    text = hanging_strip().to_toml().replace("[laws.springs]\n", "[laws]\nsprings = {} # a remark\n[laws.springs_]\n")
    text = re.sub(r"\[laws.springs_\]\n(.+\n)+", "", text)
    (folder / "odd.toml").write_text(text)
    before = Scene.from_toml("odd.toml")
    assert before.to_toml() == hanging_strip().to_toml()
    after = before.with_values({"laws.springs.buckling": 3.0})
    made, kept = with_comments(text, before, after, folder / "new.toml")
    assert (made, kept) == (after.to_toml(), False)
    code, shown = call("new", "mine", "--from", "odd.toml", "--set", "laws.springs.buckling=3")
    assert (code, "The comments of odd.toml are left out" in " ".join(shown.split())) == (0, True)
    assert Scene.from_toml("mine.toml").value("laws.springs.buckling") == 3.0


def test_nothing_is_replaced(folder: Path) -> None:
    (folder / "mine.toml").write_text("# precious\n")
    (folder / SCHEMA_FILE).write_text("{}")
    code, shown = call("new", "mine")
    assert (code, "mine.toml: is there already, and is not replaced" in shown) == (2, True)
    (folder / "link.toml").symlink_to("nowhere")
    assert call("new", "link")[0] == 2
    code, shown = call("new", "other", "--from", "spinning-tether")
    assert (code, f"{SCHEMA_FILE} is there already, and is left as it is" in " ".join(shown.split())) == (0, True)
    assert (folder / "mine.toml").read_text() == "# precious\n"
    assert (folder / SCHEMA_FILE).read_text() == "{}"
    code, shown = call("new", "third", "--from", "spinning-tether", "--no-schema")
    assert (code, (folder / "third.toml").read_text().startswith("# Made from spinning-tether.")) == (0, True)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["", "--from", "spinning-tether"], "must be the name of a file"),
        (["a/b"], "its folder a: there is none; make it first"),
        ([f"{__file__}/b"], "is no folder; choose one"),
        (["a/"], "names no file; write one such as a/my-sail"),
        ([".toml"], "names no file; write one such as my-sail"),
        (["com1.toml"], "is a device of Windows"),
        (["x" * 300], "is too long for a name of a file"),
        (["\u65e5" * 80], "must be at most 200 bytes"),
        (["a\nb"], "must be at most 200 bytes that can be printed"),
        (["x" * 101], "must be 1 to 100 characters"),
        (["mine", "--from", "okuizumi-model-3"], "is not built in; did you mean 'okuizumi-model-"),
        (["mine", "--from", "none.toml"], "there is no such scene file"),
        (["mine", "--from", "x" * 300 + ".toml"], "is too long for a name of a file"),
        (["mine", "--set", "laws.spin.frequency=3 m"], "is a length; must be a frequency"),
        (["mine", "--set", "laws.spin.frequenzy=3"], "did you mean 'laws.spin.frequency'"),
        (["mine", "--set", "x"], "must be KEY=VALUE"),
    ],
)
def test_wrong_words_write_nothing(words: list[str], said: str, folder: Path) -> None:
    code, shown = call("new", *words)
    assert (code, said in " ".join(shown.split())) == (2, True), shown
    assert list(folder.iterdir()) == []


def test_a_mesh_of_ones_own_stays_where_it_is(folder: Path) -> None:
    scene = Scene(patch(), RUBBER, hanging_strip().laws, [Fixed((0,))], name="own")
    scene.save(folder / "own")
    code, shown = call("new", "mine", "--from", "own/scene.toml")
    assert (code, "its mesh is in a file beside it; write NAME into that folder" in " ".join(shown.split())) == (
        2,
        True,
    )
    assert call("new", "own/mine", "--from", "own/scene.toml")[0] == 0
    made: Any = Scene.from_toml(folder / "own" / "mine.toml").mesh
    assert made.node_count == 4


@pytest.mark.skipif(os.name == "nt" or os.geteuid() == 0, reason="root writes anywhere")
def test_a_folder_that_cannot_be_written(folder: Path) -> None:
    folder.chmod(0o500)
    try:
        assert call("new", "mine", "--from", "spinning-tether")[0] == 1
    finally:
        folder.chmod(0o700)


def test_a_table_whose_heading_is_not_found_is_left_out_all_the_same(folder: Path) -> None:
    text = scenes.text("okuizumi-model-1").replace("[laws.air_drag]", "[ laws.air_drag ]")
    (folder / "odd.toml").write_text(text)
    code, shown = call("new", "mine", "--from", "odd.toml", "--set", "laws.air_drag=false")
    assert (code, "The comments of odd.toml are left out" in " ".join(shown.split())) == (0, True)
    assert "air_drag" not in (folder / "mine.toml").read_text()


@pytest.mark.skipif(os.name == "nt", reason="the shell of POSIX, and names that Windows refuses")
@pytest.mark.parametrize("name", ["-x", "a b", "a;b$(c)'", "plain"])
def test_the_commands_of_a_hint_are_those_of_a_shell(name: str, folder: Path) -> None:
    code, shown = call("new", "--from", "spinning-tether", "--", name)
    assert code == 0, shown
    (line,) = (line for line in shown.splitlines() if line.startswith("  membrane-rs check "))
    _, _, word = shlex.split(line, comments=True)
    assert (folder / word).samefile(folder / f"{name}.toml")
    assert call("check", word, "--until", "1e-4")[0] == 0


@pytest.mark.skipif(not Path("/proc/self").is_dir(), reason="a folder of Linux where nobody writes")
def test_a_folder_that_takes_no_files() -> None:
    code, shown = call("new", "/proc/mine", "--from", "spinning-tether", "--no-schema")
    assert (code, shown.count("\n")) == (1, 1)
    assert shown.startswith("Error: cannot write /proc/mine.toml: ")


@pytest.mark.skipif(os.name == "nt", reason="limits of POSIX")
def test_a_full_disk_leaves_nothing(folder: Path) -> None:
    words = (
        "import resource, sys; resource.setrlimit(resource.RLIMIT_FSIZE, (99, 99)); from membrane_rs.cli import main"
    )
    words += "; sys.argv = ['membrane-rs', 'new', 'mine', '--no-schema']; main()"
    done = subprocess.run([sys.executable, "-c", words], capture_output=True, text=True, check=False, timeout=300)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (1, "", 1)
    assert "cannot write mine.toml: File too large; choose a folder" in done.stderr
    assert list(folder.iterdir()) == []
