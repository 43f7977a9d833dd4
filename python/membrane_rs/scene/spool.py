"""The spool of a scene, as laws and parts describe it."""

from __future__ import annotations

from typing import NamedTuple


class Spool(NamedTuple):
    """A cylinder about z."""

    radius: float
    """[m]"""
    half_height: float | None = None
    """It reaches from -half_height to +half_height [m]; None: endless."""
