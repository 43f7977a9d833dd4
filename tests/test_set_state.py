"""A state goes on in a simulation of its own scene, method and step, and holds what a motion has, or is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from membrane_rs import InputError, InputTypeError, Simulation, integrators, scenes
from small_scenes import hanging_strip, refused

SCENE = hanging_strip()
FREE = scenes.load("spinning-disc")


def moved(integrator: str = "rk4", dt: float | None = None) -> Simulation:
    sim = Simulation(SCENE, integrator, dt)
    sim.step(7)
    return sim


@pytest.mark.parametrize("integrator", integrators())
def test_a_state_of_another_method_or_step_is_refused(integrator: str) -> None:
    own = moved(integrator, 1e-4)
    other = "leapfrog" if integrator == "rk4" else "rk4"
    for sim, words in (
        (Simulation(SCENE, other, 1e-4), f"integrator is '{integrator}', and that of this simulation '{other}'"),
        (Simulation(SCENE, integrator, 5e-5), "dt = 0.0001 s, and that of this simulation 5e-05 s"),
        (Simulation(SCENE, "dopri5"), "that of this simulation 'dopri5'|it was stepped with a fixed step"),
    ):
        sim.step(3)
        before = sim.state()
        refused(lambda sim=sim: sim.set_state(own.state()), InputError, f"{words}.*Simulation\\(scene, start=other")  # type: ignore[misc]
        np.testing.assert_equal(sim.state(), before)
        assert Simulation(SCENE, sim.integrator, sim.dt, start=own).time == own.time


@pytest.mark.parametrize("integrator", integrators())
def test_a_state_that_does_not_say_its_method_is_read(integrator: str) -> None:
    own, twin = moved(integrator), Simulation(SCENE, integrator)
    state = own.state()
    for name in ("integrator", "dt", "is_adaptive"):
        del state[name]
    twin.set_state(state)
    own.step(5)
    twin.step(5)
    np.testing.assert_equal(twin.state(), own.state())


BAD: list[tuple[str, Any]] = [
    *((name, value) for name in ("start_kinetic", "start_internal_kinetic") for value in (-1.0, 1e308, -1e308)),
    *(("swing", value) for value in (-1e-9, -1.0, 1e308)),
    *(("start_shift", value) for value in (1e3, -1e308, 1e308)),
    ("start_kinetic", 1e3),
    ("start_internal_kinetic", 1e3),
]


@pytest.mark.parametrize("scene", [SCENE, FREE], ids=["held", "free"])
@pytest.mark.parametrize(("name", "value"), BAD)
def test_energies_that_no_motion_has_are_refused(name: str, value: float, scene: Any) -> None:
    sim = Simulation(scene)
    sim.step(60)
    before = sim.state()
    words = f"saved state: {name} = |start_kinetic.*leave .* J of the energy balance"
    refused(lambda: sim.set_state({**before, name: value}), InputError, words)
    np.testing.assert_equal(sim.state(), before)


def test_truth_values_are_no_numbers() -> None:
    sim = moved("dopri5")
    state = sim.state()
    for name, value in state.items():
        if name not in ("adaptive_was_rejected", "is_adaptive", "integrator", "scene_digest"):
            wrong = np.zeros(np.shape(value), bool) if np.ndim(value) else True
            refused(lambda name=name, wrong=wrong: sim.set_state({**state, name: wrong}), InputTypeError, name)  # type: ignore[misc]


@pytest.mark.parametrize("name", scenes.names())
def test_states_of_the_scenes_are_read(name: str) -> None:
    sim = Simulation(scenes.load(name))
    for _ in range(3):
        sim.set_state(sim.state())
        sim.step(5)


@pytest.mark.parametrize(("entry", "value"), [("integrator", np.zeros(2)), ("integrator", 3), ("is_adaptive", None)])
def test_what_names_no_way_of_stepping_is_refused(entry: str, value: object) -> None:
    sim = Simulation(scenes.load("spinning-tether"))
    with pytest.raises(InputTypeError, match=f"saved state: {entry} = "):
        sim.set_state({**sim.state(), entry: value})


def test_a_restored_step_was_not_given(tmp_path: Path) -> None:
    sim = Simulation(scenes.load("spinning-tether"))
    sim.save(tmp_path / "state.npz")
    assert Simulation.restore(tmp_path / "state.npz").given_dt is None
