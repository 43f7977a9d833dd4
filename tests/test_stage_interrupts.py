"""A staged run that was interrupted, that failed at a boundary of stages, or that goes step by step is the same run."""

from __future__ import annotations

import copy
import sys
from collections.abc import Callable
from types import FrameType
from typing import Any

import pytest
from membrane_rs import InputError, Scene, Simulation, Stage
from small_scenes import refused
from staged_scenes import free, oscillator, started

STAGES = (
    Stage("one", 0.02),
    Stage("two", 0.1, lambda sim: float(sim.positions[1, 0]), below=1.55, scale={"parts.spring.axial_stiffness": 2.0}),
    Stage("three", 0.01, "largest_speed", above=1e9, set={"run.integrator": "leapfrog"}),
)
STEP = 4e-3
METHODS = ("rk4", "leapfrog", "dopri5", "generalized_alpha")


def of(scene: Scene, integrator: str) -> Simulation:
    return started(scene, integrator, None if integrator == "dopri5" else STEP)


def last(sim: Simulation) -> tuple[Any, ...]:
    """What two runs that are the same share."""
    return sim.time, sim.positions.tobytes(), sim.velocities.tobytes(), sim.ledger(), sim.stages


def interrupted(sim: Simulation, at: int) -> bool:
    """Run with Ctrl-C at one line of the code of stages, counted; whether there are as many."""
    count = 0

    def of_line(frame: FrameType, event: str, _: Any) -> Callable[..., Any]:
        nonlocal count
        count += event == "line"
        if count == at and event == "line":
            raise KeyboardInterrupt
        return of_line

    def of_call(frame: FrameType, event: str, _: Any) -> Callable[..., Any] | None:
        names = ("simulation/stages.py", "simulation/stage_end.py", "simulation/measures.py")
        return of_line if frame.f_code.co_filename.replace("\\", "/").endswith(names) else None

    before = sys.gettrace()
    sys.settrace(of_call)
    try:
        sim.run(frames=2, samples=2)
    except KeyboardInterrupt:
        return True
    finally:
        sys.settrace(before)
    return False


@pytest.mark.parametrize("integrator", ["rk4", "dopri5"])
def test_an_interrupt_anywhere_changes_no_bit(integrator: str) -> None:
    scene = oscillator(*STAGES)
    whole = of(scene, integrator)
    whole.run(frames=2, samples=2)
    assert [stage.ended_by for stage in whole.stages] == ["duration", "measure", "duration"]
    at = 1
    while interrupted(sim := of(scene, integrator), at):
        if not sim.is_over:
            sim.run(frames=2, samples=2)
        assert last(sim) == last(whole), at
        at += 29
    assert at > 500


def test_an_interrupt_at_a_boundary_leaves_a_state_to_restore() -> None:
    scene = oscillator(*STAGES)
    whole = of(scene, "rk4")
    whole.run(frames=2, samples=2)
    at, count = 1, 0
    while interrupted(sim := of(scene, "rk4"), at):
        if any(abs(sim.time - bound) < 1e-12 for bound in whole.boundaries):
            other = of(scene, "rk4")
            other.set_state(sim.state())
            if not other.is_over:
                other.run(frames=2, samples=2)
            assert last(other) == last(whole), at
            count += 1
        at += 17
    assert count > 5


def test_a_measure_that_fails_at_the_start_of_its_stage_is_asked_again() -> None:
    fails = True

    def measure(sim: Simulation) -> float:
        if fails:
            raise RuntimeError("no value")
        return float(sim.positions[1, 0])

    scene = oscillator(STAGES[0], Stage("two", 0.1, measure, below=1.55))
    sim = of(scene, "rk4")
    with pytest.raises(RuntimeError, match="no value"):
        sim.run(frames=2, samples=2)
    assert (sim.stage_name, sim.time) == ("one", 0.02)
    fails = False
    for other in (sim, copy.copy(sim)):
        other.run(frames=2, samples=2)
        assert [stage.ended_by for stage in other.stages] == ["duration", "measure"]


@pytest.mark.parametrize("integrator", METHODS)
@pytest.mark.parametrize("count", [1, 3])
@pytest.mark.parametrize("reached", [(), (0.0133, 0.0315)], ids=["from the start", "between steps"])
def test_steps_end_a_stage_where_a_run_does(integrator: str, count: int, reached: tuple[float, ...]) -> None:
    fast = free("fast", 0.5, measure="kinetic_energy", above=0.05, scale={"parts.spring.axial_stiffness": 0.7})
    scene = oscillator(STAGES[0], fast, STAGES[1], Stage("end", 0.5))
    whole, sim = of(scene, integrator), of(scene, integrator)
    whole.run(frames=2, samples=2)
    assert [stage.ended_by for stage in whole.stages] == ["duration", "measure", "measure", "duration"]
    for time in reached:
        sim.reach(time)
    while not (sim.is_over or sim.stage_name == "end"):
        sim.step(count)
    sim.run(frames=2, samples=2)
    assert last(sim)[:3] == last(whole)[:3]
    assert [(stage.end, stage.ended_by) for stage in sim.stages] == [(s.end, s.ended_by) for s in whole.stages]


def test_a_measure_that_is_not_the_same_again_is_named() -> None:
    count = 0

    def measure(sim: Simulation) -> float:
        nonlocal count
        count += 1
        return float(count % 3 == 0)

    scene = oscillator(Stage("one", 0.1, measure, above=0.5))
    words = r"stages\[0\]\.measure = .*measure: is not the same again at t = .* a measure must follow from"
    refused(lambda: of(scene, "rk4").run(frames=2, samples=2), InputError, words)


def test_a_measure_only_reads() -> None:
    def steps(sim: Simulation) -> float:
        sim.step(1)
        return 0.0

    def sets_state(sim: Simulation) -> float:
        sim.set_state(sim.state())
        return 0.0

    def steps_copy(sim: Simulation) -> float:
        copy.deepcopy(sim).step(1)
        return 0.0

    for measure, words in ((steps, "stepped"), (sets_state, "set the motion"), (steps_copy, "has copied")):
        for stages in ((), (STAGES[0],)):
            scene = oscillator(*stages, Stage("two", 0.1, measure, above=1.0))
            with pytest.raises(InputError, match=words):
                of(scene, "rk4").run(frames=2, samples=2)
