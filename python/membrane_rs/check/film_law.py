"""Whether the film has a law."""

from __future__ import annotations

from collections.abc import Iterator

from membrane_rs.mesh import Finding
from membrane_rs.scene import Scene
from membrane_rs.scene.laws import LAWS


def film_law(scene: Scene) -> Iterator[Finding]:
    """A membrane without a law of the film is a set of masses that nothing holds together."""
    if scene.mesh is not None and not any(law.is_film for law in scene.laws):
        names = " or ".join(f"[laws.{kind}]" for kind, law in LAWS.items() if law.is_film)
        yield Finding(
            "warning",
            "film_law",
            1,
            "there is no law of the film: nothing holds its nodes together, and it stretches without a force",
            f"add {names}",
        )
