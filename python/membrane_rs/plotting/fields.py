"""What a membrane can be coloured by: the one list of fields, read from the frames of a run.

name                         where      unit  values
largest_principal_stress     triangles  Pa    S1, of the second Piola-Kirchhoff stress; see `Motion.film_stress`
von_mises                    triangles  Pa    sqrt(S1^2 - S1 S2 + S2^2)
largest_principal_strain     triangles        of the Green-Lagrange strain
state                        triangles        0 taut, 1 wrinkled, 2 slack
spring_strain                lines            l / L - 1
buckled                      lines            1 below the critical length, else 0
crease_angle                 lines      deg   180 flat, 0 shut, 360 shut against its side, below 0 where facets cross
tension                      lines      N     elastic tension of the segments of cords
speed                        nodes      m/s   magnitude of the velocity, in the frame that turns with the hub

The state of a film of triangles is that of its law (`Motion.film_states`). A film of springs has none: a triangle
counts as slack where all its sides are buckled, and as wrinkled where some are.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from membrane_rs._arrays import Floats, Ints
from membrane_rs._validation import count_of
from membrane_rs.mesh.queries import find_pairs

Place = Literal["nodes", "triangles", "lines"]
TAUT, WRINKLED, SLACK = 0, 1, 2
STEPS, MOST_STEPS = 256, 2**16
"""Colours of a scale of measured values, and how many there may be."""
MISSING = (170, 176, 186)
"""Colour where a field has no value."""
BARE = (205, 210, 218)
"""Colour of the film where lines are coloured."""
LARGEST = 1e30
"""Larger values are damaged, and counted as missing: pictures are drawn in single precision."""
SHARE = 0.99
"""Share of the values of a frame that a scale of colours holds: a few corners of a fold have ten times the others'."""


class FieldFrame(Protocol):
    """What is read from a frame of a run: nodes (N, 3), triangles (m, 3), lines (s, 2), and values on each."""

    @property
    def triangles(self) -> Ints:
        """(m, 3) node indices."""

    @property
    def lines(self) -> Ints:
        """(s, 2) node indices."""

    @property
    def on_nodes(self) -> Mapping[str, NDArray[Any]]:
        """Arrays of N rows."""

    @property
    def on_triangles(self) -> Mapping[str, NDArray[Any]]:
        """Arrays of m rows."""

    @property
    def on_lines(self) -> Mapping[str, NDArray[Any]]:
        """Arrays of s rows."""


@dataclass(frozen=True)
class Field:
    """A field by which a membrane can be coloured.

    Attributes
    ----------
    name : str
        By which it is chosen, such as "von_mises".
    label : str
        For legends, without the unit.
    unit : str
        "Pa", "deg", ...; empty for a number without a unit.
    place : {"nodes", "triangles", "lines"}
        Where its values lie.
    categories : tuple of str
        What the whole numbers from 0 on mean; empty where the values are measured.
    colormap : str
        matplotlib's name of the scale of colours.
    array : str
        What frames call the array that it is read from; empty where that is its own name.

    Examples
    --------
    >>> import membrane_rs
    >>> from membrane_rs.plotting.viewer import Viewer
    >>> run = membrane_rs.run("hanging-strip", until=0.02, frames=3)
    >>> field = Viewer(run, color="speed").scale().field
    >>> field.title, field.place, field.colors(2).shape, field.values(run.frames[0]).max().item()
    ('Speed [m/s]', 'nodes', (2, 3), 0.0)
    """

    name: str
    label: str
    unit: str
    place: Place
    _read: Callable[[FieldFrame], Floats | None]
    categories: tuple[str, ...] = ()
    colormap: str = "viridis"
    array: str = ""

    @property
    def title(self) -> str:
        """Label and unit, such as "Von Mises stress [Pa]"."""
        return f"{self.label} [{self.unit}]" if self.unit else self.label

    def colors(self, steps: int = STEPS) -> NDArray[np.uint8]:
        """Colours from the lowest to the highest value.

        Parameters
        ----------
        steps : int
            How many, where the values are measured; else there is one for each category.

        Returns
        -------
        (k, 3) uint8
            Red, green, blue.

        Raises
        ------
        InputError, InputTypeError
            No number of colours.
        """
        from matplotlib import colormaps

        steps = count_of("steps", steps, 1, MOST_STEPS, "colours of a scale")
        shares = np.linspace(0.0, 1.0, len(self.categories) or steps)
        return np.round(255.0 * np.asarray(colormaps[self.colormap](shares))[:, :3]).astype(np.uint8)

    def values(self, frame: FieldFrame) -> Floats | None:
        """The values of a frame.

        Parameters
        ----------
        frame : RunFrame
            Of a run.

        Returns
        -------
        (n,) float or None
            On its nodes, triangles or lines, in the unit of the field; NaN where there is none. None where the frame
            has none at all.
        """
        with np.errstate(over="ignore", invalid="ignore"):
            found = self._read(frame)
            if found is None:
                return None
            known = np.where(np.abs(found) < LARGEST, found, np.nan)
        return known if np.isfinite(known).any() else None


