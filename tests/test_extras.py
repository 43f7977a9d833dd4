"""Libraries of extras: where one is missing, the error names the extra to install."""

from __future__ import annotations

import pickle
import re
import sys
from importlib import import_module
from pathlib import Path

import pytest
from membrane_rs import MissingExtraError
from membrane_rs._extras import EXTRAS, extra, need

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


def test_the_error_can_be_sent_to_another_process() -> None:
    error = MissingExtraError("sweeps: this needs pandas", "sweep")
    sent = pickle.loads(pickle.dumps(error))
    assert (str(sent), sent.extra) == (str(error), "sweep")
