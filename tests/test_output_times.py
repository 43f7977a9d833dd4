"""Runs end at their end and show what is asked for when it is asked for, by steps that depend on neither."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from membrane_rs import Gravity, InputError, RunSettings, Scene, Simulation, Tether, integrators, scenes
from membrane_rs.runs.request import Request
from membrane_rs.scene.run_settings import MOST_INSTANTS

METHODS = [*integrators(), "leapfrog-4"]
T1, T2 = 0.0123, 0.0217
ODD = (0.00123, 0.004567, 0.0099999, 0.0111)


def scene_of(method: str, dt: float | None = None, **run: Any) -> Scene:
    scene = scenes.load("spinning-tether")
    settings = replace(
        scene.run, integrator=method.partition("-")[0], substeps=4 if "-" in method else 1, dt=dt, samples=5, watch=10
    )
    return replace(scene, run=replace(settings, snapshots=(), **run))


class Record:
    """Keeps what a run shows: by time, positions, velocities, balance and the forces."""

    def __init__(self) -> None:
        self.samples: dict[float, tuple[Any, ...]] = {}
        self.frames: list[float] = []

    def start(self, sim: Simulation) -> None:
        pass

    def sample(self, sim: Simulation) -> None:
        ledger = sim.ledger()
        numbers = [ledger[key] for key in ("kinetic", "stored", "work", "reference_energy", "error")]
        state = (sim.positions, sim.velocities, sim.forces(), numbers, [sim.hub_angle, sim.dt, sim.step_count])
        self.samples[sim.time] = tuple(np.asarray(value).tobytes() for value in state)

    def frame(self, sim: Simulation) -> None:
        self.frames.append(sim.time)

    def finish(self, sim: Simulation, error: BaseException | None) -> None:
        pass


def progress(sim: Simulation) -> dict[str, Any]:
    return {key: np.asarray(value).tolist() for key, value in sim.state().items()}


@pytest.mark.parametrize("dt", [None, 7.7e-6])
@pytest.mark.parametrize("method", METHODS)
def test_a_run_is_the_beginning_of_a_longer_one(method: str, dt: float | None, tmp_path: Path) -> None:
    scene = scene_of(method, dt)
    whole, seen = Simulation(scene), Record()
    whole.run(T2, frames=[*ODD, T1], samples=9, observers=[seen])
    assert seen.frames == [0.0, *ODD, T1, T2]
    assert whole.time == T2

    short, first = Simulation(scene), Record()
    short.run(T1, frames=[ODD[0], ODD[2]], observers=[first])
    assert (short.time, first.frames) == (T1, [0.0, ODD[0], ODD[2], T1])
    common = first.samples.keys() & seen.samples.keys()
    assert {0.0, ODD[0], ODD[2], T1} <= common
    assert all(first.samples[time] == seen.samples[time] for time in common)

    # Continued, or saved within a step and restored: the same as in one run.
    short.save(tmp_path / "state.npz")
    for again in (short, Simulation.restore(tmp_path / "state.npz")):
        assert progress(again) == progress(Simulation.restore(tmp_path / "state.npz"))
        rest = Record()
        again.run(T2, frames=2, samples=9, observers=[rest])
        assert all(rest.samples[time] == seen.samples[time] for time in rest.samples)
        assert progress(again) == progress(whole)


@pytest.mark.parametrize("method", METHODS)
def test_the_default_step_depends_on_neither_end_nor_outputs(method: str) -> None:
    steps = {
        Simulation(scene_of(method, until=until, samples=samples)).dt
        for until, samples in [(2.0, 1001), (1e-7, 2), (0.317, 7), (1e-15, 3), (1e12, 11)]
    }
    assert len(steps) == 1
    if not integrators()[method.partition("-")[0]].is_adaptive:
        # A whole number of steps makes a power of ten of a second.
        count = 10.0 ** np.arange(-6, 2) / steps.pop()
        assert np.isclose(count, np.round(count), rtol=1e-12, atol=0)[(count > 99) & (count < 1001)].all()


@pytest.mark.parametrize(
    ("name", "method", "dt", "until"),
    [
        ("spinning-tether", "generalized_alpha", 3e-4, 7e-4),
        ("spinning-tether", "generalized_alpha", 7e-4, 1e-3),
        ("hanging-strip", "generalized_alpha", None, 0.0008),
        ("hanging-strip", "rk4", 6e-4, 8.9e-4),
        ("hanging-strip", "leapfrog", 3e-4, 1e-4),
        ("hanging-strip", "dopri5", 3e-4, 1e-4),
        ("hanging-strip", "rk4", 5e-4, 1e-15),
        ("hanging-strip", "dopri5", None, 1e-15),
        ("single-crease", "leapfrog", None, 1e-9),
    ],
)
def test_a_run_ends_at_its_end_with_all_frames(
    name: str, method: str, dt: float | None, until: float, tmp_path: Path
) -> None:
    scene = scenes.load(name)
    scene = replace(scene, run=RunSettings(until=until, integrator=method, dt=dt, frames=5, samples=5, snapshots=()))
    sim = Simulation(scene)
    sim.run(out=tmp_path / "run", pictures=False)
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    assert (summary["outcome"], summary["until"], summary["time"], sim.time) == ("finished", until, until, until)
    assert summary["frames"] == summary["samples"] == 5
    rows = np.loadtxt(tmp_path / "run" / "history.csv", delimiter=",", skiprows=1)
    assert rows[:, 0] == pytest.approx(np.linspace(0, until, 5), rel=1e-9, abs=0)
    fine = Simulation(scene, "rk4", 5e-7)
    fine.reach(until)
    assert np.abs(sim.positions - fine.positions).max() < 2e-6


def test_what_watches_a_run_between_its_outputs_changes_no_bit(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("membrane_rs.simulation.stepper.CHUNK", 0.0)
    for method in METHODS:
        whole, watched = (Simulation(scene_of(method)) for _ in range(2))
        whole.reach(0.2)
        times: list[float] = []

        def between(sim: Simulation, times: list[float] = times) -> None:
            times.append(sim.time)
            if len(times) % 7 == 3:
                sim.set_state(sim.state())

        ends: list[float] = []
        watched.march(0.2, 3, [0.1001, 0.2], [], lambda sim, ends=ends: ends.append(sim.time), between=between)  # type: ignore[misc]
        assert times == sorted(times)
        assert {0.0, 0.1, 0.1001} < set(times)
        assert times[-1] < ends[-1] == 0.2  # the end is no place to stop at any more
        assert progress(watched) == progress(whole)


@pytest.mark.parametrize("method", ["rk4", "generalized_alpha"])
def test_ends_that_no_number_of_steps_meets_are_refused(method: str) -> None:
    sim = Simulation(scene_of(method))
    acts: list[Callable[[], object]] = [lambda: sim.run(1e308), lambda: sim.reach(1e308), lambda: sim.reach(1.7e308)]
    for act in acts:
        with pytest.raises(InputError, match=r"= 1[.\d]*e\+308 s: that is .* steps of dt = .* s; give an earlier time"):
            act()
    sim.reach(0.01)
    with pytest.raises(InputError, match="not before the present time"):
        sim.reach(0.009)
    assert sim.time == 0.01


def test_an_observer_that_steps_is_told_so() -> None:
    class Stepping(Record):
        def sample(self, sim: Simulation) -> None:
            sim.step(100_000)

    for method in ("rk4", "dopri5"):
        with pytest.raises(InputError, match=r"an observer has stepped to t = .*, past the next output"):
            Simulation(scene_of(method)).run(0.1, observers=[Stepping()])


def test_nearly_equal_times_are_one() -> None:
    seen = Record()
    Simulation(scene_of("rk4")).run(0.3, frames=[0.1 + 0.2 - 1e-16, 3 * 0.1], samples=4, observers=[seen])
    assert list(seen.samples) == [0.0, 0.1, 0.2, 0.3]
    assert seen.frames == [0.0, 0.3]


@pytest.mark.parametrize("end", [(0.3, 0.0, 0.0), (0.2, 0.0, -0.2), (0.1, 0.0, -0.3)])
@pytest.mark.parametrize("samples", [2, 801])
def test_no_output_of_a_swinging_pendulum_stops_it(end: tuple[float, float, float], samples: int) -> None:
    # At its turning points little is in motion, and in fewer than a hundred steps little was exchanged before.
    tether = Tether((0.0, 0.0, 0.0), end, 1, 50.0, 0.0, tip_mass=0.01)
    sim = Simulation(Scene(None, None, [Gravity((0.0, 0.0, -9.81))], [tether]))
    sim.run(until=1.0, samples=samples)
    assert sim.time == 1.0


LATER: list[tuple[dict[str, Any], float, list[float], list[float]]] = [
    ({}, 0.65, [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.65], [0.0, 0.2, 0.4, 0.6, 0.65]),
    ({}, 0.6, [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6], [0.0, 0.2, 0.4, 0.6]),
    ({}, 0.25, [0.0, 0.1, 0.2, 0.25], [0.0, 0.2, 0.25]),
    ({"frames": [0.0, 0.15], "samples": [0.1]}, 0.5, [0.0, 0.15, 0.4, 0.5], [0.0, 0.1, 0.4, 0.5]),
    # With an interval between samples frames stand at the nearest one, but for the ends.
    ({"every": 0.15, "until": 1.0, "frames": 3}, 1.72, [0.0, 0.45, 1.0, 1.5, 1.72], [0.0, 0.5, 1.0, 1.5, 1.72]),
    ({"every": 0.15, "until": 1.0, "frames": 3}, 0.7, [0.0, 0.45, 0.7], [0.0, 0.5, 0.7]),
    ({"every": 0.4, "until": 1.0, "frames": 5}, 1.6, [0.0, 0.4, 0.8, 1.0, 1.2, 1.6], [0.0, 0.5, 1.0, 1.5, 1.6]),
    ({"every": 0.45, "until": 1.0, "frames": 11}, 1.45, [0.0, 0.45, 0.9, 1.0, 1.35, 1.45], [0.0, 0.5, 1.0, 1.45]),
    ({"every": 0.1, "frames": [0.0, 0.15]}, 0.5, [0.0, 0.15, 0.4, 0.5], [0.0, 0.2, 0.4, 0.5]),
]


@pytest.mark.parametrize(("asked", "until", "frames", "samples"), LATER)
def test_another_end_continues_the_instants(
    asked: dict[str, Any], until: float, frames: list[float], samples: list[float]
) -> None:
    request = Request(**{"until": 0.4, "frames": 5, "samples": 3, **asked})
    later = request.until_later(until)
    assert (later.until, later.frames, later.samples) == (until, frames, samples)
    assert replace(later, until=request.until, frames=request.frames, samples=request.samples) == request


def test_another_end_with_too_many_instants_is_refused() -> None:
    request = Request(1.0, 2, MOST_INSTANTS // 10)
    request.until_later(2.0)
    with pytest.raises(InputError, match=r"until = 12.0 s: that is 1.1e.07 instants; give an earlier time"):
        request.until_later(12.0)
