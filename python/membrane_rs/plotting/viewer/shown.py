"""What a viewer gives to be drawn."""

from __future__ import annotations

from dataclasses import dataclass

from membrane_rs._arrays import Floats, Ints
from membrane_rs.analysis.attitude import Turn
from membrane_rs.plotting.actors import Colors
from membrane_rs.plotting.viewer.coloring import Scale
from membrane_rs.scene.solid import Solid


@dataclass(frozen=True)
class Shown:
    """What is to be drawn.

    Attributes
    ----------
    positions : (N, 3) float64
        In the frame that turns with the hub [m].
    hub_angle : float or (4,) float64
        By which all is turned about z [rad], 0 in the turning frame; or the quaternion of a hub in six degrees of
        freedom.
    solids : tuple of Solid
        Bodies as they stand.
    upper, lower : (m, 3) uint8
        Colours of both sides of the film.
    node_values : (N,) float64 or None
        By which the film is coloured in their place, between the nodes as well, in the unit of the field.
    lines, line_colors : (k, 2) int64, (k, 3) uint8
        Lines with colours of their own; none for a field on the film.
    scale : Scale or None
        For the legend.

    Examples
    --------
    >>> import membrane_rs
    >>> from membrane_rs.plotting.viewer import Viewer
    >>> shown = Viewer(membrane_rs.run("hanging-strip", until=0.02, frames=3)).shown()
    >>> shown.positions.shape[1], shown.solids, shown.hub_angle
    (3, (), 0.0)
    """

    positions: Floats
    hub_angle: Turn
    solids: tuple[Solid, ...]
    upper: Colors
    lower: Colors
    node_values: Floats | None
    lines: Ints
    line_colors: Colors
    scale: Scale | None
