"""A default step is right to 1 % of the motion, or `check` warns."""

from __future__ import annotations

import itertools
import math
import time
from dataclasses import replace

import golden
import pytest
from membrane_rs import Scene, Simulation, UnstableError, integrators, scenes
from membrane_rs.check.step_accuracy import ALLOWED, step_accuracy
from step_accuracy_cases import all_scenes, fast_tether, random_scene, reference, row, short_tether

METHODS = list(integrators())


def until(scene: Scene, end: float) -> Scene:
    return replace(scene, run=replace(scene.run, until=min(scene.run.until, end)))


CASES = [until(fast_tether(), 0.1), short_tether(), *map(random_scene, (1, 2, 4, 8))]


@pytest.mark.parametrize("scene", CASES, ids=lambda scene: scene.name)
def test_a_default_step_is_right_to_a_hundredth_of_the_motion_or_check_warns(scene: Scene) -> None:
    true = reference(scene)
    for method in METHODS:
        step, error, warning = row(scene, method, true, work=math.inf)
        assert error <= ALLOWED or warning, (method, step, error)
        # The estimate is that of the error, and warns of nothing that is right.
        assert not warning or not error <= 0.4 * ALLOWED, (method, step, error, warning)


def test_scenes_that_give_their_step_are_run_by_their_own_method_alone() -> None:
    own = {name for name in scenes.names() if scenes.load(name).run.dt is not None}
    listed = {scene.name for scene in all_scenes()}
    assert own
    assert set(scenes.for_any_method()) < listed
    assert not own & listed
    methods = {name: [case for case, _ in golden.cases() if case.startswith(f"{name}, ")] for name in own}
    assert methods == {name: [f"{name}, {scenes.load(name).run.integrator}"] for name in own}


def test_the_explicit_methods_are_right_where_spin_or_few_elements_set_the_motion() -> None:
    for scene in CASES[:2]:
        true = reference(scene)
        for method in ("rk4", "leapfrog"):
            assert row(scene, method, true)[1] < ALLOWED, (scene.name, method)


def test_a_given_step_that_is_wrong_is_told_with_one_that_is_right() -> None:
    scene = short_tether()
    limit = Simulation(scene, "leapfrog").stable_dt()
    coarse = replace(scene, run=replace(scene.run, integrator="leapfrog", dt=0.4 * limit))
    found = step_accuracy(coarse, work=math.inf)
    assert found.reached == found.until == 1.0
    text = found.warning()
    assert text is not None
    assert text.startswith("Warning: by t = 1 s the step is wrong by ")
    better = float(text.partition("use dt = ")[2].partition(" s")[0])
    again = step_accuracy(replace(coarse, run=replace(coarse.run, dt=better)), work=math.inf)
    assert again.warning() is None
    assert 0.1 * ALLOWED < again.error < ALLOWED


def test_what_takes_too_long_or_stops_is_told() -> None:
    sail = scenes.load("okuizumi-model-1")
    text = step_accuracy(sail, work=0.0).warning()
    assert text is not None
    # Beyond the first step, which is compared in any case.
    assert f"would take too long to estimate. Up to {Simulation(sail).dt:.3g} s it is wrong by" in text
    tether = scenes.load("spinning-tether")
    stiff = replace(tether, run=replace(tether.run, dt=1.5 * Simulation(tether).stable_dt(), until=0.1))
    text = step_accuracy(stiff, work=math.inf).warning()
    assert text is not None
    assert "the run stops by itself: stopped at t =" in text


def test_what_is_known_depends_on_the_work_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Not on how long it takes: a clock that jumps changes nothing, and half of the work reaches about half as far."""
    scene = scenes.load("hanging-strip")
    found = [step_accuracy(scene, work=work) for work in (1e5, 2e5)]
    assert 0.0 < found[0].reached < found[1].reached < scene.run.until
    assert found[1].reached == pytest.approx(2.0 * found[0].reached, rel=0.2)
    clock = itertools.count(0.0, 3600.0)
    for name in ("perf_counter", "monotonic", "time"):
        monkeypatch.setattr(time, name, lambda: next(clock))
    assert step_accuracy(scene, work=1e5) == found[0]
    assert step_accuracy(scene).reached == scene.run.until


@pytest.mark.parametrize("name", ["okuizumi-model-1", "okuizumi-model-1-triangles", "okuizumi-model-2"])
def test_a_run_that_soon_stops_is_told_however_slow_its_steps_are(name: str) -> None:
    sail = scenes.load(name)
    found = step_accuracy(replace(sail, run=replace(sail.run, integrator="generalized_alpha")), work=0.0)
    assert found.reached == found.dt
    assert "the run stops by itself: stopped at t =" in (found.warning() or "")


def test_the_energy_balance_is_judged_at_the_end() -> None:
    # So it is in a run, which ends before its first regular check.
    sail = scenes.load("okuizumi-model-1")
    run = replace(sail.run, integrator="generalized_alpha", until=3e-4)
    with pytest.raises(UnstableError, match="spurious gain"):
        Simulation(replace(sail, run=run)).run(frames=2, samples=2)
    assert "spurious gain" in step_accuracy(replace(sail, run=run), work=math.inf).failure


def test_a_scene_at_rest_has_no_error() -> None:
    strip = scenes.load("hanging-strip")
    rest = replace(strip, laws=[law for law in strip.laws if law.kind != "gravity"], run=replace(strip.run, until=0.01))
    found = step_accuracy(rest, work=math.inf)
    assert found.warning() is None
    assert not math.isnan(found.error)
