"""The JSON schema of scene files: what it takes, and what it does not."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft7Validator
from membrane_rs import Scene, scenes
from membrane_rs.errors import SceneError
from membrane_rs.scene.schema import schema
from test_cli import call
from test_units import CLASSES, FILE

tomllib = import_module("tomllib" if sys.version_info >= (3, 11) else "tomli")
ROOT = Path(__file__).parents[1]
SCHEMA = schema()
VALIDATOR = Draft7Validator(SCHEMA)
FILES = [*ROOT.glob("python/membrane_rs/scenes/*.toml"), *ROOT.glob("examples/**/*.toml"), *ROOT.glob("docs/*.toml")]


def faults(text: str) -> list[str]:
    """What the schema finds wrong with a scene file."""
    return [f"{list(fault.path)}: {fault.message}" for fault in VALIDATOR.iter_errors(tomllib.loads(text))]


def test_it_is_a_schema() -> None:
    Draft7Validator.check_schema(SCHEMA)
    assert json.loads(json.dumps(SCHEMA, allow_nan=False)) == SCHEMA


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_scene_files_fit(path: Path) -> None:
    assert faults(path.read_text(encoding="utf-8")) == []


@pytest.mark.parametrize("name", scenes.names())
def test_written_scenes_fit(name: str) -> None:
    assert faults(scenes.load(name).to_toml()) == []


def test_a_file_with_units_fits() -> None:
    assert faults(FILE) == []


def test_a_step_may_be_left_to_follow_from_the_limit(tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_text(f'{FILE}dt = "auto"\n')
    assert faults(f'{FILE}dt = "auto"\n') == []
    assert Scene.from_toml(tmp_path / "scene.toml").run.dt is None


WRONG = [
    ('"1 MPa"', '"1000"', "youngs_modulus"),
    ('"1 MPa"', "-1.0", "youngs_modulus"),
    ('"1 MPa"', "true", "youngs_modulus"),
    ("poisson_ratio = 0.3", "poisson_ratio = 0.5", "poisson_ratio"),
    ("poisson_ratio = 0.3\n", "", "'poisson_ratio' is a required property"),
    ("columns = 6", "columns = 0", "mesh"),
    ("columns = 6", 'columns = "6"', "mesh"),
    ('pattern = "strip"', 'pattern = "stripe"', "mesh"),
    ("[laws.springs]", "[laws.spring]", "'spring' was unexpected"),
    ('rate = "3 1/s"', 'rates = "3 1/s"', "'rates' was unexpected"),
    ('"-981 cm/s2"]', '"-981 cm/s2", 0.0]', "acceleration"),
    ('values = ["0 Hz", "25 rpm"]', 'values = ["0 Hz", "fast"]', "schedule"),
    ('ease = "10 %"', "ease = 0.6", "schedule"),
    ('kind = "fixed"', 'kind = "fixing"', "parts"),
    ('kind = "cylinder"', 'kind = "plane"', "bodies"),
    ('duration = "20 ms"', "duration = 0", "stages"),
    ('measure = "kinetic_energy"', 'measure = "energy"', "measure"),
    ("[run]", "[runs]", "'runs' was unexpected"),
    ('snapshots = [0.0, "20 ms"]', "frames = 1", "frames"),
    ('snapshots = [0.0, "20 ms"]', 'relax = "auto"', "relax"),
    ('name = "with units"', 'name = "a/b"', "name"),
    ('snapshots = [0.0, "20 ms"]', 'integrator = "rk5"', "integrator"),
]


@pytest.mark.parametrize(("old", "new", "words"), WRONG)
def test_wrong_scenes_do_not_fit(old: str, new: str, words: str, tmp_path: Path) -> None:
    assert FILE.count(old) == 1
    text = FILE.replace(old, new)
    found = faults(text)
    assert any(words in fault for fault in found), found
    (tmp_path / "scene.toml").write_text(text)
    with pytest.raises(SceneError):  # what does not fit is refused
        Scene.from_toml(tmp_path / "scene.toml")


def tables(value: Any) -> Iterator[dict[str, Any]]:
    """All descriptions of tables in the schema."""
    if isinstance(value, dict):
        if isinstance(value.get("properties"), dict) and "additionalProperties" in value:
            yield value
        for item in value.values():
            yield from tables(item)
    elif isinstance(value, list):
        for item in value:
            yield from tables(item)


def test_every_field_of_every_class_is_described() -> None:
    described = [set(table["properties"]) for table in tables(SCHEMA)]
    for cls in CLASSES:
        names = set(cls.__pydantic_fields__)
        assert any(names <= known for known in described), cls.__name__
    for table in tables(SCHEMA):
        for name, field in table["properties"].items():
            if "const" in field or table is SCHEMA:
                continue
            assert field["description"] != name, f"{name}: no description"


def test_references_lead_somewhere() -> None:
    names = set()
    for table in tables(SCHEMA):
        text = json.dumps(table["properties"])
        names |= {part.partition('"')[0] for part in text.split("#/definitions/")[1:]}
    assert names <= set(SCHEMA["definitions"])
    assert {"in_m", "in_Hz", "plain_number"} <= names


def test_the_command_prints_it_and_new_writes_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    code, shown = call("schema")
    assert (code, json.loads(shown)) == (0, SCHEMA)
    assert call("new", "mine", "--from", "single-crease")[0] == 0
    first = (tmp_path / "mine.toml").read_text().splitlines()[0]
    assert json.loads((tmp_path / first.removeprefix("#:schema ")).read_text()) == SCHEMA


def test_old_names_are_taken_and_marked() -> None:
    old = SCHEMA["properties"]["run"]["properties"]["settle"]
    assert (old["deprecated"], old["description"]) == (True, "The old name of relax.")
    assert faults(f"{FILE}settle = 0.1\n") == []
    assert faults(f"{FILE}settle = 0.1\nrelax = 0.1\n") != []
