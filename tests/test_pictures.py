"""Pictures for their kind of scene: camera, scale bar, snapshots of short runs, figures by the ending of their name."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fake_simulation import FakeSimulation
from membrane_rs import InputError, Scene, Simulation, scenes
from membrane_rs.folding import Disc, Strip
from membrane_rs.plotting import plot_deployment
from membrane_rs.plotting.camera import Camera, bar_length, direction_of
from membrane_rs.plotting.matplotlib import MatplotlibPainter
from membrane_rs.plotting.painter import ProcessPainter, pyvista_works
from membrane_rs.plotting.picture import CREASE, Subject
from membrane_rs.plotting.sheets import contact_sheet
from membrane_rs.results import read_history
from membrane_rs.results.features import curve_features
from PIL import Image

PAINTERS = [MatplotlibPainter, *([ProcessPainter] if pyvista_works() else [])]
OBLIQUE = np.array((0.0, -0.7, 1.0)) / math.hypot(0.7, 1.0)


def dark(image: Any, limit: int = 110) -> np.ndarray[Any, np.dtype[np.bool_]]:
    """Pixels as dark as fold lines."""
    return np.asarray(image.max(axis=2) < limit)


@pytest.mark.parametrize("about_axis", [False, True])
def test_what_lies_in_a_plane_is_seen_from_straight_above_it(about_axis: bool) -> None:
    mesh = Disc(0.1, 4).mesh()
    for normal in ((0.0, 0.0, 1.0), (0.6, 0.0, 0.8)):
        side = np.array((normal[2], 0.0, -normal[0]))
        shape = mesh.reference[:, :1] * side + mesh.reference[:, 1:2] * [0.0, 1.0, 0.0]
        view, up = direction_of([shape], mesh.triangles, about_axis=about_axis)
        assert view == pytest.approx(np.array(normal))
        assert view @ up == pytest.approx(0.0, abs=1e-12)
        camera = Camera.of([shape], mesh.triangles, about_axis=about_axis)
        place, _ = camera.project(shape)
        assert np.ptp(place, axis=0) == pytest.approx([1.88, 1.88], abs=0.03)


def test_a_hanging_strip_is_not_seen_edge_on() -> None:
    mesh = Strip(0.2, 0.03, 10, 2).mesh()
    x, y, _ = mesh.reference.T
    shapes = []
    for degrees in (60.0, 90.0, 110.0):
        angle = math.radians(degrees)
        shapes.append(np.stack([x * math.cos(angle), y, -x * math.sin(angle)], axis=1))
    view, _ = direction_of(shapes, mesh.triangles, about_axis=False)
    shown = []
    for shape in shapes:
        a, b, c = (shape[mesh.triangles[:, k]] for k in range(3))
        normal = np.cross(b - a, c - a)[0]
        shown.append(abs(normal @ view) / np.linalg.norm(normal))
    assert min(shown) > 0.3
    assert np.mean(shown) > np.mean([abs(OBLIQUE[2] * math.cos(math.radians(d))) for d in (60, 90, 110)]) + 0.2


def test_a_folded_sail_is_seen_obliquely() -> None:
    sim: Any = FakeSimulation()
    assert Subject.of(sim, [sim.positions]).camera.view == pytest.approx(OBLIQUE)


@pytest.mark.parametrize("name", scenes.names())
def test_all_of_a_scene_is_seen(name: str) -> None:
    sim = Simulation(scenes.load(name))
    subject = Subject.of(sim, [sim.positions])
    # A roll is small in the picture that shows the sail which comes of it as well.
    shapes = [sim.positions, *([sim.assembly.reference] if subject.has_hub else [])]
    largest = [float(np.abs(subject.camera.project(shape)[0]).max()) for shape in shapes]
    assert 0.3 < max(largest) < 1.0


@pytest.mark.parametrize(("most", "length"), [(0.137, 0.1), (0.2, 0.2), (0.0499, 0.02), (7.0, 5.0), (1.1e-6, 1e-6)])
def test_lengths_of_the_scale_bar(most: float, length: float) -> None:
    assert bar_length(most) == pytest.approx(length)


@pytest.mark.parametrize("painter", PAINTERS)
def test_the_scale_bar_is_as_long_as_it_says(painter: type[Any]) -> None:
    # A square of 50 mm beside it, in the plane of the centre, seen from above.
    mesh = Strip(0.05, 0.05, 1, 1).mesh()
    sim: Any = FakeSimulation(Scene(mesh, scenes.load("hanging-strip").material))
    size = 400
    subject = Subject.of(sim, [mesh.reference, mesh.reference * 3.0])
    image = painter(subject, size).paint(mesh.reference)
    length = bar_length(0.6 * subject.camera.half_width)
    bar = np.flatnonzero(dark(image[round(0.955 * size) : round(0.96 * size) + 1]).any(axis=0))
    film = np.flatnonzero((image.min(axis=2) < 200)[: round(0.85 * size)].any(axis=0))
    assert (bar[-1] - bar[0]) / (film[-1] - film[0]) == pytest.approx(length / 0.05, rel=0.04)


@pytest.mark.parametrize("painter", PAINTERS)
def test_fold_lines_edges_and_the_mark_of_the_hub_are_drawn(painter: type[Any]) -> None:
    sim: Any = FakeSimulation()
    subject = Subject.of(sim, [sim.positions])
    flat = sim.assembly.reference
    whole = painter(subject, 400).paint(flat)
    for what in ({"creases": subject.creases[:0]}, {"spool": None}):
        other = painter(Subject(**{**vars(subject), **what}), 400).paint(flat)
        assert (dark(whole).sum() - dark(other).sum()) > 40, what
    # Lines of creases where the film is flat, seen along most of their length.
    place, _ = subject.camera.project(flat[subject.creases].mean(axis=1))
    column, row = np.round((place * [1, -1] + 1) / 2 * 400).astype(int).T
    near = [whole[r - 2 : r + 3, c - 2 : c + 3].max(axis=2).min() for r, c in zip(row, column, strict=True)]
    assert np.mean(np.array(near) < 255 * max(CREASE) + 70) > 0.7
    assert subject.has_edges


def test_a_title_fits_into_the_sheet() -> None:
    image = np.full((70, 70, 3), 255, dtype=np.uint8)
    for title in ("okuizumi-model-1, turning frame", "a title that is longer than one picture is wide, by far"):
        sheet = contact_sheet([image], [""], title)
        assert (sheet[:56, :4] == 255).all()
        assert (sheet[:56, -4:] == 255).all()
        assert (sheet[:56] < 100).any()


def pictures_of(tmp_path: Path, name: str, until: float, frames: int | Sequence[float]) -> set[str]:
    """Snapshots of a short run."""
    scene = scenes.load(name)
    scene = replace(scene, run=replace(scene.run, samples=11))
    Simulation(scene, "leapfrog").run(until, frames=frames, out=tmp_path / "run")
    return {file.name for file in (tmp_path / "run" / "snapshots").iterdir()}


def test_a_short_run_has_snapshots_of_its_own(tmp_path: Path) -> None:
    names = pictures_of(tmp_path, "spinning-tether", 0.02, 11)
    times = [f"{time:.3f}" for time in (0.0, 0.004, 0.008, 0.012, 0.016, 0.02)]
    assert names == {f"{view}{end}.png" for view in ("turning", "fixed") for end in ("", *(f"-{t}s" for t in times))}
    with Image.open(tmp_path / "run" / "snapshots" / "turning.png") as sheet:
        assert sheet.size[0] == 3 * 360


def test_without_a_hub_there_is_one_view_and_no_phase(tmp_path: Path) -> None:
    names = pictures_of(tmp_path, "hanging-strip", 0.02, 6)
    assert len(names) == 7
    assert all(name.startswith("fixed") for name in names)
    with Image.open(tmp_path / "run" / "deployment.png") as picture:
        assert picture.size[0] > 1.8 * picture.size[1]
    assert curve_features(read_history(tmp_path / "run"))["zero_crossing_time"] is None


def table(phase: float, hub: float) -> dict[str, Any]:
    time = np.linspace(0.0, 1.0, 50)
    return {
        "time": time, "deployment_rate": 0.5 + 0.1 * time, "phase_difference_deg": phase * np.sin(9.0 * time),
        "hub_angle": hub * time,
    }  # fmt: skip


@pytest.mark.parametrize(("phase", "hub", "panels"), [(5.0, 3.0, 2), (1e-12, 3.0, 1), (5.0, 0.0, 1), (0.0, 3.0, 1)])
def test_no_curve_of_rounding(tmp_path: Path, phase: float, hub: float, panels: int) -> None:
    plot_deployment(table(phase, hub), tmp_path / "one.png", dpi=100)
    with Image.open(tmp_path / "one.png") as picture:
        assert picture.size == pytest.approx((700, 100 * (0.4 + 3.0 * panels)), abs=1)  # in whole pixels
    if phase < 1e-6:
        assert curve_features(table(phase, hub))["zero_crossing_time"] is None


@pytest.mark.parametrize(
    ("low", "high", "shows_level"),
    [
        (2e-4, 3e-3, False),
        (0.4, 0.45, False),
        (0.73, 0.999, True),
        (0.5, 0.8, True),
        (1.0, 1.2, True),
        (0.5, 0.5, True),
    ],
)
def test_the_scale_of_the_rate_fits_the_curve(low: float, high: float, shows_level: bool) -> None:
    rate = np.linspace(low, high, 50)
    rate[7] = math.nan
    figure = plot_deployment(table(0.0, 0.0) | {"deployment_rate": rate})
    bottom, top = figure.axes[0].get_ylim()
    assert bottom < low <= high < top
    assert (bottom < 1.0 < top) == shows_level
    if high > low:
        assert high - low > 0.3 * (top - bottom)


@pytest.mark.parametrize(("ending", "head"), [(".png", b"\x89PNG"), (".pdf", b"%PDF"), (".SVG", b"<?xml")])
def test_a_figure_has_the_format_of_its_ending(tmp_path: Path, ending: str, head: bytes) -> None:
    for name in ("a", "b"):
        plot_deployment(table(5.0, 3.0), tmp_path / f"{name}{ending}")
    content = (tmp_path / f"a{ending}").read_bytes()
    assert content.startswith(head)
    assert content == (tmp_path / f"b{ending}").read_bytes()


def test_other_endings_and_resolutions_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"x\.jpeg: the ending '\.jpeg' is no format.*one of \.png, \.pdf, \.svg"):
        plot_deployment(table(5.0, 3.0), tmp_path / "x.jpeg")
    for dpi in (0.0, -1.0, math.nan, 1e6):
        with pytest.raises(InputError, match=r"dpi = .*(from 10 to 2400|finite)"):
            plot_deployment(table(5.0, 3.0), tmp_path / "x.png", dpi=dpi)
    assert not list(tmp_path.iterdir())
    with pytest.raises(InputError, match="the ending '' is no format"):
        plot_deployment(table(5.0, 3.0), tmp_path / "x")
