"""Values of laws and parts that are hardly meant."""

from __future__ import annotations

from collections.abc import Iterator

from membrane_rs.mesh import Finding
from membrane_rs.scene import Scene


def law_and_part_values(scene: Scene) -> Iterator[Finding]:
    """What each law and each part says of its own values."""
    for law in scene.laws:
        yield from law.implausible_values(scene, f"laws.{law.kind}")
    for k, part in enumerate(scene.parts):
        yield from part.implausible_values(scene, f"parts[{k}]")
