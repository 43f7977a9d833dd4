"""Implicit steps of flat membranes without stiffness across them, under loads across them."""

from __future__ import annotations

import numpy as np
import pytest
from membrane_rs import (
    Fixed,
    Gravity,
    Material,
    Mesh,
    Pressure,
    RunSettings,
    Scene,
    Simulation,
    Springs,
    TipMasses,
    Triangles,
)
from membrane_rs.folding import Disc, Strip
from membrane_rs.scene.laws import Law

LIGHT = Material(1e9, 0.3, 1.0, 1e-4)
"""Stiff and light, so that a step of 0.05 s is some thousands of those of its vibrations."""
FILMS: list[Law] = [Springs(buckling=0.0, strain_limit=100.0), Triangles(buckling=0.0, strain_limit=100.0)]


def loaded(mesh: Mesh, film: Law, held: str, load: str, dt: float) -> Simulation:
    """A film held at a node set, with a point load of 1 N on a light node, or under a pressure of 1 Pa."""
    tip, force = 1e-4, 1.0
    point = len(mesh.reference) // 3
    laws: list[Law] = [film, Gravity((0.0, 0.0, -force / tip)) if load == "point" else Pressure(force)]
    parts = [Fixed(held), *([TipMasses(tip, nodes=(point,))] if load == "point" else [])]
    run = RunSettings(until=10.0, snapshots=(), energy_loss=100.0)
    return Simulation(Scene(mesh, LIGHT, laws, parts, run=run), "generalized_alpha", dt)


@pytest.mark.parametrize("film", FILMS, ids=lambda law: str(law.kind))
@pytest.mark.parametrize("load", ["point", "pressure"])
@pytest.mark.parametrize("dt", [1e-4, 5e-3, 0.05, 0.5])
@pytest.mark.parametrize("shape", ["disc", "strip"])
def test_a_flat_slack_film_begins_under_a_load_across_it(film: Law, load: str, dt: float, shape: str) -> None:
    mesh, held = (Disc(1.0, 5).mesh(), "rim") if shape == "disc" else (Strip(1.0, 0.4, 8, 3).mesh(), "start")
    sim = loaded(mesh, film, held, load, dt)
    sim.step(3)
    assert sim.time == pytest.approx(3 * dt)
    assert np.abs(sim.positions[:, 2]).max() > 0


@pytest.mark.parametrize("force", [1.0, 100.0])
def test_where_newtons_method_alone_found_no_step(force: float) -> None:
    mesh = Disc(1.0, 8).mesh()
    tip = 1e-4
    laws: list[Law] = [FILMS[0], Gravity((0.0, 0.0, -force / tip))]
    run = RunSettings(until=10.0, snapshots=(), energy_loss=100.0)
    scene = Scene(mesh, LIGHT, laws, [Fixed("rim"), TipMasses(tip, nodes=(0,))], run=run)
    sim = Simulation(scene, "generalized_alpha", 0.05)
    sim.step(3)
    # The load hangs in a cone of springs that reaches the rim: of the order of (P/EA)^1/3 deep.
    assert 0.01 < -sim.positions[0, 2] < 0.3
