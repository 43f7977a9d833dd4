"""Drums: the lowest note of a stretched membrane whose rim is held."""

from __future__ import annotations

import math

import numpy as np
import pytest
from membrane_rs import Fixed, Material, Mesh, Scene, Simulation
from membrane_rs.folding import Disc, Strip
from small_scenes import RUBBER, UNBUCKLED, frequencies, rates

RADIUS = 0.1


def drum(mesh: Mesh, rim: np.ndarray, material: Material) -> tuple[float, float]:
    """Lowest frequency [Hz] of a membrane stretched by 1e-4 with its rim held, and its tension [N/m]."""
    sim = Simulation(Scene(mesh, material, [UNBUCKLED], [Fixed(nodes=rim.tolist())]))
    sim.positions = 1.0001 * mesh.reference
    inside = np.setdiff1d(np.arange(sim.node_count), rim)
    # All-round tension T: sum of N l over all springs is 2 T A.
    tension = -float(np.sum(sim.forces() * sim.positions)) / (2 * float(mesh.areas().sum()))
    return float(frequencies(sim, inside, 2, 1e-7)[0] / (2 * math.pi)), tension


def test_lowest_note_of_a_square_drum() -> None:
    side, errors = 0.2, []
    areal = RUBBER.density * RUBBER.thickness
    for cells in (4, 8, 16):
        mesh = Strip(side, side, cells, cells).mesh()
        rim = np.unique(mesh.boundary_edges)
        note, tension = drum(mesh, rim, RUBBER)
        errors.append(note / (math.sqrt(0.5) * math.sqrt(tension / areal) / side) - 1.0)
    # Second order; the strain of 1e-4 is 1e-4 of the frequency.
    assert abs(errors[-1]) < 0.01
    assert rates(errors) == pytest.approx(2.0, abs=0.2)


def test_lowest_note_of_a_round_drum() -> None:
    errors = []
    areal = RUBBER.density * RUBBER.thickness
    film = RUBBER.youngs_modulus * RUBBER.thickness / (1 - RUBBER.poisson_ratio) * 1e-4
    for rings in (3, 6, 12):
        mesh = Disc(RADIUS, rings).mesh()
        note, tension = drum(mesh, mesh.node_sets["rim"], RUBBER)
        assert tension == pytest.approx(film, rel=0.2 / rings)
        errors.append(note / (0.3827 * math.sqrt(tension / areal) / RADIUS) - 1.0)
    # Measured: -2.9, -0.81, -0.20 %.
    assert abs(errors[-1]) < 0.005
    assert rates(errors) == pytest.approx(2.0, abs=0.3)
