"""Columns of a history in figures: the label of each, its unit, and the prefix with which its numbers are short."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from membrane_rs._arrays import Floats

KNOWN = {
    "time": ("Time", "s"),
    "deployment_rate": ("Deployment rate", ""),
    "phase_difference_deg": ("Phase difference", "deg"),
    "kinetic_energy": ("Kinetic energy", "J"),
    "stored_energy": ("Stored energy", "J"),
    "energy_error": ("Energy error", ""),
    "hub_angle": ("Angle of the hub", "rad"),
    "reference_energy": ("Reference energy", "J"),
    "hub_force": ("Force on the hub", "N"),
    "hub_torque": ("Torque on the hub", "N m"),
    "contact_force": ("Contact force", "N"),
    "largest_cord_tension": ("Largest tension of cords", "N"),
    "largest_film_stress": ("Largest stress of the film", "Pa"),
    "energy_of_changes": ("Energy of changes of stage", "J"),
    "motor_work": ("Work of the motor", "J"),
    "stage": ("Stage", ""),
}
"""Label and unit of each column of history.csv that every scene may have."""
_OF_LAWS = {"energy_": ("Energy", "J"), "work_": ("Work", "J")}
PREFIXES = ((1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n"))
_PREFIXED = ("J", "N", "N m", "Pa", "m", "m/s", "W")


def label_of(column: str) -> str:
    """A column in words: "hub_torque" is "Torque on the hub"."""
    if column in KNOWN:
        return KNOWN[column][0]
    for start, (word, _) in _OF_LAWS.items():
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
    if column in KNOWN:
        return KNOWN[column][1]
    return next((unit for start, (_, unit) in _OF_LAWS.items() if column.startswith(start)), "")


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
