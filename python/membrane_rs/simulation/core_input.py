"""What the core is given of a scene: its model by components, its laws by kind and parameters, and how it is run."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np

from membrane_rs.analysis.extent import span
from membrane_rs.errors import InputError
from membrane_rs.material import Material
from membrane_rs.scene import Scene
from membrane_rs.scene.assembly import Assembly
from membrane_rs.scene.components import Film, Model, Nodes, Orthotropy, Surface
from membrane_rs.scene.places import places_of

MARGIN = 0.4
"""Share of the stability limit that is taken as the step where none is given."""
ENERGY_TOLERANCE = 1e-2
"""Spurious gain, as a share of the reference energy, at which a run stops."""


@dataclass(frozen=True)
class Settings:
    """How a run is monitored, and how its step is chosen."""

    check_interval: int
    """Steps between two checks."""
    loss_tolerance: float
    """Share of the reference energy that the method may lose by itself before a run stops."""
    tolerance: float
    """Error of a step, where steps are chosen by their error, as a share of length and speed."""
    tolerance_length: float
    """Distance from the origin below which the tolerance is absolute [m]."""
    tolerance_speed: float
    """Speed below which it is [m/s]."""
    spectral_radius: float
    """By what factor an implicit method shrinks, per step, what it cannot resolve."""
    substeps: int
    """Substeps in a step of leapfrog, between which slow laws rest."""
    frozen_at: float | None = None
    """The time at which all that depends on time is frozen [s]; None: time passes."""
    margin: float = MARGIN
    energy_tolerance: float = ENERGY_TOLERANCE


FREE_HUB = "does not go with a free hub"
"""Words of the core by which its refusal of what a free hub excludes is known."""
IMPULSES = "which acts by impulses"
"""Those of its refusal of what a law does not go with that acts by impulses."""
OF_A_LAW = "the law "
"""Those with which its refusals of what a law does not represent begin."""
_KEYS = {
    r"^the method (\w+)": r"run.integrator = '\1':",
    r"^substeps = (\d+)": r"run.substeps = \1:",
    r"^the law moved": "parts of kind 'moved':",
    r"^the law (\w+):?": r"laws.\1:",
    r"leave its inertia out": "leave laws.spin.inertia out",
}
"""Words of these refusals, and the keys of a scene in their place."""


@contextmanager
def refusals_named(scene: Scene) -> Iterator[None]:
    """Name by keys of the scene what the core refuses: what does not go with a law, a free hub or impulses, and the
    cause of a stiffness that is no number: coordinates were checked, so it overflowed.
    """
    try:
        yield
    except InputError as error:
        text = str(error)
        if FREE_HUB in text or IMPULSES in text or text.startswith(OF_A_LAW):
            for words, key in _KEYS.items():
                text = re.sub(words, key, text)
            raise type(error)(text) from None
        if not text.startswith("the stiffness of node"):
            raise
        where, value = max(_numbers_of(scene), key=lambda item: abs(math.log(abs(item[1]))))
        raise InputError(
            f"the stiffness, damping and masses of this scene overflow: their eigenvalues are no numbers; the value "
            f"farthest from 1 is {where} = {value:g}: check it, in SI units"
        ) from None


def _numbers_of(scene: Scene) -> Iterator[tuple[str, float]]:
    """Numbers of material, laws, parts and bodies that are not 0, by their keys, and the extent of the scene [m]."""
    yield "the extent of the scene", max(span(scene.assemble().reference), math.ulp(0.0))
    for place in places_of(scene):
        for name, value in vars(place.item).items():
            for number in value if isinstance(value, tuple) else (value,):
                if isinstance(number, float) and math.isfinite(number) and number != 0.0:
                    yield f"{place.label}.{name}", number


def settings_of(scene: Scene) -> Settings:
    """Those of a scene's run."""
    run = scene.run
    return Settings(
        check_interval=run.watch,
        loss_tolerance=run.energy_loss,
        tolerance=run.tolerance,
        tolerance_length=run.tolerance_length,
        tolerance_speed=run.tolerance_speed,
        spectral_radius=run.spectral_radius,
        substeps=run.substeps,
    )


def model_of(scene: Scene, assembly: Assembly) -> Model:
    """The scene at its start, at rest in the turning frame."""
    mesh = scene.mesh
    return Model(
        nodes=Nodes(
            positions=assembly.positions,
            velocities=np.zeros_like(assembly.positions),
            extra_masses=assembly.extra_masses,
            fixed=assembly.fixed,
            loaded=assembly.loaded,
        ),
        surface=Surface(reference=np.zeros((0, 3)) if mesh is None else mesh.reference, triangles=assembly.triangles),
        film=_film_of(scene),
        creases=assembly.creases,
        cords=assembly.cords,
        bridges=assembly.bridges,
        contacts=assembly.contacts,
        layers=assembly.layers,
        motions=assembly.motions,
        regions=assembly.regions,
        winches=assembly.cords.winches,
    )


def _film_of(scene: Scene) -> Film | None:
    material = scene.material
    if material is None:
        return None
    return Film(
        youngs_modulus=material.youngs_modulus,
        poisson_ratio=material.poisson_ratio,
        density=material.density,
        thickness=material.thickness,
        negative_springs=scene.negative_springs or "keep",
        orthotropy=_orthotropy_of(material),
    )


def _orthotropy_of(material: Material) -> Orthotropy | None:
    across, shear, along = material.youngs_modulus_across, material.shear_modulus, material.youngs_modulus
    if across is None or shear is None:
        return None
    return Orthotropy(material.direction or 0.0, across / along, shear / along)


def laws_of(scene: Scene) -> list[tuple[str, dict[str, Any]]]:
    """Kind and parameters of each law, those of the bodies last."""
    bodies = [law for body in scene.bodies for law in body.core_laws()]
    return [(law.kind, law.core_parameters()) for law in scene.laws] + bodies
