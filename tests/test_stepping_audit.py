"""The audit of how a scene is stepped: alike in `check`, `run`, summary.json and warnings from Python."""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path

import pytest
from membrane_rs import AuditWarning, Fixed, RunSettings, Scene, Simulation, Springs, integrators, scenes
from membrane_rs.check import Audit, audit, mesh_faults, step_accuracy, unaccepted_errors
from small_scenes import RUBBER
from step_accuracy_cases import short_tether
from test_scene_audit import OBTUSE, call, told_in

TETHER = scenes.load("spinning-tether")


def kinds(found: Audit) -> list[str]:
    """Of the errors and warnings."""
    return [finding.kind for finding in found.without_facts().findings]


def with_run(**settings: object) -> Scene:
    """The spinning tether, run otherwise."""
    return replace(TETHER, run=replace(TETHER.run, until=1e-3, frames=2, samples=2, **settings))  # type: ignore[arg-type]


def test_a_step_above_the_limit_is_told_alike(tmp_path: Path) -> None:
    dt = 1.2 * Simulation(TETHER).stable_dt()
    scene = with_run(dt=dt)
    words = f"dt = {dt:.4g} s is above the stability limit of {dt / 1.2:.4g} s"
    scene.save(tmp_path)
    assert words in call("check", tmp_path / "scene.toml")[1]
    out = tmp_path / "run"
    assert f"warning: {words}" in call("run", tmp_path / "scene.toml", "--out", out, "--no-pictures")[1]
    assert words in str(told_in(out))
    for of, given in ((scene, None), (TETHER, dt)):
        with pytest.warns(AuditWarning, match="above the stability limit"):
            sim = Simulation(of, dt=given)
        assert kinds(sim.audit()) == ["step"]
    # The same step by a method with a higher limit, and one that has none.
    assert kinds(audit(with_run(dt=dt, integrator="generalized_alpha"), costly=False)) == []
    assert kinds(audit(with_run(dt=dt / 1.3), costly=False)) == []


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"tolerance": 1e-3}, "run.tolerance = 0.001 has no effect with 'rk4', whose steps are not chosen by their"),
        ({"tolerance_speed": 2.0}, "run.tolerance_speed = 2 has no effect with 'rk4'"),
        ({"integrator": "dopri5", "tolerance": 1e-3, "dt": 1e-6}, "has no effect with 'dopri5' and a given step"),
        ({"spectral_radius": 0.3}, "run.spectral_radius = 0.3 has no effect with 'rk4', which is explicit"),
        ({"substeps": 4}, "run.substeps = 4 has no effect with 'rk4'; 'leapfrog' alone takes substeps"),
    ],
)
def test_a_setting_that_the_method_does_not_use_is_told_alike(
    settings: dict[str, object], words: str, tmp_path: Path
) -> None:
    scene = with_run(**settings)
    with pytest.warns(AuditWarning, match=r"has no effect with"):
        sim = Simulation(scene)
    assert [words in finding.message for finding in sim.audit().warnings] == [True]
    scene.save(tmp_path)
    for command in ("check", "run"):
        more = () if command == "check" else ("--out", tmp_path / "run", "--no-pictures")
        assert words in call(command, tmp_path / "scene.toml", *more)[1]
    assert words in str(told_in(tmp_path / "run"))


@pytest.mark.parametrize("method", integrators())
def test_settings_that_have_an_effect_and_defaults_are_not_told(method: str) -> None:
    own: dict[str, dict[str, object]] = {
        "dopri5": {"tolerance": 1e-3, "tolerance_length": 1.0},
        "generalized_alpha": {"spectral_radius": 0.3},
        "leapfrog": {"substeps": 4},
    }
    assert kinds(audit(with_run(integrator=method, **own.get(method, {})), costly=False)) == []
    assert kinds(audit(with_run(integrator=method), costly=False)) == []
    with warnings.catch_warnings():
        warnings.simplefilter("error", AuditWarning)
        # A caller that takes another method compares it; the scene's own uses the setting.
        for scene in (with_run(integrator=name, **settings) for name, settings in own.items()):
            Simulation(scene, method)


def test_an_option_without_effect_is_told(tmp_path: Path) -> None:
    shown = call(
        "run", "spinning-tether", "--until", 1e-3, "--substeps", 4, "--no-pictures", "--out", tmp_path / "run"
    )[1]
    assert shown.count("run.substeps = 4 has no effect with 'rk4'") == 1


def test_growing_modes_of_a_small_mesh_are_told_by_a_run(tmp_path: Path) -> None:
    def kept(rule: str) -> Scene:
        laws = [Springs(negative=rule)]  # type: ignore[arg-type]
        return Scene(OBTUSE, RUBBER, laws, [Fixed((0,))], run=RunSettings(until=1e-5, frames=2, samples=2))

    with pytest.warns(AuditWarning, match="mode of the unfolded membrane grows"):
        Simulation(kept("keep"))
    kept("keep").save(tmp_path)
    code, shown = call("run", tmp_path / "scene.toml", "--out", tmp_path / "run", "--no-pictures")
    assert (code, "error: 1 mode of the unfolded membrane grows" in shown) == (0, True)
    assert "growing_mode" in str(told_in(tmp_path / "run"))
    assert unaccepted_errors(kept("keep")) == ()
    # Springs that are clipped to zero make no mode that grows.
    assert "growing_mode" not in kinds(audit(kept("clip"), costly=False))


def test_growing_modes_of_a_large_mesh_are_left_to_check(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mesh_faults, "FEW_NODES", 2)
    scene = Scene(OBTUSE, RUBBER, [Springs(negative="keep")], [Fixed((0,))])
    assert list(mesh_faults.growing_modes(scene)) == []
    assert [finding.kind for finding in mesh_faults.growing_modes_of_large_meshes(scene)] == ["growing_mode"]


def test_the_error_of_the_step_is_a_finding_of_check(tmp_path: Path) -> None:
    tether = short_tether()
    limit = Simulation(tether, "leapfrog").stable_dt()
    coarse, fine = (replace(tether, run=replace(tether.run, integrator="leapfrog", dt=x * limit)) for x in (0.4, 0.05))
    found = audit(coarse)
    assert kinds(found) == ["step_accuracy"]
    assert "of the motion, whose extent is" in found.warnings[0].message
    assert "use dt =" in found.warnings[0].remedy
    assert (kinds(audit(coarse, costly=False)), kinds(audit(fine))) == ([], [])
    coarse.save(tmp_path)
    assert "no errors, 1 warning warning: by t = 1 s the step is wrong by" in call("check", tmp_path / "scene.toml")[1]
    # What cannot be run has no error of the step: `Simulation` says why.
    assert list(step_accuracy.accuracy_of_step(with_run(dt=1.0))) == []
