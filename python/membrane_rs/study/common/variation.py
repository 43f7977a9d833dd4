"""A scene with one of its values changed, by the value's name in the scene file."""

from __future__ import annotations

from typing import Any

from membrane_rs.scene import Scene
from membrane_rs.study.common.stages import refuse_stages


def varied(scene: Scene, parameter: str, value: Any) -> Scene:
    """A scene without stages with `parameter` set, as `Scene.with_values` does it. Raises InputError."""
    refuse_stages(scene)
    return scene.with_values({parameter: value})
