"""Studies of scenes: one question per file."""

from __future__ import annotations

from membrane_rs.study.mesh import FORMS, MeshRun, mesh_study, write_mesh_study

__all__ = ["FORMS", "MeshRun", "mesh_study", "write_mesh_study"]
