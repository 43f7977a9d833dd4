"""What a viewer shows of a run: which frame, coloured by what, in which frame of reference. Without a window."""

from __future__ import annotations

import sys
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import membrane_rs
import numpy as np
import pytest
from membrane_rs import Creases, Cylinder, InputError, MissingFileError, OutputError, Schedule
from membrane_rs.plotting import painter
from membrane_rs.plotting.actors import film_colors
from membrane_rs.plotting.fields import BARE, FIELDS, MISSING
from membrane_rs.plotting.viewer import viewer as module
from membrane_rs.plotting.viewer.coloring import Scale
from membrane_rs.plotting.viewer.frames import KeptFrames
from membrane_rs.plotting.viewer.keys import KEYS, key_table
from membrane_rs.plotting.viewer.pictures import save_new
from membrane_rs.plotting.viewer.viewer import FOR_CAMERA, FOR_RANGE, Viewer
from membrane_rs.plotting.viewer.window import Window
from PIL import Image
from small_scenes import hanging_strip, refused
from viewed_run import CountedFrames, with_frames

RISE = Schedule((0.0, 1.0), (0.0, 0.5))


@pytest.fixture(scope="module")
def strip() -> Any:
    """A strip of springs with a crease, which falls."""
    scene = hanging_strip()
    return membrane_rs.run(replace(scene, laws=[*scene.laws, Creases()]), until=0.04, frames=9)


@pytest.fixture(scope="module")
def tether() -> Any:
    """A cord on a hub that turns."""
    return membrane_rs.run("spinning-tether", until=0.1, frames=11)


def test_a_time_shows_the_frame_nearest_to_it(strip: Any) -> None:
    viewer = Viewer(strip)
    assert (viewer.index, viewer.time, viewer.stage) == (0, 0.0, "")
    viewer.go_to(0.0124)
    assert viewer.index == 2
    assert viewer.shown().positions == pytest.approx(np.asarray(strip.frames[2].positions))
    viewer.go_to(99.0)
    assert viewer.index == 8
    viewer.step(1)
    assert viewer.index == 8
    viewer.step(-3)
    assert viewer.index == 5
    assert viewer.words() == "0.025 s"
    viewer.step(-30)
    assert viewer.index == 0


def test_it_plays_by_the_clock_to_the_end_and_then_from_the_start(strip: Any) -> None:
    viewer = Viewer(strip)
    assert not viewer.advance(1.0)
    viewer.toggle_play()
    assert viewer.play_seconds == 4.0
    assert not viewer.advance(0.4)  # a tenth of the run, less than the distance of two frames
    assert viewer.advance(0.4)
    assert (viewer.index, viewer.is_playing) == (1, True)
    viewer.faster(1)
    assert viewer.advance(0.5)
    assert (viewer.speed, viewer.index) == (2.0, 3)
    assert viewer.advance(100.0)
    assert (viewer.index, viewer.is_playing) == (8, False)
    viewer.toggle_play()
    assert (viewer.index, viewer.is_playing) == (0, True)
    viewer.toggle_play()
    assert not viewer.is_playing
    viewer.toggle_play()
    viewer.step(1)
    assert (viewer.index, viewer.is_playing) == (1, False)
    viewer.faster(100)
    assert viewer.speed == module.SPEEDS[-1]
    viewer.faster(-100)
    assert viewer.speed == module.SPEEDS[0]


def test_the_film_has_the_colours_of_snapshots(strip: Any) -> None:
    viewer = Viewer(strip)
    shown = viewer.shown()
    assert shown.scale is None
    assert (shown.upper == film_colors(viewer.subject, back=False)).all()
    assert (shown.lower == film_colors(viewer.subject, back=True)).all()
    assert not len(shown.lines)


def test_fields_lie_on_triangles_nodes_or_lines(strip: Any) -> None:
    viewer = Viewer(strip)
    nodes, triangles = len(strip.frames[0].positions), len(strip.frames[0].triangles)
    assert viewer.colors[0] == "film"
    assert {"largest_principal_strain", "state", "crease_angle", "speed"} <= set(viewer.colors)
    assert list(viewer.labels) == viewer.colors
    for name in viewer.colors[1:]:
        viewer.choose(name)
        viewer.go_to(0.04)
        shown, field = viewer.shown(), FIELDS[name]
        assert shown.scale is not None
        assert shown.scale.field is field
        values = field.values(strip.frames[8])
        assert values is not None
        if field.place == "lines":
            has = np.isfinite(values)
            assert (shown.upper == BARE).all()
            assert (shown.lines == strip.frames[8].lines[has]).all()
            assert (shown.line_colors == shown.scale.color(values[has])).all()
        elif field.place == "nodes":
            assert len(values) == nodes
            assert np.array_equal(np.asarray(shown.node_values), values)
        else:
            assert len(shown.upper) == triangles
            assert (shown.upper == shown.scale.color(values)).all()
    creases = Viewer(strip, color="crease_angle").shown().lines
    assert 0 < len(creases) < len(strip.frames[0].lines)


