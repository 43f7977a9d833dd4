"""Stages of a scene: what they take, what they refuse, and in which words; files, audit, studies, command line."""

from __future__ import annotations

import re
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from membrane_rs import (
    AuditWarning,
    Fixed,
    Gravity,
    InputError,
    InputTypeError,
    Scene,
    SceneError,
    Simulation,
    Spin,
    Stage,
    Triangles,
    scenes,
)
from membrane_rs.check import audit
from membrane_rs.cli import app
from membrane_rs.results import read_history, read_summary
from membrane_rs.scene.stage import MEASURES
from membrane_rs.simulation.measures import OF_MOTION, PHASE
from membrane_rs.study import ablate, match_scene, work_precision
from membrane_rs.study.limits import measured_limit
from membrane_rs.study.stability import stability_map
from small_scenes import cord, hanging_strip, refused
from staged_scenes import free, oscillator, started
from typer.testing import CliRunner

BASE = oscillator()


MORE_SEGMENTS = Stage("a", 1, set={"parts.spring.segments": 2, "parts.spring.linear_density": 1.0})


def with_stages(*stages: Stage) -> Scene:
    return replace(BASE, stages=stages)


@pytest.mark.parametrize(
    ("values", "kind", "words"),
    [
        ({"name": ""}, InputError, "Stage.name = ''"),
        ({"name": "  "}, InputError, "Stage.name = ' '"),
        ({"name": "a\nb"}, InputError, "Stage.name = 'a.*in one line"),
        ({"name": "a" * 101}, InputError, "1 to 100 characters"),
        ({"name": "\udc80"}, InputError, "half of a surrogate pair"),
        ({"name": 3}, InputError, "Stage.name = 3"),
        ({"duration": 0.0}, InputError, r"Stage.duration = 0\.0: must be greater than 0 \(s\)"),
        ({"duration": -1}, InputError, "Stage.duration = -1"),
        ({"duration": float("nan")}, InputError, "Stage.duration = nan: must be finite"),
        ({"duration": float("inf")}, InputError, "Stage.duration = inf: must be finite"),
        ({"duration": 1e300}, InputError, r"Stage.duration = 1e\+300: must be from 1e-15 to 1e\+12 \(s\)"),
        ({"duration": 1e-300}, InputError, "Stage.duration = 1e-300: must be from 1e-15"),
        ({"duration": True}, InputTypeError, "Stage.duration = True: must be a number"),
        ({"duration": "1 s"}, InputTypeError, "Stage.duration = '1 s': must be a number"),
        ({"below": 1.0}, InputError, r"Stage.below = 1: is given without measure; name one, such as 'deployment_rate'"),
        ({"above": 1.0}, InputError, "Stage.above = 1: is given without measure"),
        ({"measure": "hub_angle"}, InputError, "neither below nor above is given; give one of them"),
        ({"measure": "hub_angle", "below": 1, "above": 2}, InputError, "both below and above are given; give one"),
        ({"measure": "colour", "below": 1}, InputError, "no such measure; known are: contact_force"),
        ({"measure": "deployment_rat", "below": 1}, InputError, "did you mean 'deployment_rate'?"),
        ({"measure": "python:f", "below": 1}, InputError, "was a function, which no file holds"),
        ({"measure": 3, "below": 1}, InputTypeError, "must be the name of a measure, or in Python a function"),
        ({"measure": "hub_angle", "below": float("nan")}, InputError, "Stage.below = nan: must be finite"),
        ({"measure": "hub_angle", "above": "1"}, InputTypeError, "Stage.above = '1': must be a number"),
        ({"without": "springs"}, InputTypeError, "Stage.without = 'springs': must be a list of names"),
        ({"without": (1,)}, InputTypeError, "must be a list of names"),
        ({"without": ("a", "a")}, InputError, "must not hold 'a' twice"),
        ({"scale": [1]}, InputTypeError, "must be a table of keys such as"),
        ({"scale": {1: 2.0}}, InputTypeError, "must be a table of keys such as"),
        ({"scale": {"material.density": 0.0}}, InputError, "must be greater than 0"),
        ({"scale": {"material.density": -1.0}}, InputError, "must be greater than 0"),
        ({"scale": {"material.density": float("nan")}}, InputError, "must be finite"),
        ({"scale": {"material.density": "half"}}, InputTypeError, "must be a number"),
        ({"set": 3}, InputTypeError, "must be a table of keys such as"),
        ({"set": {"run.dt": 1}, "scale": {"run.dt": 2}}, InputError, "Stage.set: 'run.dt' is scaled too"),
        ({"end": 3}, InputTypeError, "Stage.end: no such key"),
    ],
)
def test_a_field_that_is_wrong(values: dict[str, Any], kind: type[Exception], words: str) -> None:
    refused(lambda: Stage(**{"name": "a", "duration": 1.0, **values}), kind, words)


