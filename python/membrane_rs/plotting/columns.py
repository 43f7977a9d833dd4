"""Columns of a history in figures: the label of each, its unit, and the prefix with which its numbers are short."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs.results.history_table import column_units

LABELS = {
    "hub_angle": "Angle of the hub",
    "hub_rate": "Rate of the hub",
    "hub_momentum": "Angular momentum of the hub",
    "sail_momentum": "Angular momentum of the sail",
    "total_momentum": "Angular momentum of both",
    "nutation_deg": "Nutation angle",
    **{f"hub_{axis}": f"Displacement of the hub along {axis}" for axis in "xyz"},
    **{f"momentum_{axis}": f"Angular momentum in space, {axis}" for axis in "xyz"},
    "hub_force": "Force on the hub",
    "hub_torque": "Torque on the hub",
    "largest_cord_tension": "Largest tension of cords",
    "largest_film_stress": "Largest stress of the film",
    "energy_error": "Energy error",
    "energy_of_changes": "Energy of changes of stage",
    "motor_work": "Work of the motor",
    "motor_torque": "Torque of the motor",
    "motor_power": "Power of the motor",
    "phase_difference_deg": "Phase difference",
}
"""Labels of columns of history.csv that are not their names with blanks."""
_OF_LAWS = {"energy_": "Energy", "work_": "Work"}
PREFIXES = ((1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n"))
_PREFIXED = ("J", "N", "N m", "Pa", "m", "m/s", "W")


def label_of(column: str) -> str:
    """A column in words: "hub_torque" is "Torque on the hub"."""
    if column in LABELS:
        return LABELS[column]
    for start, word in _OF_LAWS.items():
        if column.startswith(start):
            return f"{word} of {column.removeprefix(start).replace('_', ' ')}"
    words = column.replace("_", " ").strip()
    return words[:1].upper() + words[1:]


def unit_of(column: str, tables: Iterable[Mapping[str, object]] = ()) -> str:
    """Unit of a column: what a table says in its `units`, and else that of history.csv; "" for a plain number."""
    for table in tables:
        unit = getattr(table, "units", {}).get(column)
        if unit is not None:
            return str(unit)
    return column_units([column], {})[column]


def prefixed(unit: str, values: Sequence[Floats]) -> tuple[float, str]:
    """What values are divided by, and the unit then: (1e-3, "mJ") where the largest is some thousandths of a joule."""
    if unit not in _PREFIXED:
        return 1.0, unit
    largest = max((float(np.nanmax(np.abs(some), initial=0.0)) for some in values), default=0.0)
    if not 0.0 < largest < np.inf:
        return 1.0, unit
    return next(((size, sign + unit) for size, sign in PREFIXES if largest >= size), (1e-9, "n" + unit))


def axis_label(label: str, unit: str) -> str:
    """Label and unit: "Torque on the hub [mN m]"; without one "Deployment rate"."""
    return f"{label} [{unit}]" if unit else label