def test_colours_go_round(strip: Any) -> None:
    viewer = Viewer(strip)
    seen = []
    for _ in viewer.colors:
        seen.append(viewer.color)
        viewer.next_color()
    assert (seen, viewer.color) == (viewer.colors, "film")
    viewer.next_color(-1)
    assert viewer.color == viewer.colors[-1]


def test_the_range_is_that_of_the_run_or_of_the_frame(strip: Any) -> None:
    viewer = Viewer(strip, color="speed")
    of_run, of_frames = viewer.scale(), []
    viewer.toggle_scale()
    for index in range(9):
        viewer.show_frame(index)
        of_frames.append(viewer.scale())
    assert of_run is not None
    lows, highs = zip(*[(scale.low, scale.high) for scale in of_frames if scale], strict=True)
    assert (of_run.low, of_run.high) == (min(lows), max(highs))
    assert highs[1] < highs[8]
    viewer.toggle_scale()
    assert viewer.scale() == of_run
    assert Viewer(strip, color="speed", scale="frame").scale() == of_frames[0]


def test_values_beyond_the_range_have_the_colour_of_its_end_and_none_is_grey() -> None:
    scale = Scale(FIELDS["speed"], 1.0, 3.0)
    colors = scale.color(np.array([-5.0, 1.0, 2.0, 3.0, 9.0, np.nan, np.inf]))
    assert (colors[[0, 1]] == scale.colors[0]).all()
    assert (colors[[3, 4]] == scale.colors[-1]).all()
    assert not (colors[2] == scale.colors[[0, -1]]).all(axis=1).any()
    assert tuple(colors[5]) == MISSING
    assert len(np.unique(Scale(FIELDS["speed"], 2.0, 2.0).color(np.array([2.0, 2.0])), axis=0)) == 1
    states = Scale(FIELDS["state"], 0.0, 2.0)
    assert (states.color(np.array([0.0, 1.0, 2.0])) == states.colors).all()


def test_the_camera_turns_with_the_hub_or_stands_still(tether: Any) -> None:
    viewer = Viewer(tether)
    viewer.go_to(0.1)
    assert viewer.shown().hub_angle == 0.0
    viewer.toggle_frame()
    assert viewer.shown().hub_angle == tether.frames[10].hub_angle != 0.0
    assert Viewer(tether, camera="fixed").in_turning_frame is False


def test_the_camera_sees_all_frames_or_the_shape_of_now(strip: Any) -> None:
    grown = with_frames(strip, [replace_positions(frame, 1.0 + index) for index, frame in enumerate(strip.frames)])
    viewer = Viewer(grown)
    seen = [np.abs(viewer.camera().project(np.asarray(frame.positions))[0]).max() for frame in grown.frames]
    assert 0.5 < max(seen) < 1.0
    assert viewer.closer().reach < 0.5 * viewer.camera().reach
    assert viewer.closer().view == pytest.approx(viewer.camera().view)


def test_bodies_stand_where_they_stand_at_that_time() -> None:
    bar = Cylinder("bar", 0.01, centre=(0.0, 0.2, 0.0), half_length=0.05, travel_z=RISE)
    scene = replace(hanging_strip(), bodies=[bar])
    viewer = Viewer(membrane_rs.run(scene, until=0.02, frames=3))
    first = viewer.shown().solids[0]
    viewer.step(2)
    moved = bar.solids(0.02)[0].centre - bar.solids(0.0)[0].centre
    assert viewer.shown().solids[0].centre - first.centre == pytest.approx(moved)


def test_frames_are_read_when_they_are_shown(strip: Any) -> None:
    frames = CountedFrames([strip.frames[k % 9] for k in range(1000)], np.linspace(0.0, 1.0, 1000))
    viewer = Viewer(with_frames(strip, frames))
    assert sum(frames.reads.values()) == FOR_CAMERA
    viewer.go_to(0.5)
    viewer.shown()
    viewer.shown()
    assert sum(frames.reads.values()) == FOR_CAMERA + 1
    viewer.choose("speed")
    viewer.shown()
    assert sum(frames.reads.values()) <= FOR_CAMERA + 1 + FOR_RANGE
    assert set(frames.reads.values()) == {1}


