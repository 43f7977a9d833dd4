"""Scene files: TOML to the parts of a scene, and back.

    name = "my-scene"
    [mesh]            pattern = "square-sail" and its dimensions, or file = "mesh.npz" (mesh/formats.py has all kinds)
    [material]        the fields of Material
    [laws.springs]    one table for each law; an empty table takes the law with its defaults
    [[parts]]         kind = "tethers" and its fields
    [[bodies]]        kind = "cylinder" and its fields
    [[stages]]        the fields of Stage
    [run]             the fields of RunSettings

A schedule in a field is an inline table: {times = [0.0, 1.0], values = [3.0, 2.0], ease = 0.1}. Units are SI. Every
error names the file, the key, the value and the allowed range.
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass
from importlib import import_module
from pathlib import Path
from typing import Any, TypeVar

from membrane_rs._files import path_of, read_text
from membrane_rs._validation import build, computable, nearest, show, unit_of
from membrane_rs.errors import InputError, MissingFileError, SceneError
from membrane_rs.folding import PATTERNS
from membrane_rs.material import Material
from membrane_rs.mesh import Mesh
from membrane_rs.mesh.formats import FORMATS, is_mesh_file, mesh_of_file
from membrane_rs.scene.bodies import BODIES, Body
from membrane_rs.scene.laws import LAWS, Law
from membrane_rs.scene.parts import PARTS, Part
from membrane_rs.scene.run_settings import RunSettings
from membrane_rs.scene.stage import Stage

tomllib = import_module("tomllib" if sys.version_info >= (3, 11) else "tomli")

T = TypeVar("T")

MESH_FILE = "mesh.npz"
"""Where a scene's folder keeps a mesh that no folding pattern made."""

MOST_TEXT = 10**7
"""Bytes of the largest scene file that is read."""
LONGEST_VALUE = 200
"""Letters of a value that is no TOML in which a mistake is looked for."""
MOST_DOTS = 100
"""Dots in the longest key that is read: the reader of TOML takes time with the square of their number."""


@dataclass(frozen=True)
class SceneContent:
    """What a scene file holds, field by field what `Scene` takes."""

    mesh: Mesh | None
    material: Material | None
    laws: tuple[Law, ...]
    parts: tuple[Part, ...]
    name: str
    run: RunSettings
    stages: tuple[Stage, ...] = ()
    bodies: tuple[Body, ...] = ()


def read_scene(path: Path, *, without_functions: bool = False) -> SceneContent:
    """Read a scene file; where measures were functions, which no file holds, without these measures if so asked.

    Raises
    ------
    MissingFileError
        No such file, or a mesh file that it names is not there.
    SceneError
        Anything in it that is wrong, with its key.
    """
    try:
        text = read_text(path, MOST_TEXT)
    except FileNotFoundError:
        raise MissingFileError(f"{path}: there is no such scene file; give the path of a TOML file") from None
    except UnicodeDecodeError as error:
        raise SceneError(f"{path}: is no UTF-8 text ({error}); a scene file is TOML") from None
    except OSError as error:
        raise SceneError(f"{path}: cannot be read ({error.strerror}); give the path of a TOML file") from None
    return content_of(text, path, without_functions=without_functions)


def content_of(text: str, path: Path, *, without_functions: bool = False) -> SceneContent:
    """What the text of a scene file holds, which stands at `path`. Raises as `read_scene`."""
    longest = max((key.count(".") for line in text.splitlines() for key in _keys(line)), default=0)
    if longest > MOST_DOTS:
        raise SceneError(f"{path}: holds a key of {longest + 1} parts; a scene file needs two, such as [laws.springs]")
    try:
        table = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise SceneError(f"{path}: is no valid TOML: {error}{_meant(text, str(error))}") from None
    except RecursionError:
        raise SceneError(f"{path}: is nested too deeply; a scene file needs tables in tables and no more") from None
    except ValueError as error:
        raise SceneError(f"{path}: holds an integer of thousands of digits ({error}); shorten it") from None
    try:
        return _content(_without_functions(table) if without_functions else table, path)
    except InputError as error:
        raise SceneError(f"{path}: {error}") from None


