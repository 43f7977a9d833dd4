"""Lines of the CSV files of a run."""

from __future__ import annotations

import csv
from array import array
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TextIO

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs._files import check_regular, read_text
from membrane_rs._validation import show
from membrane_rs.errors import MissingFileError, OutputError

MOST_NUMBERS = 2**28
"""More numbers are not read: they take 2 GB."""
LONGEST_LINE = 2**20
"""Characters of a longer line, which is not read."""


def csv_lines(path: Path, name: str, what: str, remedy: str) -> tuple[Path, list[list[str]]]:
    """A file, or the one called `name` in a run's folder, and the words of its lines.

    A last line that a killed process left unfinished is dropped. Raises MissingFileError, which says `what` is missing
    and the `remedy`.
    """
    path = csv_file(path, name, what, remedy)
    text = read_text(path)
    return path, list(csv.reader(text[: text.rfind("\n") + 1].splitlines()))


def csv_file(path: Path, name: str, what: str, remedy: str) -> Path:
    """A file, or the one called `name` in a run's folder. Raises MissingFileError as `csv_lines`."""
    if path.is_dir():
        path = path / name
    if not path.is_file():
        raise MissingFileError(f"no {what} at {path}; {remedy}")
    return path


def csv_numbers(path: Path, check: Callable[[list[str]], list[str]]) -> tuple[list[str], Floats]:
    """The columns of a file of numbers, and their (rows, columns) values. Memory is taken for the numbers alone.

    Parameters
    ----------
    path :
        Of the file. A last line that a killed process left unfinished is dropped.
    check :
        Takes the names of the columns, empty for an empty file, and gives those that they have now.

    Raises
    ------
    OutputError
        A line that is too long, or has no number for each column; more than `MOST_NUMBERS`.
    """
    check_regular(path)
    values = array("d")
    with path.open(encoding="utf-8-sig", newline="") as file:
        reader = csv.reader(_whole_lines(file, path))
        columns = check(next(reader, []))
        for words in reader:
            if len(words) != len(columns):
                what = f"has {len(words)} value{'s' * (len(words) != 1)} for {len(columns)} columns"
                raise OutputError(f"{path}: line {reader.line_num} {what}; run the scene again")
            try:
                values.extend(map(float, words))
            except ValueError:
                raise OutputError(f"{path}: line {reader.line_num} {_no_number(columns, words)}") from None
            if len(values) > MOST_NUMBERS:
                raise OutputError(f"{path}: has more than {MOST_NUMBERS} numbers, and so many are not read")
    found = np.frombuffer(values, dtype=np.float64) if values else np.zeros(0)
    return columns, found.reshape(-1, max(1, len(columns)))


def _whole_lines(file: TextIO, path: Path) -> Iterator[str]:
    """The lines that are whole."""
    number = 0
    try:
        while (line := file.readline(LONGEST_LINE)).endswith(("\n", "\r")):
            number += 1
            yield line
    except UnicodeDecodeError as error:
        what = f"it holds the byte {error.object[error.start]:#04x}"
        raise OutputError(f"{path} is no text in UTF-8: {what}; run the scene again") from None
    if len(line) == LONGEST_LINE:
        raise OutputError(f"{path}: line {number + 1} has more than {LONGEST_LINE} characters, and is no sample")


def _no_number(columns: Sequence[str], words: Sequence[str]) -> str:
    """Which word of a line is no number."""
    for name, word in zip(columns, words, strict=True):
        try:
            float(word)
        except ValueError:
            return f"has {show(word)} in the column {show(name)}, which is no number; run the scene again"
    return "holds no numbers; run the scene again"
