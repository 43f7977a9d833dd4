"""The energy that the stowed shape holds, beside the energy that the spin gives as it unfolds."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs.errors import MembraneError
from membrane_rs.mesh.findings import Finding
from membrane_rs.scene import Scene
from membrane_rs.scene.laws import Spin
from membrane_rs.simulation.stepper import Stepper


def stowed_energy(scene: Scene) -> Iterator[Finding]:
    """Both, as a fact of a scene that turns and begins in another shape than its flat one.

    Held is the potential energy of all laws at the start, but for those of the hub's turning and of fields such as
    gravity. Freed is Omega^2/2 (J_flat - J_start) [J], with J the moment of inertia about the axis and Omega
    the rate of the hub, the largest of a schedule. A free hub of inertia I is slowed to
    Omega_flat = Omega (I + J_start)/(I + J_flat), and Omega Omega_flat stands for Omega^2. What is held is put into the
    motion beside what is freed.
    """
    omega = 2.0 * math.pi * sum(law.hub_frequency or 0.0 for law in scene.laws)
    if scene.mesh is None or omega == 0.0 or (scene.mesh.positions == scene.mesh.reference).all():
        return
    try:
        start = Stepper(scene)
    except MembraneError:  # `Simulation` says why
        return
    fields = {law.kind for law in scene.laws if law.turns_hub or law.accelerates_all}
    held = sum(energy for law, energy in start.energies().items() if law not in {"kinetic", *fields})
    assembly, masses = scene.assemble(), start.masses
    film = masses - assembly.extra_masses
    shapes = assembly.reference, assembly.positions
    square = omega**2 * _slowing(scene, *(_moment(masses, shape) for shape in shapes))
    freed, by_film = (0.5 * square * _opening(mass, *shapes) for mass in (masses, film))
    share = f", {100.0 * held / freed:.3g} % of that" if freed > 0.0 else ""
    yield Finding(
        "info",
        "stowed_energy",
        1,
        f"energy held by the stowed shape {held:.4g} J; set free by the spin from the start to the flat shape "
        f"{freed:.4g} J{share} ({by_film:.4g} J by the film alone)",
        "",
    )


def _moment(masses: Floats, shape: Floats) -> float:
    """Moment of inertia about the z axis [kg m2]."""
    return float((masses * np.square(shape[:, :2]).sum(axis=1)).sum())


def _opening(masses: Floats, flat: Floats, start: Floats) -> float:
    """By how much the moment of inertia about the z axis grows [kg m2]."""
    return _moment(masses, flat) - _moment(masses, start)


def _slowing(scene: Scene, flat: float, start: float) -> float:
    """Rate of the hub with the flat sail over that at the start, by both moments of inertia [kg m2]; 1 if driven."""
    spin = scene.law("spin")
    if not isinstance(spin, Spin) or spin.inertia is None:
        return 1.0
    return (spin.inertia + start) / (spin.inertia + flat)