def _keys(line: str) -> list[str]:
    """The parts of a line that may be keys: what stands before a sign of equality, or a heading."""
    line = line.strip()
    if line.startswith("#"):
        return []
    before = [part.rpartition(",")[2] for part in line.split("=")[:-1]]
    return before or [line] * (line.startswith("[") and "," not in line)


_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_MISTAKES = {
    r"[-+]?\d+,\d.*": "write a point for the decimals",
    r"[-+]?(?:\.\d|\d+\.(?!\d)).*": "write a digit on both sides of the point: 0.1, 1.0",
    rf"{_NUMBER}\s*[a-zA-Zµμ°%/].*": 'a number with its unit is a text, in quotes: "12.5 um"',
}
"""What often stands behind a sign of equality in place of a number, and what to write."""


def _meant(text: str, fault: str) -> str:
    """The line at fault of a text that is no TOML, and what is often wrong with such a line."""
    found = re.search(r"line (\d+)", fault)
    lines = text.split("\n")
    if found is None or int(found[1]) > len(lines):
        return ""
    line = lines[int(found[1]) - 1].strip()
    value = line.partition("=")[2].strip()[:LONGEST_VALUE]
    hint = next((f"; {words}" for mistake, words in _MISTAKES.items() if re.fullmatch(mistake, value)), "")
    return f": {show(line)}{hint}"


def write_scene(content: SceneContent, *, with_later: bool = True) -> str:
    """A scene as TOML, every value resolved and its unit beside it; None is written as a comment.

    Without `with_later` fields of material, laws and parts that came later, by keyword alone, are left out where they
    are not set: the text of a scene that does not use them stays the same, as its digest needs.
    """
    lines = [f"name = {toml_value(content.name)}"]
    if content.mesh is not None:
        pattern = pattern_name(content.mesh)
        source = f"file = {toml_value(MESH_FILE)}" if pattern is None else f"pattern = {toml_value(pattern)}"
        lines += ["", "[mesh]", source]
        if pattern is not None:
            lines += _table(content.mesh.source)
    if content.material is not None:
        lines += ["", "[material]", *_table(content.material, with_later=with_later)]
    for law in content.laws:
        lines += ["", f"[laws.{law.kind}]", *_table(law, with_later=with_later)]
    for part in content.parts:
        unnamed = ("name",) if part.name is None else ()
        lines += ["", "[[parts]]", f"kind = {toml_value(part.kind)}", *_table(part, unnamed, with_later=with_later)]
    for body in content.bodies:
        lines += ["", "[[bodies]]", f"kind = {toml_value(body.kind)}", *_table(body)]
    for stage in content.stages:
        lines += ["", "[[stages]]", *_table(stage)]
    lines += ["", "[run]", *_table(content.run, ("until",) if content.stages else ())]
    return "\n".join(lines) + "\n"


def _without_functions(table: Mapping[str, Any]) -> dict[str, Any]:
    """A scene whose stages end by time alone where a function ended them."""
    stages = table.get("stages")
    if not isinstance(stages, list):
        return dict(table)
    of_measure = ("measure", "below", "above")
    made = [
        {key: value for key, value in stage.items() if key not in of_measure}
        if isinstance(stage, dict) and str(stage.get("measure")).startswith(Stage.ONLY_IN_PYTHON)
        else stage
        for stage in stages
    ]
    return {**table, "stages": made}


def pattern_name(mesh: Mesh) -> str | None:
    """The name of the folding pattern that made a mesh, or None."""
    return next((name for name, kind in PATTERNS.items() if type(mesh.source) is kind), None)


