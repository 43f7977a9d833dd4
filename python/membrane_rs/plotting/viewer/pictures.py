"""Files for pictures that a user saves: a new one each time."""

from __future__ import annotations

import re
from pathlib import Path

from membrane_rs._files import output_errors
from membrane_rs.errors import OutputError
from membrane_rs.plotting.picture import Image

MOST_FILES = 10_000
"""Of one name in one folder."""


def save_new(image: Image, folder: Path, name: str) -> Path:
    """Write a picture as PNG into a file that was not there, `name` and a number where it was. Raises OutputError."""
    from PIL import Image as Pillow

    stem = re.sub(r"[^\w.-]+", "-", name).strip("-.")[:150] or "picture"
    for number in range(1, MOST_FILES):
        path = folder / f"{stem}{'' if number == 1 else f'-{number}'}.png"
        with output_errors(path):
            try:
                with path.open("xb") as stream:
                    Pillow.fromarray(image).save(stream, "PNG", dpi=(300, 300))
                return path
            except FileExistsError:
                continue
    raise OutputError(f"{folder} holds {MOST_FILES} pictures named {stem}; move some of them")
