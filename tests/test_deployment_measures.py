"""What is measured: known motions give known numbers."""

from __future__ import annotations

from typing import Any, cast

import numpy as np
import pytest
from fake_simulation import FakeSimulation, turned_flat
from hypothesis import given
from hypothesis import strategies as st
from membrane_rs import Scene, Simulation, Tether, scenes
from membrane_rs.analysis.deployment import Corners, corner_nodes
from membrane_rs.analysis.strain import triangle_strains
from membrane_rs.results.features import curve_features, energy_balance
from membrane_rs.results.measures import deployment_rate
from numpy.testing import assert_allclose, assert_array_equal

TRIANGLE = np.array([[0, 1, 2]])
FLAT = np.array([[0.0, 0.0, 0.0], [0.02, 0.0, 0.0], [0.005, 0.01, 0.0]])


def test_flat_sail_is_fully_deployed() -> None:
    sim = FakeSimulation()
    corners = Corners(sim.assembly)
    assert corners.flat_radius == pytest.approx(0.2 / np.sqrt(2.0))
    assert corners.deployment_rate(sim.assembly.reference) == pytest.approx(1.0)
    assert corners.phase_difference(sim.assembly.reference) == pytest.approx(0.0, abs=1e-12)


def test_rate_is_the_mean_radius() -> None:
    sim = FakeSimulation()
    sim.positions = turned_flat(sim.assembly, 33.0, 0.7)
    assert deployment_rate(cast(Any, sim)) == pytest.approx(0.7)


def test_phase_is_followed_through_more_than_a_turn() -> None:
    assembly = FakeSimulation().assembly
    corners = Corners(assembly)
    for angle in [*range(0, 500, 100), *range(400, -500, -100)]:
        assert corners.phase_difference(turned_flat(assembly, angle)) == pytest.approx(angle, abs=1e-9)


def test_phase_of_asymmetric_corners_is_their_mean() -> None:
    assembly = FakeSimulation().assembly
    positions = turned_flat(assembly, 0.0)
    corner = assembly.node_sets["corners"][0]
    positions[corner] = turned_flat(assembly, -40.0)[corner]
    assert Corners(assembly).phase_difference(positions) == pytest.approx(-10.0)


def test_corners_of_a_tether_and_of_a_mesh_without_names() -> None:
    tether = Tether(start=(0.1, 0.0, 0.0), end=(0.5, 0.0, 0.0), segments=4, axial_stiffness=17.0, linear_density=1e-4)
    assembly = Scene(None, None, [], [tether]).assemble()
    assert_array_equal(corner_nodes(assembly), [4])
    rim = corner_nodes(scenes.load("spinning-disc").assemble())
    reference = scenes.load("spinning-disc").assemble().reference
    assert len(rim) > 4
    assert_allclose(np.hypot(*reference[rim, :2].T), np.hypot(*reference[:, :2].T).max())


def test_corner_on_the_axis_has_no_rate_and_no_phase() -> None:
    tether = Tether(start=(0.0, 0.0, 1.0), end=(0.0, 0.0, 0.0), segments=4, axial_stiffness=17.0, linear_density=1e-4)
    sim = Simulation(Scene(None, None, [], [tether]))
    assert np.isnan(deployment_rate(sim))
    assert np.isnan(Corners(sim.assembly).phase_difference(sim.positions))


@given(
    stretch=st.tuples(*[st.floats(0.2, 3.0)] * 2),
    shear=st.floats(-1.0, 1.0),
    euler=st.tuples(*[st.floats(-3.0, 3.0)] * 3),
)
def test_triangle_strains_are_those_of_the_deformation_gradient(
    stretch: tuple[float, float], shear: float, euler: tuple[float, float, float]
) -> None:
    gradient = np.array([[stretch[0], shear], [0.0, stretch[1]]])
    expected = 0.5 * (np.linalg.svd(gradient, compute_uv=False) ** 2 - 1.0)
    moved = np.column_stack([FLAT[:, :2] @ gradient.T, np.zeros(3)])
    for axis, angle in enumerate(euler):
        k, m = [(1, 2), (2, 0), (0, 1)][axis]
        turn = np.eye(3)
        turn[[k, k, m, m], [k, m, k, m]] = np.cos(angle), -np.sin(angle), np.sin(angle), np.cos(angle)
        moved = moved @ turn.T + angle
    assert_allclose(triangle_strains(FLAT, moved, TRIANGLE)[0], expected, atol=1e-9)


def test_strain_of_no_triangles() -> None:
    assert triangle_strains(FLAT, FLAT, np.zeros((0, 3), dtype=np.int64)).shape == (0, 2)


def test_features_of_known_curves() -> None:
    time = np.linspace(0.0, 0.8, 801)
    phase = -100.0 * np.sin(np.pi * time / 0.75)
    rate = 0.9 + 0.1 * np.cos(2.0 * np.pi * (time - 0.1) / 0.65)
    table = {"time": time, "deployment_rate": rate, "phase_difference_deg": phase}
    found = curve_features(table)
    assert found["first_peak_time"] == pytest.approx(0.1)
    assert found["first_peak_rate"] == pytest.approx(1.0)
    assert found["phase_trough_deg"] == pytest.approx(-100.0, abs=1e-3)
    assert found["phase_trough_time"] == pytest.approx(0.375)
    assert found["zero_crossing_time"] == pytest.approx(0.75, abs=1e-6)
    assert found["zero_crossing_rate"] == pytest.approx(1.0, abs=1e-4)
    early = curve_features({name: values[:300] for name, values in table.items()})
    assert early["phase_trough_deg"] is None
    assert early["zero_crossing_time"] is None
    assert early["first_peak_time"] == pytest.approx(0.1)
    assert early["final_phase_deg"] == phase[299]


def test_features_of_nothing() -> None:
    nothing = np.zeros(0)
    table = {"time": nothing, "deployment_rate": nothing, "phase_difference_deg": nothing}
    assert set(curve_features(table).values()) == {None}
    assert set(energy_balance({"energy_error": nothing, "reference_energy": nothing}).values()) == {None}


@pytest.mark.parametrize(("size", "is_seen"), [(1e-9, False), (1e-3, True)])
def test_a_phase_of_rounding_has_neither_trough_nor_zero_crossing(size: float, is_seen: bool) -> None:
    time = np.linspace(0.0, 1.0, 101)
    table = {"time": time, "deployment_rate": time, "phase_difference_deg": -size * np.sin(1.9 * np.pi * time)}
    found = curve_features(table)
    for name in ("phase_trough_deg", "phase_trough_time", "zero_crossing_time", "zero_crossing_rate"):
        assert (found[name] is not None) == is_seen, name
