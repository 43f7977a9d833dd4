"""Folders of runs that lack something, or hold what no run wrote: file, place and remedy, in bounded memory."""

from __future__ import annotations

import copy
import os
import pickle
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
from membrane_rs import MembraneError, MissingFileError, OutputError, open_run, run
from membrane_rs.results import read_history

HISTORY = "history.csv"


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a run."""
    folder = tmp_path_factory.mktemp("made") / "run"
    run("single-crease", 2e-3, frames=3, samples=5, out=folder, pictures=False, record=["largest_speed"])
    return folder


@pytest.fixture
def folder(made: Path, tmp_path: Path) -> Path:
    """A copy of it to damage."""
    return Path(shutil.copytree(made, tmp_path / "run"))


def test_a_finished_run_without_its_history_is_no_empty_one(folder: Path) -> None:
    (folder / HISTORY).unlink()
    with pytest.raises(MissingFileError, match=r"no history at .*history.csv, though summary.json says: 5 samples"):
        open_run(folder)


@pytest.mark.parametrize(
    ("damage", "words", "frames"),
    [
        (lambda folder: (folder / "frames.pvd").unlink(), r"frames.pvd: is not there.* summary.json says 3", 0),
        (lambda folder: shutil.rmtree(folder / "frames"), r"3 of its 3 frames are not there, the first .*0000.vtu", 3),
        (lambda folder: (folder / "frames/frame-0001.vtu").unlink(), r"1 of its 3 frames are not there", 3),
    ],
)
def test_frames_that_are_missing_are_told(
    damage: Callable[[Path], None], words: str, frames: int, folder: Path
) -> None:
    damage(folder)
    with pytest.warns(UserWarning, match=words):
        opened = open_run(folder)
    assert (len(opened.frames), opened.history.sample_count) == (frames, 5)


def test_samples_that_are_missing_are_told(folder: Path) -> None:
    lines = (folder / HISTORY).read_text().splitlines(keepends=True)
    (folder / HISTORY).write_text("".join(lines[:3]))
    with pytest.warns(UserWarning, match=r"history.csv: has 2 samples, and summary.json says 5; the run is not whole"):
        opened = open_run(folder)
    assert opened.history.sample_count == 2


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("\n0.001,", "\n0.001,3,", "line 4 has 19 values for 18 columns"),
        ("\n0.001,", "\n\n0.001,", "line 4 has 0 values for 18 columns"),
        ("\n0.001,", "\none,", "line 4 has 'one' in the column 'time', which is no number"),
        ("\n0.001,", "\nNaN,", "line 4 has the time nan s after 0.0005; times must be finite and go on"),
        ("\n0.001,", "\n0.0005,", "line 4 has the time 0.0005 s after 0.0005"),
        ("\n0.001,", "\n1e308,", "line 5 has the time 0.0015 s after 1e\\+308"),
        ("\n0.001,", "\n" + "1," * 10**6, "line 4 has more than 1048576 characters"),
        ("\n0.001,", '\n"0.001,', "line 6 has 1 value for 18 columns"),
        ("hub_torque", "hub_force", "has the column 'hub_force' twice"),
        ("largest_speed", "speed", "lacks the column 'largest_speed', which summary.json says was recorded"),
        ("hub_angle", "angle", "does not begin with the columns"),
    ],
)
def test_a_line_that_is_no_sample_is_named(old: str, new: str, words: str, folder: Path) -> None:
    text = (folder / HISTORY).read_text()
    (folder / HISTORY).write_text(text.replace(old, new, 1))
    with pytest.raises(OutputError, match=rf"history\.csv:? .*{words}.*(run the scene again|no sample|history.csv\?)"):
        open_run(folder)


def in_utf_16(folder: Path) -> None:
    (folder / HISTORY).write_bytes((folder / HISTORY).read_text().encode("utf-16"))


def pipe(folder: Path) -> None:
    (folder / HISTORY).unlink()
    os.mkfifo(folder / HISTORY)


def link_to_itself(folder: Path) -> None:
    (folder / "frames.pvd").unlink()
    (folder / "frames.pvd").symlink_to("frames.pvd")


@pytest.mark.parametrize(
    ("damage", "words"),
    [
        (in_utf_16, r"history.csv is no text in UTF-8: it holds the byte 0xff; run the scene again"),
        (pipe, r"history.csv"),
        (link_to_itself, r"frames.pvd"),
        (lambda folder: os.truncate(folder / "frames.pvd", 2**30), r"frames.pvd .*1073741824 bytes, and at most"),
        (lambda folder: os.truncate(folder / HISTORY, 2**30), r"history.csv: line 7 has more than"),
    ],
)
def test_what_no_run_wrote_is_refused(damage: Callable[[Path], None], words: str, folder: Path) -> None:
    damage(folder)
    with pytest.raises(MembraneError, match=words):
        open_run(folder)


def test_a_pipe_is_no_history_of_a_run_that_was_killed_at_its_start(folder: Path) -> None:
    (folder / "summary.json").write_text('{"outcome": "running"}')
    pipe(folder)
    with pytest.raises(MembraneError, match=r"history\.csv"):
        open_run(folder)


@pytest.mark.parametrize("change", [lambda data: b"\xef\xbb\xbf" + data, lambda data: data.replace(b"\n", b"\r\n")])
def test_what_editors_add_to_a_text_changes_nothing(change: Callable[[bytes], bytes], folder: Path) -> None:
    before = read_history(folder)
    (folder / HISTORY).write_bytes(change((folder / HISTORY).read_bytes()))
    after = open_run(folder).history
    assert {name: column.tolist() for name, column in after.items()} == {
        name: column.tolist() for name, column in before.items()
    }


def test_more_numbers_than_fit_are_not_read(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("membrane_rs.results.csv_lines.MOST_NUMBERS", 5 * 18)
    open_run(folder)
    monkeypatch.setattr("membrane_rs.results.csv_lines.MOST_NUMBERS", 5 * 18 - 1)
    with pytest.raises(OutputError, match="has more than 89 numbers"):
        open_run(folder)


def test_a_frame_that_is_no_frame_says_so_in_words(folder: Path) -> None:
    file = folder / "frames/frame-0001.vtu"
    for size, words in ((2, "its content cannot be read"), (2**30, "1073741824 bytes, and at most")):
        file.write_bytes(b"no")
        os.truncate(file, size)
        with pytest.raises(OutputError, match=rf"frame-0001.vtu .*{words}"):
            open_run(folder).frames[1]


def test_a_field_that_is_not_there_is_named_with_those_that_are(made: Path) -> None:
    frame = open_run(made).frames[0]
    kept = run("single-crease", 1e-3, frames=2, samples=2).frames[0]
    for one in (frame, kept, pickle.loads(pickle.dumps(frame)), copy.deepcopy(kept)):
        for table, name, words in (
            (one.on_lines, "foo", r"on_lines\['foo'\]: no such field; known are: buckled, crease_angle, spring_strain"),
            (one.on_lines, "spring_strin", "did you mean 'spring_strain'"),
            (one.on_lines, "von_mises", r"it is a field on triangles: frame.on_triangles\['von_mises'\]"),
            (one.on_lines, "tension", "this run has none, but spring_strain, crease_angle, buckled"),
            (one.on_nodes, 3, r"on_nodes\[3\]: no such field; known are: displacement, velocity"),
        ):
            with pytest.raises(KeyError, match=words) as caught:
                table[name]  # type: ignore[index]
            assert isinstance(caught.value, MembraneError)
            assert name not in table
