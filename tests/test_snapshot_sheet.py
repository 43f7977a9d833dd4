"""Snapshots of a run: spread over the time that it has come to, seen by one camera, with a scale bar that is true."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import membrane_rs
import numpy as np
import pytest
from fake_simulation import small_sail
from membrane_rs import InputError, InputTypeError, Run, Simulation, Stage, plotting, scenes
from membrane_rs.errors import UnstableError
from membrane_rs.plotting import Style
from membrane_rs.plotting.camera import length_text
from membrane_rs.plotting.drawing import spread
from membrane_rs.plotting.painter import forget_probe, pyvista_works
from membrane_rs.plotting.snapshot_sheet import PIXELS, _is_covered

plot_snapshots: Any = plotting.plot_snapshots


@pytest.fixture(params=["pyvista", "matplotlib"])
def painter(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """Each of the two that draw."""
    if request.param == "matplotlib":
        monkeypatch.setattr("membrane_rs.plotting.process.COMMAND", [sys.executable, "-c", ""])
        forget_probe()
    elif not pyvista_works():
        pytest.skip("pyvista cannot render here")
    yield request.param
    if request.param == "matplotlib":
        forget_probe()


@pytest.fixture(scope="module")
def sail() -> Run:
    return membrane_rs.run(small_sail(samples=11, dt=2e-6, integrator="leapfrog"), 2e-3, frames=5)


def texts(figure: Any) -> list[str]:
    return [text.get_text() for text in figure.texts]


def pictures(figure: Any) -> list[Any]:
    return [axes.get_images()[0].get_array() for axes in figure.axes]


def test_instants_are_spread_over_the_run() -> None:
    assert spread([0.0, 1.0, 2.0, 3.0, 4.0], 3) == [0, 2, 4]
    assert spread([0.0, 0.1, 0.2, 0.3, 4.0], 3) == [0, 3, 4]  # evenly in time, not in number
    assert spread([0.0, 1.0], 6) == [0, 1]
    assert spread([0.5], 6) == [0]
    assert spread([0.0, 1.0, 2.0], 1) == [2]


def test_a_sheet_has_letters_times_and_one_scale_bar(sail: Run, painter: str) -> None:
    figure = plot_snapshots(sail, 3, style="paper", title="not shown")
    assert texts(figure) == ["(a) 0.000 s", "(b) 0.001 s", "(c) 0.002 s"]
    assert [len(axes.texts) for axes in figure.axes] == [1, 0, 0]
    assert all((picture.min(axis=2) < 200).mean() > 0.02 for picture in pictures(figure)), painter
    assert np.abs(pictures(figure)[0].astype(int) - pictures(figure)[2]).max() > 50
    screen = plot_snapshots(sail, 3, title="a title")
    assert screen.get_suptitle() == "a title"


def test_the_scale_bar_is_as_long_as_it_says(painter: str) -> None:
    """Beside a strip of 0.2 m, as it hangs at the start."""
    scene = scenes.load("hanging-strip")
    mesh = scene.mesh
    assert mesh is not None
    run = membrane_rs.run(scene, 1e-3, frames=2, samples=2)
    figure = plot_snapshots(run, [0.0], style="paper")
    axes = figure.axes[0]
    shown = np.flatnonzero((axes.get_images()[0].get_array().min(axis=2) < 200).any(axis=1))
    bar = np.ptp(axes.get_lines()[0].get_xdata())
    size, unit = axes.texts[0].get_text().split()
    length = float(size) * {"m": 1.0, "mm": 1e-3}[unit]
    assert bar / (shown[-1] - shown[0] + 1) == pytest.approx(length / np.ptp(mesh.positions[:, 2]), rel=0.02), painter
    assert len(shown) < PIXELS


def test_panels_are_square_in_scale_and_inside_the_figure(sail: Run) -> None:
    for style, columns in ((Style(width="double"), 2), ("screen", None)):
        figure = plot_snapshots(sail, 3, style=style, columns=columns, title="a title")
        width, height = figure.get_size_inches()
        for axes in figure.axes:
            box, (rows, across) = axes.get_position(), axes.get_images()[0].get_array().shape[:2]
            assert box.width * width / across == pytest.approx(box.height * height / rows, rel=1e-6)
        figure.draw_without_rendering()
        boxes = [text.get_window_extent() for text in (*figure.texts, *figure.axes[0].texts)]
        assert all(box.x0 >= 0 and box.x1 <= figure.bbox.x1 and box.y0 >= 0 for box in boxes)
        assert not any(one.overlaps(other) for k, one in enumerate(boxes) for other in boxes[:k])


def test_the_scale_bar_stands_on_no_film() -> None:
    run = membrane_rs.run("spinning-disc", 1e-4, frames=2, samples=2)
    figure = plot_snapshots(run, 2, style="paper")
    axes = figure.axes[0]
    figure.draw_without_rendering()
    image = axes.get_images()[0].get_array()
    box = axes.transData.inverted().transform(axes.texts[0].get_window_extent())
    (left, right), (top, bottom) = sorted(box[:, 0].astype(int)), sorted(box[:, 1].astype(int))
    assert (image[max(top, 0) : bottom, max(left, 0) : right] > 240).all()


def test_where_the_scale_bar_would_stand_is_looked_at_alone() -> None:
    """The lowest 5 mm of a box of 80 mm, over the longest bar and a bit more: 50 rows of 320 pixels."""
    box, below = (100, 900, 100, 900), (0.1, 5.0)

    def is_covered(row: int, column: int, value: int = 0, sizes: tuple[float, float] = below) -> bool:
        image = np.full((PIXELS, PIXELS, 3), 255, dtype=np.uint8)
        image[row, column, 1] = value
        return _is_covered(image, box, *sizes)

    assert all(is_covered(*place) for place in ((899, 100), (899, 419), (850, 100), (850, 419)))
    assert not any(is_covered(*place) for place in ((849, 100), (900, 100), (899, 99), (899, 420)))
    assert (is_covered(899, 100, 249), is_covered(899, 100, 250)) == (True, False)
    assert is_covered(899, 100, sizes=(0.1, 1e-3))  # one row at least
    assert (is_covered(100, 100, sizes=(0.1, 1e3)), is_covered(99, 100, sizes=(0.1, 1e3))) == (True, False)


def test_room_for_the_scale_bar_is_made_where_it_would_stand_on_something(
    sail: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    heights, style = [], Style(width="single")
    for row in (200, 790):
        image = np.full((PIXELS, PIXELS, 3), 255, dtype=np.uint8)
        image[200:800, 790:800] = image[row : row + 10, 200:800] = 0
        monkeypatch.setattr("membrane_rs.plotting.painter.ProcessPainter.paint", lambda *_, image=image: image)
        heights.append(plot_snapshots(sail, 1, style=style).get_size_inches()[1])
    line = 1.5 * style.font_size / 72.0
    assert heights[1] - heights[0] == pytest.approx(line)


def test_times_that_are_given_and_the_frame_of_the_camera(sail: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    assert texts(plot_snapshots(sail, [0.0, 6e-4, 4e-4, 2e-3])) == ["(a) 0.0000 s", "(b) 0.0005 s", "(c) 0.0020 s"]
    angles: dict[str, list[float]] = {"fixed": [], "turning": []}
    for view, seen in angles.items():

        def paint(_: object, shape: Any, angle: float, around: object, seen: list[float] = seen) -> Any:
            seen.append(angle)
            return np.zeros((PIXELS, PIXELS, 3), dtype=np.uint8)

        monkeypatch.setattr("membrane_rs.plotting.painter.ProcessPainter.paint", paint)
        plot_snapshots(sail, 2, view=view)
    assert angles == {"fixed": [0.0, pytest.approx(6.0 * np.pi * 2e-3)], "turning": [0.0, 0.0]}


@pytest.mark.parametrize(
    ("call", "kind", "words"),
    [
        (lambda run: plot_snapshots(run, 0), InputError, "times = 0: must be from 1 to 60"),
        (lambda run: plot_snapshots(run, "all"), InputTypeError, "times = 'all': must be a whole number"),
        (lambda run: plot_snapshots(run, []), InputError, "times: 0 of them"),
        (lambda run: plot_snapshots(run, [0.5]), InputError, "0.5 s is outside of the run, from 0 to 0.002 s"),
        (lambda run: plot_snapshots(run, [float("nan")]), InputError, "times = nan: must be finite"),
        (lambda run: plot_snapshots(run, view="side"), InputError, "view = 'side': known are: fixed, turning"),
        (lambda run: plot_snapshots(run, columns=0), InputError, "columns = 0"),
        (lambda run: plot_snapshots(run.history), InputTypeError, "must be a Run"),
    ],
)
def test_what_is_no_sheet_is_refused(
    call: Callable[[Run], object], kind: type[Exception], words: str, sail: Run
) -> None:
    with pytest.raises(kind, match=words):
        call(sail)


@pytest.mark.parametrize(("length", "text"), [(0.2, "0.2 m"), (0.05, "50 mm"), (0.1, "0.1 m"), (2e-5, "20 µm")])
def test_lengths_have_a_suitable_unit(length: float, text: str) -> None:
    assert length_text(length) == text


def shown(folder: Path, prefix: str = "fixed") -> list[float]:
    """Times of the snapshots in the folder of a run [s]."""
    return sorted(float(file.stem.split("-")[-1][:-1]) for file in folder.glob(f"snapshots/{prefix}-*s.png"))


def quick(**settings: Any) -> Any:
    """A tether, whose pictures take no time."""
    scene = scenes.load("spinning-tether")
    return replace(scene, run=replace(scene.run, samples=11, **settings))


def test_a_run_that_outlasts_its_snapshots_is_shown_to_its_end(tmp_path: Path) -> None:
    scene = quick(snapshots=(0.0, 0.001, 0.002, 0.003, 0.004))
    Simulation(scene).run(0.1, frames=11, out=tmp_path / "long")
    assert shown(tmp_path / "long") == pytest.approx([0.0, 0.02, 0.04, 0.06, 0.08, 0.1])
    Simulation(scene).run(0.006, frames=3, out=tmp_path / "short")
    assert shown(tmp_path / "short") == pytest.approx([0.0, 0.001, 0.002, 0.003, 0.004])


def test_an_unstable_run_is_shown_as_far_as_it_came(tmp_path: Path) -> None:
    scene = quick()
    sim = Simulation(scene, "rk4", dt=1.05 * Simulation(scene).stable_dt())
    with pytest.raises(UnstableError):
        sim.run(0.6, frames=np.linspace(0.0, 0.6, 2001).tolist(), out=tmp_path / "run")
    times = shown(tmp_path / "run")
    again = membrane_rs.open_run(tmp_path / "run")
    assert 0.0 < again.frames.times[-1] < 0.3
    assert len(times) == min(6, len(again.frames))
    assert times[-1] == pytest.approx(again.frames.times[-1], abs=1e-3)
    assert len(plot_snapshots(again, 4).axes) == min(4, len(again.frames))


def test_stages_without_snapshots_of_their_own_show_frames(tmp_path: Path) -> None:
    stages = (Stage("first", 2e-4, frames=3), Stage("second", 4e-4, frames=3))
    scene = replace(small_sail(snapshots=(), samples=5, dt=2e-6, integrator="leapfrog"), stages=stages)
    Simulation(scene).run(out=tmp_path / "run")
    assert shown(tmp_path / "run", "00-first-fixed") == pytest.approx([0.0, 1e-4, 2e-4])
    assert shown(tmp_path / "run", "01-second-turning") == pytest.approx([2e-4, 4e-4, 6e-4])
