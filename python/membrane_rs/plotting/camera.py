"""From where a membrane is seen: the direction by its shapes, the projection, and the scale bar."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from membrane_rs._arrays import Floats, Ints

if TYPE_CHECKING:
    Image = NDArray[np.uint8]

OBLIQUE = (0.0, -0.70, 1.0)
"""The direction to the camera for shapes of no direction of their own: from above and a little from the front."""
ANGLE_DEG = 24.0
"""Angle of view."""
FLAT = 1e-3
"""Thickness of all shapes over their length (root mean squares) below which they are seen from straight above."""
ENOUGH = 0.6
"""Share of the film's area, as it is seen, beyond which its motion counts alone."""
BETTER = 1.1
"""Another direction than the oblique one shows so many times as much."""
MARGIN = 1.04
BAR_SHARE = 0.3
"""Largest length of the scale bar, as a share of the picture."""


@dataclass(frozen=True)
class Camera:
    """From where a picture is taken.

    Attributes
    ----------
    centre : (3,) float
        The point that it looks at [m].
    view, up : (3,) float
        Unit vectors from there to the camera, and upwards in the picture [-].
    reach : float
        Points that are nearer to the centre are seen [m].

    Examples
    --------
    >>> import numpy as np
    >>> from membrane_rs.plotting.viewer import Camera
    >>> flat = np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]])
    >>> camera = Camera.of([flat], np.array([[0, 1, 2]]), about_axis=False)
    >>> camera.centre, camera.view, camera.project(camera.centre[None])[0]
    (array([1., 1., 0.]), array([0., 0., 1.]), array([[0., 0.]]))
    """

    centre: Floats
    view: Floats
    up: Floats
    reach: float

    @property
    def distance(self) -> float:
        """From the centre to the camera [m]."""
        return MARGIN * self.reach / float(np.sin(np.radians(0.5 * ANGLE_DEG)))

    @property
    def half_width(self) -> float:
        """Half the width of the picture in the plane of the centre [m]."""
        return self.distance * float(np.tan(np.radians(0.5 * ANGLE_DEG)))

    @cached_property
    def _axes(self) -> Floats:
        return np.stack([np.cross(self.up, self.view), self.up, self.view])

    def project(self, points: Floats) -> tuple[Floats, Floats]:
        """Where points are in the picture.

        Parameters
        ----------
        points : (n, 3) float
            Positions [m].

        Returns
        -------
        (n, 2) float, (n,) float
            Place, from -1 to 1 to the right and upwards [-], and nearness to the camera [m].
        """
        seen = (points - self.centre) @ self._axes.T
        scale = self.distance / np.maximum(self.distance - seen[:, 2], 1e-3 * self.distance) / self.half_width
        return seen[:, :2] * scale[:, None], seen[:, 2]

    @classmethod
    def of(cls, shapes: Sequence[Floats], triangles: Ints, *, about_axis: bool) -> Camera:
        """The camera that sees all of some shapes.

        Parameters
        ----------
        shapes : sequence of (N, 3) float
            Positions [m].
        triangles : (m, 3) int
            Nodes of each triangle.
        about_axis : bool
            Whether it sees them as they turn about z, too.

        Returns
        -------
        Camera
            A new one.
        """
        points = np.concatenate(shapes)
        view, up = direction_of(shapes, triangles, about_axis=about_axis)
        if about_axis:
            centre = np.zeros(3)
            reach = float(np.linalg.norm(points, axis=1).max())
        else:
            axes = np.stack([np.cross(up, view), up, view])
            seen = points @ axes.T
            low, high = seen.min(axis=0), seen.max(axis=0)
            centre = 0.5 * (low + high) @ axes
            half = 0.5 * (high - low)
            # What is nearer than the centre looks larger, by nearness over distance.
            reach = float(max(half[0], half[1]) + 0.2 * half[2])
        return cls(centre, view, up, reach if reach > 0.0 else 1.0)


def direction_of(shapes: Sequence[Floats], triangles: Ints, *, about_axis: bool) -> tuple[Floats, Floats]:
    """Unit vectors to the camera and upwards.

    Shapes in one plane are seen from straight above it, those about a hub obliquely. Of other shapes the direction is
    that which shows enough of the film and most of its motion: the mean of |n . view| over the area, n the normals, up
    to `ENOUGH`, and the share of the variance that lies across the view.
    """
    points = np.concatenate(shapes)
    _, extents, axes = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)
    oblique, z = _unit(np.array(OBLIQUE)), np.array((0.0, 0.0, 1.0))
    view = oblique
    if len(extents) == 3 and extents[0] > 0.0:
        if extents[1] < FLAT * extents[0]:  # a line
            across = z - (z @ axes[0]) * axes[0]
            view = _unit(across) if np.linalg.norm(across) > 0.1 else np.array((0.0, -1.0, 0.0))
        elif extents[2] < FLAT * extents[0]:
            view = axes[2] * (1.0 if axes[2] @ oblique > 0.0 else -1.0)
        elif not about_axis:
            views = np.concatenate([[oblique], _candidates()])
            hidden = ((views @ axes.T) ** 2 @ extents**2) / (extents @ extents)
            scores = 1.0 - hidden
            if len(triangles):
                corners = np.concatenate([shape[triangles] for shape in shapes])
                normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
                shown = np.abs(normals @ views.T).sum(axis=0) / np.linalg.norm(normals, axis=1).sum()
                scores = scores + np.minimum(shown, ENOUGH) / ENOUGH
            best = int(np.argmax(scores))
            view = views[best] if scores[best] > BETTER * scores[0] else oblique
    up = z if abs(view[2]) < 0.95 else np.array((0.0, 1.0, 0.0))
    return view, _unit(up - (up @ view) * view)


def _candidates() -> Floats:
    """Directions from above, from all sides."""
    azimuth, elevation = np.meshgrid(np.radians(np.arange(0, 360, 15)), np.radians((15, 30, 45, 60)))
    x, y = np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth)
    return np.stack([x, y, np.sin(elevation)], axis=-1).reshape(-1, 3)


def with_scale_bar(image: Image, camera: Camera) -> Image:
    """The square picture (size, size, 3) with a bar and its length in m, of the plane of the camera's centre."""
    from PIL import Image as Pillow
    from PIL import ImageDraw, ImageFont

    size = len(image)
    length = bar_length(2.0 * BAR_SHARE * camera.half_width)
    pixels = round(length / (2.0 * camera.half_width) * size)
    picture = Pillow.fromarray(image)
    draw = ImageDraw.Draw(picture)
    left, base, line = round(0.04 * size), round(0.96 * size), max(2, round(size / 250))
    draw.rectangle((left, base - line + 1, left + pixels, base), fill="black")
    font = ImageFont.load_default(max(9, size // 28))
    draw.text((left + pixels / 2, base - 2 * line), length_text(length), "black", font, anchor="mb")
    return np.asarray(picture)


def bar_length(most: float) -> float:
    """The largest of 1, 2 and 5 times a power of ten that is not above `most` [m]."""
    power = 10.0 ** np.floor(np.log10(most))
    return float(max(factor * power for factor in (1.0, 2.0, 5.0) if factor * power <= most * (1.0 + 1e-9)))


def length_text(length: float) -> str:
    """A length [m] with its unit: "0.2 m", "50 mm", "5 µm"."""
    factor, unit = next((pair for pair in ((1.0, "m"), (1e3, "mm")) if length * pair[0] > 0.0999), (1e6, "µm"))
    return f"{length * factor:g} {unit}"


def _unit(vector: Floats) -> Floats:
    return np.asarray(vector / np.linalg.norm(vector))
