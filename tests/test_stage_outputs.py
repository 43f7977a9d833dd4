"""Frames and samples of stages: so many in each, at times that an interruption does not change."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from killed_runs import contents, run_copied
from membrane_rs import InputError, Scene, Simulation, Stage
from membrane_rs.errors import SceneError
from membrane_rs.results import read_history, read_pvd
from membrane_rs.runs import resume
from staged_scenes import free, oscillator, started

FIRST = Stage("damped", 0.1, frames=3, samples=6)
EVENT = free("until fast", 0.5, measure="kinetic_energy", above=0.05, frames=51, samples=101)
LAST = free("fall", 0.06, without=("hold",), frames=4, samples=4)


class Seen:
    """Times of samples and frames."""

    def __init__(self) -> None:
        self.samples: list[float] = []
        self.frames: list[float] = []

    def start(self, sim: Simulation) -> None:
        pass

    def sample(self, sim: Simulation) -> None:
        self.samples.append(sim.time)

    def frame(self, sim: Simulation) -> None:
        self.frames.append(sim.time)

    def finish(self, sim: Simulation, error: BaseException | None) -> None:
        pass


def seen(scene: Scene, **run: object) -> tuple[Simulation, Seen]:
    sim, found = started(scene), Seen()
    sim.run(observers=[found], **run)  # type: ignore[arg-type]
    return sim, found


def samples_in(folder: Path) -> list[float]:
    times: list[float] = read_history(folder)["time"].tolist()
    return times


def frames_in(folder: Path) -> list[float]:
    return [time for time, _ in read_pvd(folder / "frames.pvd")]


def test_a_stage_has_its_own_number() -> None:
    _, found = seen(oscillator(FIRST, Stage("plain", 0.1), LAST, frames=14, samples=14))
    # Of the stage without a number: its share of 13 intervals over 0.26 s.
    assert found.frames == pytest.approx([0, 0.05, *np.arange(5, 11) * 0.02, 0.22, 0.24, 0.26], rel=1e-12)
    assert found.samples == sorted(set(found.samples) | set(found.frames))
    first = [0, 0.02, 0.04, 0.05, 0.06, 0.08, 0.1]  # samples, and the frame between two of them
    assert [time for time in found.samples if time <= 0.1] == pytest.approx(first, rel=1e-12)


def test_an_event_drops_the_rest_and_moves_later_ones() -> None:
    sim, found = seen(oscillator(FIRST, EVENT, LAST))
    bounds = sim.boundaries
    assert sim.stages[1].ended_by == "measure"
    inside = [time for time in found.frames if bounds[0] < time < bounds[1]]
    assert inside == pytest.approx(0.1 + 0.01 * np.arange(1, len(inside) + 1), rel=1e-12)
    assert bounds[1] - inside[-1] <= 0.01
    assert [time for time in found.frames if time >= bounds[1]] == pytest.approx(bounds[1] + np.arange(4) * 0.02)
    for times in (found.frames, found.samples):
        assert times == sorted(set(times))
        assert np.diff(times).min() > 1e-9


def test_other_numbers_of_the_run_leave_them() -> None:
    few, many = (seen(oscillator(FIRST, LAST), frames=number)[1] for number in (2, [0.01, 0.05, 0.07]))
    assert few.frames == many.frames == pytest.approx([0, 0.05, 0.1, 0.12, 0.14, 0.16])


@pytest.mark.parametrize("until", [0.0331, 0.1, 0.123, 0.19])
def test_in_parts_the_times_are_the_same(until: float, tmp_path: Path) -> None:
    scene = oscillator(FIRST, EVENT, LAST)
    whole, part = tmp_path / "whole", tmp_path / "part"
    started(scene).run(out=whole, pictures=False)
    started(scene).run(until, out=part, pictures=False)
    resume(part, started(scene).planned_end)
    for read in (samples_in, frames_in):
        # The end of the first part is shown as well.
        assert set(read(whole)) ^ set(read(part)) <= {until}


def test_a_killed_run_has_the_same_times(tmp_path: Path) -> None:
    whole = tmp_path / "whole"
    sim = started(oscillator(FIRST, EVENT, LAST))
    run_copied(sim, whole, until=None, frames=None, samples=None)
    for left in sorted(tmp_path.glob("left-*")):
        resume(left)
        assert contents(left) == contents(whole)


def test_files_hold_them_and_the_motion_does_not_depend_on_them(tmp_path: Path) -> None:
    scene = oscillator(FIRST, LAST)
    scene.save(tmp_path)
    assert Scene.from_toml(tmp_path / "scene.toml").stages == scene.stages
    other = replace(scene, stages=[replace(stage, frames=None, samples=None) for stage in scene.stages])
    assert "frames" not in other.to_toml().partition("[run]")[0]
    sim = started(scene)
    sim.reach(0.07)
    again = Simulation(other)
    again.set_state(sim.state())
    assert again.time == 0.07


@pytest.mark.parametrize("count", [1, 0, -3, 10**7 + 1, 2.5])
@pytest.mark.parametrize("key", ["frames", "samples"])
def test_wrong_numbers_are_refused(key: str, count: float) -> None:
    with pytest.raises((InputError, TypeError), match=rf"Stage\.{key} = "):
        Stage("one", 1.0, **{key: count})  # type: ignore[arg-type]


def test_too_many_in_all_are_refused() -> None:
    with pytest.raises(SceneError, match=r"stages: 12000000 frames in all; must be at most 10000000"):
        oscillator(Stage("one", 1.0, frames=6_000_000), Stage("two", 1.0, frames=6_000_000))


@pytest.mark.parametrize("until", [2.22, 2.2200000000000006])
def test_a_run_ends_at_the_end_as_it_is_printed(until: float) -> None:
    scene = oscillator(Stage("one", 0.6), Stage("two", 1.02), Stage("three", 0.6))
    assert scene.run.until < until  # by rounding
    runs = [started(scene, "rk4", 1e-2) for _ in range(4)]
    runs[0].run()
    runs[1].run(until=until)
    runs[2].reach(until)
    while not runs[3].reach_within(until, 1.0):
        pass
    assert all(sim.is_over and sim.time == scene.run.until for sim in runs)
    with pytest.raises(InputError, match=r"the last stage ends at 2\.22 s"):
        started(scene, "rk4", 1e-2).run(until=2.221)
