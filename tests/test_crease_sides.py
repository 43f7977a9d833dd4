"""Creases that are folded against their side, from one motion to the next: the angle keeps its whole turn."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from membrane_rs import Mesh, Scene, Simulation, Stage, scenes

UNTIL = 0.06


def against() -> Scene:
    """The scene of one crease, whose natural angle is on the other side."""
    return scenes.load("single-crease").with_values({"laws.creases.natural_angle": 6.0, "mesh.fold_angle": 0.5})


@pytest.fixture(scope="module")
def folded() -> Simulation:
    """Folded against its side, beyond 270 degrees."""
    sim = Simulation(against())
    sim.reach(UNTIL)
    assert sim.crease_angles()[0] > 1.55 * pi
    return sim


def test_velocities_alone_leave_the_angles(folded: Simulation) -> None:
    before, energy = folded.crease_angles(), folded.energies()["creases"]
    folded.velocities = np.zeros_like(folded.velocities)
    assert np.array_equal(folded.crease_angles(), before)
    assert folded.energies()["creases"] == energy


def test_another_motion_starts_with_the_angles_of_the_first(folded: Simulation) -> None:
    softer = against().with_values({"laws.creases.stiffness": 0.5 * folded.scene.value("laws.creases.stiffness")})
    assert np.array_equal(Simulation(softer, start=folded).crease_angles(), folded.crease_angles())


def test_creases_that_fold_to_the_other_side_do_not_take_them(folded: Simulation) -> None:
    mesh = folded.scene.mesh
    assert mesh is not None
    turned = Mesh(
        mesh.reference,
        mesh.triangles,
        creases=mesh.creases,
        fold_angles=-mesh.fold_angles,
        node_sets=mesh.node_sets,
    )
    found = Simulation(replace(folded.scene, mesh=turned), start=folded).crease_angles()[0]
    assert found == pytest.approx(2.0 * pi - folded.crease_angles()[0], abs=1e-12)


def test_a_stage_goes_on_with_the_angles() -> None:
    sim = Simulation(replace(against(), stages=[Stage("fold", UNTIL), Stage("on", 0.01)]))
    sim.reach(UNTIL - 1e-5)
    before = sim.crease_angles()[0]
    sim.reach(UNTIL + 1e-5)
    assert sim.stage_name == "on"
    assert before > 1.5 * pi
    assert sim.crease_angles()[0] == pytest.approx(before, abs=0.05)
    assert "on: creases" not in sim.ledger()["changes"]
