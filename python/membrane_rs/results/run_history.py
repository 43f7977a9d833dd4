"""The history of a run as it is read: named columns with their units."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs._given_arrays import numeric
from membrane_rs._known_attributes import KnownAttributes
from membrane_rs._read_only import ReadOnly
from membrane_rs._validation import check_kind, nearest, number_of, show
from membrane_rs.errors import InputError
from membrane_rs.mesh.triangulation import frozen
from membrane_rs.results.history_table import column_units


class UnknownColumnError(InputError, KeyError):
    """A name that no column of a history has."""

    __str__ = InputError.__str__


class RunHistory(KnownAttributes, Mapping[str, Floats]):
    """The history of a run: a mapping from the names of its columns to (samples,) arrays, which are read only.

    Parameters
    ----------
    table : dict of str to (samples,) float
        The columns, "time" [s] among them.
    recorded : Mapping of str to str, optional
        Units of the measures that the run was asked to record.

    Attributes
    ----------
    units : dict of str to str
        The unit of each column, such as "N m"; empty for a number alone. Read only.

    Raises
    ------
    InputTypeError
        No table of arrays of numbers, no table of units.

    Examples
    --------
    >>> import membrane_rs
    >>> history = membrane_rs.run("spinning-tether", until=1e-3, every=5e-4).history
    >>> history["time"].tolist(), history.units["kinetic_energy"]
    ([0.0, 0.0005, 0.001], 'J')
    >>> history.at(0.00025, "time")
    0.00025
    """

    ONCE = ("units",)
    INSTEAD = "run the scene again"

    def __init__(self, table: Mapping[str, Floats], recorded: Mapping[str, str] | None = None) -> None:
        check_kind(table, Mapping, "table", "a table of arrays by the names of their columns")
        check_kind({} if recorded is None else recorded, Mapping, "recorded", "a table of units by names of columns")
        columns = {name: numeric(column, f"table[{show(name)}]", "fiub", "numbers") for name, column in table.items()}
        self._table = {name: frozen(column.astype(np.float64)) for name, column in columns.items()}
        self.units: Mapping[str, str] = ReadOnly(column_units(self._table, recorded or {}))

    def __getitem__(self, name: str) -> Floats:
        """(samples,) a column. Raises InputError, which is a KeyError too, for a name that none has."""
        try:
            return self._table[name]
        except (KeyError, TypeError):
            pass
        raise UnknownColumnError(f"history[{show(name)}]: no such column; {nearest(str(name), self._table)}")

    def __iter__(self) -> Iterator[str]:
        """The names of the columns."""
        return iter(self._table)

    def __len__(self) -> int:
        """The number of columns."""
        return len(self._table)

    @property
    def sample_count(self) -> int:
        """The number of rows."""
        return len(self._table["time"])

    def at(self, time: float, name: str) -> float:
        """A column at a time.

        Parameters
        ----------
        time : float
            [s]
        name : str
            Of the column.

        Returns
        -------
        float
            In its unit: exactly at the time of a sample, linear between two of them; NaN without samples.

        Raises
        ------
        InputError, InputTypeError
            No column of that name, or no time.
        """
        time = number_of("time", time)
        times, column = self["time"], self[name]
        return float(np.interp(time, times, column)) if len(times) else float("nan")

    def __repr__(self) -> str:
        """The columns with their units."""
        names = ", ".join(f"{name} [{unit}]" if unit else name for name, unit in self.units.items())
        return f"RunHistory({self.sample_count} samples: {names})"
