"""A cord of a scene: a chain of segments."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs.scene.schedule import Schedule


@dataclass(frozen=True)
class Cord:
    """A chain of segments, each a spring that buckles."""

    segments: int
    length: float
    """Without load [m]."""
    axial_stiffness: float
    """EA [N]."""
    linear_density: float
    """Mass per length [kg/m]."""
    strain_limit: float
    """Of a segment; a run stops beyond it."""
    critical_strain: float = 0.0
    """Compressive strain at which a segment buckles [-]; 0: it bears tension alone."""
    shares: Floats | None = None
    """(segments,) share of each in the length [-]; None: all are equal."""
    winch: Schedule | None = None
    """Factor of the length as a function of time [-]."""

    @property
    def rest_lengths(self) -> Floats:
        """(segments,) of the segments without load [m]."""
        return np.full(self.segments, self.length / self.segments) if self.shares is None else self.length * self.shares
