"""A strip of film pulled over a post: the angle by which it lies on it, and Euler's and Eytelwein's tensions."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from membrane_rs import (
    Cylinder,
    Fixed,
    Gravity,
    MassDamping,
    Material,
    Mesh,
    Scene,
    Schedule,
    Simulation,
    SpringDamping,
    Springs,
    TipMasses,
)
from membrane_rs.folding import Strip

RADIUS, LEG, FRICTION = 0.02, 0.03, 0.3
FILM = Material(1e7, 1 / 3, 2000.0, 1e-4)


def draped(columns: int, friction: float) -> Simulation:
    """A strip over the upper half of a post, at rest; one end is held, at the other hangs a weight of 8 g.

    With friction the post turns, so that its surface slides towards the weight.
    """
    length = 2.0 * LEG + math.pi * RADIUS
    flat = Strip(length, 0.006, columns, 1).mesh()
    path, y = flat.reference[:, 0], flat.reference[:, 1]
    angle = np.clip((path - LEG) / RADIUS, 0.0, math.pi)
    below = np.minimum(path - LEG, 0.0) - np.maximum(path - LEG - math.pi * RADIUS, 0.0)
    positions = np.column_stack([-RADIUS * np.cos(angle), y, RADIUS * np.sin(angle) + below])
    positions[:, ::2] *= 1.002 / math.cos(0.5 * length / columns / RADIUS)  # edges touch at their middle
    mesh = Mesh(flat.reference, flat.triangles, positions=positions, node_sets=flat.node_sets)
    turning: dict[str, Any] = {"spin": Schedule((0.0, 10.0), (0.0, 50.0), ease=0.01)} if friction else {}
    post = Cylinder(
        "post",
        RADIUS,
        direction=(0, 1, 0),
        stiffness=4e3,
        friction=friction,
        felt_by="triangles",
        damping=0.1,
        **turning,
    )
    laws = [Springs(), SpringDamping(0.05), Gravity(), MassDamping(60.0)]
    weight = TipMasses(0.004, nodes="end")
    sim = Simulation(Scene(mesh, FILM, laws, [Fixed("start"), weight], bodies=[post]), "leapfrog")
    sim.run(0.25 if friction else 0.12)
    return sim


def tensions(sim: Simulation) -> tuple[float, float]:
    """At the held end, and at the weight; each where the strip leaves the post [N]."""
    weights = 9.81 * sim.masses
    is_held = np.zeros(len(weights), dtype=bool)
    is_held[sim.assembly.node_sets["start"]] = True
    is_free = ~np.abs(sim.forces("post")).any(axis=1) & ~is_held
    x = sim.positions[:, 0]
    held = (sim.forces("springs") + sim.forces("spring_damping"))[is_held, 2].sum()
    return abs(float(held)) - float(weights[is_free & (x < 0.0)].sum()), float(weights[is_free & (x > 0.0)].sum())


def test_a_strip_without_friction_lies_on_half_a_post() -> None:
    # With a tension T all along, the sum of the contact is T times the angle.
    errors = []
    for columns in (14, 28):
        sim = draped(columns, 0.0)
        held, hanging = tensions(sim)
        assert held == pytest.approx(hanging, rel=0.02)
        angle = sim.body_loads()["post"].contact / (0.5 * (held + hanging))
        errors.append(abs(angle / math.pi - 1.0))
    assert errors[0] < 0.05
    assert errors[1] < 0.5 * errors[0]


def test_the_tension_of_a_strip_that_slides_grows_with_the_exponent_of_the_angle() -> None:
    expected, errors = math.exp(FRICTION * math.pi), []
    for columns in (14, 28):
        held, hanging = tensions(draped(columns, FRICTION))
        errors.append(abs(held / hanging / expected - 1.0))
    assert errors[0] < 0.06
    assert errors[1] < 0.5 * errors[0]
