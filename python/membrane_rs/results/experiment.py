"""Measured curves: a CSV file with a column of times and others named as those of history.csv.

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
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs._files import path_of, read_text
from membrane_rs._quantities import conversion
from membrane_rs._read_only import ReadOnly
from membrane_rs._validation import show
from membrane_rs.errors import InputError, MissingFileError

TIME = "time"
MOST_BYTES = 2**26
"""A longer file is not read: it has a million lines of eight columns."""
MOST_COLUMNS = 1000
_HEADER = re.compile(r"\s*(?P<name>[^\[\]]*?)\s*(?:\[\s*(?P<unit>[^\[\]]*?)\s*\])?\s*")
_MISSING = ("", "nan", "na", "n/a", "-")


@dataclass(frozen=True, eq=False)
class Experiment:
    """Curves that were measured, of one file.

    Attributes
    ----------
    name : str
        Of the file, without its ending.
    time : (n,) float
        Ascending times [s].
    columns : mapping of str to (n,) float
        Measured values by the name of their column, in its unit, NaN where there is none; the time is not among them.
    units : mapping of str to str
        The unit of each column, as text; empty where neither the file gives one nor one was wanted.

    Examples
    --------
    >>> import numpy as np
    >>> from membrane_rs.results import Experiment
    >>> torque = {"hub_torque": np.array([0.5, np.nan])}
    >>> measured = Experiment("drop", np.array([0.0, 1.0]), torque, {"hub_torque": "N m"})
    >>> measured.curve("hub_torque")
    (array([0.]), array([0.5]))
    """

    name: str
    time: Floats
    columns: Mapping[str, Floats]
    units: Mapping[str, str]

    def curve(self, name: str) -> tuple[Floats, Floats]:
        """Times and values of a column, where there are any.

        Parameters
        ----------
        name : str
            One of `columns`.

        Returns
        -------
        times : (k,) float
            [s]
        values : (k,) float
            In the unit of the column, `units`.

        Raises
        ------
        InputError
            No such column.
        """
        if name not in self.columns:
            raise InputError(f"column {show(name)}: {self.name} has none; it has {', '.join(self.columns)}")
        values = self.columns[name]
        known = np.isfinite(values)
        return self.time[known], values[known]


def read_experiment(path: str | Path, units: Mapping[str, str] | None = None) -> Experiment:
    """Read measured curves from a CSV file.

    Cells are separated by commas, or by semicolons or tabs where the first line has such, and no commas.

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
    if not path.exists():
        raise MissingFileError(f"no measured curves at {path}; name a CSV file with a column 'time'")
    lines = _cells(path)
    place, header = next(lines, (0, []))
    given = _columns(path, place, header)
    names, wanted = list(given), {TIME: "s", **(units or {})}
    numbers, rows = [], []
    for number, cells in lines:
        rows.append(_numbers(path, number, cells, names, place))
        numbers.append(number)
    if not rows:
        raise InputError(f"{path} holds names of columns and no line of numbers; add the measured values")
    table = np.array(rows)
    for k, (name, unit) in enumerate(given.items()):
        if unit and wanted.get(name, unit) != unit:
            table[:, k] = _converted(table[:, k], unit, wanted[name], f"{path}, line {place}, column {name!r}")
    time = table[:, names.index(TIME)]
    _check_times(path, time, numbers)
    columns = {name: table[:, k] for k, name in enumerate(names) if name != TIME}
    return Experiment(
        path.stem, time, ReadOnly(columns), ReadOnly({name: wanted.get(name) or given[name] for name in columns})
    )


def _converted(values: Floats, unit: str, wanted: str, place: str) -> Floats:
    """Values in one unit as values in another. Raises InputError, which names the place."""
    try:
        factor, offset = conversion(unit, wanted)
    except InputError as error:
        raise InputError(f"{place}: {error}") from None
    return values * factor + offset


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


def _columns(path: Path, place: int, header: list[str]) -> dict[str, str]:
    """The unit of each column by its name, in their order; empty without one. Raises InputError."""
    where = f"{path}, line {place}"
    if not header:
        raise InputError(f"{path} is empty; its first line must name the columns, one of them 'time'")
    if len(header) > MOST_COLUMNS:
        raise InputError(f"{where} names {len(header)} columns, and at most {MOST_COLUMNS} are read; leave some out")
    units: dict[str, str] = {}
    for k, cell in enumerate(header, start=1):
        found = _HEADER.fullmatch(cell)
        if found is None or not found["name"]:
            raise InputError(f"{where}, column {k}: {show(cell)} is no name; write one such as hub_torque [N m]")
        if found["name"] in units:
            raise InputError(
                f"{where}, column {k}: {show(found['name'])} is there already; give each a name of its own"
            )
        units[found["name"]] = found["unit"] or ""
    if TIME not in units:
        raise InputError(f"{where}: no column is named 'time'; the columns are {show(', '.join(units))}")
    if len(units) == 1:
        raise InputError(f"{where}: 'time' is the only column; add one that is named as in history.csv")
    return units


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
            value = math.nan if cell.strip().lower() in _MISSING else float(cell)
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


def _check_times(path: Path, time: Floats, numbers: list[int]) -> None:
    """Refuse times that do not ascend. Raises InputError."""
    steps = np.flatnonzero(np.diff(time) <= 0.0)
    if len(steps):
        k = int(steps[0])
        what = f"time {time[k + 1]:g} s comes after {time[k]:g} s"
        raise InputError(f"{path}, line {numbers[k + 1]}: {what}; order the lines by time, each time once")