def fields_of(frame: FieldFrame) -> list[Field]:
    """The fields of `FIELDS` that a frame has values of, in that order."""
    return [field for field in FIELDS.values() if field.values(frame) is not None]


def value_ranges(
    frames: Iterable[FieldFrame], share: float = 1.0, fields: Iterable[Field] | None = None
) -> dict[str, tuple[float, float]]:
    """Lowest and highest value of each field over the frames of a run, which are read once, one at a time.

    Parameters
    ----------
    frames : iterable of FieldFrame
        Those of a run.
    share : float
        Share of the values of each frame that lie between both, from 0 to 1; the rest is left out in equal parts at
        both ends. `SHARE` keeps single corners from taking the whole scale.
    fields : iterable of Field, optional
        Those that are wanted. Default: all of `FIELDS`.

    Returns
    -------
    dict
        (lowest, highest) by name, of the fields that any of the frames has; (0, number of categories - 1) of a field
        with categories. Both are equal where the field is uniform.
    """
    wanted = list(FIELDS.values() if fields is None else fields)
    found: dict[str, tuple[float, float]] = {}
    for frame in frames:
        for field in wanted:
            values = field.values(frame)
            if values is not None:
                found[field.name] = range_with(field, values, share, found.get(field.name))
    return {name: found[name] for name in FIELDS if name in found}


def range_with(
    field: Field, values: NDArray[np.floating[Any]], share: float, before: tuple[float, float] | None = None
) -> tuple[float, float]:
    """The range that holds a share of the values of a frame, some of them finite, and the range of frames before."""
    if field.categories:
        return 0.0, len(field.categories) - 1.0
    outside = 0.5 * (1.0 - share)
    low, high = np.quantile(values[np.isfinite(values)], (outside, 1.0 - outside))
    lowest, highest = before or (np.inf, -np.inf)
    return min(float(low), lowest), max(float(high), highest)


def _column(array: NDArray[Any] | None, index: int = 0) -> Floats | None:
    """A column of an array of one or two dimensions."""
    if array is None or not len(array):
        return None
    return np.asarray(array if array.ndim == 1 else array[:, index], dtype=np.float64)


def _on_triangles(name: str) -> Callable[[FieldFrame], Floats | None]:
    return lambda frame: _column(frame.on_triangles.get(name))


def _on_lines(name: str) -> Callable[[FieldFrame], Floats | None]:
    return lambda frame: _column(frame.on_lines.get(name))


def _crease_angle(frame: FieldFrame) -> Floats | None:
    """[deg]"""
    angles = _column(frame.on_lines.get("crease_angle"))
    return None if angles is None else np.degrees(angles)


def _speed(frame: FieldFrame) -> Floats | None:
    """|v| [m/s]"""
    velocities = frame.on_nodes.get("velocity")
    if velocities is None or not len(velocities):
        return None
    speeds: Floats = np.linalg.norm(velocities, axis=1)
    return speeds


def _buckled(frame: FieldFrame) -> Floats | None:
    buckled = _column(frame.on_lines.get("buckled"))
    return None if buckled is None else np.where(buckled < 0.0, np.nan, buckled)


def _state(frame: FieldFrame) -> Floats | None:
    """By the law of the film where the frame has it, else by the sides of each triangle."""
    states = _column(frame.on_triangles.get("film_state"))
    if states is not None and (states >= 0.0).any():
        return np.where(states < 0.0, np.nan, states)
    buckled, triangles = _column(frame.on_lines.get("buckled")), frame.triangles
    if buckled is None or not len(triangles):
        return None
    sides = triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    rows = find_pairs(frame.lines, sides)
    count = np.where(rows >= 0, buckled[rows] > 0.0, False).reshape(-1, 3).sum(axis=1)
    state: Floats = np.array((TAUT, WRINKLED, WRINKLED, SLACK), np.float64)[count]
    return state


FIELDS: dict[str, Field] = {
    field.name: field
    for field in (
        Field(
            "largest_principal_stress",
            "Largest principal stress",
            "Pa",
            "triangles",
            _on_triangles("stress_1"),
            array="stress_1",
        ),
        Field("von_mises", "Von Mises stress", "Pa", "triangles", _on_triangles("von_mises")),
        Field(
            "largest_principal_strain",
            "Largest principal strain",
            "",
            "triangles",
            _on_triangles("triangle_strain"),
            array="triangle_strain",
        ),
        Field(
            "state",
            "State of the film",
            "",
            "triangles",
            _state,
            ("taut", "wrinkled", "slack"),
            "cividis_r",
            "film_state",
        ),
        Field("spring_strain", "Strain of springs", "", "lines", _on_lines("spring_strain")),
        Field("buckled", "Buckled springs", "", "lines", _buckled, ("taut", "buckled"), "cividis_r"),
        Field("crease_angle", "Crease angle", "deg", "lines", _crease_angle, colormap="plasma"),
        Field("tension", "Tension of cords", "N", "lines", _on_lines("tension"), colormap="magma"),
        Field("speed", "Speed", "m/s", "nodes", _speed, colormap="plasma", array="velocity"),
    )
}
"""The fields by their names, in the order in which they are offered."""
