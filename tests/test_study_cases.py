"""One run of a study: samples, stops, the monitor, warnings."""

from __future__ import annotations

from threading import Event

import numpy as np
import pytest
from membrane_rs import Cylinder, Gravity, RunSettings, Scene, Simulation, scenes
from membrane_rs.study.common.run import run_case, study_case
from small_scenes import cord, hanging_strip


def test_a_run_ends_at_its_next_instant_once_stopped() -> None:
    stop = Event()
    stop.set()
    assert len(run_case(study_case(hanging_strip(), 0.01, 5), "rk4", 1e-4, stop=stop).times) == 0


class Third(Event):
    """Set from the third question on."""

    asked = 0

    def is_set(self) -> bool:
        """Whether it was asked twice before."""
        self.asked += 1
        return self.asked > 2


def test_a_run_that_is_stopped_keeps_its_samples() -> None:
    assert len(run_case(study_case(hanging_strip(), 0.01, 5), "rk4", 1e-4, stop=Third()).times) == 2
    assert len(run_case(study_case(hanging_strip(), 0.01, 2), "rk4", 1e-4, stop=Third()).times) == 2


@pytest.mark.parametrize(("until", "instants"), [(0.01, 5), (0.0123, 7)])
def test_a_case_moves_as_a_run_does(until: float, instants: int) -> None:
    scene = hanging_strip()
    case = study_case(scene, until, instants)
    found = run_case(case, "rk4", 1e-4, shapes=True)
    sim, shapes = Simulation(scene, "rk4", case.step_near(1e-4)), []
    for time in case.times:
        sim.run(time, frames=2, samples=2)
        shapes.append(sim.positions)
    assert found.shapes.tolist() == np.array(shapes).tolist()
    assert (found.times.tolist(), found.steps) == (case.times, sim.step_count)
    assert found.seconds > 0.0


def test_the_balance_is_judged_at_each_instant() -> None:
    limit = Simulation(scenes.load("hanging-strip"), "rk4").stable_dt()
    case = study_case(scenes.load("hanging-strip"), 1.0, 20)
    found = run_case(case, "generalized_alpha", 50.0 * limit)
    assert "spurious gain" in str(found.failure)
    assert 0 < len(found.times) < 20


def test_a_case_warns_of_a_body_that_nothing_touches() -> None:
    far = Cylinder("bar", 0.1, centre=(0.5, 3.0, 0.0))
    scene = Scene(None, None, [Gravity()], [cord()], bodies=[far], run=RunSettings(until=0.01))
    with pytest.warns(UserWarning, match="bar touches nothing"):
        run_case(study_case(scene, 0.01, 5), "rk4", None)
