"""Scales of a scene, by which values are called plausible: its masses, stiffness, waves, and the pull of its spin."""

from __future__ import annotations

import math
from weakref import WeakKeyDictionary

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs.analysis.extent import span
from membrane_rs.errors import MeshError
from membrane_rs.material import Material
from membrane_rs.mesh import Mesh
from membrane_rs.mesh.triangulation import frozen
from membrane_rs.scene.components import FilmRegion
from membrane_rs.scene.law import Surroundings


def film_mass(scene: Surroundings) -> float:
    """Of the membrane [kg]; 0 without one."""
    if scene.mesh is None or scene.material is None:
        return 0.0
    density = scene.material.density * scene.material.thickness
    if not scene.assemble().regions:
        return float(scene.mesh.areas().sum()) * density
    return float(scene.mesh.areas() @ areal_densities(scene, density))


def areal_densities(scene: Surroundings, of_film: float) -> Floats:
    """(m,) mass per area of each triangle, `of_film` outside of the regions [kg/m2]."""
    found = np.full(len(scene.assemble().triangles), of_film)
    for region in scene.assemble().regions:
        found[region.triangles] = region.areal_density
    return found


def free_of_stress(region: FilmRegion, vectors: Floats) -> Floats:
    """Places or edges (..., 3) of the flat shape, as they are in the film of a region free of stress [m]."""
    xx, yy, xy = region.natural_strain
    freed: Floats = vectors @ np.array([[1.0 + xx, xy, 0.0], [xy, 1.0 + yy, 0.0], [0.0, 0.0, 1.0]])
    return freed


def natural_lengths(scene: Surroundings, mesh: Mesh) -> Floats:
    """(e,) lengths of the edges in the film free of stress [m]; between two films the mean of both."""
    spans = (mesh.reference[mesh.edges[:, 1]] - mesh.reference[mesh.edges[:, 0]])[mesh.triangle_edges]
    for region in scene.assemble().regions:
        spans[region.triangles] = free_of_stress(region, spans[region.triangles])
    lengths = np.linalg.norm(spans, axis=2)
    sums: Floats = np.bincount(mesh.triangle_edges.ravel(), lengths.ravel(), len(mesh.edges)).astype(np.float64)
    return sums / mesh.triangles_per_edge


def outermost(scene: Surroundings, *, with_cords: bool = True) -> float:
    """Distance of the outermost node of the flat shape, or of the flat membrane alone, from the z axis [m]."""
    points = scene.assemble().reference if with_cords or scene.mesh is None else scene.mesh.reference
    return float(np.hypot(points[:, 0], points[:, 1]).max())


def widest_spool(scene: Surroundings) -> float:
    """Radius beyond which a spool is hardly meant [m]: the reach of the flat scene from the axis, or its width."""
    return max(outermost(scene), span(scene.assemble().reference))


def stiffest(scene: Surroundings) -> float:
    """Of the springs [N/m]: E h, which is about that of each spring of a film, or EA/l of a cord's segment."""
    film = 0.0 if scene.material is None else scene.material.youngs_modulus * scene.material.thickness
    return max(film, float(scene.assemble().cords.stiffness.max(initial=0.0)))


def first_frequency(scene: Surroundings) -> float:
    """Of waves of tension as long as the scene, 2 pi c / width [rad/s]; inf where there are none.

    c is (E/rho)^(1/2) in a film, and in cords (EA L/M)^(1/2), with L the length and M the mass of all.
    """
    assembly = scene.assemble()
    width = span(assembly.reference)
    if scene.material is not None:
        speed = math.sqrt(scene.material.youngs_modulus / scene.material.density)
    else:
        lengths, mass = assembly.cords.rest_length, float(assembly.extra_masses.sum())
        tension = float((assembly.cords.stiffness * lengths).max(initial=0.0))
        speed = math.sqrt(tension * float(lengths.sum()) / mass) if mass > 0.0 else math.inf
    return 2.0 * math.pi * speed / width if width > 0.0 else math.inf


def hub_frequency(scene: Surroundings) -> float:
    """Turns per second [Hz], at the start or the most of a schedule; 0 where nothing turns."""
    return abs(next((law.hub_frequency for law in scene.laws if law.hub_frequency is not None), 0.0))


def pull_of_spin(scene: Surroundings) -> float:
    """(2 pi f)^2 sum m r [N]: the outward pull of the flat membrane, or of cords alone, as they turn at the start."""
    points = scene.assemble().reference
    if scene.mesh is not None and scene.material is not None:
        points = scene.mesh.reference
    radii = np.hypot(points[:, 0], points[:, 1])
    return (2.0 * math.pi * hub_frequency(scene)) ** 2 * float(node_masses(scene)[: len(points)] @ radii)


def moment_of_inertia(scene: Surroundings) -> float:
    """Of all nodes at the start about the z axis [kg m2]."""
    return float(node_masses(scene) @ np.square(scene.assemble().positions[:, :2]).sum(axis=1))


def node_masses(scene: Surroundings) -> Floats:
    """(N,) masses of all nodes, of membrane, cords and tips [kg]; read-only."""
    if scene not in _MASSES:
        masses: Floats = scene.assemble().extra_masses.copy()
        if scene.mesh is not None and scene.material is not None:
            masses[: scene.mesh.node_count] += film_masses(scene, scene.mesh, scene.material)
        _MASSES[scene] = frozen(masses)
    return _MASSES[scene]


def film_masses(scene: Surroundings, mesh: Mesh, material: Material) -> Floats:
    """(n,) [kg]; of a mesh that is refused for a triangle without area, which has no mass, as well."""
    if not scene.assemble().regions:
        try:
            return mesh.masses(material)
        except MeshError:
            pass
    shares = np.repeat(mesh.areas() * areal_densities(scene, material.density * material.thickness) / 3.0, 3)
    found: Floats = np.bincount(mesh.triangles.ravel(), shares, mesh.node_count).astype(np.float64)
    return found


_MASSES: WeakKeyDictionary[Surroundings, Floats] = WeakKeyDictionary()
"""Of scenes that are still there, which never change."""
