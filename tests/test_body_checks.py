"""Bodies that are hardly meant: those that touch nothing, move too fast, or rub more than the step resolves."""

from __future__ import annotations

import math
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from killed_runs import run_copied
from membrane_rs import (
    AuditWarning,
    Cylinder,
    Gravity,
    Plane,
    RunSettings,
    Scene,
    Schedule,
    Simulation,
    Stage,
    UnstableError,
    integrators,
)
from membrane_rs.check import audit
from membrane_rs.cli import app
from membrane_rs.results import read_summary
from membrane_rs.results.body_contacts import BodyContacts
from membrane_rs.runs import resume
from membrane_rs.scene.bodies import Body
from small_scenes import cord
from typer.testing import CliRunner


def lying(*bodies: Body, until: float = 0.1, stages: tuple[Stage, ...] = (), **run: Any) -> Scene:
    """A mass of 1 kg that weight presses on what is below it."""
    settings = RunSettings(until=RunSettings().until if stages else until, frames=3, samples=11, snapshots=(), **run)
    return Scene(None, None, [Gravity()], [cord(axial_stiffness=1e-9)], bodies=bodies, stages=stages, run=settings)


def warned(sim: Simulation, **how: Any) -> list[str]:
    """What a run warns of at its end."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", AuditWarning)
        sim.run(**how)
    return [str(one.message) for one in caught if issubclass(one.category, AuditWarning)]


FLOOR = Plane("floor", centre=(0.0, 0.0, 9.81e-3), stiffness=1e3)
FAR = Cylinder("bar", 0.1, centre=(0.5, 3.0, 0.0))


def test_a_body_that_touches_nothing_is_described_at_the_end(tmp_path: Path) -> None:
    for how in ({}, {"out": tmp_path / "run", "pictures": False}):
        (text,) = warned(Simulation(lying(FLOOR, FAR)), **how)
        assert "the body bar touches nothing at any sample of the run, up to 0.1 s" in text
        assert "centre is at (0.5, 3, 0) m; check its place" in text
    bodies = read_summary(tmp_path / "run")["bodies"]
    assert bodies["bar"]["first_contact"] is None
    assert bodies["floor"]["first_contact"] == 0.0
    assert bodies["floor"]["largest_force"] == pytest.approx(9.81, rel=1e-3)


def test_the_command_line_and_the_audit_of_the_run_say_it(tmp_path: Path) -> None:
    lying(FLOOR, FAR).save(tmp_path)
    words = ["run", tmp_path / "scene.toml", "--out", tmp_path / "run", "--no-pictures"]
    result = CliRunner().invoke(app, [str(word) for word in words])
    assert result.exit_code == 0, result.output
    assert "Warning: the body bar touches nothing at any sample" in result.output
    kinds = [finding["kind"] for finding in read_summary(tmp_path / "run")["audit"]]
    assert kinds.count("body_without_contact") == 1


def test_a_run_that_ends_before_its_scene_does_not_say_so() -> None:
    assert warned(Simulation(lying(FLOOR, FAR)), until=0.05) == []
    assert warned(Simulation(lying(FLOOR)), until=0.1) == []


def test_a_body_at_work_in_one_stage_alone_is_judged_there() -> None:
    stages = (Stage("first", 0.05, without=("bar",)), Stage("second", 0.05, without=("floor",)))
    (text,) = warned(Simulation(lying(FLOOR, FAR, stages=stages)))
    assert text.startswith("warning: the body bar touches nothing")
    never = (Stage("first", 0.05, without=("bar",)),)
    assert warned(Simulation(lying(FLOOR, FAR, stages=never))) == []


def test_what_touched_before_a_kill_counts(tmp_path: Path) -> None:
    gone = Schedule((0.03, 0.03), (0.0, -1.0))
    floor = replace(FLOOR, travel_z=gone)
    run_copied(Simulation(lying(floor)), tmp_path / "whole", until=0.1, frames=5)
    whole = read_summary(tmp_path / "whole")["bodies"]
    assert whole["floor"]["first_contact"] == 0.0
    left = sorted(tmp_path.glob("left-*"))[-2]
    resume(left)
    assert read_summary(left)["bodies"] == whole
    assert BodyContacts({"floor": {"first_contact": 1.0}, "bar": 3}).bodies == {}
    assert BodyContacts([1]).bodies == {}


@pytest.mark.parametrize("method", ["rk4", "leapfrog", "generalized_alpha"])
def test_friction_that_the_step_does_not_resolve_is_described(method: str) -> None:
    """1 kg under 9.81 N with mu = 0.5: the rate is 4905/s with e of 1 mm/s."""
    rough = replace(FLOOR, friction=0.5)
    limit = integrators()[method].real_limit / (0.5 * 9.81 / 1e-3)
    assert warned(Simulation(lying(rough), method, 0.9 * min(limit, 1e-3))) == []
    found = warned(Simulation(lying(rough), method, 1e-3))
    if math.isinf(limit):
        assert found == []
        return
    (text,) = found
    assert f"the friction of the body floor needs steps below {limit:.3g} s near rest, at node 1" in text
    advised = float(text.partition("friction_speed of ")[2].partition(" m/s")[0])
    assert advised == pytest.approx(1e-3 * 1e-3 / limit, rel=1e-2)
    assert warned(Simulation(lying(replace(rough, friction_speed=1.01 * advised)), method, 1e-3)) == []


def test_the_limit_of_friction_is_that_of_the_motion() -> None:
    """A mass that slides more slowly than e comes to rest below it; above it the monitor names the friction."""
    limit = integrators()["rk4"].real_limit / (0.5 * 9.81 / 1e-3)
    for share in (0.8, 1.2):
        sim = Simulation(lying(replace(FLOOR, friction=0.5)), "rk4", share * limit)
        assert sim.stable_dt() == pytest.approx(limit, rel=1e-2)
        sim.velocities = np.array([[0.0, 0.0, 0.0], [1e-5, 0.0, 0.0]])
        if share < 1.0:
            sim.step(400)
            assert abs(sim.velocities[1, 0]) < 1e-9
        else:
            with pytest.raises(UnstableError, match=r"above the stability limit of .* that floor_friction near node 1"):
                sim.step(400)


def test_a_bar_that_moves_faster_than_its_penalty_can_push_is_described() -> None:
    """1 kg at 1 m/s into 200 N/m: 7.1 cm, of a radius of 10 cm. A jump is no speed."""
    swept = Schedule((0.0, 0.5, 1.0, 1.0), (0.0, 0.0, -0.5, 3.0))
    (found,) = [one for one in audit(lying(replace(FAR, travel_y=swept))).findings if one.kind == "fast_body"]
    assert found.severity == "warning"
    assert "the body bar moves at 1 m/s at 0.5 s of its schedules: a node of the median mass, 1 kg" in found.message
    assert "sinks 0.0707 m into its radius of 0.1 m" in found.message
    stiffness = float(found.remedy.partition("stiffness of ")[2].partition(" N/m")[0])
    assert stiffness == pytest.approx(400.0)
    for body in (
        replace(FAR, travel_y=swept, stiffness=401.0),
        replace(FAR, travel_y=replace(swept, values=(0, 0, -0.3, 1))),
    ):
        assert "fast_body" not in {one.kind for one in audit(lying(body)).findings}


def test_what_starts_inside_a_body_is_judged_for_the_first_stage_alone() -> None:
    """Later stages start from a shape that is not known; the speed of a body is judged for each."""
    inside = Cylinder("bar", 0.1, centre=(0.5, 0.02, 0.0))
    stages = (Stage("first", 0.05, without=("bar",)), Stage("second", 0.05))
    scene = lying(FLOOR, inside, stages=stages)
    assert {one.kind for one in audit(scene, costly=False).findings if "the body bar" in one.message} == set()
    fast = {"bodies.bar.travel_x": Schedule((0.0, 0.01), (0.0, 0.1))}
    scene = lying(FLOOR, inside, stages=(Stage("first", 0.05, without=("bar",)), Stage("second", 0.05, set=fast)))
    (found,) = [one for one in audit(scene, costly=False).findings if "the body bar" in one.message]
    assert found.kind == "fast_body"
    assert found.message.startswith("stage 'second': the body bar moves at 10 m/s")
