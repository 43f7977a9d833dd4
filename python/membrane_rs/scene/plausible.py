"""Values that a scene accepts and that are hardly meant: beyond bounds of physics, often by a slip of a unit."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass

from membrane_rs.mesh.findings import Finding

FILM = ("mesh", "material")
"""Keys of what the film is."""
RATES = {"turns per minute": 1.0 / 60.0, "rad/s": 0.5 / math.pi}
"""Units of a rate of turning [Hz]."""

STRETCHED = 0.1
"""Strain at which films are torn."""


@dataclass(frozen=True)
class Doubt(Finding):
    """A value that is hardly meant.

    Attributes
    ----------
    severity, kind, count, message, remedy, where
        As `membrane_rs.mesh.Finding` has them.
    place : str
        Its key in a scene file.
    derived_from : tuple of str
        Beginnings of the keys of other values by which it is judged; what follows a "*" is their end.

    Examples
    --------
    >>> from membrane_rs.scene import Doubt
    >>> doubt = Doubt("warning", "implausible_value", 1, "a film of 7.5 m", "was 7.5 um meant?", place="thickness")
    >>> doubt.place, doubt.rests_on("material.density")
    ('thickness', False)
    >>> doubt.as_dict()["remedy"]
    'was 7.5 um meant?'
    """

    place: str = ""
    derived_from: tuple[str, ...] = ()

    def rests_on(self, place: str) -> bool:
        """Whether it is judged by the value of a key.

        Parameters
        ----------
        place : str
            The key.

        Returns
        -------
        bool
            Whether it is.
        """
        ends = (key.partition("*")[::2] for key in self.derived_from)
        return any(place.startswith(first) and place.endswith(last) for first, last in ends)


def implausible(
    place: str,
    value: float,
    unit: str,
    reason: str,
    *,
    least: float = 0.0,
    most: float = float("inf"),
    units: Mapping[str, float] | None = None,
    derived_from: tuple[str, ...] = (),
) -> Iterator[Doubt]:
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
    derived_from : tuple of str, optional
        Keys of other values of which the range is made, as in `Doubt`.
    """
    if least <= value <= most:
        return
    meant = [(name, value * size) for name, size in (units or {}).items() if least <= value * size <= most]
    remedy = f"check the value and its unit ({unit})" if unit else "check the value, a ratio"
    if meant and not unit:
        remedy = f"was {value:g} {meant[0][0]} meant? That is {meant[0][1]:.4g}"
    elif meant:
        remedy = f"was {value:g} {meant[0][0]} meant? That is {meant[0][1]:.4g} {unit}"
        remedy += "".join(f"; or {value:g} {name}? That is {size:.4g} {unit}" for name, size in meant[1:])
    message = f"{place} = {f'{value:g} {unit}'.strip()}: {reason}"
    yield Doubt("warning", "implausible_value", 1, message, remedy, place=place, derived_from=derived_from)


def first_causes(doubts: Iterable[Doubt], doubted: Collection[str] = ()) -> Iterator[Doubt]:
    """Doubts but for those of values that are judged by another one in doubt: that one is to be mended first.

    `doubted` are keys of further values in doubt.
    """
    places, pending = set(doubted), list(doubts)
    while pending:
        others = {doubt.place for doubt in pending}
        judged = [doubt for doubt in pending if not any(map(doubt.rests_on, others - {doubt.place}))] or pending[:1]
        for doubt in judged:
            if not any(map(doubt.rests_on, places)):
                places.add(doubt.place)
                yield doubt
        pending = [doubt for doubt in pending if doubt not in judged]
