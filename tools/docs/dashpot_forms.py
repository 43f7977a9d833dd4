"""The forms of the dashpots that docs/dashpots.md compares, and scenes with them."""

from __future__ import annotations

from dataclasses import replace

from membrane_rs import Scene, SpringDamping

PAPER, DEFAULT, ALL = "the paper's: mean mass, no limit", "cords limited (the default)", "cords and film limited"
REDUCED, FREE, NONE = "reduced mass, cords limited", "reduced mass, no limit", "no dashpots"
FORMS: dict[str, SpringDamping] = {
    PAPER: SpringDamping(limited="none"),
    DEFAULT: SpringDamping(),
    ALL: SpringDamping(limited="all"),
    REDUCED: SpringDamping(mass="reduced"),
    FREE: SpringDamping(limited="none", mass="reduced"),
    NONE: SpringDamping(0.0),
}
"""By their names in tables; the ratio is that of the scene, but 0 without dashpots."""


def damped(scene: Scene, damping: SpringDamping) -> Scene:
    """The scene with these dashpots in place of its own, at its own ratio."""
    own = scene.law(SpringDamping)
    law = replace(damping, ratio=own.ratio) if own and damping.ratio else damping
    return replace(scene, laws=[law if each.kind == law.kind else each for each in scene.laws])
