"""The stiffness of a crease whose facets have their reference area: exactly kappa, whatever `collapse` is."""

import numpy as np
import pytest
from membrane_rs import Creases, Mesh, Scene, Simulation
from numpy.typing import NDArray
from small_scenes import FILM

REFERENCE = np.array([[0.0, 0.0, 0.0], [0.03, 0.0, 0.0], [0.008, 0.02, 0.0], [0.017, -0.011, 0.0]])
"""A crease along x with facets of unequal heights."""
HEIGHTS = np.array([0.02, 0.011])
LENGTH, BETA = 0.03, 10.0
KAPPA = BETA * FILM.youngs_modulus * FILM.thickness**3 / 12 * LENGTH / HEIGHTS.mean()
"""beta E_Y J L / H [N m/rad]."""


def folded(fold: float, natural_angle: float, collapse: float) -> Simulation:
    """The two facets, each turned by half the fold angle [rad] about the crease and not strained."""
    turn = np.array([0.5, -0.5]) * fold
    positions = REFERENCE.copy()
    positions[2:, 1] = REFERENCE[2:, 1] * np.cos(turn)
    positions[2:, 2] = REFERENCE[2:, 1] * np.sin(turn)
    mesh = Mesh(REFERENCE, [[0, 1, 2], [1, 0, 3]], positions=positions, creases=[[0, 1]], fold_angles=[fold or 0.5])
    return Simulation(Scene(mesh, FILM, [Creases(BETA, natural_angle=natural_angle, collapse=collapse)]), dt=1e-6)


def apex_moments(sim: Simulation) -> NDArray[np.float64]:
    """The moments of the forces on both apexes about the crease [N m]."""
    return np.asarray(np.linalg.norm(sim.forces("creases")[2:], axis=1) * HEIGHTS)


@pytest.mark.parametrize("collapse", [0.0, 0.05, 0.3, 1.0])
@pytest.mark.parametrize("fold", [0.0, 0.7, 2.5])
def test_energy_and_slope_of_the_energy_are_those_of_kappa(fold: float, collapse: float) -> None:
    opening = 0.4
    natural_angle = np.pi - fold - opening
    energy = folded(fold, natural_angle, collapse).energies()["creases"]
    assert energy == pytest.approx(KAPPA * opening**2 / 2, rel=1e-12, abs=0)
    step = 1e-5
    ahead, behind = (folded(fold + by, natural_angle, collapse).energies()["creases"] for by in (step, -step))
    if fold:  # flat, the side to which a crease folds is given, not found
        assert (behind - ahead) / (2 * step) == pytest.approx(KAPPA * opening, rel=1e-6, abs=0)


@pytest.mark.parametrize("collapse", [0.0, 0.05, 0.3, 1.0])
def test_the_moment_at_rest_is_kappa_times_the_opening(collapse: float) -> None:
    # Near the natural angle the energy, and with it the force of the weights, is of second order in the opening.
    opening = 1e-7
    moments = apex_moments(folded(0.7, np.pi - 0.7 - opening, collapse))
    assert moments == pytest.approx(KAPPA * opening, rel=1e-6, abs=0)
