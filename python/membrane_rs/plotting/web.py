"""Pictures and colours for pages."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from membrane_rs._files import check_regular
from membrane_rs.plotting.fields import Field
from membrane_rs.plotting.picture import Image

WIDTH = 1500
"""Of a picture in a page, at most [pixels]."""
QUALITY = 82
MOST_BYTES = 2**26
STEPS = 33
"""Colours of a scale, between which a page interpolates."""


@dataclass(frozen=True)
class WebPicture:
    """A picture as WebP, and its width and height [pixels]."""

    content: bytes
    size: tuple[int, int]


def web_picture(image: Image) -> WebPicture:
    """An image (height, width, 3) as WebP, not wider than `WIDTH`."""
    from PIL import Image as Pillow

    return _compressed(Pillow.fromarray(image))


def web_picture_of(path: Path) -> WebPicture | None:
    """A PNG file as WebP; None where it is no picture, or not there."""
    from PIL import Image as Pillow

    try:
        check_regular(path, MOST_BYTES)
        with Pillow.open(path, formats=("PNG",)) as image:
            return _compressed(image.convert("RGB"))
    except (OSError, ValueError, SyntaxError, Pillow.DecompressionBombError):
        return None


def scale_colors(field: Field) -> list[str]:
    """The scale of a field as #rrggbb: one for each category, or `STEPS` from the lowest to the highest value."""
    return [hex_of(color) for color in field.colors(STEPS).tolist()]


def hex_of(color: Sequence[int]) -> str:
    """A colour of three bytes as #rrggbb."""
    red, green, blue = color
    return f"#{red:02x}{green:02x}{blue:02x}"


def _compressed(image: Any) -> WebPicture:
    if image.width > WIDTH:
        image = image.resize((WIDTH, max(1, round(image.height * WIDTH / image.width))))
    with io.BytesIO() as file:
        image.save(file, "WEBP", quality=QUALITY, method=4)
        return WebPicture(file.getvalue(), image.size)
