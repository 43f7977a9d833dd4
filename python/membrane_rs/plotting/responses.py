"""What figures of many runs show: numbers of their rows, with a label and a unit each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs._validation import nearest
from membrane_rs.errors import InputError
from membrane_rs.plotting.columns import label_of, unit_of

Row = Mapping[str, Any]
FEATURES = {
    "first_peak_rate": ("First peak of the rate", ""),
    "first_peak_time": ("Time of the first peak", "s"),
    "phase_trough_deg": ("Trough of the phase", "deg"),
    "phase_trough_time": ("Time of the trough", "s"),
    "zero_crossing_time": ("Phase back at zero at", "s"),
    "zero_crossing_rate": ("Rate as the phase is back", ""),
    "initial_rate": ("Initial rate", ""),
    "final_rate": ("Final rate", ""),
    "highest_rate": ("Highest rate", ""),
    "final_phase_deg": ("Final phase", "deg"),
    "energy_error": ("Energy error", ""),
    "lowest_error": ("Lowest energy error", ""),
    "highest_error": ("Highest energy error", ""),
    "reference_energy": ("Reference energy", "J"),
    "motor_work": ("Work of the motor", "J"),
    "momentum_error": ("Error of the angular momentum", ""),
    "time": ("Time at the end", "s"),
    "dt": ("Step", "s"),
    "wall_time": ("Wall time", "s"),
}
"""Label and unit of the numbers of a row that are no value of a column of the history."""
ENDS = ("final_", "lowest_", "highest_")
PREFERRED = (
    "first_peak_rate", "phase_trough_deg", "zero_crossing_time", "final_rate", "highest_largest_film_stress",
    "highest_largest_cord_tension", "final_phase_deg", "highest_hub_torque", "final_kinetic_energy", "energy_error",
)  # fmt: skip
"""What is shown unless the caller says otherwise, as far as runs differ in it, behind measures that were recorded."""
MOST = 4
LEAST_CHANGE = 1e-6
"""Runs that differ by a smaller share of a number differ in rounding alone."""
LEAST = {"deg": 1e-3}
"""Values below it, by the unit, are of rounding, or of its growth."""
LEAST_OTHER = 1e-15
"""The same of other units, of which none is far from those of SI."""


@dataclass(frozen=True)
class Response:
    """A number of each row."""

    name: str
    label: str
    unit: str

    def of(self, row: Row) -> float:
        """Its value, NaN where there is none."""
        value = row.get(self.name)
        return float(value) if isinstance(value, int | float) else np.nan

    def values(self, rows: Sequence[Row]) -> Floats:
        """(rows,) values."""
        return np.array([self.of(row) for row in rows], dtype=np.float64)


def response_of(name: str, units: Mapping[str, str]) -> Response:
    """A number by its name; `units` are those of columns of the history."""
    if name in FEATURES:
        return Response(name, *FEATURES[name])
    for end in ENDS:
        if name.startswith(end):
            column = name.removeprefix(end)
            unit = units.get(column, unit_of(column))
            return Response(name, f"{label_of(column)}, {end.removesuffix('_')}", unit)
    return Response(name, label_of(name), "")


def responses_of(
    rows: Sequence[Row], names: Sequence[str] | None, units: Mapping[str, str], varied: Sequence[str]
) -> list[Response]:
    """What is to be shown: the numbers of these names, or those that say most. `units` are those of measures that the
    runs have recorded.

    Raises InputError for a name that no row has as a number, and where there is no number at all.
    """
    known = [
        name
        for name in dict.fromkeys(name for row in rows for name in row)
        if name not in (*varied, "run", "start") and np.isfinite(response_of(name, units).values(rows)).any()
    ]
    if not known:
        raise InputError("no run has come to its end; see in the table what failed")
    if names is not None:
        unknown = next((name for name in names if name not in known), None)
        if unknown is not None:
            raise InputError(f"columns: no run has a number {unknown!r}; {nearest(unknown, known)}")
        return [response_of(name, units) for name in names]
    recorded = [f"final_{column}" for column in units]
    found = [
        response
        for response in (response_of(name, units) for name in dict.fromkeys((*recorded, *PREFERRED)) if name in known)
        if _differ(response, rows)
    ]
    return found[:MOST] or [response_of(next((name for name in PREFERRED if name in known), known[0]), units)]


def _differ(response: Response, rows: Sequence[Row]) -> bool:
    """Whether most runs have a value, and these differ by more than rounding."""
    values = response.values(rows)
    some = values[np.isfinite(values)]
    if len(some) < 0.5 * len(values) or not len(some):
        return False
    largest = float(np.abs(some).max())
    return float(np.ptp(some)) > LEAST_CHANGE * largest and largest > LEAST.get(response.unit, LEAST_OTHER)
