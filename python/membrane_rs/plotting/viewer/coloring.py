"""Values of a field as colours, and what a legend says of them."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs.plotting.actors import Colors
from membrane_rs.plotting.fields import MISSING, Field


@dataclass(frozen=True)
class Scale:
    """The colours of a field between two values; what lies beyond has the colour of the end.

    Attributes
    ----------
    field : Field
        The field.
    low, high : float
        The two values, in the unit of the field.

    Examples
    --------
    >>> import membrane_rs, numpy as np
    >>> from membrane_rs.plotting.viewer import Viewer
    >>> scale = Viewer(membrane_rs.run("hanging-strip", until=0.02, frames=3), color="speed").scale()
    >>> scale.low, scale.field.unit, scale.color(np.array([scale.low, np.nan])).shape
    (0.0, 'm/s', (2, 3))
    """

    field: Field
    low: float
    high: float

    @property
    def colors(self) -> Colors:
        """(k, 3) from the lowest to the highest value: one for each category, else many steps."""
        return self.field.colors()

    def color(self, values: Floats) -> Colors:
        """The colours of values.

        Parameters
        ----------
        values : (n,) float
            In the unit of the field; grey for NaN.

        Returns
        -------
        (n, 3) uint8
            Red, green, blue.
        """
        colors = np.vstack([self.colors, np.array([MISSING], np.uint8)])
        last = len(colors) - 2
        span = self.high - self.low
        shares = (values - self.low) / span if span > 0.0 and isfinite(span) else np.full(len(values), 0.5)
        rows = np.where(np.isnan(values), last + 1, np.clip(np.nan_to_num(shares, nan=0.0), 0.0, 1.0) * last)
        chosen: Colors = colors[rows.round().astype(np.int64)]
        return chosen
