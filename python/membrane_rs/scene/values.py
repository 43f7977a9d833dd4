"""A scene with other values, by dotted keys: for studies, `--set` and sweeps."""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields, is_dataclass, replace
from typing import Any, TypeVar

from membrane_rs._other_names import OTHER_NAMES
from membrane_rs._renamed import deprecated, new_names
from membrane_rs._validation import (
    build,
    check_kind,
    checked_class,
    computable,
    is_table,
    is_whole,
    nearest,
    show,
    unit_of,
)
from membrane_rs.errors import InputError, InputTypeError, SceneError
from membrane_rs.scene.laws import LAWS
from membrane_rs.scene.places import SINGLE, Changeable, Place, labelled, located, places_of

S = TypeVar("S", bound=Changeable)

OPTIONAL = ("laws", "parts", "bodies")
"""Sections whose entries a scene may be without."""
EXAMPLES = "laws.creases.stiffness, parts.0.mass, material.thickness, run.dt or mesh.rows (of a pattern)"
MOST_NAMED = 3
"""Keys, at most, that a message about an unknown one names."""
LONGEST_KEY, LONGEST_SHOWN = 1000, 80


@dataclass
class Change:
    """What is changed at one place."""

    place: Place
    values: dict[str, Any] = field(default_factory=dict)
    """New values by the names of fields."""
    is_gone: bool = False


class Valued:
    """What has values by dotted keys: a scene."""

    def with_values(self: S, values: Mapping[str, Any]) -> S:
        """The scene with other values, by dotted keys.

        Parameters
        ----------
        values : mapping of str to object
            Values, in SI units or as text with a unit ("7.5 um"), by keys such as "material.thickness", "run.dt",
            "laws.creases.stiffness" (which adds a law that the scene lacks), "parts.<name or index>.mass",
            "stages.<name or index>.duration", "mesh.fold_lines" (of the pattern, which makes the mesh anew). "laws.x"
            takes True, False or a table of several keys. None takes an optional value away, {} an optional table such
            as a schedule. docs/units.md has all.

        Returns
        -------
        Scene
            A new one.

        Raises
        ------
        SceneError
            No such key, with the nearest one; two values for one key; values that the rest of the scene refuses.
        InputError, InputTypeError
            A value outside its range, or of a wrong type.

        Examples
        --------
        >>> from membrane_rs import scenes
        >>> scene = scenes.load("okuizumi-model-1").with_values({"laws.spin.frequency": "30 rpm", "mesh.fold_lines": 3})
        >>> scene.law("spin").frequency, scene.mesh.source.strips
        (0.5, 4)
        """
        return with_values(self, values)

    def value(self: Changeable, key: str) -> Any:
        """The value of a dotted key, as `with_values` takes it, in SI units.

        Parameters
        ----------
        key : str
            Such as "material.thickness".

        Returns
        -------
        object
            The value.

        Raises
        ------
        SceneError
            No such key, or none that has a value in this scene.

        Examples
        --------
        >>> from membrane_rs import scenes
        >>> scenes.load("okuizumi-model-1").with_values({"material.thickness": "12.5 um"}).value("material.thickness")
        1.25e-05
        """
        check_kind(key, str, "key", "a dotted key, such as 'material.thickness'")
        return getattr(self, key) if key == "name" else value_at(self, key)

    def unit(self: Changeable, key: str) -> str:
        """The unit of the value of a dotted key; empty for a plain number, and for what is none.

        Parameters
        ----------
        key : str
            Such as "material.thickness".

        Returns
        -------
        str
            Such as "m".

        Raises
        ------
        SceneError
            No such key.

        Examples
        --------
        >>> from membrane_rs import scenes
        >>> scenes.load("okuizumi-model-1").unit("laws.spin.frequency")
        'Hz'
        """
        check_kind(key, str, "key", "a dotted key, such as 'material.thickness'")
        return "" if key == "name" else unit_at(self, key)


