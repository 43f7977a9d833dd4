"""A scene: what is simulated, made of what, under which laws, with which parts."""

from __future__ import annotations

from membrane_rs.scene.scene import Scene

__all__ = ["Scene"]
