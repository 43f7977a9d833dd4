"""The softening of a scene's film: what it is, and the scene with another one."""

from __future__ import annotations

from dataclasses import replace

from membrane_rs.scene.scene import Scene


def softening_of(scene: Scene) -> float | None:
    """Of its material [-], above 1; None without one, or without material."""
    factor = None if scene.material is None else scene.material.softening
    return None if factor == 1.0 else factor


def with_softening(scene: Scene, factor: float | None) -> Scene:
    """The scene with this softening [-], or with the film as it is; itself where that is what it has."""
    if scene.material is None or scene.material.softening == factor:
        return scene
    return replace(scene, material=replace(scene.material, softening=factor))
