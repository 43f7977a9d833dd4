"""What is measured on a scene in motion."""

from __future__ import annotations

from membrane_rs.analysis import strain
from membrane_rs.analysis.deployment import Corners
from membrane_rs.simulation.motion import Motion


def deployment_rate(sim: Motion) -> float:
    """Mean radius of the corners now over that of the reference."""
    return Corners(sim.assembly).deployment_rate(sim.positions)


def peak_stress(sim: Motion) -> float:
    """The largest principal stress of the film [Pa], of `membrane_rs.analysis.strain.peak_stress`; NaN without film."""
    mesh, film = sim.scene.mesh, sim.scene.material
    if mesh is None or film is None:
        return float("nan")
    strains = strain.triangle_strains(mesh.reference, sim.positions[: mesh.node_count], mesh.triangles)
    return strain.peak_stress(strains, film.youngs_modulus, film.poisson_ratio)