@pytest.mark.parametrize(
    ("stage", "words"),
    [
        (Stage("a", 1, without=("spring_damping",)), r"stages\[1\].without: 'spring_damping': no law of that kind"),
        (Stage("a", 1, without=("mass_dampin",)), "did you mean 'mass_damping'?"),
        (Stage("a", 1, without=("tethers",)), "no law of that kind, and no part or body of that name"),
        (Stage("a", 1, without=("spring",)), r"stages\[1\]: parts\[1\].nodes = \(0,\): node 0 is not there"),
        (Stage("a", 1, scale={"laws.gravity.acceleration": 2}), "is .50.0, 0.0, 0.0., no number, so it is not scaled"),
        (Stage("a", 1, scale={"parts.spring.fixed": 2}), "is False, no number"),
        (Stage("a", 1, scale={"parts.spring.length": 2}), "is None, no number"),
        (Stage("a", 1, scale={"parts.spring.segments": 2}), "parts.spring.segments = 2.0: must be a whole"),
        (MORE_SEGMENTS, r"stages\[1\]: has other nodes or cords than the first stage"),
        (Stage("a", 1, set={"laws.mass_damping.rate": -1}), r"laws.mass_damping.rate = -1: must be at least 0 \(1/s\)"),
        (Stage("a", 1, set={"laws.mass_damping.rat": 1}), "laws.mass_damping.rat: no such key; did you mean 'rate'?"),
        (Stage("a", 1, scale={"laws.mass_damping.rat": 1}), "laws.mass_damping.rat: no such key; did you mean 'rate'?"),
        (Stage("a", 1, set={"laws.springs.buckling": 1}), "laws has no 'springs'; known are: gravity, mass_damping"),
        (Stage("a", 1, set={"laws.rate": 1}), "is no key of a value; write one such as 'laws.gravity.key'"),
        (Stage("a", 1, set={"law.mass_damping.rate": 1}), "does not begin with .*did you mean 'laws'"),
        (Stage("a", 1, set={"": 1}), "does not begin with"),
        (Stage("a", 1, set={"parts": 1}), "'parts': is no key of a value"),
        (Stage("a", 1, set={"parts.3.mass": 1}), "parts has no '3'"),
        (Stage("a", 1, set={"material.density": 1}), "does not begin with"),
        (Stage("a", 1, set={"parts.hold.name": "b"}), "a stage renames nothing; leave it out"),
        (Stage("a", 1, set={"run.until": 1}), "'run.until': is no setting of a stage"),
        (Stage("a", 1, set={"run.frames": 1}), "is no setting of a stage"),
        (Stage("a", 1, set={"run.dt": 0}), r"run.dt = 0: must be greater than 0 \(s\)"),
        (Stage("a", 1, scale={"run.dt": 2}), "settings of the run are not scaled"),
        (Stage("a", 1, set={"laws.gravity.acceleration": 1}), "laws.gravity.acceleration = 1: must be three numbers"),
        (Stage("a", 1, without=("hold",), set={"parts.hold.nodes": (0,)}), "'parts.hold.nodes' is not at work in this"),
        (Stage("first", 1), r"stages\[1\].name = 'first': is that of an earlier stage too"),
        (Stage("a", 1e12), r"stages: last 1e\+12 s in all"),
    ],
)  # fmt: skip
def test_a_stage_that_the_scene_does_not_fit(stage: Stage, words: str) -> None:
    refused(lambda: with_stages(Stage("first", 1.0), stage), SceneError, words)


