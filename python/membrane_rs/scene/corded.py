"""What parts made of cords have in common."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

from membrane_rs.scene.cord import Cord
from membrane_rs.scene.part import Part
from membrane_rs.scene.plausible import Doubt, implausible

C = TypeVar("C", bound="Corded")

SLOWEST_WAVE, FASTEST_WAVE = 20.0, 3e4
"""sqrt(EA/mu) of a cord [m/s]: some 30 m/s in soft rubber, 18 km/s in carbon fibres."""
ALONE = 20.0
"""Gain of step from which cords count as the only stiff part."""


class Corded(Part):
    """A part whose fields describe a cord, or several alike."""

    if TYPE_CHECKING:  # fields, in the order of each part, are those of its own class
        segments: int
        axial_stiffness: float
        linear_density: float
        strain_limit: float

    def with_softened_film(self: C, factor: float) -> C:
        """Cords `factor` times as heavy, and no softer: the sail's pull stretches them far more than the film."""
        return _with(self, linear_density=self.linear_density * factor)

    def softened(self: C, factor: float) -> C:
        """Cords of `factor` times the axial stiffness."""
        return _with(self, axial_stiffness=self.axial_stiffness * factor)

    def step_advice(self, gain: float) -> str:
        """A smaller stiffness or fewer segments."""
        if gain > ALONE:
            return "nothing else comes near: with half of its segments the step is twice as long"
        fewer = max(1, math.floor(self.segments / gain))
        return (
            f"an axial_stiffness of {self.axial_stiffness / gain**2:.3g} N in place of {self.axial_stiffness:g} N, "
            f"or {fewer} segments in place of {self.segments}, would take it out of the limit"
        )

    def coarser(self, factor: int) -> tuple[str, Part] | None:
        """Cords of fewer segments."""
        if self.segments == 1:
            return None
        segments = max(1, self.segments // factor)
        return f"all but {segments} of {self.segments} segments", _with(self, segments=segments)


def _with(part: C, **values: Any) -> C:
    """The part with other values of its fields."""
    changed: Any = part
    made: C = replace(changed, **values)
    return made


def cord_of(part: Corded, length: float) -> Cord:
    """A cord of the part, of a length [m]."""
    return Cord(part.segments, length, part.axial_stiffness, part.linear_density, part.strain_limit)


class Line(Protocol):
    """What has the stiffness and the mass of a cord."""

    @property
    def axial_stiffness(self) -> float:
        """EA [N]."""

    @property
    def linear_density(self) -> float:
        """Mass per length [kg/m]."""


def implausible_waves(part: Line, where: str) -> Iterator[Doubt]:
    """A wave runs along a cord as it does along some material."""
    if part.linear_density == 0.0:
        return
    speed = math.sqrt(part.axial_stiffness / part.linear_density)
    reason = f"with axial_stiffness = {part.axial_stiffness:g} N a wave would run along the cord at {speed:.3g} m/s, "
    reason += f"and in cords it runs at {SLOWEST_WAVE:g} to {FASTEST_WAVE:g} m/s"
    heaviest, lightest = (part.axial_stiffness / bound**2 for bound in (SLOWEST_WAVE, FASTEST_WAVE))
    place, units = f"{where}.linear_density", {"g/m": 1e-3, "mg/m": 1e-6}
    bounds = {"least": lightest, "most": heaviest}
    derived = (f"{where}.axial_stiffness",)
    yield from implausible(place, part.linear_density, "kg/m", reason, **bounds, units=units, derived_from=derived)
