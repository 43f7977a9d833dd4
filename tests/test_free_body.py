"""A hub in six degrees of freedom: its parameters, readings, columns, pictures and stages."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import membrane_rs
import numpy as np
import pytest
from membrane_rs import (
    Fixed,
    MassDamping,
    PointForces,
    RunSettings,
    Scene,
    Schedule,
    Simulation,
    Spin,
    Stage,
    Tether,
    scenes,
)
from membrane_rs.analysis.attitude import turn_at, turned
from membrane_rs.check import audit
from membrane_rs.errors import InputError
from membrane_rs.plotting import plot_momentum
from membrane_rs.results import read_history, read_summary
from membrane_rs.results.history_table import OF_BODY, HistoryTable, column_units

BODY = Spin(0.2, inertia=9.0, mass=30.0, transverse_inertia=6.0, tumble=0.02)


def flown(spin: Spin, stages: tuple[Stage, ...] = (), **run: Any) -> Scene:
    """Two unequal masses on cords of a body, at different heights."""
    tethers = [
        Tether((x, 0.0, z), (5.0 * x, 0.0, z), 2, 500.0, 1e-3, tip_mass=mass)
        for x, z, mass in ((0.4, 0.1, 0.2), (-0.4, 0.0, 0.3))
    ]
    settings = RunSettings(**{"until": 1.0, "frames": 3, "samples": 21, "integrator": "leapfrog", **run})
    return Scene(None, None, [spin], tethers, stages=stages, run=settings, name="flown")


@pytest.mark.parametrize("integrator", ["leapfrog", "rk4"])
def test_angular_momentum_in_space_is_constant(integrator: str) -> None:
    sim = Simulation(flown(BODY, integrator=integrator))
    before, start = sim.angular_momentum(), sim.hub_attitude
    sim.reach(2.0)
    after = sim.angular_momentum()
    size = np.linalg.norm(before.in_space)
    assert np.linalg.norm(after.in_space - before.in_space) < (1e-12 if integrator == "leapfrog" else 1e-7) * size
    assert np.linalg.norm(sim.hub_attitude - start) > 0.1
    assert np.linalg.norm(sim.hub_displacement) > 1e-4
    assert sim.hub_rotation @ sim.hub_rotation.T == pytest.approx(np.eye(3), abs=1e-12)
    assert 0.0 < sim.nutation_angle < 0.5
    whole = sim.hub_rotation.T @ after.in_space
    assert whole[2] == pytest.approx(after.total, rel=1e-12)
    assert sim.nutation_angle == pytest.approx(math.acos(whole[2] / np.linalg.norm(whole)), rel=1e-6)


def test_places_in_space_follow_from_rotation_and_displacement() -> None:
    """A body with a weight at the end of a mast, pushed there: its centre of mass flies as a point."""
    mast = Tether((0.05, 0.0, 0.02), (0.06, 0.0, 0.02), 1, 1.0, 1e-9, tip_mass=0.01)
    spin = Spin(3.0, inertia=4e-5, mass=0.02, transverse_inertia=3e-5, tumble=2.0)
    push = PointForces("tether-0-end", (0.0, 0.1, 0.2), frame="inertial")
    run = RunSettings(until=0.1, integrator="rk4", dt=1e-4)
    sim = Simulation(Scene(None, None, [spin, push], [mast, Fixed("tether-0-end")], run=run))
    centre = 0.01 * sim.positions[1] / 0.03
    sim.reach(0.1)
    masses, places = np.append(sim.masses, 0.02), np.vstack([sim.positions, np.zeros(3)])
    places = (places - centre) @ sim.hub_rotation.T + sim.hub_displacement
    flown_by = 0.5 * np.array([0.0, 0.1, 0.2]) / 0.03 * 0.1**2
    assert masses @ places / 0.03 == pytest.approx(flown_by, rel=1e-6, abs=1e-9)


def test_a_bearing_holds_the_axis_of_another_hub() -> None:
    sim = Simulation(flown(Spin(0.2, inertia=9.0)))
    sim.reach(0.5)
    assert sim.nutation_angle == 0.0
    assert (sim.hub_displacement == 0.0).all()
    assert turned(np.eye(3), sim.hub_angle) == pytest.approx(turned(np.eye(3), sim.hub_attitude), abs=1e-14)
    assert sim.angular_momentum().in_space[2] == pytest.approx(sim.angular_momentum().total, rel=1e-14)


def test_a_run_records_attitude_and_momentum_and_resumes_with_them(tmp_path: Path) -> None:
    scene = flown(BODY)
    run = membrane_rs.run(scene, out=tmp_path / "run", pictures=False)
    assert set(OF_BODY) <= set(run.history)
    units = column_units(OF_BODY, {})
    assert (units["nutation_deg"], units["attitude_w"], units["hub_x"], units["momentum_z"]) == (
        "deg",
        "",
        "m",
        "kg m2/s",
    )
    assert not set(OF_BODY) & set(
        HistoryTable(Simulation(flown(replace(BODY, mass=None, transverse_inertia=None, tumble=None)))).columns
    )
    table = read_history(tmp_path / "run")
    summary = read_summary(tmp_path / "run")
    assert 0.0 < summary["momentum_error"] < 1e-12
    last = run.frames[-1]
    assert last.attitude == pytest.approx([table[f"attitude_{name}"][-1] for name in "wxyz"])
    assert turn_at(table, 1.0) == pytest.approx(last.turn)
    first = Simulation(scene)
    first.reach(0.503)
    first.save(tmp_path / "state.npz")
    again = Simulation.restore(tmp_path / "state.npz")
    for sim in (first, again):
        sim.reach(1.0)
    assert (again.hub_attitude == first.hub_attitude).all()
    assert (again.positions == first.positions).all()
    figure = plot_momentum(table)
    assert [axes.get_ylabel() for axes in figure.axes][-1] == "Nutation angle [deg]"


def test_a_stage_goes_on_with_the_whole_motion() -> None:
    stages = (Stage("first", 0.5), Stage("second", 0.5))
    staged, whole = Simulation(flown(BODY, stages)), Simulation(flown(BODY))
    for sim in (staged, whole):
        sim.reach(1.0)
    assert staged.positions == pytest.approx(whole.positions, abs=1e-6)
    assert staged.hub_attitude == pytest.approx(whole.hub_attitude, abs=1e-6)
    assert staged.hub_displacement == pytest.approx(whole.hub_displacement, abs=1e-6)


@pytest.mark.parametrize("anchor", [(0.4, 0.1, 0.0), (0.0, 0.4, 0.1), (0.4, -0.2, 0.1)])
def test_a_cord_may_be_held_anywhere(anchor: tuple[float, float, float]) -> None:
    """The mass of its end tilts the principal axes of the hub in any way."""
    x, y, z = anchor
    cord = Tether(anchor, (3.0 * x, 3.0 * y, 3.0 * z), 1, 500.0, 0.5, tip_mass=0.1)
    sim = Simulation(replace(flown(BODY), parts=[cord]))
    before = sim.angular_momentum().in_space
    sim.reach(0.5)
    assert np.linalg.norm(sim.angular_momentum().in_space - before) < 1e-12 * np.linalg.norm(before)


def test_a_stage_that_lets_a_node_go_keeps_the_momentum() -> None:
    cords = [Tether((x, 0.0, 0.0), (3.5 * x, 0.0, 0.0), 2, 500.0, 0.1, tip_mass=0.1) for x in (0.4, -0.4)]
    stages = (Stage("held", 0.2), Stage("let go", 0.2, without=("hold",)))
    sim = Simulation(replace(flown(BODY), stages=stages, parts=[*cords, Fixed([2], name="hold")]))
    before, changes = sim.angular_momentum().in_space, []
    for instant in (0.2 - 1e-9, 0.2, 0.4):
        sim.reach(instant)
        changes.append(np.linalg.norm(sim.angular_momentum().in_space - before))
    assert max(changes) < 1e-9 * np.linalg.norm(before)


def test_a_hub_may_be_let_go_from_its_axis() -> None:
    free = {"laws.spin.inertia": 9.0, "laws.spin.mass": 30.0, "laws.spin.transverse_inertia": 6.0}
    sim = Simulation(flown(Spin(0.2), (Stage("driven", 0.5), Stage("free", 0.5, set=free))))
    sim.reach(0.5)
    attitude = sim.hub_attitude
    assert attitude == pytest.approx([math.cos(0.5 * sim.hub_angle), 0.0, 0.0, math.sin(0.5 * sim.hub_angle)])
    sim.reach(1.0)
    assert 0.0 < sim.nutation_angle < 0.2


def test_pictures_from_outside_show_the_tilt(tmp_path: Path) -> None:
    run = membrane_rs.run(flown(BODY), out=tmp_path / "run")
    folder = tmp_path / "run" / "snapshots"
    names = sorted(path.name for path in folder.glob("*.png"))
    fixed, turning = ([name for name in names if name.startswith(view + "-")] for view in ("fixed", "turning"))
    assert len(fixed) == len(turning) > 1
    last = [(folder / some[-1]).read_bytes() for some in (fixed, turning)]
    assert last[0] != last[1]
    assert run.frames[-1].attitude is not None


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ({"mass": 1.0}, "Spin.mass = 1.0: belongs to a hub .* give its inertia and transverse_inertia too"),
        ({"inertia": 1.0, "mass": 1.0}, "Spin.mass = 1.0: .* give its transverse_inertia too"),
        ({"inertia": 1.0, "transverse_inertia": 1.0}, "Spin.transverse_inertia = 1.0: .* give its mass too"),
        ({"inertia": 1.0, "tumble": 0.1}, "Spin.tumble = 0.1: .* give its mass and transverse_inertia too"),
        ({"inertia": 2.1, "mass": 1.0, "transverse_inertia": 1.0}, "at least half of the inertia, 1.05"),
        ({"inertia": 1.0, "mass": -1.0, "transverse_inertia": 1.0}, "mass"),
        ({"inertia": 1.0, "mass": 1.0, "transverse_inertia": 1.0, "torque": 1.0}, "torque"),
    ],
)
def test_half_a_body_is_refused(values: dict[str, Any], expected: str) -> None:
    with pytest.raises((InputError, TypeError), match=expected):
        Spin(0.2, **values)


@pytest.mark.parametrize("integrator", ["leapfrog", "rk4"])
def test_damping_between_sail_and_hub_takes_no_momentum(integrator: str) -> None:
    scene = flown(BODY, integrator=integrator)
    sim = Simulation(replace(scene, laws=[*scene.laws, MassDamping(1.0)]))
    before = sim.angular_momentum().in_space
    sim.reach(1.0)
    assert np.linalg.norm(sim.angular_momentum().in_space - before) < 1e-7 * np.linalg.norm(before)
    ledger = sim.ledger()
    assert ledger["work_by_law"]["mass_damping"] < 0.0
    assert abs(ledger["error"]) < 1e-3


def test_the_nutation_of_the_scene_is_that_of_its_equation() -> None:
    """The slowest mode of the tilt, by its phase over forty seconds."""
    scene = scenes.load("nutating-hub").with_values({"laws.spin.tumble": 1e-4})
    across, along, arm, link, mass = 61.0, 91.0, 0.8, 6.0, 2.0
    ratio, kappa = (arm + link) / link, mass * (arm + link) ** 2 * arm / (2.0 * link)
    tilt = np.polymul(np.polymul([-across, along, kappa], [1.0]), [1.0, -2.0, 1.0 - ratio])
    modes = np.sort(np.roots(np.polyadd(tilt, [kappa * (ratio - 1.0)])).real)
    sim, found = Simulation(scene), []
    for time in np.arange(0.0, 200.0, 0.1):
        sim.reach(float(time))
        x, y, _ = sim.hub_rotation[:, 2]
        found.append(x + 1j * y)
    signal, times = np.array(found), np.arange(len(found)) * 0.1
    window = np.sin(np.pi * times / times[-1]) ** 2
    for mode in modes[np.abs(modes) > 0.05]:
        near = mode + np.linspace(-0.02, 0.02, 81)
        heights = np.abs(np.exp(-1j * np.outer(near, times)) @ (window * (signal - signal.mean())))
        assert near[heights.argmax()] == pytest.approx(mode, abs=5e-3)


def test_torque_of_a_motor_turns_a_body() -> None:
    spin = Spin(0.0, inertia=9.0, mass=30.0, transverse_inertia=6.0, torque=Schedule((0.0,), (0.9,)))
    sim = Simulation(
        replace(flown(spin), parts=[Tether((1.0, 0.0, 0.0), (2.0, 0.0, 0.0), 1, 500.0, 0.0, tip_mass=1e-9)]), dt=1e-6
    )
    sim.reach(1e-3)
    assert sim.hub_rate == pytest.approx(0.9 / 9.0 * 1e-3, rel=1e-6)
    assert sim.hub_motor().power == pytest.approx(0.9 * sim.hub_rate)


def test_a_tumble_is_that_of_the_start_alone() -> None:
    """In later stages it has no effect, and is refused there; what the first stage sets changes no energy later."""
    later = Stage("later", 0.1, set={"laws.spin.tumble": 1.0})
    words = r"stages\[1\]: laws.spin.tumble = 1.0: has no effect: a hub goes on at the rates that it has; leave it out"
    driven = replace(BODY, inertia=None, mass=None, transverse_inertia=None, tumble=None)
    of_body = {f"laws.spin.{name}": getattr(BODY, name) for name in ("inertia", "mass", "transverse_inertia")}
    freed = replace(later, set={**of_body, "laws.spin.tumble": 1.0})
    for spin, stage in ((BODY, later), (driven, freed)):
        with pytest.raises(InputError, match=words):
            Simulation(flown(spin, (Stage("first", 0.1), stage)))
    first, last = Stage("first", 0.1, set={"laws.spin.tumble": 1.0}), Stage("last", 0.1)
    scene = flown(replace(BODY, tumble=None), (first, last))
    assert scene.staged(1).law("spin") == replace(BODY, tumble=1.0)
    sim = Simulation(scene)
    sim.run()
    assert sim.is_over
    assert sum(map(abs, sim.ledger()["changes"].values())) < 1e-9 * sim.energies()["kinetic"]
    taken = dict.fromkeys(("laws.spin.mass", "laws.spin.transverse_inertia", "laws.spin.tumble"))
    about_axis = flown(BODY, (Stage("first", 0.1), Stage("axis", 0.1, set=taken)))
    assert about_axis.staged(1).law("spin") == Spin(0.2, inertia=9.0)


def test_a_tumble_that_is_hardly_meant_is_doubted() -> None:
    def doubts(tumble: float) -> list[str]:
        findings = audit(flown(replace(BODY, tumble=tumble)), costly=False).findings
        return [finding.message for finding in findings if finding.kind == "implausible_value"]

    assert doubts(0.02) == []
    for sign in (1.0, -1.0):
        assert "laws.spin.tumble = 1000 Hz: the rim, 2 m from the axis, would move at" in doubts(1e3 * sign)[0]


def test_a_tilted_body_does_not_go_on_upright() -> None:
    tilted = Simulation(flown(BODY))
    tilted.reach(0.5)
    for spin in (Spin(0.2), Spin(0.2, inertia=9.0)):
        with pytest.raises(InputError, match=r"tilt of the hub.* six degrees of freedom"):
            Simulation(flown(spin), start=tilted)
    gone: dict[str, Any] = dict.fromkeys(("laws.spin.mass", "laws.spin.transverse_inertia", "laws.spin.tumble"))
    staged = Simulation(flown(BODY, (Stage("body", 0.1), Stage("upright", 0.1, set=gone))))
    with pytest.raises(InputError, match="tilt of the hub"):
        staged.reach(0.2)