def test_stages_that_are_no_list_of_stages() -> None:
    for stages, words in (
        ("ab", "Scene.stages = 'ab': must be a list of stages"),
        ([{"name": "a"}], r"Scene.stages\[0\] = .*: must be one of Stage"),
        (3, "must be a list of stages"),
    ):
        refused(lambda stages=stages: replace(BASE, stages=stages), InputTypeError, words)  # type: ignore[misc]
    many = tuple(Stage(str(k), 1e-3) for k in range(10**5))
    refused(lambda: with_stages(*many), SceneError, "stages: 100000 of them; must be at most 100")
    assert len(with_stages(*many[:100]).stages) == 100
    refused(lambda: BASE.staged(0), SceneError, "stage 0")
    refused(lambda: with_stages(many[0]).staged(1), SceneError, "stage 1: must be from 0 to 0")


def test_names_of_parts() -> None:
    parts = list(BASE.parts)
    for name, words in (
        ("gravity", "is that of a law, of a body or of another part"),
        ("spring", "is that of a law, of a body or of another part"),
        ("", "must be 1 to 100 characters"),
        ("a/b", "must be 1 to 100 characters"),
    ):
        named = [*parts[:2], replace(parts[2], name=name)]
        refused(lambda named=named: replace(BASE, parts=named), SceneError, rf"parts\[2\].name = .*{words}")  # type: ignore[misc]
    refused(lambda: replace(parts[0], name=3), InputError, "name = 3")  # type: ignore[arg-type]
    assert Fixed((0,)) == Fixed((0,), name=None)
    assert "name" not in Scene(None, None, [Gravity()], [cord()]).to_toml().split("\n", 1)[1]


def stepped(sim: Simulation) -> float:
    sim.step(1)
    return 0.0


def reached(sim: Simulation) -> float:
    sim.reach(0.5)
    return 0.0


def moved(sim: Simulation) -> float:
    sim.positions = sim.positions
    return 0.0


@pytest.mark.parametrize(
    ("measure", "words"),
    [
        (lambda _: float("nan"), r"stages\[1\].measure = a lambda in line .* at t = 0.1 s = nan: must be finite"),
        (lambda _: np.zeros(3), "must be a number"),
        (lambda _: "1", "must be a number"),
        (lambda _: None, "must be a number"),
        (stepped, "a measure only reads"),
        (reached, "a measure only reads"),
        (moved, "a measure only reads"),
    ],
)
def test_a_measure_that_is_none(measure: Any, words: str) -> None:
    sim = started(with_stages(free("a", 0.1), free("b", 0.1, measure=measure, above=1.0)), dt=1e-3)
    refused(lambda: sim.reach(0.15), (InputError, InputTypeError), words)  # type: ignore[arg-type]


def test_a_measure_that_raises_or_steps_later_leaves_the_last_state() -> None:
    def raises(sim: Simulation) -> float:
        if sim.time > 0.15:
            raise ZeroDivisionError("of a test")
        return 0.0

    def steps(sim: Simulation) -> float:
        if sim.time > 0.15:
            sim.step(3)
        return 0.0

    for measure, kind, words in ((raises, ZeroDivisionError, "of a test"), (steps, InputError, "only reads")):
        sim = started(with_stages(free("a", 0.1), free("b", 0.1, measure=measure, above=1.0)), dt=1e-3)
        with pytest.raises(kind, match=words):
            sim.reach(0.19)
        assert sim.time == pytest.approx(0.15, abs=1e-3)
        sim.reach(sim.time)


def test_a_measure_without_a_value_is_named() -> None:
    sim = Simulation(with_stages(Stage("a", 0.1), Stage("b", 0.1, "largest_film_stress", above=1.0)), dt=1e-3)
    refused(lambda: sim.reach(0.2), InputError, r"stages\[1\].measure = 'largest_film_stress' at t = 0.1 s = nan")


def test_every_measure_is_evaluated() -> None:
    assert {*OF_MOTION, PHASE} == set(MEASURES)
    for measure in MEASURES:
        scene = hanging_strip()
        sim = Simulation(replace(scene, stages=[Stage("a", 2e-4, measure, above=1e9)]))
        sim.run()
        assert sim.stages[0].ended_by == "duration"


