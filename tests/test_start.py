"""A simulation that goes on from another one's motion, under other laws and parameters."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from membrane_rs import (
    Fixed,
    Gravity,
    InputError,
    InputTypeError,
    Mesh,
    MissingFileError,
    RunSettings,
    Scene,
    Simulation,
    Spin,
    Springs,
    integrators,
)
from membrane_rs.folding import Strip
from small_scenes import RUBBER, cord, hanging_strip, patch, refused

STRIP = hanging_strip()


def spinning(frequency: float, acceleration: float = 0.0, **changes: Any) -> Scene:
    """A tip of 1 kg on a stiff spring that turns under gravity across the axis."""
    part = cord(axial_stiffness=1e4, **changes)
    return Scene(None, None, [Spin(frequency, acceleration), Gravity((1.0, 0.0, 0.0))], [part])


@pytest.mark.parametrize("integrator", integrators())
def test_a_start_keeps_motion_clock_and_hub_and_opens_the_ledger(integrator: str) -> None:
    first = Simulation(spinning(1.0, 0.5), integrator)
    first.step(20)
    second = Simulation(spinning(3.0), integrator, start=first)
    assert second.time == first.time
    assert second.hub_angle == pytest.approx(first.hub_angle, rel=1e-12)
    assert (second.positions == first.positions).all()
    assert (second.velocities == first.velocities).all()
    assert (second.ledger()["work"], second.ledger()["error"]) == (0.0, 0.0)
    before = second.hub_angle, second.time
    second.step(50)
    turned = 2 * np.pi * 3.0 * (second.time - before[1])
    assert second.hub_angle - before[0] == pytest.approx(turned, rel=1e-9)


def test_gravity_across_the_axis_goes_on_from_where_it_pointed() -> None:
    first = Simulation(spinning(1.0), dt=1e-3)
    first.run(until=0.125, frames=2, samples=2)
    second = Simulation(spinning(2.0), dt=1e-3, start=first)
    angle = 2 * np.pi * 0.125
    expected = [np.cos(angle), -np.sin(angle), 0.0]
    for sim in (first, second):
        assert sim.forces("gravity")[1] == pytest.approx(expected, abs=1e-9)
    second.run(until=0.25, frames=2, samples=2)
    angle += 2 * 2 * np.pi * 0.125
    assert second.forces("gravity")[1] == pytest.approx([np.cos(angle), -np.sin(angle), 0.0], abs=1e-9)


def test_the_angle_of_the_hub_is_saved_and_restored(tmp_path: Path) -> None:
    first = Simulation(spinning(1.0))
    first.step(30)
    second = Simulation(spinning(2.5), start=first)
    second.step(10)
    second.save(tmp_path / "state.npz")
    again = Simulation.restore(tmp_path / "state.npz")
    assert again.hub_angle == second.hub_angle
    for sim in (second, again):
        sim.step(40)
    assert (again.positions == second.positions).all()
    assert again.hub_angle == second.hub_angle


@pytest.mark.parametrize("integrator", integrators())
def test_a_run_goes_on_under_another_thickness(integrator: str, tmp_path: Path) -> None:
    first = Simulation(STRIP, integrator)
    first.run(until=0.01, frames=2, samples=2)
    first.save(tmp_path / "state.npz")
    thinner = replace(STRIP, material=replace(RUBBER, thickness=1.5e-4))
    for start in (first, tmp_path / "state.npz", str(tmp_path / "state.npz")):
        second = Simulation(thinner, integrator, start=start)
        second.run(until=0.02, frames=2, samples=2)
        assert second.time == pytest.approx(0.02)
        assert abs(second.ledger()["error"]) < 0.02


def test_the_same_scene_goes_on_to_the_same_motion() -> None:
    one = Simulation(STRIP, "rk4", 1e-5)
    one.step(100)
    two = Simulation(STRIP, "rk4", 1e-5, start=one)
    one.step(100)
    two.step(100)
    assert two.positions == pytest.approx(one.positions, rel=0, abs=1e-15)


def test_a_start_with_other_nodes_is_refused(tmp_path: Path) -> None:
    sim = Simulation(STRIP)
    for scene, words in (
        (hanging_strip(4), "has 21 nodes, and this scene 15"),
        (replace(STRIP, mesh=Strip(0.1, 0.04, 2, 6, creases=(0.5,)).mesh(), parts=STRIP.parts), "has other triangles"),
    ):
        refused(lambda scene=scene: Simulation(scene, start=sim), InputError, f"start: its scene {words}")  # type: ignore[misc]
    # As many nodes, in two cords in place of one.
    one, two = [cord(segments=3, linear_density=0.1)], [cord(), cord(start=(0.0, 1.0, 0.0), end=(1.0, 1.0, 0.0))]
    chain, pair = (Scene(None, None, [Gravity()], parts) for parts in (one, two))
    refused(lambda: Simulation(pair, start=Simulation(chain)), InputError, "has cords between other nodes")
    refused(lambda: Simulation(STRIP, start=3), InputTypeError, "start = 3: must be a Simulation")  # type: ignore[arg-type]


def test_a_state_of_another_scene_is_refused_with_the_remedy() -> None:
    state = Simulation(spinning(1.0)).state()
    words = r"scene_digest is that of another scene.*Simulation\(scene, start=other\)"
    refused(lambda: Simulation(spinning(2.0)).set_state(state), InputError, words)
    Simulation(replace(spinning(1.0), name="renamed")).set_state(state)
    Simulation(replace(spinning(1.0), run=RunSettings(until=7.0, frames=3))).set_state(state)
    for name in ("scene_digest", "hub_phase"):
        less = {key: value for key, value in state.items() if key != name}
        refused(lambda less=less: Simulation(spinning(1.0)).set_state(less), InputError, f"{name} is missing")  # type: ignore[misc]


def test_a_state_of_another_mesh_is_refused() -> None:
    def scene(shift: float) -> Scene:
        mesh = patch()
        moved = Mesh(mesh.reference + np.array([shift, 0.0, 0.0]), mesh.triangles)
        return Scene(moved, RUBBER, [Springs()], [Fixed((0,))])

    state = Simulation(scene(0.0)).state()
    Simulation(scene(0.0)).set_state(state)
    refused(lambda: Simulation(scene(0.01)).set_state(state), InputError, "scene_digest is that of another scene")


def test_a_start_that_was_relaxed_stays_so() -> None:
    first = Simulation(STRIP)
    assert not Simulation(STRIP, start=first).is_relaxed
    first.is_relaxed = True
    assert Simulation(STRIP, start=first).is_relaxed


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"origin": np.inf}, "origin"),
        ({"origin": np.nan}, "origin"),
        ({"hub_phase": np.inf}, "angle of the hub"),
        ({"step_count": 2**64 - 1}, "step_count = 18446744073709551615 is above"),
        ({"step_count": -1}, "step_count"),
        ({"evaluation_count": 2**64 - 1}, "evaluation_count"),
        ({"start_kinetic": np.nan}, "ledger"),
        ({"swing": np.inf}, "ledger"),
        ({"history_vectors": np.full((2, 3), np.nan)}, "history_vectors"),
        ({"positions": np.full((2, 3), np.nan)}, "positions"),
        ({"positions": None}, "positions"),
    ],
)
def test_values_that_no_state_has_are_refused_by_name(change: dict[str, Any], words: str) -> None:
    sim = Simulation(spinning(1.0), "leapfrog")
    sim.step(3)
    before = sim.state()
    refused(lambda: sim.set_state({**before, **change}), InputError, words)
    after = sim.state()
    assert all(np.array_equal(before[name], after[name]) for name in before)
    refused(lambda: sim.set_state([]), InputTypeError, "must be a dict")  # type: ignore[arg-type]


def test_the_folder_of_a_run_is_a_start_and_is_restored(tmp_path: Path) -> None:
    first = Simulation(STRIP)
    first.run(until=1e-3, frames=2, samples=2, out=tmp_path / "run", pictures=False)
    for again in (Simulation(STRIP, start=tmp_path / "run"), Simulation.restore(tmp_path / "run")):
        assert again.time == first.time
        assert (again.positions == first.positions).all()
    (tmp_path / "empty").mkdir()
    refused(lambda: Simulation(STRIP, start=tmp_path / "empty"), MissingFileError, "empty/state.npz: there is no such")
