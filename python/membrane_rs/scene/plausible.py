"""Values that a scene accepts and that are hardly meant: beyond bounds of physics, often by a slip of a unit."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from membrane_rs.mesh.findings import Finding


def implausible(
    place: str,
    value: float,
    unit: str,
    reason: str,
    *,
    least: float = 0.0,
    most: float = float("inf"),
    units: Mapping[str, float] | None = None,
) -> Iterator[Finding]:
    """A warning where a value lies outside its plausible range.

    Parameters
    ----------
    place : str
        The key of the value in a scene file.
    value : float
        In `unit`, as given.
    reason : str
        What the bound is, in words.
    least, most : float
        The plausible range, in `unit`.
    units : mapping of str to float, optional
        Units in which it may have been given by mistake, and their size in `unit`.
    """
    if least <= value <= most:
        return
    meant = next((name for name, size in (units or {}).items() if least <= value * size <= most), None)
    remedy = f"check the value and its unit ({unit})"
    if meant is not None and units is not None:
        remedy = f"was {value:g} {meant} meant? That is {value * units[meant]:.4g} {unit}"
    yield Finding("warning", "implausible_value", 1, f"{place} = {value:g} {unit}: {reason}", remedy)