def with_values(scene: S, values: Mapping[str, Any]) -> S:
    """A scene with other values, as `Valued.with_values` says."""
    if not isinstance(values, Mapping):
        raise InputTypeError(f"values = {show(values)}: must be a table of values by keys such as {EXAMPLES}")
    places = [*_places(scene)]
    changes: dict[str, Change] = {}
    top: dict[str, Any] = {}
    given: dict[tuple[str, str], str] = {}
    for key, value in _singly(places, values):
        if key == "name":
            top[key] = value
            continue
        place, rest = _located(scene, places, key, value)
        if (place.label, rest) in given:
            other = given[place.label, rest]
            raise SceneError(f"{_shown(key, value)}: {other} sets the same value; leave out one of them")
        given[place.label, rest] = key
        change = changes.setdefault(place.label, Change(place))
        if not rest:
            change.is_gone = value is False
        else:
            name, new = _field(change, rest, _shown(key, value), value)
            change.values[name] = new
        if change.is_gone and change.values:
            raise SceneError(f"{change.place.label} = False: keys of it are set too; leave out one of them")
    for section in dict.fromkeys(change.place.section for change in changes.values()):
        top |= _changed(scene, section, [change for change in changes.values() if change.place.section == section])
    whole: Any = scene
    try:
        made: S = replace(whole, **top)
    except InputError as error:
        several = ", ".join(_shown(key, value) for key, value in list(values.items())[:MOST_NAMED])
        raise type(error)(f"with {several}: {error}") from None
    return made


def value_at(scene: Changeable, key: str) -> Any:
    """The value of a key. Raises SceneError."""
    place, name, inside = _read(scene, key)
    if isinstance(place.item, type):
        raise SceneError(f"{key}: the scene has no {place.label}, so that this has no value")
    value = getattr(place.item, name)
    if not inside:
        return value
    entries = value if isinstance(value, Mapping) else vars(value) if is_dataclass(value) else {}
    if inside not in entries:
        raise SceneError(f"{key}: is not set; {place.label}.{name} is {show(value)}")
    return entries[inside]


def unit_at(scene: Changeable, key: str) -> str:
    """The unit of a key. Raises SceneError."""
    place, name, inside = _read(scene, key)
    if inside and is_table(place.kind, name):
        return unit_at(scene, inside) if name == "set" else ""
    unit = unit_of(place.kind, name, {} if isinstance(place.item, type) else vars(place.item))
    inner = checked_class(place.kind, name)
    return (unit_of(inner, inside, outer=unit) if inside and inner is not None else unit) or ""


def key_at(scene: Changeable, key: str) -> str:
    """Of all keys that name a value, the one by the name of its place rather than its index. Raises SceneError."""
    place, name, inside = _read(scene, key)
    return ".".join(filter(None, (place.label, name, inside)))


def keys_of(scene: Changeable) -> list[str]:
    """All keys of fields that `Scene.with_values` takes for a scene, those of laws that it lacks among them."""
    return _all_keys([*_places(scene)])


def _read(scene: Changeable, key: str) -> tuple[Place, str, str]:
    """The place, the field and what is inside it that a key names. Raises SceneError."""
    if not isinstance(key, str) or len(key) > LONGEST_KEY:
        raise InputTypeError(f"key {show(key)}: must be a name such as {EXAMPLES}")
    place, rest = _found([*_places(scene)], key, show(key))
    name, _, inside = rest.partition(".")
    known = [entry.name for entry in fields(place.kind)]
    if name not in known:
        hint = nearest(name, known, f"{place.label}.") if name else f"name one, such as {_keys(place)[0]}"
        raise SceneError(f"{show(key)}: no such key; {hint}")
    return place, name, inside


def _places(scene: Changeable) -> Iterator[Place]:
    """All of a scene that has values."""
    yield from places_of(scene)
    if scene.mesh is not None and is_dataclass(scene.mesh.source):
        yield Place("mesh", 0, scene.mesh.source, "")
    for k, stage in enumerate(scene.stages):
        yield Place("stages", k, stage, stage.name)


