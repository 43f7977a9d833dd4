"""Arrays that an object keeps are read only, and its attributes cannot be deleted: what follows stays right."""

from __future__ import annotations

import inspect
from collections.abc import Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from membrane_rs import Simulation, UnknownAttributeError, scenes
from membrane_rs._renamed import Renamed
from membrane_rs.folding import Strip
from membrane_rs.runs import RunFolder
from small_scenes import refused


def arrays_of(thing: Any, name: str, seen: set[int], depth: int = 5) -> Iterator[tuple[str, np.ndarray[Any, Any]]]:
    """All arrays that public attributes of an object of this package hold, by their names."""
    if isinstance(thing, np.ndarray):
        yield name, thing
    elif isinstance(thing, Mapping):
        for key, value in thing.items():
            yield from arrays_of(value, f"{name}[{key!r}]", seen, depth - 1)
    elif isinstance(thing, list | tuple):
        for k, value in enumerate(thing):
            yield from arrays_of(value, f"{name}[{k}]", seen, depth - 1)
    elif type(thing).__module__.startswith("membrane_rs.") and depth and id(thing) not in seen:
        seen.add(id(thing))
        for part in dir(thing):
            value = None if part.startswith("_") else inspect.getattr_static(thing, part, None)
            is_method = inspect.isroutine(value) and not isinstance(value, cached_property)
            if value is not None and not is_method and not isinstance(value, Renamed):
                yield from arrays_of(getattr(thing, part), f"{name}.{part}", seen, depth - 1)


THINGS: list[Any] = [
    *(Simulation(scenes.load(name)) for name in ("single-crease", "spinning-tether", "spinning-disc")),
    Strip(0.1, 0.02, 4, 1, creases=(0.5,)).mesh(),
]


@pytest.mark.parametrize("thing", THINGS, ids=lambda thing: type(thing).__name__)
def test_no_array_of_an_object_can_be_written(thing: Any) -> None:
    found = dict(arrays_of(thing, type(thing).__name__, set()))
    wanted = {"masses", "spring_pairs", "positions"} if isinstance(thing, Simulation) else {"boundary_edges", "edges"}
    assert {f"{type(thing).__name__}.{name}" for name in wanted} <= found.keys()
    assert [name for name, array in found.items() if array.flags.writeable] == []


@pytest.mark.parametrize("thing", [*THINGS, THINGS[0].scene, Strip(0.1, 0.02, 4, 1)], ids=lambda t: type(t).__name__)
def test_no_attribute_can_be_deleted(thing: Any) -> None:
    names = [name for name in dir(thing) if not name.startswith("_")]
    for name in names:
        with pytest.raises(AttributeError):
            delattr(thing, name)
    assert [name for name in dir(thing) if not name.startswith("_")] == names


def test_a_class_of_a_user_deletes_its_own(tmp_path: Path) -> None:
    class Mine(Simulation):
        extra = 2

    sim = Mine(scenes.load("spinning-tether"))
    sim.extra = 3
    del sim.extra
    for name in ("scene", "is_relaxed", "masses", "time"):
        refused(lambda name=name: delattr(sim, name), UnknownAttributeError, f"Mine.{name}: cannot be deleted; make")  # type: ignore[misc]
    refused(lambda: delattr(RunFolder(tmp_path / "run"), "path"), UnknownAttributeError, "path: cannot be deleted")
