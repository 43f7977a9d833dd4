"""What is simulated: nodes and triangles, and what is wrong with them."""

from __future__ import annotations

from membrane_rs.mesh.findings import Audit, Finding
from membrane_rs.mesh.mesh import Mesh

__all__ = ["Audit", "Finding", "Mesh"]
