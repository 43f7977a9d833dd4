"""Studies compare runs of one scene without stages."""

from __future__ import annotations

from membrane_rs.errors import InputError
from membrane_rs.scene import Scene


def refuse_stages(scene: Scene) -> None:
    """Raise InputError for a scene with stages, of which a study would compare no one knows which."""
    if scene.stages:
        raise InputError(
            f"scene {scene.name!r} has {len(scene.stages)} stages; a study compares runs of a scene without: give it "
            "a scene file without [[stages]], or the first stage, which Python makes: scene.staged(0), and "
            "scene.staged(0).save(folder) as a file"
        )
