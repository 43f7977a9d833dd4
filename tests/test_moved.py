"""Old public names and places: each leads to the new one, and warns."""

from __future__ import annotations

import pkgutil
from importlib import import_module

import membrane_rs
import pytest
from membrane_rs._moved import Moved

OLD = {
    info.name: getattr(import_module(info.name), "__getattr__", None)
    for info in pkgutil.iter_modules(membrane_rs.__path__, "membrane_rs.")
}
NAMES = [(old, name, *new) for old, moved in OLD.items() if isinstance(moved, Moved) for name, new in moved.new.items()]


@pytest.mark.parametrize(("old", "name", "place", "new"), NAMES)
def test_an_old_name_leads_to_the_new_one(old: str, name: str, place: str, new: str) -> None:
    with pytest.warns(DeprecationWarning, match=f"import {new} from {place}$") as warned:
        found = getattr(import_module(old), name)
    assert found is getattr(import_module(place), new)
    assert found is not None
    assert [warning.filename for warning in warned] == [__file__]


def test_other_names_are_not_there() -> None:
    with pytest.raises(AttributeError, match=r"'membrane_rs\.observe' has no attribute 'nothing'"):
        Moved("membrane_rs.observe", {})("nothing")


@pytest.mark.parametrize("old", ["audit", "laws", "observe", "output", "parts", "run_settings"])
def test_all_names_of_an_old_module_are_imported_by_a_star(old: str) -> None:
    module = import_module(f"membrane_rs.{old}")
    found: dict[str, object] = {}
    with pytest.warns(DeprecationWarning, match="is deprecated"):
        exec(f"from membrane_rs.{old} import *", found)
    assert set(module.__all__) == set(dir(module)) <= set(found)