def test_each_stage_holds_what_it_says() -> None:
    film = replace(hanging_strip(), name="film")
    scene = replace(
        film,
        laws=[*film.laws, Triangles(), Spin(1.0)],
        parts=[replace(part, name="hold") for part in film.parts],
        stages=[
            Stage("a", 1.0, without=("triangles", "spin"), scale={"material.youngs_modulus": 0.1}),
            Stage("b", 2.0, without=("springs", "hold"), set={"laws.spin.frequency": 2.0, "run.watch": 7}),
        ],
    )
    a, b = scene.staged(0), scene.staged(1)
    assert [law.kind for law in a.laws] == ["springs", "spring_damping", "gravity"]
    assert [law.kind for law in b.laws] == ["spring_damping", "gravity", "triangles", "spin"]
    assert (a.material.youngs_modulus, b.material.youngs_modulus) == (1e5, 1e6)  # type: ignore[union-attr]
    assert (len(a.parts), len(b.parts), b.run.watch, a.run.watch) == (1, 0, 7, 100)
    assert (scene.run.until, a.run.until, b.run.until) == (3.0, 1.0, 3.0)
    assert b.law(Spin).frequency == 2.0  # type: ignore[union-attr]
    assert scene.staged(1) is b
    both = [Stage("a", 1.0)]
    refused(lambda: replace(scene, stages=both), SceneError, r"stages\[0\]: laws.springs and laws.triangles")


def test_a_file_holds_stages_and_reads_back(tmp_path: Path) -> None:
    scene = with_stages(
        Stage("a", 0.25, without=("mass_damping",), set={"laws.gravity.acceleration": [1, 2.5, np.float64(3.0)]}),
        Stage('"quoted" name', 1.0, "kinetic_energy", below=1e-3, scale={"parts.spring.axial_stiffness": 0.1}),
    )
    scene.save(tmp_path)
    text = (tmp_path / "scene.toml").read_text()
    again = Scene.from_toml(tmp_path / "scene.toml")
    assert again.stages == scene.stages
    assert again.to_toml() == text
    assert "until" not in text
    (tmp_path / "scene.toml").write_text(text + "until = 0.8\n")
    refused(lambda: Scene.from_toml(tmp_path / "scene.toml"), SceneError, "run.until = 0.8: the run ends with the last")
    (tmp_path / "scene.toml").write_text(text.replace("duration = 0.25", "duration = -1"))
    refused(lambda: Scene.from_toml(tmp_path / "scene.toml"), SceneError, r"stages\[0\].duration = -1: must be")
    (tmp_path / "scene.toml").write_text("stages = 3\n" + text[: text.index("[[stages]]")])
    refused(lambda: Scene.from_toml(tmp_path / "scene.toml"), SceneError, "stages: must be a list of tables")


def test_a_function_is_told_in_a_file_and_refused_when_it_is_read(tmp_path: Path) -> None:
    scene = with_stages(free("a", 0.5, measure=lambda sim: sim.positions[1, 0], below=1.5), free("b", 0.1))
    sim = started(scene, dt=1e-3)
    sim.run(out=tmp_path / "run", pictures=False)
    assert sim.stages[0].ended_by == "measure"
    words = "measure = 'python:.*was a function, which no file holds"
    refused(lambda: Scene.from_toml(tmp_path / "run/scene.toml"), SceneError, words)
    state = tmp_path / "run/state.npz"
    refused(lambda: Simulation.restore(state), InputError, r"no file holds; build .*Simulation\(scene, start=FILE\)")


@pytest.mark.parametrize("time", [0.0, 0.0117, 0.31, 0.7])
def test_the_motion_of_a_run_with_a_function_is_a_start(time: float, tmp_path: Path) -> None:
    stages = free("a", 0.5, measure=lambda sim: sim.positions[1, 0], below=1.5), free("b", 0.7)
    sim = started(with_stages(*stages), dt=1e-3)
    sim.reach(time)
    sim.save(tmp_path / "state.npz")
    rest = with_stages(free("rest", 0.2))
    for start in (sim, tmp_path / "state.npz", str(tmp_path / "state.npz")):
        other = Simulation(rest, start=start)
        assert other.time == sim.time == time
        assert other.positions.tobytes() == sim.positions.tobytes()
        assert other.velocities.tobytes() == sim.velocities.tobytes()


def test_the_audit_names_stages() -> None:
    scene = with_stages(Stage("held", 0.1), Stage("free", 0.1, without=("hold",)))
    found = audit(scene, costly=False)
    assert [finding.message[:12] for finding in found.warnings if finding.kind == "supports"] == ["stage 'free'"]
    assert sum(finding.kind == "implausible_value" for finding in found.warnings) == 1
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        Simulation(scene)
    assert [item.category for item in caught] == [AuditWarning, AuditWarning]


