"""Docstrings of all that is public: parameters, what is returned, and examples that run."""

from __future__ import annotations

import doctest
import importlib
import inspect
from functools import cached_property
from pathlib import Path
from typing import Any

import membrane_rs
import pytest
from numpydoc.docscrape import NumpyDocString
from website.public import INTERFACES, PublicName, members, public_names

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
    "membrane_rs.study.Comparison",
    "membrane_rs.study.Comparison.as_dict",
    "membrane_rs.study.Comparison.difference",
    "membrane_rs.study.Comparison.figure",
    "membrane_rs.study.Comparison.summary",
    "membrane_rs.study.Comparison.table",
    "membrane_rs.study.Difference",
    "membrane_rs.study.Ensemble.band",
    "membrane_rs.study.Ensemble.plot",
    "membrane_rs.study.Ensemble.save",
    "membrane_rs.study.Ensemble.statistics",
    "membrane_rs.study.Ensemble.summary",
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
    "membrane_rs.study.match_scene",
    "membrane_rs.study.open_ensemble",
    "membrane_rs.study.open_sweep",
    "membrane_rs.study.work_precision",
    "membrane_rs.study.write_mesh_study",
)
"""Names whose docstrings lack something still. None is added; one that is complete leaves the list."""


def plain(member: Any) -> Any:
    """The function of a method or of a property."""
    if isinstance(member, property):
        return member.fget
    return member.func if isinstance(member, cached_property) else getattr(member, "__func__", member)


def parameters(value: Any) -> list[str]:
    """Names of parameters that a caller gives."""
    if inspect.isclass(value) and getattr(value, "_is_protocol", False):
        return []
    names = [name for name in inspect.signature(value).parameters if not name.startswith("_")]
    return [name for name in names if name not in ("self", "cls")]


def described(value: Any) -> set[str]:
    """Names of the parameters, and of the attributes of results, that a docstring or that of a base class describes."""
    kinds = value.__mro__ if inspect.isclass(value) else [value]
    docs = [NumpyDocString(inspect.getdoc(kind) or "") for kind in kinds if inspect.getdoc(kind) and kind is not object]
    rows = [row for doc in docs for row in (*doc["Parameters"], *doc["Attributes"])]
    return {name.strip().lstrip("*") for row in rows for name in row.name.split(",")}


def lacks(value: Any, examples: str, *, is_interface: bool = False) -> list[str]:
    """What the docstring of a function, method, class or property lacks; `examples` are those of its class.

    Methods of an interface are called by the package, not by users: its class has an example, and
    `test_recipes.py` has more.
    """
    function = plain(value)
    text = inspect.getdoc(function) or ""
    doc = NumpyDocString(text)
    found = [] if text else ["a docstring"]
    if isinstance(value, property | cached_property):
        return found
    if not (inspect.isclass(value) and issubclass(value, BaseException)):
        found += [f"parameter {name}" for name in parameters(function) if name not in described(function)]
    if not inspect.isclass(value):
        returned = inspect.signature(function).return_annotation
        is_silent = returned in ("None", None, inspect.Signature.empty) or doc["Returns"] or doc["Yields"]
        found += [] if is_silent else ["Returns"]
    is_shown = doc["Examples"] or f".{function.__name__}(" in examples
    is_error = inspect.isclass(value) and issubclass(value, BaseException)
    return found if is_shown or is_error or is_interface else [*found, "Examples"]


def faults(name: PublicName) -> dict[str, str]:
    """What a public name and its members lack, by path."""
    value = name.value
    found = {name.path: lacks(value, "")}
    if name.kind == "class":
        examples = inspect.getdoc(value) or ""
        for member in members(value):
            what = lacks(inspect.getattr_static(value, member), examples, is_interface=value in INTERFACES)
            found[f"{name.path}.{member}"] = what
    return {path: ", ".join(what) for path, what in found.items() if what}


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


def test_what_a_docstring_lacks_is_found() -> None:
    def shown(a: int, b: int) -> int:
        """Sum.

        Parameters
        ----------
        a : int
            First.
        """
        return a + b

    assert lacks(shown, "") == ["parameter b", "Returns", "Examples"]
    assert lacks(shown, ">>> it.shown(1, 2)") == ["parameter b", "Returns"]
