"""What is simulated: nodes and triangles, and what is wrong with them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from membrane_rs._on_demand import OnDemand

if TYPE_CHECKING:
    from membrane_rs.mesh.crossings import Crossings
    from membrane_rs.mesh.findings import Audit, Finding
    from membrane_rs.mesh.fold import read_fold, write_fold
    from membrane_rs.mesh.mesh import Mesh
    from membrane_rs.mesh.moduli import NetModuli, net_moduli, rectangle_moduli
    from membrane_rs.mesh.origin import MeshOrigin

__all__ = [
    "Audit",
    "Crossings",
    "Finding",
    "Mesh",
    "MeshOrigin",
    "NetModuli",
    "net_moduli",
    "read_fold",
    "rectangle_moduli",
    "write_fold",
]

if not TYPE_CHECKING:  # a type checker would take every name for one that is there
    _on_demand = OnDemand(
        __name__,
        {
            "membrane_rs.mesh.crossings": ("Crossings",),
            "membrane_rs.mesh.findings": ("Audit", "Finding"),
            "membrane_rs.mesh.fold": ("read_fold", "write_fold"),
            "membrane_rs.mesh.mesh": ("Mesh",),
            "membrane_rs.mesh.moduli": ("NetModuli", "net_moduli", "rectangle_moduli"),
            "membrane_rs.mesh.origin": ("MeshOrigin",),
        },
    )
    __getattr__, __dir__ = _on_demand, _on_demand.names
