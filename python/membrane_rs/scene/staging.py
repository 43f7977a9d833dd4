"""The scenes of the stages of a scene: each without what is not at work in it, and with its values."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, fields, replace
from typing import Any, TypeVar

import numpy as np

from membrane_rs._validation import in_si, is_list, nearest, number_of, show
from membrane_rs.errors import InputError, InputTypeError, SceneError
from membrane_rs.scene.assembly import Assembly
from membrane_rs.scene.places import SINGLE, Changeable, Place, labelled, located, names_of, places_of
from membrane_rs.scene.run_settings import LONGEST, MOST_INSTANTS
from membrane_rs.scene.stage import Stage, has_text

MOST_STAGES = 100
OF_A_STAGE = (
    "integrator", "dt", "tolerance", "tolerance_length", "tolerance_speed", "spectral_radius", "substeps", "watch",
    "energy_loss",
)  # fmt: skip
"""Run settings that a stage may set; the others are those of the whole run."""
SECTIONS = ("material", "laws", "parts", "bodies", "run")
"""What dotted keys begin with."""


S = TypeVar("S", bound=Changeable)


def planned_starts(stages: Sequence[Stage]) -> list[float]:
    """Start of each stage, and the end of the last one, where none ends before its time [s]."""
    return [math.fsum(stage.duration for stage in stages[:k]) for k in range(len(stages) + 1)]


def checked_starts(starts: object, index: int) -> tuple[float, ...]:
    """Start of each stage up to one [s], as a caller gives them. Raises InputError and InputTypeError."""
    wanted = f"must be {index + 1} ascending times (s): the start of each stage up to stage {index}"
    if not is_list(starts):
        raise InputTypeError(f"starts = {show(starts)}: {wanted}")
    found = tuple(number_of("starts", time) for time in starts)
    if len(found) != index + 1 or sorted(found) != list(found):
        raise InputError(f"starts = {show(starts)}: {wanted}")
    return found


def check_stages(scene: Changeable) -> None:
    """Refuse stages that contradict each other or the scene. Raises SceneError."""
    stages = scene.stages
    if len(stages) > MOST_STAGES:
        raise SceneError(f"stages: {len(stages)} of them; must be at most {MOST_STAGES}")
    names = [stage.name for stage in stages]
    twice = next((k for k, name in enumerate(names) if name in names[:k]), None)
    if twice is not None:
        raise SceneError(f"stages[{twice}].name = {show(names[twice])}: is that of an earlier stage too; rename one")
    if planned_starts(stages)[-1] > LONGEST:
        raise SceneError(f"stages: last {planned_starts(stages)[-1]:g} s in all; must be at most {LONGEST:g} (s)")
    for key in ("frames", "samples"):
        count = sum(getattr(stage, key) or 0 for stage in stages)
        if count > MOST_INSTANTS:
            raise SceneError(f"stages: {count} {key} in all; must be at most {MOST_INSTANTS}")


def in_numbers(scene: Changeable) -> tuple[Stage, ...]:
    """The stages of a scene, with numbers in place of texts with units in what they set. Raises SceneError."""
    places, made = list(places_of(scene)), []
    for k, stage in enumerate(scene.stages):
        own = {}
        for key, value in stage.set.items():
            if has_text(value):
                place, name = _find(places, key, where := f"stages[{k}].set")
                try:
                    own[key] = in_si(type(place.item), {name: value}, f"{where}: {place.label}")[name]
                except InputError as error:
                    raise SceneError(str(error)) from None
        made.append(replace(stage, set={**stage.set, **own}) if own else stage)
    return tuple(made)


def check_same_nodes(first: Assembly, other: Assembly, where: str) -> None:
    """Refuse a stage with other nodes than the first one. Raises SceneError."""
    if (
        first.node_count == other.node_count
        and np.array_equal(first.cords.nodes, other.cords.nodes)
        and first.node_sets.keys() == other.node_sets.keys()
        and all(np.array_equal(first.node_sets[name], other.node_sets[name]) for name in first.node_sets)
    ):
        return
    raise SceneError(
        f"{where}: has other nodes or cords than the first stage; parts with nodes of their own must be at work in all "
        "stages, with as many segments"
    )


def staged(scene: S, index: int, starts: Sequence[float]) -> S:
    """The scene of a stage, without stages, from the start times [s] of all stages up to it. Raises SceneError."""
    stage, where = scene.stages[index], f"stages[{index}]"
    places = list(places_of(scene))
    run_of = Run(scene, places, starts)
    try:
        gone = _gone(places, stage, where)
        values = _values(scene, places, index, starts)
        for place in gone:
            changed = next((key for key in (*stage.scale, *stage.set) if _find(places, key, where)[0] is place), None)
            if changed is not None:
                raise SceneError(f"{where}: {changed!r} is not at work in this stage; leave it out here or in without")
        made: dict[str, list[Any]] = {section: [] for section in SECTIONS}
        for place in places:
            if place not in gone:
                own = values.get((place.section, place.index))
                made[place.section].append(run_of.item(place, index, own))
        run = made["run"][0]
        until = starts[index] + stage.duration
        whole: Any = scene
        with _numbered_as_in_scene([place for place in places if place not in gone]):
            found: S = replace(
                whole,
                material=next(iter(made["material"]), None),
                laws=made["laws"],
                parts=made["parts"],
                bodies=made["bodies"],
                run=replace(run, until=until, relax=run.relax if index == 0 else 0.0),
                stages=(),
            )
        return found
    except InputError as error:
        text = str(error)
        raise SceneError(text if text.startswith(where) else f"{where}: {text}") from None


@dataclass(frozen=True)
class Run:
    """A scene with the start of each of its stages up to one."""

    scene: Changeable
    places: Sequence[Place]
    starts: Sequence[float]
    """[s]"""

    def item(self, place: Place, index: int, own: Mapping[str, Any] | None) -> Any:
        """What stands at a place in a stage, with its own values of that stage. Raises InputError."""
        stage, where = self.scene.stages[index], f"stages[{index}]"
        item, delay = place.item, self.starts[0]
        if delay:
            item = place.rebuilt(_delayed(item, delay), where)
        if own is not None:
            item = replace(place, item=item).rebuilt(own, where)
        is_set, changed = (
            [name for found, name in (_find(self.places, key, where) for key in keys) if found is place]
            for keys in (stage.set, (*stage.set, *stage.scale))
        )
        with labelled(place, where):
            if place.section == "laws":
                item.check_set(place.item, changed, is_first=index == 0)
            elif place.section == "parts":
                item.check_set(place.item, changed)
        if place.section != "laws":
            return item
        if is_set:
            item = item.within(self.starts[index], self.starts[index] + stage.duration)
        return item.carried(lambda: self._before(place, index), self.starts[index]) if index else item

    def _before(self, place: Place, index: int) -> Any:
        """The law at a place in the stage before one; None where that is without it."""
        before = index - 1
        if place.name in self.scene.stages[before].without:
            return None
        values = _values(self.scene, self.places, before, self.starts)
        return self.item(place, before, values.get((place.section, place.index)))


@contextmanager
def _numbered_as_in_scene(kept: Sequence[Place]) -> Iterator[None]:
    """Name parts and bodies in an error by their indices in the scene, of which these places are kept."""

    def in_scene(found: re.Match[str]) -> str:
        indices = [place.index for place in kept if place.section == found[1]]
        return f"{found[1]}[{indices[int(found[2])]}]" if int(found[2]) < len(indices) else found[0]

    try:
        yield
    except InputError as error:
        raise type(error)(re.sub(r"\b(parts|bodies)\[(\d+)\]", in_scene, str(error))) from None


def _gone(places: Sequence[Place], stage: Stage, where: str) -> list[Place]:
    """What is not at work in a stage."""
    named = {place.name: place for place in places if place.name}
    for name in stage.without:
        if name not in named:
            hint = nearest(name, named) if named else "this scene has none"
            what = "no law of that kind, and no part or body of that name, in the scene"
            raise SceneError(f"{where}.without: {name!r}: {what}; {hint}")
    return [named[name] for name in stage.without]


@dataclass
class Changes:
    """What stages have changed of one thing, up to one of them."""

    place: Place
    values: dict[str, Any] = field(default_factory=dict)
    """By the names of fields."""
    replaced: set[str] = field(default_factory=set)
    """Fields in whose place another one stands: they have their defaults."""

    def now(self, name: str) -> Any:
        """The value of a field."""
        return self.all().get(name, getattr(self.place.item, name, None))

    def all(self) -> dict[str, Any]:
        """All values that are not those of the scene."""
        return self.place.defaults(self.replaced) | self.values

    def set(self, name: str, value: Any, others: Sequence[str]) -> None:
        """Set a field, in place of others."""
        self.values = {other: own for other, own in self.values.items() if other not in others} | {name: value}
        self.replaced = (self.replaced - {name}) | set(others)


def _values(
    scene: Changeable, places: Sequence[Place], index: int, starts: Sequence[float]
) -> dict[tuple[str, int], dict[str, Any]]:
    """The values of a stage in place of those of the scene, by place and key."""
    found = {(place.section, place.index): Changes(place) for place in places}
    for k, stage in enumerate(scene.stages[: index + 1]):
        where, is_last = f"stages[{k}]", k == index
        own: dict[tuple[str, int], dict[str, Any]] = {}
        for key, value in stage.set.items():
            place, name = _find(places, key, f"{where}.set")
            own.setdefault((place.section, place.index), {})[name] = value
        for key_of_place, values in own.items():
            changes = found[key_of_place]
            place = changes.place
            replaced = {name: place.replaced_by(name) for name in values}
            others = {name: [other for other in replaced[name] if other not in values] for name in values}
            defaults = place.defaults([other for of_name in others.values() for other in of_name])
            made = place.rebuilt(changes.all() | defaults | values, where)
            for name in values:
                value, names = getattr(made, name), (name, *replaced[name])
                holds = _is_schedule(value) or any(
                    _is_schedule(changes.now(other)) or other in changes.values for other in names
                )
                holds = holds or not place.held_fields.isdisjoint(values)
                if is_last or holds:
                    changes.set(name, value.delayed(starts[k]) if _is_schedule(value) else value, others[name])
    for key, factor in scene.stages[index].scale.items():
        place, name = _find(places, key, f"stages[{index}].scale")
        where = f"stages[{index}].scale: {key!r}"
        if place.section == "run":
            raise SceneError(f"{where}: settings of the run are not scaled; set them")
        if name not in {item.name for item in fields(place.item)}:
            place.rebuilt({name: factor}, f"stages[{index}]")  # raises, and says which keys there are
        changes = found[place.section, place.index]
        value = changes.now(name)
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise SceneError(f"{where}: is {show(value)}, no number, so it is not scaled; set it")
        changes.values[name] = value * factor
    return {key: changes.all() for key, changes in found.items() if changes.all()}


def _find(places: Sequence[Place], key: str, where: str) -> tuple[Place, str]:
    """What a dotted key names, and the name of its field. Raises SceneError."""
    section, _, rest = key.partition(".")
    known = sorted({place.section for place in places})
    if section not in known:
        raise SceneError(f"{where}: {key!r}: does not begin with {', '.join(known)}; {nearest(section, known)}")
    place, field = located(places, key) or (None, "")
    if place is None or not field:
        named = names_of([place for place in places if place.section == section])
        name, example = rest.rpartition(".")[0], f"{section}.{next(iter(named), 'name')}.key"
        if not name:
            what = f"is no key of a value; write one such as {example!r}, in quotes in files"
            raise SceneError(f"{where}: {key!r}: {what}")
        hint = nearest(name, named) if named else "the scene has none"
        raise SceneError(f"{where}: {key!r}: {section} has no {name!r}; {hint}. A key is such as {example!r}")
    if section == "run" and field not in OF_A_STAGE:
        raise SceneError(f"{where}: {key!r}: is no setting of a stage; {nearest(field, OF_A_STAGE)}")
    if section not in SINGLE and field == "name":
        raise SceneError(f"{where}: {key!r}: a stage renames nothing; leave it out")
    return place, field


def _delayed(item: Any, by: float) -> dict[str, Any]:
    """The schedules among the fields of something, later by a time [s]."""
    values = {field.name: getattr(item, field.name) for field in fields(item)}
    return {name: value.delayed(by) for name, value in values.items() if _is_schedule(value)}


def _is_schedule(value: object) -> bool:
    return hasattr(value, "delayed")
