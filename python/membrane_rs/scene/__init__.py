"""A scene: what is simulated, made of what, under which laws, with which parts."""

from __future__ import annotations

from membrane_rs.scene.assembly import Assembly
from membrane_rs.scene.plausible import Doubt
from membrane_rs.scene.scene import Scene
from membrane_rs.scene.spool import Spool

__all__ = ["Assembly", "Doubt", "Scene", "Spool"]
