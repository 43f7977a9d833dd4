"""Size, masses and spin of a scene, in which a slip of a unit shows."""

from __future__ import annotations

import numpy as np

from membrane_rs._validation import check_kind
from membrane_rs.check.film_law import moduli_in_words
from membrane_rs.folding.pattern import facts_of
from membrane_rs.scene import Scene
from membrane_rs.scene.hub import hub_of
from membrane_rs.scene.scales import film_mass
from membrane_rs.scene.softened import with_softening


def facts(scene: Scene) -> dict[str, str]:
    """What a scene is, by name, each with its unit: size, area, thickness, masses, spin.

    Parameters
    ----------
    scene : Scene
        The scene.

    Returns
    -------
    dict of str to str
        Values with their units, by name.

    Raises
    ------
    InputTypeError
        No scene.

    Examples
    --------
    >>> from membrane_rs import scenes
    >>> from membrane_rs.check import facts
    >>> facts(scenes.load("okuizumi-model-1"))["thickness"]
    '7.5e-06 m'
    """
    check_kind(scene, Scene, "scene", "a Scene")
    assembly = scene.assemble()
    found: dict[str, str] = {}
    for name, points in (("size", assembly.reference), ("at start", assembly.positions)):
        sides = " x ".join(f"{side:.4g}" for side in np.ptp(points, axis=0))
        found[name] = f"{sides} m"
    found |= facts_of(scene.mesh)
    # Softening makes cords heavier in the simulation alone.
    own = with_softening(scene.staged(0) if scene.stages else scene, None)
    masses = {"tips and cords": float(own.assemble().extra_masses.sum())}
    if scene.mesh is not None and scene.material is not None:
        area = float(scene.mesh.areas().sum())
        found["area"] = f"{area:.4g} m2"
        found["thickness"] = f"{scene.material.thickness:.4g} m"
        film = scene.material
        waves = (film.youngs_modulus / film.density) ** 0.5
        found["material"] = f"{film.youngs_modulus:.4g} Pa, {film.density:.4g} kg/m3 (waves at {waves:.4g} m/s)"
        moduli = moduli_in_words(film)
        if moduli is not None:
            found["moduli"] = moduli
        owned = dict.fromkeys(region.name for region in assembly.regions)
        if owned:
            inside = sum(len(region.triangles) for region in assembly.regions)
            found["regions"] = f"{inside} of {len(assembly.triangles)} triangles ({', '.join(owned)})"
        if film.softening is not None:
            found["softening"] = f"{film.softening:g}-fold in stretch"
        masses = {"film": film_mass(own)} | masses
    shares = ", ".join(f"{name} {mass:.4g} kg" for name, mass in masses.items() if mass > 0.0)
    found["mass"] = f"{sum(masses.values()):.4g} kg ({shares})"
    hub = hub_of(scene)
    found["spin"] = "none" if hub is None else hub.turning_in_words
    return found
