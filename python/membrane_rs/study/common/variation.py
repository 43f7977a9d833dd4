"""A scene with one of its values changed, by the value's name in the scene file."""

from __future__ import annotations

from dataclasses import fields, is_dataclass, replace
from typing import Any

from membrane_rs._renamed import new_names
from membrane_rs._validation import nearest, show
from membrane_rs.errors import InputTypeError, SceneError
from membrane_rs.scene import Scene
from membrane_rs.scene.laws import LAWS
from membrane_rs.study.common.stages import refuse_stages


def varied(scene: Scene, parameter: str, value: Any) -> Scene:
    """The scene with `parameter` set: laws.creases.stiffness, parts.0.axial_stiffness, material.thickness,
    mesh.rows or run.dt.

    A law that the scene lacks is added with its defaults.

    Raises
    ------
    SceneError
        No such parameter; the nearest known one is named.
    InputError
        A value outside its range.
    """
    if not isinstance(parameter, str):
        raise InputTypeError(f"parameter = {show(parameter)}: must be a name such as 'laws.creases.stiffness'")
    refuse_stages(scene)
    head, *rest = parameter.split(".")
    if head == "laws" and len(rest) == 2:
        kind = _known(rest[0], list(LAWS), "laws")
        law = scene.law(kind)
        laws = [other for other in scene.laws if other.kind != kind]
        if law is None:
            names = [item.name for item in fields(LAWS[kind])]
            new = LAWS[kind](**{_known(rest[1], names, f"laws.{kind}"): value})
        else:
            new = _changed(law, rest[1], value, f"laws.{kind}")
        return replace(scene, laws=[*laws, new])
    if head == "parts" and len(rest) == 2:
        parts = list(scene.parts)
        row = int(_known(rest[0], [str(i) for i in range(len(parts))], "parts"))
        parts[row] = _changed(parts[row], rest[1], value, f"parts.{row}")
        return replace(scene, parts=parts)
    if head == "material" and len(rest) == 1 and scene.material is not None:
        return replace(scene, material=_changed(scene.material, rest[0], value, "material"))
    if head == "run" and len(rest) == 1:
        return replace(scene, run=_changed(scene.run, rest[0], value, "run"))
    if head == "mesh" and len(rest) == 1 and scene.mesh is not None and is_dataclass(scene.mesh.source):
        pattern: Any = _changed(scene.mesh.source, rest[0], value, "mesh")
        return replace(scene, mesh=pattern.mesh())
    raise SceneError(
        f"parameter {parameter!r}: this scene has none of that name; give one such as laws.creases.stiffness, "
        "parts.0.axial_stiffness, material.thickness, mesh.rows (of a pattern) or run.dt"
    )


def _changed(part: Any, name: str, value: Any, where: str) -> Any:
    key = _known(new_names(type(part)).get(name, name), [item.name for item in fields(part)], where)
    old = getattr(part, key)
    whole = isinstance(old, int) and not isinstance(old, bool) and isinstance(value, float) and value.is_integer()
    return replace(part, **{key: int(value) if whole else value})


def _known(name: str, names: list[str], where: str) -> str:
    if name not in names:
        raise SceneError(f"parameter {where}.{name}: no such key; {nearest(name, names)}")
    return name
