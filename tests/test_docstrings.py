"""Docstrings of all that is public: parameters, units, what is returned and raised, and examples that run."""

from __future__ import annotations

import doctest
import importlib
import inspect
import re
from pathlib import Path

import membrane_rs
import pytest
from docstring_rules import faults, lacks
from membrane_rs._validation import number_of
from membrane_rs.check.stepping import Stepping
from membrane_rs.errors import InputError, InputTypeError, MissingFileError
from membrane_rs.results import read_experiment
from membrane_rs.runs.place import Place
from membrane_rs.runs.running import _keep
from membrane_rs.simulation.timeline import Timeline
from raised_errors import raised
from received_types import received, undescribed
from website.public import PACKAGES, PublicName, members, public_names

NAMES = [name for name in public_names() if name.kind != "data"]
"""Constants have a docstring that a program does not see."""
PACKAGE = Path(membrane_rs.__file__).parent
WITH_EXAMPLES = [path for path in sorted(PACKAGE.rglob("*.py")) if ">>> " in path.read_text(encoding="utf-8")]


def test_packages_of_the_reference_are_those_that_are_said_to_be_public() -> None:
    page = (Path(__file__).parent.parent / "docs" / "compatibility.md").read_text(encoding="utf-8")
    said = re.findall(r"`([\w.]+)`", page[page.index("the names in the `__all__`") :].partition(";")[0])
    public = {name if name in ("__all__", "membrane_rs") else f"membrane_rs.{name}" for name in said}
    assert public - {"__all__"} == set(PACKAGES)


def test_public_names_are_found() -> None:
    assert {"membrane_rs.Scene", "membrane_rs.folding.SquareSail", "membrane_rs.scenes.load"} <= {
        name.path for name in NAMES
    }
    assert "step" in members(membrane_rs.Simulation)


@pytest.mark.parametrize("name", NAMES, ids=lambda name: name.path)
def test_docstrings_are_complete(name: PublicName) -> None:
    assert faults(name) == {}


def test_types_that_users_receive_are_public() -> None:
    assert undescribed() == {}


def test_a_type_that_is_given_and_not_public_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(membrane_rs.Simulation.hub_load, "__annotations__", {"return": "Stepping"})
    monkeypatch.setattr(membrane_rs.Simulation.step, "__annotations__", {"return": Timeline | None})
    assert received(membrane_rs.Simulation) >= {Stepping, Timeline}
    monkeypatch.setattr(membrane_rs.Mesh.areas, "__annotations__", {"return": "dict[str, list[Timeline]]"})
    found = undescribed()
    assert found["membrane_rs.check.stepping.Stepping"] == "membrane_rs.Simulation"
    assert "membrane_rs.simulation.timeline.Timeline" in found


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


def test_a_parameter_that_only_a_base_class_describes_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    text = inspect.getdoc(membrane_rs.Simulation) or ""
    monkeypatch.setattr(membrane_rs.Simulation, "__doc__", text.replace("dt : float, optional", "Step", 1))
    assert "parameter dt" in lacks(membrane_rs.Simulation)


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
