"""What a page is made of: text that stays text, arrays that come back, curves that keep their peaks, colours."""

from __future__ import annotations

import base64
import json
import zlib
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from membrane_rs.plotting.fields import FIELDS
from membrane_rs.plotting.page_panel import MOST_POINTS, Curve, panel_svg, thinned
from membrane_rs.plotting.web import STEPS, WIDTH, scale_colors, web_picture, web_picture_of
from membrane_rs.report import library
from membrane_rs.report.markup import clean, data, drawing, element, page_text, script, table
from membrane_rs.report.packing import KINDS, LEVELS, category_levels, coordinates, levels, packed
from numpy.typing import NDArray

RED = np.full((40, 60, 3), (200, 0, 0), np.uint8)


class Reader(HTMLParser):
    """The tags of a page, its texts and its attributes."""

    def __init__(self) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.text = ""
        self.values: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.values += [value or "" for _, value in attrs]

    def handle_data(self, data: str) -> None:
        self.text += data


@given(st.text())
def test_a_text_is_text_wherever_it_stands(text: str) -> None:
    page = page_text(element("p", text, element("b", text, title=text), text))
    reader = Reader()
    reader.feed(page.partition("\n")[2])
    reader.close()
    assert reader.tags == ["p", "b"]
    assert reader.text.removesuffix("\n") == clean(text) * 3
    assert reader.values == [clean(text)]
    page.encode("utf-8")


@given(
    st.recursive(st.text() | st.integers() | st.none(), lambda some: st.lists(some) | st.dictionaries(st.text(), some))
)
def test_data_end_no_script(content: object) -> None:
    made = data(content, id="data")
    assert "<" not in str(made.text)
    assert json.loads(str(made.text)) == content


def test_a_script_does_not_end_early() -> None:
    with pytest.raises(ValueError, match="end of an element"):
        script("const text = '</SCRIPT>';")
    assert script("a < b && c", id="x").text == "a < b && c"


def test_a_table_names_rows_and_columns() -> None:
    made = table(("Law", "J"), [("springs", "1"), ("spin", None)], caption="Balance")
    assert [part.get("scope") for part in made.iter("th")] == ["col", "col", "row", "row"]
    assert [part.tag for part in made] == ["caption", "thead", "tbody"]


def test_arrays_come_back() -> None:
    rng = np.random.default_rng(1)
    arrays: dict[str, NDArray[Any]] = {
        "bytes": rng.integers(0, 255, 7).astype(np.uint8), "steps": rng.integers(-9, 9, (3, 5)).astype(np.int16),
        "nodes": rng.integers(0, 9**9, 4).astype(np.uint32), "numbers": rng.normal(size=3).astype(np.float32),
        "none": np.zeros(0, np.uint32),
    }  # fmt: skip
    text, places = packed(arrays)
    content = zlib.decompress(base64.b64decode(text))
    for name, array in arrays.items():
        place = places[name]
        assert place["offset"] % 4 == 0
        again = np.frombuffer(content, KINDS[place["kind"]], place["count"], place["offset"])
        assert (again == array.ravel()).all()


def test_coordinates_are_rounded_to_a_step() -> None:
    points = np.random.default_rng(2).uniform(-0.3, 0.5, (200, 3))
    centre, half = np.array([0.1, 0.1, 0.1]), 0.4
    again = centre + coordinates(points, centre, half) * (half / 32767)
    assert np.abs(again - points).max() <= 0.5 * half / 32767 * (1 + 1e-9)
    assert coordinates(np.array([[9.0, -9.0, 0.1]]), centre, half).tolist() == [[32767, -32767, 0]]


def test_values_are_levels_of_their_scale() -> None:
    assert levels(np.array([0.0, 0.5, 1.0, -9.0, 9.0, np.nan]), 0.0, 1.0).tolist() == [1, 128, 255, 1, 255, 0]
    assert levels(np.array([2.0, np.nan]), 2.0, 2.0).tolist() == [128, 0]
    found = category_levels(np.array([0.0, 1.0, 2.0, np.nan]), 3)
    assert found[3] == 0
    assert [int(level / LEVELS * 3) for level in found[:3]] == [0, 1, 2]


def test_a_long_curve_keeps_its_peaks() -> None:
    times = np.linspace(0.0, 1.0, 100_001)
    values = np.sin(40.0 * times)
    values[[777, 50_003]] = 9.0, -9.0
    values[5] = np.nan
    kept, shown = thinned(times, values)
    assert len(kept) <= MOST_POINTS + 2
    assert (shown.min(), shown.max()) == (-9.0, 9.0)
    assert (kept[0], kept[-1]) == (0.0, 1.0)
    assert (np.diff(kept) > 0.0).all()
    assert len(thinned(times[:100], values[:100])[0]) == 99


def test_a_panel_has_text_and_classes() -> None:
    times = np.linspace(0.0, 2.0, 50)
    curve = Curve(times, times**2, "a $b$ <i>", key="run-3", edges=(times, 2.0 * times))
    svg = panel_svg([curve], "Rate <b>", level=1.0, stages=[("one", 0.0), ("</svg>", 1.0)], legend=True)
    figure = drawing(svg, "curve7", "A curve <b>")
    assert [part.get("class") for part in figure.iter() if part.get("class")] == ["run-3", "run-3"]
    words = "".join(figure.itertext())
    assert all(text in words for text in ("Rate <b>", "</svg>", "a $b$ <i>", "Time [s]"))
    names = [part.get("id") for part in figure.iter() if part.get("id")]
    assert all(str(name).startswith("curve7-") for name in names)
    used = [value for part in figure.iter() for key, value in part.items() if key in ("clip-path", "href")]
    assert used
    assert all(value.removeprefix("url(").strip("#)") in names for value in used)


def test_scales_of_colours() -> None:
    assert len(scale_colors(FIELDS["state"])) == 3
    found = scale_colors(FIELDS["von_mises"])
    assert (len(found), found[0], found[-1]) == (STEPS, "#440154", "#fde725")


def test_pictures_are_made_small(tmp_path: Path) -> None:
    from PIL import Image

    made = web_picture(np.repeat(RED, 50, axis=1))
    assert made.size == (WIDTH, 20)
    assert made.content[8:12] == b"WEBP"
    Image.fromarray(RED).save(tmp_path / "a.png")
    Image.fromarray(RED).save(tmp_path / "a.gif")
    (tmp_path / "a.gif").rename(tmp_path / "gif.png")
    (tmp_path / "text.png").write_text("no picture")
    (tmp_path / "half.png").write_bytes((tmp_path / "a.png").read_bytes()[:50])
    found = web_picture_of(tmp_path / "a.png")
    assert found is not None
    assert found.size == (60, 40)
    for name in ("gif.png", "text.png", "half.png", "none.png", "."):
        assert web_picture_of(tmp_path / name) is None


def test_the_library_names_nothing_beside_the_page() -> None:
    text = zlib.decompress(base64.b64decode(library.source())).decode()
    assert "@font-face{" not in text
    assert ".woff" not in text
    assert "font/woff2;base64" not in text
    assert "</script" not in text.lower()
    assert len(library.source()) < 1_000_000
    assert "MIT" in library.licence() or "Permission is hereby granted" in library.licence()
    assert library.plot() == library.plot()


def test_attributes_without_a_value_and_none() -> None:
    made = element("input", hidden=True, checked=False, title=None, data_of="x", class_="y")
    assert page_text(made).partition("\n")[2].strip() == '<input hidden="" data-of="x" class="y">'
