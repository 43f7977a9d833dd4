"""The spool of a scene, as laws and parts describe it."""

from __future__ import annotations

from typing import NamedTuple


class Spool(NamedTuple):
    """A cylinder about z, round which a sail is wound.

    Attributes
    ----------
    radius : float
        Of the cylinder [m].
    half_height : float or None
        It reaches from -half_height to +half_height [m]; None: endless.

    Examples
    --------
    >>> from membrane_rs import SpoolContact
    >>> SpoolContact(radius=0.025).spool
    Spool(radius=0.025, half_height=None)
    """

    radius: float
    half_height: float | None = None
