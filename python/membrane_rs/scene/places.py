"""The places of a scene that dotted keys name: its material, laws, parts, bodies, stages, mesh and run settings."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, fields
from typing import Any, Protocol

from membrane_rs._validation import build
from membrane_rs.errors import InputError
from membrane_rs.material import Material
from membrane_rs.mesh import Mesh
from membrane_rs.scene.bodies import Body
from membrane_rs.scene.law import Law
from membrane_rs.scene.part import Part
from membrane_rs.scene.run_settings import RunSettings
from membrane_rs.scene.stage import Stage

SINGLE = ("material", "run", "mesh")
"""Sections that are one thing, without a name between section and key."""


class Changeable(Protocol):
    """What of a scene dotted keys name."""

    @property
    def mesh(self) -> Mesh | None:
        """The membrane."""

    @property
    def material(self) -> Material | None:
        """Of the membrane."""

    @property
    def laws(self) -> Sequence[Law]:
        """All laws."""

    @property
    def parts(self) -> Sequence[Part]:
        """All parts."""

    @property
    def bodies(self) -> Sequence[Body]:
        """All bodies."""

    @property
    def run(self) -> RunSettings:
        """How it is run."""

    @property
    def stages(self) -> Sequence[Stage]:
        """The stages."""


@dataclass(frozen=True)
class Place:
    """Something of a scene whose values have dotted keys."""

    section: str
    index: int
    item: Any
    """What stands here; of a law that the scene lacks, its class."""
    name: str
    """Of the law, part, body or stage; empty where it has none."""

    @property
    def kind(self) -> type[Any]:
        """The class of what stands here, or which would stand here."""
        return self.item if isinstance(self.item, type) else type(self.item)

    @property
    def label(self) -> str:
        """What stands before its keys: "material", "laws.creases", "parts.0"."""
        return self.section if self.section in SINGLE else f"{self.section}.{self.name or self.index}"

    def replaced_by(self, name: str) -> Sequence[str]:
        """Fields that the field of this name stands in place of: they get their defaults where it is set."""
        replaced: Sequence[str] = self.item.replaced_by(name) if self.section == "laws" else ()
        return replaced

    @property
    def held_fields(self) -> frozenset[str]:
        """Fields that hold in later stages too where a stage sets them, and all that is set beside them."""
        return frozenset(self.item.held_fields if self.section == "laws" else ())

    def defaults(self, names: Collection[str]) -> dict[str, Any]:
        """The defaults of fields."""
        return {entry.name: entry.default for entry in fields(self.item) if entry.name in names}

    def rebuilt(self, values: Mapping[str, Any], where: str = "") -> Any:
        """What stands here with other values of its fields, checked by its own class. Raises InputError."""
        own = {field.name: getattr(self.item, field.name) for field in fields(self.item)}
        return build(type(self.item), own | dict(values), f"{where}: {self.label}" if where else self.label)


@contextmanager
def labelled(place: Place, where: str = "") -> Iterator[None]:
    """Name what stands at a place by its keys, in an error that begins with its class."""
    try:
        yield
    except InputError as error:
        text = str(error).removeprefix(f"{place.kind.__name__}.")
        raise type(error)(f"{where}: {place.label}.{text}" if where else f"{place.label}.{text}") from None


def places_of(scene: Changeable) -> Iterator[Place]:
    """What a stage of a scene may change: all but its mesh and its stages."""
    if scene.material is not None:
        yield Place("material", 0, scene.material, "")
    for k, law in enumerate(scene.laws):
        yield Place("laws", k, law, law.kind)
    for k, part in enumerate(scene.parts):
        yield Place("parts", k, part, part.name or "")
    for k, body in enumerate(scene.bodies):
        yield Place("bodies", k, body, body.name)
    yield Place("run", 0, scene.run, "")


def located(places: Sequence[Place], key: str) -> tuple[Place, str] | None:
    """What a dotted key names, and the rest of the key, which is its field; None where it names nothing."""
    section, _, rest = key.partition(".")
    of_section = [place for place in places if place.section == section]
    if section in SINGLE:
        return (of_section[0], rest) if of_section else None
    named = names_of(of_section)
    name = max((name for name in named if f"{rest}.".startswith(f"{name}.")), key=len, default=None)
    return None if name is None else (named[name], rest[len(name) + 1 :])


def names_of(of_section: Sequence[Place]) -> dict[str, Place]:
    """The places of a section by their names, and by their indices where these name them too."""
    named = {place.name: place for place in of_section if place.name}
    return named | {str(place.index): place for place in of_section if place.section != "laws"}
