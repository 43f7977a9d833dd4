"""Cords wound round the axis, as those of a yo-yo: where they lie, what they refuse, and how they unwind."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from membrane_rs import (
    InputError,
    InputTypeError,
    RunSettings,
    Scene,
    SceneError,
    Simulation,
    Spin,
    SpoolContact,
    Tether,
)
from membrane_rs.check.spool import spool
from small_scenes import refused
from test_schema import faults

CORD = {"segments": 60, "axial_stiffness": 50.0, "linear_density": 1e-5}
R = 0.025


def wound(sense: Any = "clockwise", start: tuple[float, float, float] = (R, 0.0, 0.0), **changes: Any) -> Tether:
    values: dict[str, Any] = {**CORD, "length": 6.35 * R, "tip_mass": 0.36e-3, **changes}
    return Tether(start, None, **values, wound=sense)


def scene_of(*parts: Tether, **spin: Any) -> Scene:
    return Scene(None, None, [Spin(3.0, **spin)], parts)


@pytest.mark.parametrize(("sense", "sign"), [("clockwise", -1.0), ("counterclockwise", 1.0)])
@pytest.mark.parametrize("start", [(R, 0.0, 0.0), (-0.6 * R, 0.8 * R, 0.3)])
def test_it_lies_on_the_circle_through_its_start(sense: str, sign: float, start: tuple[float, float, float]) -> None:
    """In chords that are as long as their segments without load."""
    assembly = scene_of(wound(sense, start)).assemble()
    points = assembly.positions
    assert np.array_equal(points[0], start)
    assert np.hypot(points[:, 0], points[:, 1]) == pytest.approx(np.full(61, R), rel=1e-12)
    assert np.all(points[:, 2] == start[2])
    chords = np.linalg.norm(np.diff(points, axis=0), axis=1)
    assert chords == pytest.approx(assembly.cords.rest_length, rel=1e-12)
    turned = np.unwrap(np.arctan2(points[:, 1], points[:, 0]))
    expected = 60 * 2.0 * math.asin(6.35 / 120.0)
    assert turned[-1] - turned[0] == pytest.approx(sign * expected, rel=1e-12)
    # Unwound it leads outward.
    assert np.hypot(*assembly.reference[-1, :2]) == pytest.approx(7.35 * R)
    assert assembly.reference[-1, :2] / 7.35 == pytest.approx(start[:2], abs=1e-15)
    assert assembly.fixed.tolist() == [0]
    assert assembly.extra_masses.sum() == pytest.approx(0.36e-3 + 1e-5 * 6.35 * R)


@pytest.mark.parametrize(
    ("changes", "kind", "words"),
    [
        ({"length": None}, InputError, "Tether.length = None: is missing; a cord wound clockwise needs its length"),
        ({"end": (1.0, 0.0, 0.0)}, InputError, "Tether.end = .*: is not used with wound.*; leave it out"),
        ({"start": (0.0, 0.0, 1.0)}, InputError, r"Tether.start = .*: lies on the z axis.*; give a point off it \(m\)"),
        ({"wound": "left"}, InputError, "Tether.wound = 'left': must be 'clockwise' or 'counterclockwise'"),
        ({"wound": 1}, InputError, "Tether.wound = 1: must be"),
        ({"wound": None}, InputError, "Tether.end = None: is missing; give the point at which it ends, or wound"),
    ],
)
def test_what_it_is_not_is_refused(changes: dict[str, Any], kind: type[Exception], words: str) -> None:
    values: dict[str, Any] = {"start": (R, 0.0, 0.0), "end": None, "length": 0.1, "wound": "clockwise", **CORD}
    refused(lambda: Tether(**(values | changes)), kind, words)


def test_an_end_is_needed_by_others_and_left_out_by_a_wound_one() -> None:
    values: dict[str, Any] = {"start": (R, 0.0, 0.0), **CORD}
    refused(lambda: Tether(**values), InputTypeError, "Tether.end: is missing")
    assert Tether(**values, length=0.1, wound="clockwise") == wound(length=0.1, tip_mass=0.0)


def test_segments_that_do_not_follow_the_circle_are_refused() -> None:
    words = r"parts\[0\].segments = 6: each is 0.0264583 m long, and the radius of the circle 0.025 m: give the cord 7"
    refused(lambda: scene_of(wound(segments=6)), SceneError, words)
    assert scene_of(wound(segments=7)).assemble().node_count == 8


def test_a_file_holds_it(tmp_path: Path) -> None:
    scene = scene_of(wound(), replace(wound(), start=(-R, 0.0, 0.0)))
    scene.save(tmp_path)
    again = Scene.from_toml(tmp_path / "scene.toml")
    assert (again.parts, again.to_toml()) == (scene.parts, scene.to_toml())
    text = scene.to_toml()
    assert faults(text) == []
    assert faults(text.replace("# end: not set", "end = [1, 0, 0]")) != []
    assert faults(text.replace("\nlength = ", "\n# ")) != []
    assert faults(text.replace('wound = "clockwise"', "")) != []
    assert "# wound: not set" in scene_of(Tether((R, 0.0, 0.0), (1.0, 0.0, 0.0), **CORD)).to_toml()  # type: ignore[arg-type]


def test_it_describes_the_spool_that_it_lies_on() -> None:
    assert list(spool(Scene(None, None, [SpoolContact(R)], [wound()]))) == []
    (finding,) = spool(Scene(None, None, [SpoolContact(0.8 * R)], [wound()]))
    assert "parts[0] starts its cords 0.025 m from the axis" in finding.message
    assert Tether((R, 0.0, 0.0), (1.0, 0.0, 0.0), 8, 17.0, 1e-4).spool is None


def test_it_is_not_made_coarser() -> None:
    """Fewer chords end elsewhere."""
    assert wound().coarser(4) is None
    assert Tether((R, 0.0, 0.0), (1.0, 0.0, 0.0), 8, 17.0, 1e-4).coarser(4) is not None
    assert wound().resized({"corners": (4, 8)}) == wound()


def test_a_stage_or_a_study_changes_its_length() -> None:
    scene = scene_of(wound()).with_values({"parts.0.length": "20 cm", "parts.0.wound": "counterclockwise"})
    assert scene.parts == (wound("counterclockwise", length=0.2),)


def test_a_yo_yo_takes_the_spin_of_its_hub() -> None:
    """Two masses on cords wound against the spin: w/w0 = (C - f^2)/(C + f^2), f the free length over R."""
    ratio, tip = 41.0, 0.36e-3
    inertia = (ratio - 1.0) * 2.0 * tip * R**2
    cords = [wound(start=(side * R, 0.0, 0.0), linear_density=0.0036e-3 / (6.35 * R)) for side in (1.0, -1.0)]
    laws = [Spin(3.0, inertia=inertia), SpoolContact(radius=R, stiffness=2000.0, membrane=False)]
    sim = Simulation(Scene(None, None, laws, cords, run=RunSettings(integrator="leapfrog")))
    reached = 0.0
    while reached < 5.0:
        sim.reach(sim.time + 0.01)
        assert sim.time < 0.5
        x, y, _ = sim.positions[60]
        reached = math.sqrt(max(0.0, (x * x + y * y) / R**2 - 1.0))
        expected = (ratio - reached**2) / (ratio + reached**2)
        assert sim.hub_rate / (3.0 * math.tau) == pytest.approx(expected, abs=4e-3)
    assert sim.hub_rate < 0.3 * 3.0 * math.tau
