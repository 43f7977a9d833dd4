"""Docstrings of all that is public: parameters, units, what is returned and raised, and examples that run."""

from __future__ import annotations

import doctest
import importlib
import inspect
from pathlib import Path

import membrane_rs
import pytest
from docstring_rules import faults, lacks
from membrane_rs._validation import number_of
from membrane_rs.errors import InputError, InputTypeError, MissingFileError
from membrane_rs.results import read_experiment
from membrane_rs.runs.place import Place
from membrane_rs.runs.running import _keep
from raised_errors import raised
from website.public import PublicName, members, public_names

NAMES = [name for name in public_names() if name.kind != "data"]
"""Constants have a docstring that a program does not see."""
PACKAGE = Path(membrane_rs.__file__).parent
WITH_EXAMPLES = [path for path in sorted(PACKAGE.rglob("*.py")) if ">>> " in path.read_text(encoding="utf-8")]
INCOMPLETE = (
    "membrane_rs.study.Ablation",
    "membrane_rs.study.Ablation.as_dict",
    "membrane_rs.study.Ablation.heading",
    "membrane_rs.study.Ablation.save",
    "membrane_rs.study.Ablation.summary",
    "membrane_rs.study.Ablation.table",
    "membrane_rs.study.Ablation.verdict",
    "membrane_rs.study.Calibration",
    "membrane_rs.study.Calibration.as_dict",
    "membrane_rs.study.Calibration.plot",
    "membrane_rs.study.Calibration.save",
    "membrane_rs.study.Calibration.table",
    "membrane_rs.study.Calibration.values",
    "membrane_rs.study.Comparison",
    "membrane_rs.study.Comparison.as_dict",
    "membrane_rs.study.Comparison.difference",
    "membrane_rs.study.Comparison.figure",
    "membrane_rs.study.Comparison.summary",
    "membrane_rs.study.Comparison.table",
    "membrane_rs.study.Difference",
    "membrane_rs.study.Ensemble.band",
    "membrane_rs.study.Ensemble.histories",
    "membrane_rs.study.Ensemble.plot",
    "membrane_rs.study.Ensemble.save",
    "membrane_rs.study.Ensemble.statistics",
    "membrane_rs.study.Ensemble.summary",
    "membrane_rs.study.LengthScales",
    "membrane_rs.study.MeshRun",
    "membrane_rs.study.SceneMatch",
    "membrane_rs.study.SceneMatch.table",
    "membrane_rs.study.Sweep.failures",
    "membrane_rs.study.Sweep.history",
    "membrane_rs.study.Sweep.name_of",
    "membrane_rs.study.Sweep.outcomes",
    "membrane_rs.study.Sweep.plot",
    "membrane_rs.study.Sweep.save_table",
    "membrane_rs.study.Sweep.summary",
    "membrane_rs.study.Sweep.to_pandas",
    "membrane_rs.study.WorkPrecision",
    "membrane_rs.study.WorkPrecision.as_dict",
    "membrane_rs.study.WorkPrecision.points_of",
    "membrane_rs.study.WorkPrecision.save",
    "membrane_rs.study.WorkPrecision.summary",
    "membrane_rs.study.ablate",
    "membrane_rs.study.calibrate",
    "membrane_rs.study.compare",
    "membrane_rs.study.match_scene",
    "membrane_rs.study.open_ensemble",
    "membrane_rs.study.open_sweep",
    "membrane_rs.study.work_precision",
    "membrane_rs.study.write_mesh_study",
)
"""Names whose docstrings lack something still. None is added; one that is complete leaves the list."""


def test_public_names_are_found() -> None:
    assert {"membrane_rs.Scene", "membrane_rs.folding.SquareSail", "membrane_rs.scenes.load"} <= {
        name.path for name in NAMES
    }
    assert "step" in members(membrane_rs.Simulation)


@pytest.mark.parametrize("name", NAMES, ids=lambda name: name.path)
def test_docstrings_are_complete(name: PublicName) -> None:
    assert {path: what for path, what in faults(name).items() if path not in INCOMPLETE} == {}


def test_names_leave_the_list_once_they_are_complete() -> None:
    found = {path for name in NAMES for path in faults(name)}
    assert set(INCOMPLETE) - found == set()


@pytest.mark.parametrize("path", WITH_EXAMPLES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_examples_run(path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    name = ".".join(["membrane_rs", *path.relative_to(PACKAGE).with_suffix("").parts]).removesuffix(".__init__")
    outcome = doctest.testmod(importlib.import_module(name), optionflags=doctest.ELLIPSIS)
    assert outcome.attempted > 0
    assert outcome.failed == 0


NUMBER, MATERIAL = inspect.getdoc(membrane_rs.units.number) or "", inspect.getdoc(membrane_rs.Material) or ""


@pytest.mark.parametrize(
    ("removed", "instead", "lacking"),
    [
        ("name : str\n", "", ["parameter name"]),
        ("name : str\n", "names : str\n", ["parameter name", "no parameter names"]),
        ("Returns\n-------\n", "Notes\n-----\n", ["Returns"]),
        (", in the unit asked for", "", ["a unit of what is returned"]),
        ("InputTypeError\n", "InputError\n", ["error InputTypeError"]),
        ("\nInputError\n", "\nInputErorr\n", ["error InputError", "no error InputErorr"]),
        ("Examples\n--------\n", "Notes\n-----\n", ["Examples"]),
    ],
)
def test_what_a_docstring_lacks_is_found(
    removed: str, instead: str, lacking: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    number = membrane_rs.units.number
    assert lacks(number) == []
    assert removed in NUMBER
    monkeypatch.setattr(number, "__doc__", NUMBER.replace(removed, instead))
    assert lacks(number) == lacking


def test_a_unit_that_is_not_that_of_the_field_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    assert lacks(membrane_rs.Material) == []
    monkeypatch.setattr(membrane_rs.Material, "__doc__", MATERIAL.replace("[kg/m3]", "[g/m3]").replace("nu [-]", "nu"))
    assert lacks(membrane_rs.Material) == ["a unit of poisson_ratio", "the unit [kg/m3] of density"]


def test_a_property_says_its_unit(monkeypatch: pytest.MonkeyPatch) -> None:
    time = inspect.getattr_static(membrane_rs.Simulation, "time")
    assert lacks(time, membrane_rs.Simulation) == []
    monkeypatch.setattr(time.fget, "__doc__", "Simulated time.")
    assert lacks(time, membrane_rs.Simulation) == ["a unit"]


def test_an_example_of_the_class_counts_for_its_methods() -> None:
    step = inspect.getattr_static(membrane_rs.Simulation, "step")
    assert (lacks(step, membrane_rs.Simulation), lacks(step)) == ([], ["Examples"])


def test_errors_are_found_in_a_body_and_in_what_it_calls_but_for_those_that_it_catches() -> None:
    assert raised(membrane_rs.Simulation.step, membrane_rs.Simulation) == {InputError, InputTypeError}
    assert raised(number_of) == {InputError, InputTypeError}
    assert raised(membrane_rs.units.of) == {InputError}
    assert raised(read_experiment) >= {InputError, MissingFileError}
    assert raised(Place._occupied, Place) == raised(_keep) == set()
