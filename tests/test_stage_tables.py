"""The tables of a stage: errors name their keys, and nobody changes them."""

from __future__ import annotations

import copy
import dataclasses
import pickle
from pathlib import Path
from typing import Any

import pytest
from membrane_rs import InputError, InputTypeError, Scene, SceneError, Schedule, Stage
from small_scenes import refused
from staged_scenes import oscillator

BAD = {"times": [0.4, 0.3], "values": [0.0, 1.0]}
VALUES: dict[str, Any] = {"laws.gravity.acceleration": [1, 2, 3], "x": {"y": [Schedule((0.0,), (1.0,))]}}
STAGE = Stage("a", 1.0, set=VALUES, scale={"z": 2.0})


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"set": {"parts.grip.x": BAD}}, r"Stage\.set\['parts\.grip\.x'\]\.times\[1\] = 0\.3: must not be below the"),
        ({"set": {"a": {"b": [BAD]}}}, r"Stage\.set\['a'\]\.b\[0\]\.times\[1\] = 0\.3"),
        ({"set": {"a": {**BAD, "eas": 1}}}, r"Stage\.set\['a'\]\.eas: no such key; did you mean 'ease'"),
        ({"set": {"a": {"times": [0.4], 3: 1}}}, r"Stage\.set\['a'\]: its key 3 must be a text"),
        ({"set": {"a": [[[[[[[[1]]]]]]]]}}, r"Stage\.set\['a'\]\[0\].*: is nested too deeply"),
        ({"scale": {"a": BAD}}, r"Stage\.scale\['a'\]\.times\[1\] = 0\.3"),
        ({"scale": {"material.density": 0.0}}, r"Stage\.scale\['material\.density'\] = 0\.0: must be greater than 0"),
        ({"frames": 1}, r"Stage\.frames = 1: must be at least 2 and at most 1e\+07"),
        ({"samples": 10**8}, r"Stage\.samples = 100000000: must be at least 2 and at most 1e\+07"),
    ],
)
def test_an_error_names_the_key(values: dict[str, Any], words: str) -> None:
    refused(lambda: Stage("a", 1.0, **values), (InputError, InputTypeError), words)  # type: ignore[arg-type]


def test_an_error_in_a_file_names_the_stage_too(tmp_path: Path) -> None:
    text = oscillator(Stage("a", 1.0, set={"laws.mass_damping.rate": 2.0})).to_toml()
    file = tmp_path / "scene.toml"
    for table, words in (
        (
            "{times = [0.4, 0.3], values = [0.0, 1.0]}",
            r"stages\[0\]\.set\['laws.mass_damping.rate'\]\.times\[1\] = 0\.3",
        ),
        ('2.0}\nscale = {"laws.gravity.x" = 0.0', r"stages\[0\]\.scale\['laws.gravity.x'\] = 0\.0: must be greater"),
    ):
        file.write_text(text.replace("scale = {}\n", "").replace('rate" = 2.0', f'rate" = {table}'))
        refused(lambda: Scene.from_toml(file), SceneError, words)


@pytest.mark.parametrize(
    "change",
    [
        lambda table: table.update(a=1),
        lambda table: table.__setitem__("a", 1),
        lambda table: table.__delitem__("x"),
        lambda table: table.pop("x"),
        lambda table: table.popitem(),
        lambda table: table.clear(),
        lambda table: table.setdefault("a", 1),
        lambda table: table.__ior__({"a": 1}),
    ],
)
def test_a_table_is_read_only(change: Any) -> None:
    for table in (STAGE.set, STAGE.scale, STAGE.set["x"]):
        before = dict(table)
        refused(lambda table=table: change(table), InputTypeError, "the table is read-only; build what holds it")  # type: ignore[misc]
        assert table == before


def test_a_table_that_was_given_may_change_later() -> None:
    given: dict[str, Any] = {"laws.mass_damping.rate": 1.0, "x": {"y": [1.0]}}
    stage = Stage("a", 1.0, set=given)
    given["laws.mass_damping.rate"] = 5.0
    given["x"]["y"].append(2.0)
    assert stage.set == {"laws.mass_damping.rate": 1.0, "x": {"y": (1.0,)}}


@pytest.mark.parametrize("level", range(pickle.HIGHEST_PROTOCOL + 1))
def test_it_is_copied_pickled_and_compared(level: int) -> None:
    for again in (
        copy.copy(STAGE),
        copy.deepcopy(STAGE),
        pickle.loads(pickle.dumps(STAGE, level)),
        dataclasses.replace(STAGE),
    ):
        assert again == STAGE
        refused(lambda again=again: again.set["x"].clear(), InputTypeError, "read-only")  # type: ignore[misc]
    assert dataclasses.asdict(STAGE)["scale"] == {"z": 2.0}
    more = dataclasses.replace(STAGE, set=STAGE.set | {"b": 1})
    assert more.set == {**STAGE.set, "b": 1}
