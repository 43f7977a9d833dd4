"""Libraries of extras: where one is missing, the error names the extra to install."""

from __future__ import annotations

import pickle
import re
import sys
from importlib import import_module
from pathlib import Path

import pytest
import typer
from membrane_rs import MissingExtraError, Simulation, scenes
from membrane_rs._extras import EXTRAS, extra, need
from membrane_rs.cli.application import FAILED, app, reported_errors
from typer.testing import CliRunner

tomllib = import_module("tomllib" if sys.version_info >= (3, 11) else "tomli")
ROOT = Path(__file__).parents[1]
DISTRIBUTIONS = {"PIL": "pillow", "trame_vtk": "trame-vtk", "trame_vuetify": "trame-vuetify"}
"""Names of distributions that are not those of their modules."""


OPTIONAL = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]


@pytest.mark.parametrize(("module", "name"), EXTRAS.items())
def test_each_library_comes_with_the_extra_that_its_error_names(module: str, name: str) -> None:
    distributions = {re.split(r"[<>=;\[ ]", line)[0] for line in OPTIONAL[name]}
    assert DISTRIBUTIONS.get(module, module) in distributions


@pytest.mark.parametrize("module", EXTRAS)
def test_a_missing_library_is_an_error_that_names_its_extra(module: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, module, None)
    remedy = re.escape(f'pip install "membrane_rs[{EXTRAS[module]}]"')
    with pytest.raises(MissingExtraError, match=remedy) as caught:
        extra(module)
    assert caught.value.extra == EXTRAS[module]
    with pytest.raises(MissingExtraError, match=f"pictures: this needs {module}.*{remedy}"):
        need(module, use="pictures")


def test_a_library_that_is_there_is_imported() -> None:
    need("matplotlib", "PIL")
    assert extra("PIL").__name__ == "PIL"


def test_a_module_that_no_extra_brings_is_an_error_of_its_own() -> None:
    with pytest.raises(ModuleNotFoundError, match="no_such_module"):
        extra("no_such_module")


def test_a_library_that_cannot_be_loaded_is_named_with_the_reason(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    reason = "libGL.so.1: cannot open shared object file"
    (tmp_path / "xarray.py").write_text(f"raise ImportError({reason!r})\n", encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "xarray", raising=False)
    with pytest.raises(
        MissingExtraError, match=rf"frames: xarray cannot be loaded \({reason}\); install what it lacks"
    ):
        extra("xarray", "frames")
    with pytest.raises(typer.Exit), reported_errors():
        import_module("xarray")
    shown = capsys.readouterr().err
    assert reason in shown
    assert "fault of membrane_rs" not in shown


def test_an_import_that_this_package_gets_wrong_is_its_fault(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(typer.Exit), reported_errors():
        raise ImportError("cannot import name 'x'", name="membrane_rs.scene")
    assert "fault of membrane_rs" in capsys.readouterr().err


def test_the_error_can_be_sent_to_another_process() -> None:
    error = MissingExtraError("sweeps: this needs pandas", "sweep")
    sent = pickle.loads(pickle.dumps(error))
    assert (str(sent), sent.extra) == (str(error), "sweep")


def test_a_run_with_pictures_is_refused_before_it_begins(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    sim = Simulation(scenes.load("spinning-tether"))
    with pytest.raises(MissingExtraError, match=r"pictures=False.*membrane_rs\[plot\]"):
        sim.run(until=1e-3, out=tmp_path / "drawn")
    assert not (tmp_path / "drawn").exists()
    sim.run(until=1e-3, frames=2, samples=2, out=tmp_path / "bare", pictures=False)
    assert (tmp_path / "bare" / "history.csv").is_file()


def test_the_command_line_names_the_extra(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    shown = CliRunner().invoke(app, ["run", "spinning-tether", "--until", "0.001", "--out", str(tmp_path / "run")])
    assert shown.exit_code == FAILED
    assert 'pip install "membrane_rs[plot]"' in " ".join(shown.stderr.split())
    assert "--no-pictures" in shown.stderr


def test_a_library_that_is_missing_within_a_command_is_named_too(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(typer.Exit) as caught, reported_errors():
        raise ModuleNotFoundError("No module named 'pyvista.core'", name="pyvista.core")
    assert caught.value.exit_code == FAILED
    assert "membrane_rs[plot]" in capsys.readouterr().err


@pytest.mark.parametrize("command", ["stability", "work-precision", "mesh-study"])
def test_a_study_asks_for_what_draws_before_its_runs(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    shown = CliRunner().invoke(app, [command, "okuizumi-model-1"])
    assert shown.exit_code == FAILED
    assert "membrane_rs[plot]" in " ".join(shown.stderr.split())
    assert not list(tmp_path.iterdir())
