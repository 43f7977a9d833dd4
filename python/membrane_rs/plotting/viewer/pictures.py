"""Files for pictures that a user saves: a new one each time."""

from __future__ import annotations

import re
from pathlib import Path

from membrane_rs._files import check_kind_of_file, replacing
from membrane_rs.errors import OutputError
from membrane_rs.plotting.picture import Image

DPI = 300
MOST_FILES = 10_000
"""Of one name in one folder."""


def save_new(image: Image, folder: Path, name: str) -> Path:
    """Write a picture as PNG into a file that was not there, `name` and a number where it was. Raises OutputError."""
    stem = re.sub(r"[^\w.-]+", "-", name).strip("-.")[:150] or "picture"
    for number in range(1, MOST_FILES):
        path = folder / f"{stem}{'' if number == 1 else f'-{number}'}.png"
        if not path.exists():
            return save_as(image, path)
    raise OutputError(f"{folder} holds {MOST_FILES} pictures named {stem}; move some of them")


def save_as(image: Image, path: Path) -> Path:
    """Write a picture as PNG into a file that is not there yet, whole or not at all. Raises OutputError, and InputError
    for a name of another kind of file.
    """
    from PIL import Image as Pillow

    check_kind_of_file(path, "image/png", "a picture is PNG", ".png")
    if path.exists() or path.is_symlink():
        raise OutputError(f"{path}: is there already; name another file, or remove it")
    with replacing(path) as part:
        Pillow.fromarray(image).save(part, "PNG", dpi=(DPI, DPI))
    return path
