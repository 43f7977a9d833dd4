"""The JSON schema of scene files, for editors: made of the classes that check them.

Types, bounds and defaults are pydantic's, descriptions those of the docstrings, units those of the fields. It is of
draft 7, which editors of TOML read. What only the whole scene tells, such as a node set that is not there, no schema
sees.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator, Mapping
from dataclasses import fields
from typing import Any

from pydantic import TypeAdapter

from membrane_rs._fields import is_automatic, takes_numbers, unit_of
from membrane_rs._numbers import AUTO
from membrane_rs._quantities import KINDS, LONGEST
from membrane_rs._renamed import new_names
from membrane_rs.folding import PATTERNS
from membrane_rs.material import Material
from membrane_rs.mesh.formats import FORMATS
from membrane_rs.scene.bodies import BODIES
from membrane_rs.scene.laws import LAWS
from membrane_rs.scene.parts import PARTS
from membrane_rs.scene.run_settings import RunSettings
from membrane_rs.scene.schedule import Schedule
from membrane_rs.scene.schema_rules import NAME, OF_CLASSES, OF_KEYS, of_old_names, of_scene
from membrane_rs.scene.stage import Stage
from membrane_rs.scene.staging import MOST_STAGES

BOUNDS = {"gt": "exclusiveMinimum", "ge": "minimum", "lt": "exclusiveMaximum", "le": "maximum"}
"""Words of a schema for bounds that pydantic hands on from annotated-types."""
_SIGN = r"[-+\u2212]?"
_POWER = rf"([eE]{_SIGN}[0-9]+)?"
WITH_UNIT = rf"^\s*(?!{_SIGN}[0-9.]+{_POWER}\s*$){_SIGN}([0-9]+\.?[0-9]*|\.[0-9]+){_POWER}(\s+[^\s,]|[^\s,0-9.])"
"""A number with something behind it that is no comma."""
NEGATIVE = "^\\s*[-\u2212]0*\\.?0*[1-9]"
"""A number below 0."""


def schema() -> dict[str, Any]:
    """The JSON schema of a scene file, as plain values that `json.dumps` writes.

    Returns
    -------
    dict
        Of draft 7.

    Examples
    --------
    >>> from membrane_rs.scene.schema import schema
    >>> schema()["properties"]["material"]["properties"]["thickness"]["anyOf"][0]
    {'exclusiveMinimum': 0, 'type': 'number'}
    """
    patterns = [_table(kind, {"pattern": {"const": name}}) for name, kind in PATTERNS.items()]
    laws = {name: _table(law) for name, law in LAWS.items()}
    return {
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": "Scene of membrane_rs",
        "description": "Numbers are in SI units, angles in radians; a text may have its unit: '7.5 um'.",
        "type": "object",
        "properties": {
            "name": {**NAME, "description": "Of the scene, for titles and folders. Default: the name of the file."},
            "mesh": {
                "description": "The membrane: a folding pattern, or a file.",
                "oneOf": [*patterns, *_mesh_files()],
            },
            "material": _table(Material),
            "laws": {
                "description": "An empty table takes a law with its defaults; one that is left out costs nothing.",
                "type": "object",
                "properties": laws,
                "additionalProperties": False,
            },
            "parts": _list("What a scene has beside its membrane.", PARTS),
            "bodies": _list("Bodies of prescribed motion.", BODIES),
            "stages": {
                "description": "One after the other in one run.",
                "type": "array",
                "items": _table(Stage),
                "maxItems": MOST_STAGES,
            },
            "run": _table(RunSettings),
        },
        "additionalProperties": False,
        **of_scene(),
        "definitions": _texts(),
    }


def _mesh_files() -> Iterator[dict[str, Any]]:
    """Tables that name a mesh file, by what is to be said beside it."""
    kinds: dict[type | None, list[str]] = {}
    for suffix, (options, _) in FORMATS.items():
        kinds.setdefault(options, []).append(suffix.removeprefix("."))
    for options, suffixes in kinds.items():
        letters = ("".join(f"[{letter}{letter.upper()}]" for letter in suffix) for suffix in suffixes)
        file = {"type": "string", "pattern": rf"\.({'|'.join(letters)})$", "description": "A mesh of your own."}
        if options is None:
            yield {"type": "object", "properties": {"file": file}, "required": ["file"], "additionalProperties": False}
            continue
        table = _table(options, {"file": file})
        unit = {"type": "string", "pattern": r"^\s*[A-Za-zµμ]+\s*$", "description": "The unit: 'mm'."}
        scale = table["properties"]["scale"]
        yield {**table, "properties": {**table["properties"], "scale": {**scale, "anyOf": [*scale["anyOf"], unit]}}}


def _list(description: str, kinds: Mapping[str, type]) -> dict[str, Any]:
    """A list of tables, each of a kind."""
    items = [_table(kind, {"kind": {"const": name}}) for name, kind in kinds.items()]
    return {"description": description, "type": "array", "items": {"oneOf": items}}


def _table(cls: type[Any], first: Mapping[str, Any] | None = None, outer: str | None = None) -> dict[str, Any]:
    """The schema of a checked class, behind keys of its own that are needed."""
    own = TypeAdapter(cls).json_schema()
    texts, properties = descriptions(cls), dict(first or {})
    for entry in fields(cls):
        plain, name = own["properties"][entry.name], entry.name
        unit = unit_of(cls, name, outer=outer)
        if _is_schedule(plain):
            made = _table(Schedule, outer=unit)
        else:
            made = {**_plain(plain), **OF_KEYS.get(cls, {}).get(name, {})}
            if takes_numbers(cls, name)[0]:
                made = _with_units(made, unit)
            if is_automatic(cls, name):
                made = {"anyOf": [*made["anyOf"], {"const": AUTO}]}
        default = plain.get("default")
        if default is not None and made.get("type") != "object":
            made["default"] = default
        properties[name] = {**made, "description": texts.get(name, name)}
    for old, new in new_names(cls).items():
        properties[old] = {**properties[new], "description": f"The old name of {new}.", "deprecated": True}
    needed = [*(first or {}), *own.get("required", [])]
    return {
        "description": (cls.__doc__ or "").partition("\n")[0],
        "type": "object",
        "properties": properties,
        **({"required": needed} if needed else {}),
        "additionalProperties": False,
        **of_old_names(new_names(cls)),
        **OF_CLASSES.get(cls, {}),
    }


def descriptions(cls: type) -> dict[str, str]:
    """The text of each parameter in the docstrings of a class and its bases, by name."""
    found: dict[str, str] = {}
    for owner in reversed(cls.__mro__):
        text = inspect.cleandoc(owner.__doc__ or "") + "\n"  # Python 3.13 has removed the indentation already
        entries = re.findall(r"^(\w[\w, ]*) : [^\n]*\n((?:    [^\n]*\n)+)", text, re.M)
        for names, text in entries:
            found |= dict.fromkeys(names.split(", "), " ".join(text.split()))
    return found


def _is_schedule(plain: Mapping[str, Any]) -> bool:
    return any("$ref" in item for item in (plain, *plain.get("anyOf", ())))


def _plain(plain: Mapping[str, Any]) -> dict[str, Any]:
    """What pydantic says of a field in words of draft 7, without null, which TOML has not."""
    if "anyOf" in plain:
        others = [_plain(item) for item in plain["anyOf"] if item.get("type") != "null"]
        return others[0] if len(others) == 1 else {"anyOf": others}
    made = {
        BOUNDS.get(key, key): value for key, value in plain.items() if key not in ("title", "default", "description")
    }
    if "prefixItems" in made:
        made["items"] = _plain(made.pop("prefixItems")[0])
    elif isinstance(made.get("items"), Mapping):
        made["items"] = _plain(made["items"])
    if isinstance(made.get("additionalProperties"), Mapping):
        made["additionalProperties"] = _plain(made["additionalProperties"])
    return made


def _with_units(made: dict[str, Any], unit: str | None) -> dict[str, Any]:
    """A number, or the numbers of a list, or text with a unit; of several forms those that hold numbers."""
    if any("items" in form for form in made.get("anyOf", ())):
        return {"anyOf": [_with_units(form, unit) if "items" in form else form for form in made["anyOf"]]}
    if made.get("type") == "array":
        return {**made, "items": _with_units(made["items"], unit)}
    text: dict[str, Any] = {"$ref": f"#/definitions/{_label(unit)}"}
    least = made.get("minimum", made.get("exclusiveMinimum", -1.0))
    if least >= 0.0 and unit != "K":  # degrees Celsius may be below 0
        text = {"allOf": [text], "not": {"pattern": NEGATIVE}}
    return {"anyOf": [made, text]}


def _texts() -> dict[str, Any]:
    """Texts with a unit, by the unit of the field that they stand in."""
    made = {}
    for unit in (None, *KINDS):
        what, example = ("a number", "3 N") if unit is None else KINDS[unit]
        text = {"type": "string", "pattern": WITH_UNIT, "maxLength": LONGEST}
        said = f"Text with a unit, of {what}: {example!r}."
        made[_label(unit)] = {**text, "description": said, "examples": [example]}
    return made


def _label(unit: str | None) -> str:
    return "any_unit" if unit is None else "in_" + re.sub(r"\W", "_", unit) if unit else "plain_number"
