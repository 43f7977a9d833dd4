"""membrane-rs figures: the figures of a run, in the formats and the style that are asked for."""

from __future__ import annotations

import json
from pathlib import Path

import membrane_rs
import pytest
from membrane_rs.plotting import save_run_figures
from PIL import Image
from test_cli import call


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("runs") / "run"
    membrane_rs.run("spinning-tether", 0.01, frames=3, samples=6, out=path, pictures=False)
    return path


def test_figures_of_a_run(folder: Path, tmp_path: Path) -> None:
    words = ("--format", "png,SVG", "--format", "pdf", "--width", "60mm", "--out", tmp_path / "a" / "b")
    code, shown = call("figures", folder, *words)
    names = ["deployment", "energy", "snapshots", "snapshots-turning"]
    assert code == 0
    assert shown.count("Wrote ") == 12
    assert sorted(file.name for file in (tmp_path / "a" / "b").iterdir()) == sorted(
        f"{name}.{ending}" for name in names for ending in ("pdf", "png", "svg")
    )
    for name in names:
        with Image.open(tmp_path / "a" / "b" / f"{name}.png") as picture:
            assert picture.width == pytest.approx(60 / 25.4 * 300, abs=1)


def test_columns_and_json(folder: Path) -> None:
    code, shown = call(
        "figures", folder, "--columns", "hub_torque,energy_spin+kinetic_energy", "--json", "--snapshots", 1
    )
    files = [Path(file) for file in json.loads(shown)]
    assert code == 0
    assert all(file.read_bytes().startswith(b"%PDF") for file in files)
    assert files[-1] == folder / "figures" / "history.pdf"


def test_a_style_sheet(folder: Path, tmp_path: Path) -> None:
    sheet = tmp_path / "mine.mplstyle"
    sheet.write_text("axes.labelcolor: ff0000\n")
    code, _ = call("figures", folder, "--style", sheet, "--format", "svg", "--out", tmp_path / "out")
    assert code == 0
    assert "#ff0000" in (tmp_path / "out" / "deployment.svg").read_text()


@pytest.mark.parametrize(
    ("words", "found"),
    [
        (("--format", "jpg"), "formats: 'jpg' is no format of a figure; did you mean 'png'?"),
        (("--width", "85"), "must be a length with its unit such as '85 mm'"),
        (("--style", "papr"), "did you mean 'paper'"),
        (("--snapshots", "0"), "must be from 1 to 60"),
        (("--columns", "hub_torq"), "'hub_torq'; did you mean 'hub_torque'"),
    ],
)
def test_what_cannot_be_drawn_is_refused(words: tuple[str, ...], found: str, folder: Path, tmp_path: Path) -> None:
    code, shown = call("figures", folder, "--out", tmp_path / "out", *words)
    assert code == 2
    assert found in " ".join(shown.split())


def test_what_is_no_run_is_refused(tmp_path: Path) -> None:
    code, shown = call("figures", tmp_path)
    assert code == 2
    assert "name a run's folder" in shown


def test_a_run_in_memory_without_much_in_it(tmp_path: Path) -> None:
    run = membrane_rs.run("hanging-strip", 1e-4, frames=2, samples=2)
    files = save_run_figures(run, tmp_path, ["svg"], style="screen", times=1)
    assert [file.name for file in files] == ["deployment.svg", "energy.svg", "snapshots.svg"]