def _content(table: Mapping[str, Any], path: Path) -> SceneContent:
    known = ("name", "mesh", "material", "laws", "parts", "bodies", "stages", "run")
    for key in table:
        if key not in known:
            raise SceneError(f"{key}: no such key; {nearest(key, known)}")
    name = table.get("name", path.stem.encode(errors="replace").decode())
    if not isinstance(name, str):
        raise SceneError(f"name = {show(name)}: must be a text")
    mesh = _mesh(_as_table(table["mesh"], "mesh"), path.parent) if "mesh" in table else None
    material = None
    if "material" in table:
        material = build(Material, _as_table(table["material"], "material"), "material")
    laws = tuple(
        build(_known(kind, LAWS, "laws"), _as_table(values, f"laws.{kind}"), f"laws.{kind}")
        for kind, values in _as_table(table.get("laws", {}), "laws").items()
    )
    parts = tuple(_listed(table, "parts", PARTS))
    bodies = tuple(_listed(table, "bodies", BODIES))
    items = table.get("stages", [])
    if not isinstance(items, list):
        raise SceneError("stages: must be a list of tables; write [[stages]] above each")
    stages = tuple(build(Stage, _as_table(item, f"stages[{i}]"), f"stages[{i}]") for i, item in enumerate(items))
    values = _as_table(table.get("run", {}), "run")
    if stages and "until" in values:
        raise SceneError(f"run.until = {show(values['until'])}: the run ends with the last of the stages; leave it out")
    run = build(RunSettings, values, "run")
    return SceneContent(mesh, material, laws, parts, name, run, stages, bodies)


def _mesh(table: Mapping[str, Any], folder: Path) -> Mesh:
    values = dict(table)
    if ("pattern" in values) == ("file" in values):
        raise SceneError(f"mesh: must hold either pattern ({', '.join(PATTERNS)}) or file ({', '.join(FORMATS)})")
    if "file" in values:
        file = values.pop("file")
        if not is_mesh_file(file):
            raise SceneError(f"mesh.file = {show(file)}: must be the path of a mesh file ({', '.join(FORMATS)})")
        return mesh_of_file(Mesh, folder / path_of(file, "mesh.file"), values, "mesh")
    pattern = values.pop("pattern")
    with computable("mesh"):
        mesh: Mesh = build(_known(pattern, PATTERNS, "mesh.pattern"), values, "mesh").mesh()
    return mesh


def _listed(table: Mapping[str, Any], key: str, kinds: Mapping[str, type[T]]) -> Iterator[T]:
    """The items of a list of tables, each of a kind."""
    items = table.get(key, [])
    if not isinstance(items, list):
        raise SceneError(f"{key}: must be a list of tables; write [[{key}]] above each")
    for i, item in enumerate(items):
        where, values = f"{key}[{i}]", dict(_as_table(item, f"{key}[{i}]"))
        if "kind" not in values:
            raise SceneError(f"{where}.kind: is missing; must be one of {', '.join(kinds)}")
        yield build(_known(values.pop("kind"), kinds, f"{where}.kind"), values, where)


def _known(name: object, classes: Mapping[str, type[Any]], where: str) -> type[Any]:
    if not isinstance(name, str) or name not in classes:
        raise SceneError(f"{where} = {show(name)}: is not known; {nearest(str(name), classes)}")
    return classes[name]


def _as_table(value: object, where: str) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise SceneError(f"{where} = {show(value)}: must be a table; write [{where}]")
    return value


def _table(item: Any, left_out: Sequence[str] = (), *, with_later: bool = False) -> list[str]:
    """The fields of a validated dataclass, one line each."""
    lines = []
    for entry in fields(item):
        is_unset = entry.kw_only and getattr(item, entry.name) is None
        if entry.name in left_out or (is_unset and not with_later):
            continue  # a field by keyword alone came later: without it a file, and the digest of it, stay the same
        value, unit = getattr(item, entry.name), unit_of(type(item), entry.name)
        suffix = f"  # {unit}" if unit else ""
        lines.append(
            f"# {entry.name}: not set{suffix}" if value is None else f"{entry.name} = {toml_value(value)}{suffix}"
        )
    return lines


def toml_value(value: object) -> str:
    """A value as TOML writes it; floats keep every bit."""
    if value is None or isinstance(value, bool):
        return {None: "{}", True: "true", False: "false"}[value]  # None as a stage sets it
    if isinstance(value, tuple | list):
        return "[" + ", ".join(toml_value(item) for item in value) + "]"
    if isinstance(value, dict):
        return _inline({json.dumps(key, ensure_ascii=False): item for key, item in value.items()})
    if is_dataclass(value):
        return _inline({entry.name: getattr(value, entry.name) for entry in fields(value)})
    text = Stage.function_name(value) if callable(value) else value
    if isinstance(text, str):
        return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
    return repr(value)


def _inline(table: Mapping[str, Any]) -> str:
    """An inline table."""
    return "{" + ", ".join(f"{name} = {toml_value(item)}" for name, item in table.items()) + "}"