def _singly(places: list[Place], values: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """Keys of single values: a table of several keys of one place is taken apart."""
    for key, value in values.items():
        if not isinstance(key, str) or len(key) > LONGEST_KEY:
            raise InputTypeError(f"key {show(key)}: must be a name such as {EXAMPLES}")
        is_whole_place = (found := located([*places, *_absent(places)], key)) is not None and not found[1]
        if isinstance(value, Mapping) and is_whole_place:
            if key.startswith("laws."):
                yield key, True
            for name, item in value.items():
                yield f"{key}.{name}", item
        else:
            yield key, value


def _absent(places: list[Place]) -> Iterator[Place]:
    """Laws that the scene lacks; each would stand behind the others."""
    there = {place.name for place in places if place.section == "laws"}
    for kind, law in LAWS.items():
        if kind not in there:
            yield Place("laws", len(there), law, kind)


def _found(places: list[Place], key: str, what: str) -> tuple[Place, str]:
    """The place that a key names, and the rest of the key. Raises SceneError."""
    place, rest = located([*places, *_absent(places)], key) or (None, "")
    if place is None:
        raise SceneError(f"{what}: this scene has no value of that name; {_hint(places, key)}")
    return place, rest


def _located(scene: Changeable, places: list[Place], key: str, value: object) -> tuple[Place, str]:
    """The place whose value a key sets, and the rest of the key. Raises SceneError."""
    what = _shown(key, value)
    place, rest = _found(places, key, what)
    if not rest and (place.section not in OPTIONAL or not isinstance(value, bool)):
        off = ", true or false" if place.section in OPTIONAL else ""
        raise SceneError(f"{what}: must be a table of its keys{off}; or set one key, such as {_keys(place)[0]}")
    if place.section == "run" and rest == "until" and scene.stages:
        last = scene.stages[-1].name
        raise SceneError(f"{what}: the run ends with the last of the stages; set stages.{last}.duration")
    return place, rest


def _field(change: Change, rest: str, what: str, value: Any) -> tuple[str, Any]:
    """The name of a field and its new value, from what a key says behind its place. Raises SceneError."""
    name, _, inside = rest.partition(".")
    item = change.place.item
    kind = change.place.kind
    renamed = new_names(kind)
    if name in renamed:
        deprecated(f"{change.place.label}.{name}", f"use {renamed[name]}", depth=3)
        name = renamed[name]
    known = [entry.name for entry in fields(kind)]
    if name not in known:
        raise SceneError(f"{what}: no such key; {nearest(name, known, f'{change.place.label}.')}")
    if not inside:
        if value == {} and not is_table(kind, name) and checked_class(kind, name) is not None:
            return name, None  # an empty table in place of one such as a schedule
        is_count = isinstance(value, float) and value.is_integer() and is_whole(kind, name)
        return name, int(value) if is_count else value
    now = change.values.get(name, None if isinstance(item, type) else getattr(item, name))
    if isinstance(now, Mapping):
        return name, {**now, inside: value}
    if not is_dataclass(now):
        raise SceneError(f"{what}: {change.place.label}.{name} is no table; leave .{inside} out")
    own = {entry.name: getattr(now, entry.name) for entry in fields(now)}
    if inside not in own:
        raise SceneError(f"{what}: no such key; {nearest(inside, own, f'{change.place.label}.{name}.')}")
    return name, {**own, inside: value}


def _changed(scene: Changeable, section: str, changes: list[Change]) -> dict[str, Any]:
    """The field of a scene that holds a section, with its changes."""
    if section == "mesh":
        (change,) = changes
        with computable("mesh"):
            return {"mesh": _rebuilt(change).mesh()}
    if section in ("material", "run"):
        return {section: _rebuilt(changes[0])}
    items = list(getattr(scene, section))
    for change in changes:
        made = None if change.is_gone else _rebuilt(change)
        if change.place.index < len(items):
            items[change.place.index] = made
        else:
            items.append(made)
    return {section: [item for item in items if item is not None]}


def _rebuilt(change: Change) -> Any:
    """What stands at a place, changed."""
    place, values = change.place, change.values
    if isinstance(place.item, type):
        return build(place.item, values, place.label)
    replaced = place.defaults([other for name in values for other in place.replaced_by(name)])
    made = place.rebuilt({**replaced, **values})
    if place.section == "laws":
        with labelled(place):
            made.check_set(place.item, values, is_first=True)
    return made


def _hint(places: list[Place], key: str) -> str:
    """What may have been meant by a key that names nothing."""
    section, last = key.partition(".")[0], key.rpartition(".")[2]
    if section in SINGLE and all(place.section != section for place in places):
        return f"it has no {section}"
    labels = [place.label for place in [*places, *_absent(places)]]
    known = ["name", *labels, *_all_keys(places)]
    others = [name for name, _ in OTHER_NAMES.get(last.lower(), ())]
    alike = [other for other in known if last in other.split(".") or other.split(".")[-1] in others]
    close = difflib.get_close_matches(key, alike or known, MOST_NAMED) or alike[:MOST_NAMED]
    if close:
        return "did you mean " + " or ".join(repr(other) for other in close) + "?"
    return f"give one such as {EXAMPLES}"


def _shown(key: str, value: object) -> str:
    """A key with its value, in messages."""
    return f"{key if key.isprintable() and 0 < len(key) <= LONGEST_SHOWN else show(key)} = {show(value)}"


def _all_keys(places: list[Place]) -> list[str]:
    """The keys of all places, and of laws that the scene lacks."""
    return [key for place in [*places, *_absent(places)] for key in _keys(place)]


def _keys(place: Place) -> list[str]:
    """The keys of a place."""
    return [f"{place.label}.{entry.name}" for entry in fields(place.item)]
