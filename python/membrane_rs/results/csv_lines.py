"""Lines of the CSV files of a run."""

from __future__ import annotations

import csv
from pathlib import Path

from membrane_rs._files import read_text
from membrane_rs.errors import MissingFileError


def csv_lines(path: Path, name: str, what: str, remedy: str) -> tuple[Path, list[list[str]]]:
    """A file, or the one called `name` in a run's folder, and the words of its lines.

    A last line that a killed process left unfinished is dropped. Raises MissingFileError, which says `what` is missing
    and the `remedy`.
    """
    if path.is_dir():
        path = path / name
    if not path.is_file():
        raise MissingFileError(f"no {what} at {path}; {remedy}")
    text = read_text(path)
    return path, list(csv.reader(text[: text.rfind("\n") + 1].splitlines()))
