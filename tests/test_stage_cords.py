"""What stages set of cords: a hold that is released or made, and refusals of what says where cords lie at the start."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
from membrane_rs import Boltrope, Cord, Gravity, Scene, Simulation, Springs, Stage, Tether, Tethers
from membrane_rs.errors import SceneError
from membrane_rs.scene.parts import Part
from numpy.testing import assert_allclose
from small_scenes import FILM, patch, refused

ROPE: dict[str, Any] = {"segments": 4, "axial_stiffness": 100.0, "linear_density": 1e-3}
RISER = Cord((0.0, 0.0, 1.0), (0.0, 0.0, 0.5), **ROPE, name="riser")
LEG = Cord("riser-end", "corners[0]", **ROPE, name="leg", length=2.0)


def test_a_stage_releases_the_start_of_a_cord_and_holds_it_again() -> None:
    """A hanging cord without load on its start falls as a free body once it is released."""
    rope = Cord((0.0, 0.0, 1.0), (0.0, 0.0, 0.5), **ROPE, name="rope")
    stages = [Stage("held", 0.01), Stage("free", 0.05, set={"parts.rope.fixed": False}), Stage("held again", 0.01)]
    sim = Simulation(Scene(None, None, [Gravity()], [rope], stages=stages))
    sim.reach(0.01)
    at_release = sim.positions[0].copy()
    assert_allclose(at_release, (0.0, 0.0, 1.0), atol=0.0)
    centre, speed = (sim.masses @ values[:, 2] / sim.masses.sum() for values in (sim.positions, sim.velocities))
    sim.reach(0.06 - 1e-9)
    fallen = sim.masses @ sim.positions[:, 2] / sim.masses.sum()
    assert fallen == pytest.approx(centre + speed * 0.05 - 0.5 * 9.81 * 0.05**2, abs=1e-6)
    assert sim.positions[0, 2] < 1.0 - 1e-3
    sim.reach(0.065)
    held = sim.positions[0].copy()
    sim.reach(0.07)
    assert np.array_equal(sim.positions[0], held)


@pytest.mark.parametrize(
    ("key", "value", "parts", "words"),
    [
        (
            "parts.riser.start",
            (0.0, 0.0, 2.0),
            [RISER, LEG],
            "parts.riser.start = (0.0, 0.0, 2.0): says where nodes lie",
        ),
        ("parts.riser.end", (0.0, 0.0, 0.6), [RISER, LEG], "leave it at (0.0, 0.0, 0.5), or change the part"),
        ("parts.leg.start", "riser-start", [RISER, LEG], "parts.leg.start = 'riser-start': says where nodes lie"),
        ("parts.leg.fixed", False, [RISER, LEG], "parts.leg.fixed = False: is without effect where a cord starts at "),
        (
            "parts.hem.closed",
            True,
            [Boltrope("corners", 10.0, 1e-4, name="hem")],
            "parts.hem.closed = True: says where nodes lie at the start of the run, and no stage moves them",
        ),
        (
            "parts.line.end",
            (0.0, 0.0, 3.0),
            [Tether((0.0, 0.0, 1.0), (0.0, 0.0, 0.5), **ROPE, name="line")],
            "parts.line.end = (0.0, 0.0, 3.0): says where nodes lie",
        ),
        (
            "parts.lines.anchor_radius",
            0.02,
            [Tethers("corners", 0.03, **ROPE, name="lines")],
            "parts.lines.anchor_radius = 0.02: says where nodes lie",
        ),
    ],
)
@pytest.mark.parametrize("index", [0, 1])
def test_what_says_where_a_cord_lies_is_refused(
    key: str, value: Any, parts: list[Part], words: str, index: int
) -> None:
    mesh = patch(node_sets={"corners": [1, 2]}) if "hem" in key else patch()

    def scene(value: Any) -> Scene:
        stages = [Stage(name, 0.01, set={key: value} if k == index else {}) for k, name in enumerate(("one", "two"))]
        return Scene(mesh, FILM, [Springs(), Gravity()], parts, stages=stages)

    refused(lambda: scene(value), SceneError, f"^stages\\[{index}\\].*{re.escape(words)}")
    _, name, field = key.split(".")
    own = getattr(next(part for part in parts if part.name == name), field)
    if field != "fixed":
        assert len(scene(own).stages) == 2
