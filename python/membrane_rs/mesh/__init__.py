"""What is simulated: nodes and triangles, and what is wrong with them."""

from __future__ import annotations

from membrane_rs.mesh.crossings import Crossings
from membrane_rs.mesh.findings import Audit, Finding
from membrane_rs.mesh.mesh import Mesh
from membrane_rs.mesh.net_moduli import NetModuli, net_moduli

__all__ = ["Audit", "Crossings", "Finding", "Mesh", "NetModuli", "net_moduli"]
