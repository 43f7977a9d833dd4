"""Measured curves in files: CSV with a column of times and others named as those of history.csv.

    time [ms], deployment_rate, hub_torque [mN m]
    # a line that begins with a number sign is a remark
    0,         0.231,           0.0
    12.5,      0.240,

Names may be followed by a unit in brackets; without one a column is in the unit that is wanted, and times are in
seconds. Times ascend; an empty cell or "nan" is a value that was not measured.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from membrane_rs._files import path_of, read_text
from membrane_rs._validation import show
from membrane_rs.errors import InputError, MissingFileError
from membrane_rs.results.experiment import (
    MOST_COLUMNS,
    TIME,
    Experiment,
    check_ascends,
    checked_units,
    converted,
    headings,
)

MOST_BYTES = 2**26
"""A longer file is not read: it has a million lines of eight columns."""
_MISSING = ("", "nan", "na", "n/a", "-")


def read_experiment(path: str | Path, units: Mapping[str, str] | None = None) -> Experiment:
    """Read measured curves from a CSV file.

    Cells are separated by commas, or by semicolons or tabs where the first line has such, and no commas. Units stand in
    brackets behind the names, as "hub_torque [mN m]" or "rate (1/s)".

    Parameters
    ----------
    path : str or path
        The file: UTF-8, its first line the names of the columns, one of them "time".
    units : mapping of str to str, optional
        The unit in which each column is wanted, by its name, such as those of the history of a run: values in others
        are converted. Default: as in the file.

    Returns
    -------
    Experiment
        The curves.

    Raises
    ------
    MissingFileError
        No file there.
    InputError
        What is no such table, by its line and column; a unit that is unknown, or no unit of what is wanted.
    InputTypeError
        No path.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     file = Path(folder) / "drop test.csv"
    ...     _ = file.write_text("time,hub_torque [N m]\\n0,0.5\\n1,\\n2,0.7\\n")
    ...     measured = read_experiment(file)
    >>> measured.name, measured.units["hub_torque"]
    ('drop test', 'N m')
    >>> measured.curve("hub_torque")
    (array([0., 2.]), array([0.5, 0.7]))
    """
    path = path_of(path)
    wanted = checked_units(units)
    if not path.exists():
        raise MissingFileError(f"no measured curves at {path}; name a CSV file with a column 'time'")
    lines = _cells(path)
    place, header = next(lines, (0, []))
    given = _columns(path, place, header)
    names = list(given)
    numbers, rows = [], []
    for number, cells in lines:
        rows.append(_numbers(path, number, cells, names, place))
        numbers.append(number)
    if not rows:
        raise InputError(f"{path} holds names of columns and no line of numbers; add the measured values")
    columns = dict(zip(names, np.array(rows).T, strict=True))
    where, unit = f"{path}, line {place}", given.pop(TIME)
    time = columns.pop(TIME)
    if unit and unit != "s":
        time = converted(time, unit, "s", f"{where}, column 'time'")
    check_ascends(time, str(path), numbers)
    return replace(Experiment(where, time, columns, given).in_units(wanted), name=path.stem)


def _cells(path: Path) -> Iterator[tuple[int, list[str]]]:
    """Number of each line that is neither empty nor a remark, and its cells. Raises InputError."""
    try:
        text = read_text(path, MOST_BYTES)
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: byte {error.start} is no UTF-8 text; save the table as CSV in UTF-8") from None
    except OSError as error:
        raise InputError(f"{path} cannot be read: {error.strerror}; name a CSV file with a column 'time'") from None
    if "\0" in text:
        raise InputError(f"{path} holds a NUL, so it is no text; save the table as CSV in UTF-8")
    lines = [(k, line) for k, line in enumerate(text.splitlines(), start=1) if line.strip() and line.strip()[0] != "#"]
    first = lines[0][1] if lines else ""
    separator = next((mark for mark in ",;\t" if mark in first), ",")
    for number, line in lines:
        try:
            yield number, next(csv.reader([line], delimiter=separator, skipinitialspace=True))
        except (csv.Error, StopIteration) as error:
            raise InputError(f"{path}, line {number}: {error}; write numbers separated by commas") from None


def _columns(path: Path, place: int, header_cells: list[str]) -> dict[str, str]:
    """The unit of each column by its name, in their order; empty without one. Raises InputError."""
    where = f"{path}, line {place}"
    if not header_cells:
        raise InputError(f"{path} is empty; its first line must name the columns, one of them 'time'")
    if len(header_cells) > MOST_COLUMNS:
        raise InputError(
            f"{where} names {len(header_cells)} columns, and at most {MOST_COLUMNS} are read; leave some out"
        )
    if all(_is_number(cell) for cell in header_cells):
        raise InputError(f"{where} holds numbers; the first line must name the columns, one of them 'time'")
    return headings(header_cells, where)


def _numbers(path: Path, number: int, cells: list[str], names: list[str], header: int) -> list[float]:
    """The numbers of a line, NaN where a value is missing. Raises InputError."""
    where = f"{path}, line {number}"
    if len(cells) != len(names):
        raise InputError(
            f"{where} has {len(cells)} cells, and line {header} names {len(names)} columns; give one for each"
        )
    values = []
    for name, cell in zip(names, cells, strict=True):
        try:
            value = math.nan if cell.strip().lower() in _MISSING else _number(cell)
        except ValueError:
            remedy = "write a point for the decimals" if re.fullmatch(r"\s*-?\d+,\d+\s*", cell) else "write a number"
            raise InputError(
                f"{where}, column {name!r}: {show(cell)} is no number; {remedy}, or leave it empty"
            ) from None
        if math.isinf(value):
            raise InputError(f"{where}, column {name!r}: {value} is not finite; leave out what was not measured")
        if name == TIME and math.isnan(value):
            raise InputError(f"{where}: the time is missing; give one, or leave the line out")
        values.append(value)
    return values


def _number(cell: str) -> float:
    """A number in digits, without the underscores that Python allows. Raises ValueError."""
    if "_" in cell:
        raise ValueError(cell)
    return float(cell)


def _is_number(cell: str) -> bool:
    try:
        _number(cell)
    except ValueError:
        return False
    return True
