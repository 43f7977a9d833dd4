"""The picture and the page of a viewer, without a browser."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import membrane_rs
import numpy as np
import pytest
from membrane_rs.plotting.viewer import Viewer, look_at
from membrane_rs.plotting.viewer.canvas import Canvas, canvas_of
from viewed_run import with_frames


@pytest.fixture(scope="module")
def strip() -> Any:
    return membrane_rs.run("hanging-strip", 0.015, frames=4)


def test_the_page_tells_of_a_frame_that_cannot_be_drawn(strip: Any) -> None:
    pytest.importorskip("trame")
    names = ("time", "hub_angle", "triangles", "lines", "on_nodes", "on_triangles", "on_lines")
    last = strip.frames[3]
    bad = SimpleNamespace(
        positions=np.full_like(last.positions, np.nan), **{name: getattr(last, name) for name in names}
    )
    shown = look_at(with_frames(strip, [*list(strip.frames)[:3], bad]), where="notebook")
    assert shown is not None
    assert shown.page is not None
    shown.viewer.show_frame(3)
    shown.page.refresh()
    assert "cannot be drawn" in shown.page.server.state.words
    shown.viewer.show_frame(1)
    shown.page.refresh()
    assert shown.page.server.state.words == "0.005 s"


def test_the_legend_has_short_numbers(strip: Any) -> None:
    shown = strip.view(color="von_mises", time=0.01, where="picture")
    canvas = canvas_of(shown.viewer, (300, 200))
    low, high = canvas._legend.GetLookupTable().GetTableRange()
    scale = shown.viewer.scale()
    factor = {"Von Mises stress [MPa]": 1e6, "Von Mises stress [kPa]": 1e3}[canvas._legend_title.words]
    assert (low, high) == pytest.approx((scale.low / factor, scale.high / factor))
    assert 1.0 <= high < 1000.0
    canvas.plotter.close()


@pytest.mark.parametrize(("size", "foot"), [((320, 240), 92), ((150, 400), 92), ((150, 400), 0)])
def test_all_of_the_film_is_seen_above_the_foot(strip: Any, size: tuple[int, int], foot: int) -> None:
    import pyvista

    plotter: Any = pyvista.Plotter(off_screen=True, window_size=list(size), lighting="none", notebook=False)
    canvas = Canvas(plotter, Viewer(strip), foot)
    plotter.camera.roll += 90.0  # the strip lies across the picture
    for _ in range(2):
        canvas.draw()
        is_film = np.ptp(canvas.image().astype(int), axis=2) > 60  # yellow
        rows, columns = np.flatnonzero(is_film.any(axis=1)), np.flatnonzero(is_film.any(axis=0))
        assert rows[0] > 0
        assert rows[-1] < size[1] - foot
        assert columns[0] > 0
        assert columns[-1] < size[0] - 1
        long = max(np.ptp(rows), np.ptp(columns))
        assert long > 0.8 * min(size[0], size[1] - foot)
        canvas.aim(canvas.viewer.camera())  # and upright
    plotter.close()


def test_the_legend_of_a_uniform_field_has_one_number_and_its_colour_in_the_middle(strip: Any) -> None:
    shown = strip.view(color="speed", time=0.0, scale="frame", where="picture")
    canvas = canvas_of(shown.viewer, (300, 200))
    assert canvas._legend.GetNumberOfLabels() == 1
    assert canvas._legend.GetLookupTable().GetTableRange() == (-1.0, 1.0)
    canvas.plotter.close()
