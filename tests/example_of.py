"""An instance of any checked class, made from the types of its fields: for tests that walk a list."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, get_args, get_origin

from membrane_rs import Schedule

LENGTH, COUNT = 0.1, 4
BESIDE_OTHERS = ("torque",)
"""Fields that a class refuses without another one."""


ONE_OF_SEVERAL: dict[str, dict[str, Any]] = {"region": {"nodes": "some_name"}, "crease_set": {"stiffness": 2.0}}
"""Fields of which a kind needs one, though each has a default."""


def example_of(cls: type[Any], **changes: Any) -> Any:
    """An instance: fields without a default get a value of their type, each number and point another one.

    Fields for a schedule get one too, but for those that stand beside another field: a class may need one of several.
    """
    return cls(**(needed(cls) | changes))


def needed(cls: type[Any]) -> dict[str, Any]:
    """Values for the fields that have no default, and for those of schedules."""
    known: Mapping[str, Any] = cls.__pydantic_fields__
    return ONE_OF_SEVERAL.get(getattr(cls, "kind", ""), {}) | {
        name: _value(info.annotation, k)
        for k, (name, info) in enumerate(known.items())
        if info.is_required() or (_is_schedule(info.annotation) and name not in BESIDE_OTHERS)
    }


def _is_schedule(kind: Any) -> bool:
    return Schedule in get_args(kind)


def _bare(kind: Any) -> Any:
    """A type without what is annotated to it."""
    return get_args(kind)[0] if get_origin(kind) is Annotated else kind


def _value(kind: Any, k: int) -> Any:
    if kind is float:
        return LENGTH * (k + 1)
    if kind is int:
        return COUNT
    if kind is str:
        return "some_name"
    if _is_schedule(kind):
        return Schedule((0.0, 1.0), (0.0, LENGTH))
    if (vector := next((one for one in map(_bare, get_args(kind)) if get_origin(one) is tuple), None)) is not None:
        kind = vector
    if get_origin(kind) is tuple:
        return tuple(LENGTH * (k + i) for i, _ in enumerate(get_args(kind)))
    if any(get_origin(one) is Sequence for one in get_args(kind)):
        return (0,)
    raise NotImplementedError(f"a field of type {kind}: say here what to make of it")
