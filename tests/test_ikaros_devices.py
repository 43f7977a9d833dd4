"""The deployed sail of IKAROS with devices that curl it: the example scene, and its variants for the docs."""

from __future__ import annotations

import math
from dataclasses import replace

import ikaros_devices_runs as runs
import numpy as np
import pytest
from ikaros_devices import meshes, rest_table, spins, values
from ikaros_runs import sail_of
from membrane_rs import Scene, Simulation, SolarPressure


@pytest.fixture(scope="module")
def coarse() -> Scene:
    return runs.on_mesh(runs.own(), "coarse")


def test_light_pushes_the_sail_by_the_reported_thrust(coarse: Scene) -> None:
    law = next(law for law in coarse.laws if isinstance(law, SolarPressure))
    assert (Simulation(coarse).forces(law)[:, 2] <= 0.0).all()
    assert runs.light_on(coarse) == pytest.approx(1.12e-3, rel=0.02)


def test_the_pull_of_a_quarter_is_that_of_its_moment(coarse: Scene) -> None:
    """Of a square with a square hole and a tip: |x| + |y| over a quarter of the plane is twice the integral of x."""
    first = 2.0 * runs.areal_mass(coarse) * (7.0**3 - 1.9**3) / 2.0 / math.sqrt(2.0)
    tether = 4.0 * 0.019 * 1.74 / 4.0
    assert runs.pull_of_quarter(coarse, 1.0) == pytest.approx(first + 0.5 * 7.0 * math.sqrt(2.0) + tether, rel=0.01)


def test_devices_are_as_heavy_as_the_film_without_them(coarse: Scene) -> None:
    alone = Simulation(runs.without_devices(coarse))
    assert Simulation(coarse).masses == pytest.approx(alone.masses, rel=1e-12)
    assert alone.masses.sum() == pytest.approx(15.0 + 2.0, rel=0.01)


def test_strips_curl_to_arcs_with_their_middles_away_from_the_sun(coarse: Scene) -> None:
    """Free of spin and light, a strip that turns freely about its fold lines takes up its natural curvature."""
    laws = tuple(law for law in coarse.laws if law.kind not in ("spin", "solar_pressure"))
    sim = Simulation(replace(coarse, laws=laws))
    sim.reach(20.0)
    assert coarse.mesh is not None
    x, y = coarse.mesh.reference[:, :2].T
    height = sim.positions[: len(x), 2]
    near, sail = np.abs(y) < 0.2, sail_of(coarse)
    lines = 1.9 + sail.strip_height * np.arange(1, 10)
    on_lines = near & (np.abs(x[:, None] - lines).min(axis=1) < 0.01)
    between = near & (np.abs(x[:, None] - lines[:-1] - 0.5 * sail.strip_height).min(axis=1) < 0.01)
    arc = 2.0 * sail.strip_height**2 / 8.0
    assert 0.7 * arc < height[on_lines].mean() - height[between].mean() < arc


def test_variants_change_what_they_say(coarse: Scene) -> None:
    """A softer or stiffer film leaves devices their bending and their buckling forces, and spin goes with the step."""
    harder = runs.with_modulus(coarse, 3.2e7)
    assert runs.number(harder, "parts.devices.bending_stiffness") == 4e-5
    assert runs.number(harder, "parts.devices.buckling") == pytest.approx(3.5e4)
    assert harder.run.dt == pytest.approx(coarse.run.dt / 10**0.5)  # type: ignore[operator]
    cell = runs.stiffened(coarse, 5e-6)
    assert runs.number(cell, "parts.devices.buckling") == pytest.approx(3.5e5 / 8)
    turning = runs.at_spin(coarse, 4 * runs.RPM, 3.2e6)
    assert [stage.duration for stage in turning.stages] == [30.0, 750.0]
    assert turning.value("laws.spin.frequency") == pytest.approx(4 * runs.RPM / 60.0)


def test_every_run_has_its_own_name() -> None:
    made = [*meshes(), *values(), *spins()]
    common = {"film alone, coarse", "devices, coarse"}
    assert len(made) - len(set(made)) == len(common)


def test_the_table_has_depths_away_from_the_sun(coarse: Scene) -> None:
    assert coarse.mesh is not None
    positions = coarse.mesh.reference.copy()
    positions[:, 2] = -0.5
    run = {
        "positions": positions, "tensions": np.full(4, 2e-3), "drift": np.array([-0.01]), "nodes": np.array([9.0]),
    }  # fmt: skip
    row = rest_table({"own": (coarse, run)}).splitlines()[-1]
    assert row == "| own | 9 | 0.500 | 0.500 | 0.500 | 0.500 | 0.000 | 0.010 | 2.00 |"
