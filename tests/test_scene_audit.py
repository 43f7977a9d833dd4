"""One audit: the same findings by `check`, by `run`, in summary.json, and as warnings from Python."""

from __future__ import annotations

import json
import subprocess
import sys
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from membrane_rs import AuditWarning, Fixed, Gravity, Mesh, RunSettings, Scene, Simulation, Springs, run, scenes
from membrane_rs.check import CHECKS, COSTLY_CHECKS, Finding, audit, unaccepted_errors
from membrane_rs.cli import app
from membrane_rs.folding import Strip
from small_scenes import RUBBER, hanging_strip
from typer.testing import CliRunner

SHEET = Strip(0.1, 0.04, 4, 2).mesh()
OBTUSE = Mesh([[0.01, 0.0, 0.0], [0.02, 0.002, 0.0], [0.03, 0.0, 0.0]], [[0, 1, 2]])


def doubled() -> Scene:
    """A strip in which one triangle is given twice."""
    triangles = np.vstack([SHEET.triangles, SHEET.triangles[:1]])
    mesh = Mesh(SHEET.reference, triangles, node_sets=SHEET.node_sets)
    return Scene(mesh, RUBBER, [Springs(), Gravity()], [Fixed("start")], name="doubled", run=RunSettings(until=0.01))


def call(*words: object) -> tuple[int, str]:
    """Exit code and everything that was printed."""
    result = CliRunner().invoke(app, [str(word) for word in words])
    assert result.exception is None or isinstance(result.exception, SystemExit)
    return result.exit_code, " ".join(result.output.split())


def told_in(folder: Path) -> list[dict[str, object]]:
    """The audit in summary.json."""
    found: list[dict[str, object]] = json.loads((folder / "summary.json").read_text())["audit"]
    return found


@pytest.mark.parametrize("name", scenes.names())
def test_built_in_scenes_have_neither_errors_nor_warnings(name: str) -> None:
    found = audit(scenes.load(name))
    # But for the error of the step over a chaotic motion (docs/step_accuracy.md).
    assert [one.kind for one in found.without_facts().findings if one.kind != "step_accuracy"] == [], str(found)


@pytest.mark.parametrize("check", [*CHECKS, *COSTLY_CHECKS], ids=lambda check: check.__name__)
def test_each_check_yields_findings_of_documented_kinds(check: Callable[[Scene], Iterator[Finding]]) -> None:
    assert Finding.__doc__ is not None
    for scene in (doubled(), hanging_strip(), *map(scenes.load, ("spinning-tether", "single-crease"))):
        for finding in check(scene):
            assert f'"{finding.kind}"' in Finding.__doc__
            assert finding.message
            assert finding.remedy or finding.severity == "info"


def test_one_audit_is_reported_by_check_run_summary_and_python(tmp_path: Path) -> None:
    doubled().save(tmp_path)
    path, out = tmp_path / "scene.toml", tmp_path / "run"
    with pytest.warns(AuditWarning) as caught:
        sim = Simulation(Scene.from_toml(path))
    found = sim.audit()
    assert found.errors[0].kind == "duplicate_triangles"
    assert [warning.filename for warning in caught] == [__file__] * len(found.errors + found.warnings)
    code, shown = call("check", path)
    ran, ran_shown = call("run", path, "--out", out)
    assert (code, ran) == (1, 1)
    for finding, warning in zip(found.without_facts().findings, caught, strict=True):
        assert str(warning.message) == f"{finding.severity}: {finding.message}; {finding.remedy}"
        for text in (shown, ran_shown):
            assert f"{finding.severity}: {finding.message}" in text
    assert told_in(out) == [finding.as_dict() for finding in found.findings]
    assert json.loads((out / "summary.json").read_text())["steps"] == 0


def test_a_named_option_runs_despite_errors(tmp_path: Path) -> None:
    doubled().save(tmp_path)
    out = tmp_path / "run"
    code, shown = call("run", tmp_path / "scene.toml", "--out", out, "--despite-errors", "--no-pictures")
    assert (code, "triangles are given more than once" in shown) == (0, True)
    assert told_in(out)[0]["kind"] == "duplicate_triangles"
    assert json.loads((out / "summary.json").read_text())["outcome"] == "finished"


def test_a_saved_state_that_goes_on_is_audited_too(tmp_path: Path) -> None:
    with pytest.warns(AuditWarning):
        Simulation(doubled()).save(tmp_path / "state.npz")
    code, shown = call("resume", tmp_path / "state.npz", "--until", "1e-5", "--out", tmp_path / "run", "--no-pictures")
    assert (code, "triangles are given more than once" in shown) == (0, True), shown


def test_errors_that_a_setting_accepts_stop_no_run(tmp_path: Path) -> None:
    stretched = Mesh(SHEET.reference, SHEET.triangles, positions=1.2 * SHEET.reference)
    for mesh, accepting, other in (
        (OBTUSE, Springs(negative="clip"), None),
        (OBTUSE, Springs(negative="keep"), None),
        (stretched, Springs(strain_limit=1.0), Springs()),
    ):
        scene = Scene(mesh, RUBBER, [accepting], [Fixed((0,))], name="accepted", run=RunSettings(until=1e-4))
        assert audit(scene, costly=False).errors
        assert unaccepted_errors(scene) == ()
        scene.save(tmp_path / "scene")
        code, shown = call("run", tmp_path / "scene" / "scene.toml", "--out", tmp_path / "run", "--overwrite")
        assert (code, "error:" in shown) == (0, True), shown
        if other is not None:
            refused = Scene(mesh, RUBBER, [other], [Fixed((0,))])
            assert [error.kind for error in unaccepted_errors(refused)] == ["strain"]


def test_a_sound_scene_runs_without_a_warning() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error", AuditWarning)
        Simulation(scenes.load("spinning-tether"))
        with pytest.raises(AuditWarning, match="given more than once"):
            Simulation(doubled())


def test_what_a_run_leaves_out_is_said() -> None:
    scene = doubled()
    left_out = audit(scene, costly=False).find("left_out")
    assert left_out is not None
    assert (
        "growing modes of large meshes, crossings of large meshes, net of springs, stowed energy, accuracy of step"
        in left_out.message
    )
    assert audit(scene).find("left_out") is None


def test_a_study_does_not_warn_of_the_scenes_that_it_varies(tmp_path: Path) -> None:
    doubled().save(tmp_path)
    code = (
        "from membrane_rs import Scene, Simulation\n"
        "from membrane_rs.study.common.run import study_case\n"
        f"scene = Scene.from_toml({str(tmp_path / 'scene.toml')!r})\n"
        "study_case(scene, 0.01, 2)\n"
    )
    for more, count in (("", 0), ("Simulation(scene)\n", 1)):
        done = subprocess.run([sys.executable, "-c", code + more], capture_output=True, text=True, check=True)
        assert done.stderr.count("given more than once") == count


def test_a_run_warns_at_the_line_of_its_caller() -> None:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        run("spinning-tether", 0.01, frames=[0.0, 0.005, 0.02], stop_when=lambda sim: sim.time >= 0.0)
    assert {str(warning.message).split(":")[0].split(" =")[0] for warning in caught} == {"frames", "stop_when"}
    assert {warning.filename for warning in caught} == {__file__}
