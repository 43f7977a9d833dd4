"""What a run shows of a hub that turns freely: columns, momentum and its error, pictures, reports and studies."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import membrane_rs
import numpy as np
import pytest
from membrane_rs import (
    CordDrag,
    Gravity,
    MassDamping,
    RunSettings,
    Scene,
    Schedule,
    Simulation,
    Spin,
    Stage,
    Tether,
    scenes,
)
from membrane_rs.check.stowed_energy import stowed_energy
from membrane_rs.errors import InputTypeError
from membrane_rs.plotting import plot_momentum, save_run_figures
from membrane_rs.report import write_report
from membrane_rs.results import read_history, read_summary
from membrane_rs.results.history_table import HistoryTable, column_units
from membrane_rs.results.momentum import momentum_error
from membrane_rs.scene.laws import LAWS
from membrane_rs.scene.scales import moment_of_inertia, node_masses
from membrane_rs.study import sweep
from membrane_rs.study.stability import stability_map

FREE = Spin(2.0, inertia=0.01)
COLUMNS = ["motor_work", "hub_rate", "hub_momentum", "sail_momentum", "motor_torque", "motor_power"]
PUSH = Schedule((0.0, 0.05, 0.05), (0.0, 0.02, 0.01))


def whirled(spin: Spin, *more: Any, stages: tuple[Stage, ...] = (), **run: Any) -> Scene:
    """A mass on a cord that a hub turns."""
    tether = Tether((0.1, 0.0, 0.0), (0.2, 0.0, 0.0), 2, 17.0, 1e-3, tip_mass=0.05, strain_limit=10.0)
    settings = RunSettings(**{"until": 0.1, "frames": 3, "samples": 21, "snapshots": (), "integrator": "rk4", **run})
    return Scene(None, None, [spin, *more], [tether], stages=stages, run=settings, name="whirled")


def table_of(scene: Scene, hub: Any, sail: Any, **more: Any) -> dict[str, Any]:
    """A history in which hub and sail have these parts of the angular momentum."""
    time = np.linspace(0.0, 0.1, 21)
    return {"time": time, "hub_momentum": hub(time), "sail_momentum": sail(time), **more}


def test_columns_of_a_free_hub_stand_behind_the_others() -> None:
    free, driven = (HistoryTable(Simulation(whirled(spin))).columns for spin in (FREE, Spin(2.0)))
    assert free[-6:] == COLUMNS
    assert driven == [name for name in free if name not in COLUMNS[1:4]]
    units = column_units(free, {})
    assert [units[name] for name in COLUMNS] == ["J", "rad/s", "kg m2/s", "kg m2/s", "N m", "W"]
    stages = (Stage("driven", 0.05), Stage("free", 0.05, set={"laws.spin.inertia": 0.01}))
    assert HistoryTable(Simulation(whirled(Spin(2.0), stages=stages))).columns[-6:] == COLUMNS
    still = Scene(None, None, [Gravity()], whirled(FREE).parts)
    assert not set(COLUMNS) & set(HistoryTable(Simulation(still)).columns)


def test_a_recorded_rate_is_a_column_once() -> None:
    for spin in (FREE, Spin(2.0)):
        run = membrane_rs.run(whirled(spin), record=["hub_rate"])
        assert list(run.history).count("hub_rate") == 1
        assert run.history["hub_rate"][0] == pytest.approx(2.0 * math.tau)
        assert run.history.units["hub_rate"] == "rad/s"


def test_the_error_of_the_momentum_is_what_torque_does_not_explain() -> None:
    scene = whirled(replace(FREE, torque=PUSH))
    table = table_of(scene, lambda t: 3.0 - t, lambda t: 1.0 + t)
    given = np.array([PUSH.integral(0.0, time) for time in table["time"]])
    table["sail_momentum"] = table["sail_momentum"] + given
    assert momentum_error(table, scene) == pytest.approx(0.0, abs=1e-15)
    table["hub_momentum"][-1] += 0.06
    assert momentum_error(table, scene) == pytest.approx(0.02, rel=1e-3)
    assert momentum_error(table, whirled(Spin(2.0))) is None
    assert momentum_error({"time": table["time"]}, scene) is None
    damped = whirled(replace(FREE, torque=PUSH), MassDamping(1.0))
    assert momentum_error(table, damped) == pytest.approx(0.02, rel=1e-3)
    outside = {name for name, law in LAWS.items() if law.exerts_outside_torque}
    assert outside == {"air_drag", "cord_drag", "pressure", "solar_pressure", "point_forces"}
    assert momentum_error(table, whirled(replace(FREE, torque=PUSH), Gravity())) == pytest.approx(0.02, rel=1e-3)
    turning, still = (CordDrag(1e-3, air=air) for air in ("turning", "still"))
    assert momentum_error(table, whirled(replace(FREE, torque=PUSH), turning)) == pytest.approx(0.02, rel=1e-3)
    assert momentum_error(table, whirled(replace(FREE, torque=PUSH), still)) is None
    nothing = table_of(scene, np.zeros_like, np.zeros_like)
    assert momentum_error(nothing, whirled(FREE)) is None


def test_the_error_is_that_of_the_stages_with_a_free_hub() -> None:
    """A torque counts from the start of its stage; what a driven hub gains is none."""
    stages = (
        Stage("driven", 0.05, set={"laws.spin.schedule": Schedule((0.0, 0.05), (1.0, 2.0))}),
        Stage("free", 0.05, set={"laws.spin.inertia": 0.01, "laws.spin.torque": PUSH}),
    )
    scene = whirled(Spin(1.0), stages=stages)
    time = np.linspace(0.0, 0.08, 33)
    stage = (time >= 0.03).astype(np.float64)  # a measure ended the first one
    given = np.array([PUSH.integral(0.0, max(0.0, now - 0.03)) for now in time])
    table = {"time": time, "stage": stage, "hub_momentum": np.where(stage, 2.0, 0.0), "sail_momentum": time + given}
    table["sail_momentum"] = np.where(stage, 1.0 + given, time)
    assert momentum_error(table, scene, [0.0, 0.03]) == pytest.approx(0.0, abs=1e-15)
    table["sail_momentum"][-1] += 0.2
    assert momentum_error(table, scene, [0.0, 0.03]) == pytest.approx(0.1, rel=1e-3)
    assert momentum_error(table, scene, [0.0]) is None


def test_a_folder_has_all_of_it(tmp_path: Path) -> None:
    out = tmp_path / "run"
    Simulation(whirled(FREE)).run(out=out)
    table, summary = read_history(out), read_summary(out)
    assert list(table)[-6:] == COLUMNS
    assert summary["momentum_error"] == momentum_error(table, whirled(FREE))
    assert (out / "momentum.png").is_file()
    run = membrane_rs.open_run(out)
    files = save_run_figures(run, tmp_path / "figures", ["svg"], times=2)
    assert "momentum.svg" in [path.name for path in files]
    page = write_report([run], tmp_path / "report.html").read_text()
    assert "Error of the angular momentum" in page
    assert "Rate of the hub" in page


def test_a_folder_of_a_driven_hub_has_no_momentum(tmp_path: Path) -> None:
    out = tmp_path / "run"
    Simulation(whirled(Spin(2.0))).run(out=out)
    assert "momentum_error" not in read_summary(out)
    assert not (out / "momentum.png").exists()


def test_the_picture_shows_rate_and_parts(tmp_path: Path) -> None:
    time = np.linspace(0.0, 1.0, 5)
    table = {"time": time, "hub_rate": np.full(5, math.tau), "hub_momentum": 2.0 - time, "sail_momentum": time}
    figure = plot_momentum(table, tmp_path / "momentum.svg", style="paper")
    rate, momentum = figure.axes
    assert rate.get_ylabel() == "Rate of the hub [rpm]"
    assert rate.lines[0].get_ydata() == pytest.approx(np.full(5, 60.0))
    curves = {line.get_label(): line.get_ydata() for line in momentum.lines if "momentum" in str(line.get_label())}
    assert curves["Angular momentum of both"] == pytest.approx(np.full(5, 2.0))
    assert len(curves) == 3
    assert table["hub_rate"][0] == math.tau
    several = plot_momentum({"one": table, "other": table})
    assert len(several.axes[0].lines) == 2


def test_a_sweep_varies_the_inertia() -> None:
    found = sweep(whirled(FREE), {"laws.spin.inertia": ["50 kg cm2", "0.02 kg m2"]}, until=0.02, samples=3)
    assert [row["laws.spin.inertia"] for row in found.rows] == [0.005, 0.02]
    assert all(row["outcome"] == "finished" for row in found.rows)
    assert all(isinstance(row["momentum_error"], float) for row in found.rows)
    assert all("final_hub_rate" in row for row in found.rows)


def test_a_stability_map_varies_the_inertia() -> None:
    cells = stability_map(
        whirled(FREE), "laws.spin.inertia", [1e-3, 1e-2], methods=["leapfrog"], shares=[0.5], until=0.02
    )
    assert [cell.outcome for cell in cells] == ["fine", "fine"]


def test_the_energy_of_the_spin_is_less_by_what_slows_a_free_hub() -> None:
    """L^2/2 (1/(I + J_start) - 1/(I + J_flat)), beside Omega^2/2 (J_flat - J_start) of a driven one."""
    scene = scenes.load("okuizumi-model-1")
    spin = scene.law(Spin)
    assert spin is not None
    laws = [law for law in scene.laws if law is not spin]
    settings = replace(scene.run, integrator="leapfrog")

    def freed(one: Spin) -> float:
        (found,) = stowed_energy(replace(scene, laws=[*laws, one], run=settings))
        return float(re.findall(r"to the flat shape ([0-9.e-]+) J", found.message)[0])

    inertia = 2e-4
    start = moment_of_inertia(scene)
    shape = scene.assemble().reference
    flat = float(node_masses(scene) @ (shape[:, 0] ** 2 + shape[:, 1] ** 2))
    expected = 0.5 * (spin.hub_frequency * math.tau) ** 2 * (flat - start)
    assert freed(spin) == pytest.approx(expected, rel=1e-3)
    slower = (inertia + start) / (inertia + flat)
    assert freed(Spin(spin.frequency, inertia=inertia)) == pytest.approx(expected * slower, rel=1e-3)


def test_a_sample_evaluates_the_load_on_the_hub_once(monkeypatch: pytest.MonkeyPatch) -> None:
    sim, calls, evaluated = Simulation(whirled(Spin(2.0))), [], Simulation.hub_load

    def counted(self: Simulation) -> Any:
        calls.append(self)
        return evaluated(self)

    monkeypatch.setattr(Simulation, "hub_load", counted)
    table = HistoryTable(sim)
    assert table.add(sim)
    assert calls == [sim]
    row = dict(zip(table.columns, table.last, strict=True))
    assert row["motor_torque"] == -row["hub_torque"]
    with pytest.raises(InputTypeError, match="load = 1: must be what hub_load"):
        sim.hub_motor(1)  # type: ignore[arg-type]