def test_a_stage_that_the_core_refuses_is_named_at_once() -> None:
    unknown = Stage("b", 0.1, set={"run.integrator": "euler"})
    refused(lambda: with_stages(Stage("a", 0.1), unknown), SceneError, r"stages\[1\]: run.integrator = 'euler': is no")
    scene = with_stages(Stage("a", 0.1), Stage("b", 0.1, set={"run.dt": 1e3}))
    refused(lambda: Simulation(scene), InputError, r"stages\[1\]: ")


def test_studies_refuse_stages(tmp_path: Path) -> None:
    scene = replace(scenes.load("single-crease"), stages=[Stage("a", 1e-3)])
    bounds = (1.0, 2.0)
    for study in (
        lambda: ablate(scene),
        lambda: work_precision(scene),
        lambda: measured_limit(scene),
        lambda: stability_map(scene, "material.density", [1.0], methods=["rk4"]),
        lambda: match_scene(scene, "material.density", bounds, scene, tmp_path),
    ):
        refused(study, InputError, "has 1 stages; a study compares runs of a scene without")


def test_the_command_line_runs_and_checks_stages(tmp_path: Path) -> None:
    scene = with_stages(free("swing", 0.01), free("on", 0.02, scale={"parts.spring.axial_stiffness": 0.5}))
    scene.save(tmp_path / "scene")
    file, out = str(tmp_path / "scene/scene.toml"), str(tmp_path / "out")

    def call(*words: str) -> str:
        result = CliRunner().invoke(app, list(words))
        assert result.exit_code == 0, result.output
        return result.output

    shown = call("check", file)
    assert "Stage    swing, 0.01 s" in shown
    assert "Stage    on, 0.02 s" in shown
    assert shown.count("  cost  ") == 2
    call("run", file, "--out", out, "--no-pictures", "--until", "0.015")
    assert read_history(out)["time"][-1] == 0.015
    call("resume", out, "--until", "0.03")
    assert read_history(out)["time"][-1] == 0.03
    stages = read_summary(out)["stages"]
    assert [(stage["name"], stage["ended_by"]) for stage in stages] == [("swing", "duration"), ("on", "duration")]
    assert [stage["start"] for stage in stages] == [0.0, 0.01]


def test_a_history_has_the_columns_of_all_stages(tmp_path: Path) -> None:
    scene = with_stages(
        Stage("a", 0.01, without=("hold", "gravity")), Stage("b", 0.01, without=("mass_damping",)), Stage("c", 0.01)
    )
    sim = Simulation(scene)
    sim.run(out=tmp_path / "run", pictures=False)
    table = read_history(tmp_path / "run")
    assert {"energy_gravity", "energy_tethers", "work_mass_damping", "work_gravity", "hub_force"} <= set(table)
    assert list(table)[-2:] == ["stage", "energy_of_changes"]
    assert (table["energy_gravity"][table["stage"] == 0] == 0.0).all()
    assert (table["hub_force"][table["stage"] == 0] == 0.0).all()
    assert table["energy_of_changes"][-1] == pytest.approx(sum(sim.ledger()["changes"].values()))


def test_a_scene_of_springs_and_stages_keeps_its_digest_apart() -> None:
    one, two = with_stages(Stage("a", 1.0)), with_stages(Stage("a", 2.0))
    state = Simulation(one).state()
    refused(lambda: Simulation(two).set_state(state), InputError, "scene_digest is that of another scene")


def test_the_stages_of_the_page_run(tmp_path: Path) -> None:
    docs = Path(__file__).parent.parent / "docs"
    pages = [(docs / name).read_text(encoding="utf-8") for name in ("units.md", "stages.md")]
    sail, stages = (block for page in pages for block in re.findall(r"```toml\n(.*?)```", page, re.DOTALL))
    file = tmp_path / "scene.toml"
    file.write_text(sail.replace('until = "0.6 s"', "watch = 50") + stages)
    scene = Scene.from_toml(file)
    assert scene.staged(0).law("mass_damping") is not None
    assert scene.staged(1).law("mass_damping") is None
    short = [replace(stage, duration=2e-4) for stage in scene.stages]
    sim = Simulation(replace(scene, stages=short))
    sim.run(frames=2, samples=3)
    assert sim.is_over
    assert "deploy: creases" in sim.ledger()["changes"]
