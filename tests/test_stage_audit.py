"""What the audit of a scene judges of its later stages, and what is told when one of them begins."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from membrane_rs import AuditWarning, Cylinder, Moved, Plane, Scene, Schedule, Simulation, Springs, Stage, UnstableError
from membrane_rs.check import CHECKS, COSTLY_CHECKS, Finding, audit, scene_audit, unaccepted_errors
from membrane_rs.cli import app
from membrane_rs.folding import Strip
from membrane_rs.results import read_summary
from membrane_rs.runs import resume
from small_scenes import RUBBER, refused
from staged_scenes import free, oscillator, started
from typer.testing import CliRunner

POST = Cylinder("post", 0.02, centre=(0.05, 0.01, 0.0), stiffness=50.0, felt_by="nodes")


def carried(by: float) -> Scene:
    """A strip that is carried away by so much [m], and then a post where it was."""
    away = Schedule((0.0, 0.4), (0.0, by), ease=0.4)
    return Scene(
        Strip(0.1, 0.02, 6, 2).mesh(),
        RUBBER,
        [Springs()],
        [Moved((0, 1, 2), name="grip")],
        bodies=[POST],
        name="carried",
        stages=[Stage("carry", 0.5, without=("post",), set={"parts.grip.x": away}), Stage("beside", 0.02)],
    )


def touched(depth: float) -> Scene:
    """A mass at rest, and then a wall that it lies in by so much [m]."""
    wall = Plane("wall", centre=(1.6 - depth, 0.0, 0.0), direction=(-1.0, 0.0, 0.0), stiffness=1e4)
    stages = free("wait", 1e-4, without=("wall",)), free("push", 5e-3), free("on", 0.05)
    return replace(oscillator(), bodies=[wall], stages=stages)


def call(*words: str) -> str:
    result = CliRunner().invoke(app, list(words))
    assert result.exit_code == 0, result.output
    return result.output


def test_a_body_where_the_scene_was_at_its_start_is_no_fault_of_a_later_stage(tmp_path: Path) -> None:
    scene = carried(0.3)
    assert audit(replace(scene, stages=())).find("start_inside") is not None
    assert unaccepted_errors(scene) == ()
    assert [one.kind for one in audit(scene, costly=False).without_facts().findings] == []
    scene.save(tmp_path)
    call("run", str(tmp_path / "scene.toml"), "--out", str(tmp_path / "run"), "--no-pictures")
    summary = read_summary(tmp_path / "run")
    assert summary["outcome"] == "finished"
    assert [one["kind"] for one in summary["audit"] if one["severity"] != "info"] == ["body_without_contact"]


def test_what_begins_a_stage_deep_inside_a_body_stops_the_run() -> None:
    sim = Simulation(carried(0.005))
    with pytest.raises(UnstableError, match=r"t = 5\.0*e-1 s, step 0: a node goes .* into the body post"):
        sim.reach(0.5)
    assert (sim.stage_name, sim.time) == ("carry", 0.5)


def test_what_begins_a_stage_a_little_inside_a_body_is_told(tmp_path: Path) -> None:
    sim = started(touched(1e-3))
    with pytest.warns(AuditWarning, match=r"nodes start the stage .push., at 0\.0001 s, inside the body wall") as told:
        sim.run(out=tmp_path / "run", frames=3, samples=5, pictures=False)
    assert len(told) == 1
    found = [one for one in read_summary(tmp_path / "run")["audit"] if one["kind"] == "start_inside"]
    assert [one["severity"] for one in found] == ["warning"]
    assert "by 0.001 m at most" in found[0]["message"]


def test_a_stage_that_begins_in_contact_as_the_one_before_ended_is_not_told() -> None:
    sim = started(touched(1e-3))
    with pytest.warns(AuditWarning, match="inside the body wall"):
        sim.reach(2e-3)
    with warnings.catch_warnings():
        warnings.simplefilter("error", AuditWarning)
        sim.reach(sim.boundaries[0] + 5e-3)
    assert sim.stage_name == "on"
    assert sim.energies()["wall"] > 0.0


def test_a_run_that_is_resumed_tells_it_once(tmp_path: Path) -> None:
    with pytest.warns(AuditWarning, match="inside the body wall"):
        started(touched(1e-3)).run(1e-4, out=tmp_path, frames=3, samples=5, pictures=False, checkpoint=0.0)
    resume(tmp_path, until=0.05)
    assert sum(one["kind"] == "start_inside" for one in read_summary(tmp_path)["audit"]) == 1


def test_checks_of_the_start_are_made_for_the_first_stage_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    assert {*CHECKS, *COSTLY_CHECKS} > scene_audit.OF_START
    seen: list[tuple[str, float]] = []

    def of_start(scene: Scene) -> Iterator[Finding]:
        seen.append(("start", scene.run.until))
        yield Finding("warning", "strain", 1, "of the start", "")

    def of_values(scene: Scene) -> Iterator[Finding]:
        seen.append(("values", scene.run.until))
        yield from ()

    monkeypatch.setattr(scene_audit, "CHECKS", [of_values])
    monkeypatch.setattr(scene_audit, "COSTLY_CHECKS", [of_start])
    monkeypatch.setattr(scene_audit, "OF_START", frozenset({of_start}))
    found = audit(oscillator(free("a", 0.1), free("b", 0.2)))
    assert seen == [("values", 0.1), ("start", 0.1), ("values", pytest.approx(0.3))]
    assert [finding.message for finding in found.findings] == ["of the start"]


def test_check_judges_stages_up_to_a_time(tmp_path: Path) -> None:
    oscillator(free("a", 0.1), free("b", 0.2), free("c", 0.1)).save(tmp_path)
    file = str(tmp_path / "scene.toml")
    shown = call("check", file, "--until", "0.15")
    assert "Stage    b, 0.05 s" in shown
    assert "Stage    c" not in shown
    for until in ("0.5", "0"):
        result = CliRunner().invoke(app, ["check", file, "--until", until])
        assert result.exit_code == 2
        assert "must be above 0, and at most 0.4, where the stages end" in " ".join(result.output.split())
    refused(lambda: Simulation(oscillator(free("a", 0.1))).run(0.5), ValueError, "the last stage ends at 0.1 s")
