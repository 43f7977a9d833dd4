"""Styles of figures: sheets of matplotlib, widths, and files that are the same for the same figure."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import pytest
from membrane_rs import InputError, InputTypeError, MembraneError, MissingFileError
from membrane_rs.plotting import PAPER, SCREEN, Style, plot_history, save_figure
from membrane_rs.plotting.style import COLORS, style_of
from PIL import Image

TABLE = {"time": np.linspace(0.0, 1.0, 30), "hub_torque": np.linspace(0.0, 2.0, 30)}


def draw(style: Any = "paper", **options: Any) -> Any:
    return plot_history(TABLE, ["hub_torque", "hub_torque"], style=style, **options)


@pytest.mark.parametrize(("width", "millimetres"), [("single", 85), ("double", 174), (120.0, 120), ("4 in", 101.6)])
def test_a_figure_is_as_wide_as_the_style_says(width: Any, millimetres: float, tmp_path: Path) -> None:
    save_figure(draw(Style(width=width)), tmp_path / "a.png")
    with Image.open(tmp_path / "a.png") as picture:
        assert picture.width == pytest.approx(millimetres / 25.4 * 300, abs=1)
        assert picture.info["dpi"] == pytest.approx((300, 300), abs=0.1)


@pytest.mark.parametrize("ending", ["png", "pdf", "svg"])
def test_the_same_figure_is_the_same_file(ending: str, tmp_path: Path) -> None:
    """Also where settings of matplotlib have changed in between."""
    draw(path=tmp_path / f"a.{ending}")
    with matplotlib.rc_context({"font.size": 20.0, "svg.fonttype": "path", "pdf.fonttype": 3, "savefig.bbox": "tight"}):
        draw(path=tmp_path / f"b.{ending}")
        figure = draw()
    save_figure(figure, tmp_path / f"c.{ending}")
    contents = [(tmp_path / f"{name}.{ending}").read_bytes() for name in "abc"]
    assert contents[0] == contents[1] == contents[2]
    assert b"CreationDate" not in contents[0]
    assert b"<dc:date>" not in contents[0]


def test_text_of_a_file_stays_text(tmp_path: Path) -> None:
    draw(path=tmp_path / "a.svg")
    assert "Torque on the hub [N m]</text>" in (tmp_path / "a.svg").read_text(encoding="utf-8")
    draw(path=tmp_path / "a.pdf")
    content = (tmp_path / "a.pdf").read_bytes()
    assert b"/FontFile2" in content  # TrueType, embedded
    assert b"/Type3" not in content
    if shutil.which("pdftotext"):
        shown = subprocess.run(["pdftotext", str(tmp_path / "a.pdf"), "-"], capture_output=True, text=True, check=True)
        assert "Time [s]" in shown.stdout


def test_settings_of_the_user_are_left_alone() -> None:
    with matplotlib.rc_context({"font.size": 17.0}):
        draw()._repr_png_()
        assert matplotlib.rcParams["font.size"] == 17.0


def test_styles_by_name_sheet_and_parameters(tmp_path: Path) -> None:
    assert style_of(None) is SCREEN
    assert style_of("paper") is PAPER
    assert style_of("ggplot").sheets == ("ggplot",)
    sheet = tmp_path / "mine.mplstyle"
    sheet.write_text("axes.labelsize: 13\naxes.prop_cycle: cycler('color', ['ff0000'])\n")
    for style in (sheet, str(sheet), Style(sheets=[sheet])):
        axes = draw(style).axes[0]
        assert axes.yaxis.label.get_size() == 13
        assert axes.get_lines()[0].get_color() == "#ff0000"
    assert draw(Style(sheets=[sheet], rc={"axes.labelsize": 9})).axes[0].yaxis.label.get_size() == 9
    assert draw({"lines.linewidth": 3.0}).axes[0].get_lines()[0].get_linewidth() == 3.0
    assert draw("paper").axes[0].get_lines()[0].get_color() == COLORS[0]


@pytest.mark.parametrize(
    "seen",
    [
        np.eye(3),
        [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
        [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
    ],
)
def test_colours_differ_for_readers_without_red_or_green(seen: Any) -> None:
    """As seen without the cones for long or for medium waves: matrices of Machado et al. 2009, on linear values."""
    linear = np.array([matplotlib.colors.to_rgb(color) for color in COLORS]) ** 2.2
    shown = np.clip(linear @ np.transpose(seen), 0.0, 1.0) ** (1.0 / 2.2)
    apart = np.linalg.norm(shown[:, None] - shown, axis=-1) + np.eye(len(COLORS))
    assert apart.min() > 0.12
    assert (shown @ [0.2126, 0.7152, 0.0722]).max() < 0.8  # dark enough on white


@pytest.mark.parametrize(
    ("style", "kind", "words"),
    [
        (3, InputTypeError, "style = 3: must be a Style"),
        ("papr", MissingFileError, "style = papr: no such file, and no style of matplotlib; did you mean 'paper'"),
        (Path("no.mplstyle"), MissingFileError, "style = no.mplstyle: no such file"),
        ({"axes.gird": True}, InputError, "matplotlib has no parameter 'axes.gird'; did you mean 'axes.grid'"),
        ({"axes.grid": "perhaps"}, InputError, "axes.grid = 'perhaps': matplotlib refuses it"),
        ({3: True}, InputError, "Style.rc.3. = 3: must be a text"),
    ],
)
def test_what_is_no_style_is_refused(style: Any, kind: type[Exception], words: str) -> None:
    with pytest.raises(kind, match=words):
        draw(style)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"axes.gird: True\n", "axes.gird"),
        (b"axes.grid\n", "Missing colon"),
        (b"lines.linewidth: wide\n", "linewidth"),
        (b"\xff\xfe\x00", "no style sheet|colon"),
        (b"axes.prop_cycle: __import__('os').abort()\n", "prop_cycle"),
    ],
)
def test_what_is_no_sheet_is_refused(content: bytes, words: str, tmp_path: Path) -> None:
    sheet = tmp_path / "sheet.mplstyle"
    sheet.write_bytes(content)
    with pytest.raises(MembraneError, match=words) as caught:
        draw(sheet)
    assert str(sheet) in str(caught.value)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"width": "thrice"}, "Style.width = 'thrice': must be a length with its unit such as '85 mm'"),
        ({"width": "85"}, "must be a length with its unit"),
        ({"width": "85 kg"}, "is a mass"),
        ({"width": 5000.0}, "Style.width = 5000.0: must be from 20 to 1000"),
        ({"width": "1 um"}, "must be from 20 to 1000"),
        ({"dpi": 1e6}, r"Style.dpi = 1000000.0: must be .*at most 2400"),
        ({"font_size": 0.0}, "Style.font_size = 0.0"),
        ({"colors": ()}, "must hold one colour or more"),
        ({"letter": True}, "did you mean 'letters'"),
    ],
)
def test_what_is_no_value_of_a_style_is_refused(options: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        Style(**options)


def test_colours_that_matplotlib_does_not_know_are_refused() -> None:
    with pytest.raises(InputError, match=r"Style\.colors: 'bluish' is no colour of matplotlib"):
        draw(Style(colors=["bluish"]))


def test_a_style_that_matplotlib_cannot_draw_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"a\.png: matplotlib cannot draw this figure \(.*change its style"):
        draw({"xtick.labelsize": 1e7}, path=tmp_path / "a.png")
    assert not list(tmp_path.iterdir())


def test_images_stand_in_the_file_itself(tmp_path: Path) -> None:
    """Whatever a style sheet says: matplotlib would write them beside it."""
    with Style(rc={"svg.image_inline": False}).context():
        assert matplotlib.rcParams["svg.image_inline"]


def test_settings_of_the_caller_stay_and_no_figure_stays_open(tmp_path: Path) -> None:
    """Whatever backend is set: more than twenty figures, which pyplot warns of where it keeps them."""
    from matplotlib import pyplot, rcParams

    pyplot.switch_backend("svg")
    open_before = pyplot.get_fignums()
    before, table = dict(rcParams), {"time": [0.0, 1.0], "hub_torque": [0.0, 2.0]}
    for k in range(25):
        plot_history(table, ["hub_torque"], tmp_path / "a.png", style="paper" if k % 2 else {"font.size": 17.0})
    with pytest.raises(InputError, match="is no format of a figure"):
        plot_history(table, ["hub_torque"], tmp_path / "a.bmp")
    assert dict(rcParams) == before
    assert pyplot.get_fignums() == open_before
