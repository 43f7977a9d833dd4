"""The factor of a load as a function of time."""

from __future__ import annotations

from membrane_rs.scene.schedule import Schedule


def largest_factor(factor: Schedule | None) -> float:
    """The largest magnitude of a factor [-]; 1 where there is none."""
    return 1.0 if factor is None else max(map(abs, factor.values))