def test_what_is_kept_of_large_frames_is_bounded(strip: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("membrane_rs.plotting.viewer.frames.MOST_BYTES", 1.0)
    frames = CountedFrames(list(strip.frames), strip.frames.times)
    kept = KeptFrames(frames)
    for index in (0, 1, 0, 1, 2, 1, 0):
        assert kept[index] is frames.all[index]
    assert frames.reads == {0: 2, 1: 1, 2: 1}
    assert kept.spread(3) == [0, 4, 8]
    assert kept.spread(99) == list(range(9))


def test_wrong_words_are_refused_with_those_that_are_right(strip: Any) -> None:
    refused(lambda: Viewer(strip, color="stres"), InputError, r"color = 'stres': must be one of film, .*speed")
    refused(lambda: Viewer(strip, camera="up"), InputError, "camera = 'up': must be one of turning, fixed")
    refused(lambda: Viewer(strip, scale="all"), InputError, "scale = 'all': must be one of run, frame")
    refused(lambda: Viewer(with_frames(strip, [])), InputError, "'hanging' has no frames.*frames=")


def test_a_wrong_colour_is_told_with_the_nearest(strip: Any, tether: Any) -> None:
    refused(lambda: Viewer(strip, color="strain"), InputError, "did you mean largest_principal_strain or spring_strain")
    refused(lambda: Viewer(strip, color="sped"), InputError, "did you mean speed")
    refused(lambda: Viewer(tether, color="state"), InputError, "color = 'state': this run has no values of it; must be")


@pytest.mark.parametrize("far", [np.nan, np.inf, 1e200])
def test_frames_that_cannot_be_drawn_are_told(strip: Any, far: float) -> None:
    frames = list(strip.frames)
    bad = replace_positions(frames[3], 1.0)
    bad.positions[:] = far
    viewer = Viewer(with_frames(strip, [bad, *frames[1:3], bad, *frames[4:]]))
    refused(viewer.shown, OutputError, "frame 0 at 0 s cannot be drawn: its positions are not finite, or beyond")
    viewer.show_frame(2)
    assert np.isfinite(viewer.shown().positions).all()
    assert 0.0 < viewer.camera().reach < 10.0
    refused(
        lambda: Viewer(with_frames(strip, [bad, bad])), OutputError, "no frame of the run of 'hanging' can be drawn"
    )


def test_a_scene_without_a_membrane_is_shown(tether: Any) -> None:
    viewer = Viewer(tether, color="tension")
    shown = viewer.shown()
    assert len(shown.upper) == 0
    assert len(shown.lines) > 0


def test_pictures_replace_no_file(tmp_path: Any) -> None:
    image = np.zeros((4, 5, 3), np.uint8)
    names = [save_new(image, tmp_path, "a/b: 0.1 s").name for _ in range(3)]
    assert names == ["a-b-0.1-s.png", "a-b-0.1-s-2.png", "a-b-0.1-s-3.png"]
    refused(lambda: save_new(image, tmp_path / "none", "x"), OutputError, "none")
    assert save_new(image, tmp_path, "../..").parent == tmp_path


def test_a_picture_is_saved_where_it_is_told(strip: Any, tmp_path: Any) -> None:
    shown = strip.view(color="speed", time=0.021, where="picture")
    assert repr(shown) == "<view of hanging at 0.020 s, coloured by speed>"
    assert "data:image/png;base64,iVBOR" in shown._repr_html_()
    path = shown.save(tmp_path / "picture.png")
    with Image.open(path) as picture:
        assert picture.size == (960, 600)
    refused(lambda: shown.save(path), OutputError, "picture.png: is there already")
    refused(lambda: shown.save(tmp_path / "none" / "a.png"), OutputError, "none")
    refused(lambda: shown.save(tmp_path / "a.jpg"), InputError, r"a\.jpg: a picture is PNG, .* image/jpeg; .* \.png")
    refused(lambda: strip.view(time=float("nan"), where="picture"), InputError, "time = nan: must be finite")
    refused(lambda: strip.view(where="wall"), InputError, "where = 'wall': must be one of window, notebook, browser")


def test_where_pyvista_fails_the_picture_is_by_matplotlib(strip: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("membrane_rs.plotting.viewer.notebook.pyvista_works", lambda: False)
    without = type(painter._pyvista)()
    without.works = False
    monkeypatch.setattr(painter, "_pyvista", without)
    shown = strip.view(where="notebook")
    assert shown.page is None
    assert "for want of OpenGL" in shown._repr_html_()


def test_without_trame_a_notebook_has_a_picture_and_a_hint(strip: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "trame", None)
    shown = strip.view(where="notebook")
    assert shown.page is None
    assert 'pip install "membrane_rs[view]"' in shown._repr_html_()


def test_a_folder_or_a_scene_is_viewed(strip: Any, tmp_path: Any) -> None:
    membrane_rs.run(strip.scene, until=0.01, frames=3, out=tmp_path / "run", pictures=False)
    again = membrane_rs.view(str(tmp_path / "run"), time=1.0, where="picture")
    assert again is not None
    assert again.viewer.time == 0.01
    start = membrane_rs.view("spinning-tether", where="picture")
    assert start is not None
    assert (len(start.viewer.times), start.viewer.time) == (1, 0.0)
    staged = membrane_rs.view("okuizumi-stage-1", where="picture")
    assert staged is not None
    assert staged.viewer.subject.has_hub
    refused(lambda: membrane_rs.view(tmp_path, where="picture"), MissingFileError, "summary.json")


def test_every_key_has_what_it_does() -> None:
    symbols = [symbol for key in KEYS for symbol in key.symbols]
    assert len(set(symbols)) == len(symbols)
    for key in KEYS:
        assert callable(getattr(Window, key.action))
        assert f"  {key.words}" in key_table()


def replace_positions(frame: Any, factor: float) -> Any:
    """The same frame with a larger shape."""
    names = ("time", "hub_angle", "triangles", "lines", "on_nodes", "on_triangles", "on_lines")
    rest = {name: getattr(frame, name) for name in names}
    return SimpleNamespace(positions=factor * np.asarray(frame.positions), **rest)
