"""The picture and the page of a viewer, without a browser."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import membrane_rs
import numpy as np
import pytest
from membrane_rs.plotting.viewer import look_at
from membrane_rs.plotting.viewer.canvas import canvas_of
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
