"""What a scene holds, checked: its lists of laws, parts, bodies and stages, and their names."""

from __future__ import annotations

from collections.abc import Sequence

from membrane_rs._validation import check_text, show
from membrane_rs.errors import InputTypeError, SceneError
from membrane_rs.scene.bodies import Body
from membrane_rs.scene.laws import LAWS
from membrane_rs.scene.parts import PARTS

LONGEST_NAME = 100
OF_PARTS = ("tethers", "bridges", *(part.working_law for part in PARTS.values() if part.working_law is not None))
"""Laws of the core that come with parts."""
OF_ENERGY = ("kinetic", "error", "of_changes", "turned_over")
"""Terms of the energy, and what else history.csv has in a column energy_<name>, by old names too."""


def check_names(bodies: Sequence[Body]) -> None:
    """Each body has a name of its own among laws, bodies and their frictions, and the terms of the energy."""
    taken = dict.fromkeys((*LAWS, *OF_PARTS), "a law") | dict.fromkeys(OF_ENERGY, "a term of the energy")
    for k, body in enumerate(bodies):
        for name in filter(None, (body.name, body.friction_name)):
            if name in taken:
                what = f"{name} is the name of {taken[name]} too; rename it"
                raise SceneError(f"bodies[{k}].name = {show(body.name)}: {what}")
            taken[name] = f"bodies[{k}]"


def check_type(name: str, value: object, kinds: tuple[type, ...], wanted: str) -> None:
    """Refuse what is not of a kind."""
    if not isinstance(value, kinds):
        raise InputTypeError(f"Scene.{name} = {show(value)}: must be {wanted}")


def check_name(name: str, where: str = "Scene.name") -> None:
    """The name becomes a folder's, so it must be one plain component of a path, which files can hold."""
    check_text(name, f"{where} =", SceneError)
    if name in ("", ".", "..") or len(name) > LONGEST_NAME or any(sign in name for sign in "/\\\0"):
        raise SceneError(
            f"{where} = {show(name)}: names a folder; must be 1 to {LONGEST_NAME} characters without slash, "
            "backslash or NUL, and neither '.' nor '..'"
        )


def checked(name: str, items: object, kinds: tuple[type, ...]) -> tuple[object, ...]:
    """A list of things of these kinds, as a tuple."""
    if isinstance(items, (str, bytes)) or not isinstance(items, Sequence):
        raise InputTypeError(f"Scene.{name} = {show(items)}: must be a list of {name}")
    for i, item in enumerate(items):
        known = ", ".join(kind.__name__ for kind in kinds)
        check_type(f"{name}[{i}]", item, kinds, f"one of {known}; with its brackets")
    return tuple(items)
