"""Arrays in the page: as few bytes as the picture needs, compressed by zlib, as base64."""

from __future__ import annotations

import base64
import zlib
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from membrane_rs._arrays import Floats

KINDS = {"int16": "<i2", "uint8": "<u1", "uint32": "<u4", "float32": "<f4"}
LEVELS = 255
"""Of a field: 1 to 255 are its scale, 0 is a missing value."""
STEPS = 32767
"""Of a coordinate, from the middle to the end of what all frames take."""
_ALIGNED = 4
_EFFORT = 6
"""Of zlib: the highest takes three times as long for a hundredth of the size."""


def packed(arrays: Mapping[str, NDArray[Any]]) -> tuple[str, dict[str, dict[str, Any]]]:
    """The arrays as one text, and by their names the kind, the place in the unpacked bytes and the count of each."""
    content, places = bytearray(), {}
    for name, array in arrays.items():
        kind = array.dtype.name
        content += bytes(-len(content) % _ALIGNED)
        places[name] = {"kind": kind, "offset": len(content), "count": array.size}
        content += array.astype(KINDS[kind]).tobytes()
    return encoded(bytes(content)), places


def encoded(content: bytes) -> str:
    """Bytes as text."""
    return base64.b64encode(zlib.compress(content, _EFFORT)).decode("ascii")


def coordinates(points: Floats, centre: Floats, half: float) -> NDArray[np.int16]:
    """Points (N, 3) [m] as steps from the centre: `half` [m] is `STEPS` of them."""
    return np.round((points - centre) * (STEPS / half)).clip(-STEPS, STEPS).astype(np.int16)


def levels(values: NDArray[np.floating[Any]], low: float, high: float) -> NDArray[np.uint8]:
    """Values as levels from 1 to `LEVELS` between two ends, beyond which they stay at these; 0 for NaN."""
    span = high - low
    share = (values - low) / span if span > 0.0 else np.where(np.isfinite(values), 0.5, np.nan)
    found = 1.0 + (LEVELS - 1) * share.clip(0.0, 1.0)
    return np.where(np.isfinite(found), np.round(np.nan_to_num(found)), 0.0).astype(np.uint8)


def category_levels(values: NDArray[np.floating[Any]], count: int) -> NDArray[np.uint8]:
    """Whole numbers from 0 to `count` - 1 as levels in the middle of so many parts of the scale; 0 for NaN."""
    found = np.round(LEVELS * (values + 0.5) / count)
    return np.where(np.isfinite(found), np.nan_to_num(found).clip(1, LEVELS), 0.0).astype(np.uint8)
