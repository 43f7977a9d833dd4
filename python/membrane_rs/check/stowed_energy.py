"""The energy that the stowed shape holds, beside the energy that the spin gives as it unfolds."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs.errors import MembraneError
from membrane_rs.mesh.findings import Finding
from membrane_rs.scene import Scene
from membrane_rs.scene.hub import hub_of
from membrane_rs.scene.scales import moment_of_inertia
from membrane_rs.simulation.stepper import Stepper


def stowed_energy(scene: Scene) -> Iterator[Finding]:
    """Both, as a fact of a scene that turns and begins in another shape than its flat one.

    Held is the potential energy of all laws at the start, but for those of the hub's turning and of fields such as
    gravity. Freed is Omega^2/2 (J_flat - J_start) [J], with J the moment of inertia about the axis and Omega
    the rate of the hub, the largest of a schedule. A free hub of inertia I slows down: its spin has that energy less,
    times (I + J_start)/(I + J_flat). What is held is put into the motion beside what is freed.
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
    slowing = _slowing(scene, masses)
    freed, by_film = (0.5 * omega**2 * slowing * _opening(mass, *shapes) for mass in (masses, film))
    share = f", {100.0 * held / freed:.3g} % of that" if freed > 0.0 else ""
    yield Finding(
        "info",
        "stowed_energy",
        1,
        f"energy held by the stowed shape {held:.4g} J; set free by the spin from the start to the flat shape "
        f"{freed:.4g} J{share} ({by_film:.4g} J by the film alone)",
        "",
    )


def _slowing(scene: Scene, masses: Floats) -> float:
    """The rate of a free hub with the flat shape over that at the start; 1 of a driven hub."""
    hub = hub_of(scene)
    if hub is None or hub.inertia is None:
        return 1.0
    start = moment_of_inertia(scene)
    return (hub.inertia + start) / (
        hub.inertia + start + _opening(masses, scene.assemble().reference, scene.assemble().positions)
    )


def _opening(masses: Floats, flat: Floats, start: Floats) -> float:
    """By how much the moment of inertia about the z axis grows [kg m2]."""
    return float((masses * (np.square(flat[:, :2]) - np.square(start[:, :2])).sum(axis=1)).sum())
