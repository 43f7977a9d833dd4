"""Results of runs that are kept in files and read again; remove a file to repeat its run."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
from membrane_rs._arrays import Floats
from membrane_rs._files import replacing


def kept(file: Path, make: Callable[[], Mapping[str, Floats]]) -> Mapping[str, Floats]:
    """The arrays in `file`, an NPZ archive; made and written there, whole or not at all, where it is missing."""
    if file.is_file():
        with np.load(file) as archive:
            return dict(archive)
    arrays = make()
    file.parent.mkdir(parents=True, exist_ok=True)
    with replacing(file) as part, part.open("wb") as stream:
        np.savez(stream, **arrays)  # type: ignore[arg-type]
    return arrays


def slug(*words: object) -> str:
    """Words as the name of a file: letters, digits and dots, joined by hyphens."""
    return "-".join(re.findall(r"[\w.]+", " ".join(map(str, words))))
