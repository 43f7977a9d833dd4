"""What is measured on a scene in motion."""

from __future__ import annotations

import numpy as np

from membrane_rs.analysis import strain
from membrane_rs.analysis.deployment import Corners
from membrane_rs.scene.scales import free_of_stress
from membrane_rs.simulation.motion import Motion, check_simulation


def deployment_rate(sim: Motion) -> float:
    """Mean radius of the corners now over that of the reference.

    Parameters
    ----------
    sim : Simulation
        Or another motion.

    Returns
    -------
    float
        [-], 1 for the flat sail.

    Raises
    ------
    InputTypeError
        No motion.

    Examples
    --------
    >>> from membrane_rs import Simulation, scenes
    >>> from membrane_rs.results import deployment_rate
    >>> round(deployment_rate(Simulation(scenes.load("okuizumi-model-1"))), 2)
    0.73
    """
    check_simulation(sim)
    return Corners(sim.assembly).deployment_rate(sim.positions)


def peak_stress(sim: Motion) -> float:
    """The largest principal stress of the film [Pa]; 0 where none of it is in tension, NaN without film.

    Of a film of triangles it is that of its law, `Motion.largest_film_stress`. Of a film of springs it is not: the mean
    stress by the springs, `Motion.film_stress`, varies from triangle to triangle with the shape of the mesh. It is the
    stress of the film that the springs stand for, a tension field under the strain of each triangle,
    `membrane_rs.analysis.strain.peak_stress`, which can be compared from mesh to mesh.

    Parameters
    ----------
    sim : Simulation
        Or another motion.

    Returns
    -------
    float
        [Pa]

    Raises
    ------
    InputTypeError
        No motion.

    Examples
    --------
    >>> from membrane_rs import Simulation, scenes
    >>> from membrane_rs.results import peak_stress
    >>> peak_stress(Simulation(scenes.load("spinning-disc")))
    0.0
    """
    check_simulation(sim)
    mesh, film = sim.scene.mesh, sim.stage_scene.as_simulated.material
    if mesh is None or film is None:
        return float("nan")
    if (sim.film_states() >= 0).all():
        return sim.largest_film_stress()
    strains = strain.triangle_strains(mesh.reference, sim.positions[: mesh.node_count], mesh.triangles)
    moduli = np.full(len(strains), film.youngs_modulus)
    for region in sim.stage_scene.assemble().regions:
        moduli[region.triangles] = region.youngs_modulus
        if any(region.natural_strain):
            free, own = free_of_stress(region, mesh.reference), mesh.triangles[region.triangles]
            strains[region.triangles] = strain.triangle_strains(free, sim.positions[: mesh.node_count], own)
    return strain.peak_stress(strains, moduli, film.poisson_ratio)
