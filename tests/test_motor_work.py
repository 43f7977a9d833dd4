"""The work of the motor that turns the hub: cases by hand, the torque on the hub, energy in inertial space, orders."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from membrane_rs import (
    AirDrag,
    Fixed,
    Gravity,
    MassDamping,
    Moved,
    Pressure,
    RunSettings,
    Scene,
    Schedule,
    Simulation,
    SolarPressure,
    Spin,
    SpringDamping,
    Springs,
    Stage,
    Tether,
    resume,
)
from membrane_rs.folding import Disc, Strip
from membrane_rs.results import read_history, read_summary
from methods import METHODS, ORDER, WAYS
from small_scenes import FILM, RUBBER

UP = Schedule((0.02, 0.12), (1.0, 4.0), 0.5)
"""A spin-up [s, Hz]."""


def whirled(spin: Spin, *more: Any, stages: tuple[Stage, ...] = (), **run: Any) -> Scene:
    """A mass on a cord that a hub turns."""
    tether = Tether((0.1, 0.0, 0.0), (0.2, 0.0, 0.0), 2, 17.0, 1e-3, tip_mass=0.05, strain_limit=10.0)
    return Scene(None, None, [spin, *more], [tether], stages=stages, run=RunSettings(**run))


def flag(*more: Any, **run: Any) -> Scene:
    """A strip of rubber held at one end, off the axis of a hub that speeds up."""
    laws = [Springs(), SpringDamping(), Spin(schedule=UP), *more]
    mesh = Strip(0.1, 0.04, 4, 2, creases=(0.5,)).mesh()
    return Scene(mesh, RUBBER, laws, [Fixed("start")], run=RunSettings(**run))


def rate_of(sim: Simulation, spin: Schedule) -> float:
    """Omega [rad/s]."""
    return 2.0 * math.pi * spin.at(sim.time)


def energy_in_space(sim: Simulation, omega: float) -> float:
    """Kinetic energy in inertial space, and the potential energies but for the centrifugal one [J]."""
    (x, y, _), (u, v, w) = sim.positions.T, sim.velocities.T
    kinetic = 0.5 * float(sim.masses @ ((u - omega * y) ** 2 + (v + omega * x) ** 2 + w**2))
    return kinetic + math.fsum(energy for name, energy in sim.energies().items() if name not in ("kinetic", "spin"))


@pytest.mark.parametrize(("method", "substeps"), WAYS)
def test_held_mass_is_spun_up_by_half_its_inertia(method: str, substeps: int) -> None:
    """1/2 I (w1^2 - w0^2), by the quadrature of the method."""
    cord = Tether((0.1, 0.0, 0.0), (0.3, 0.0, 0.0), 1, 17.0, 0.0, tip_mass=0.05, strain_limit=10.0)
    errors = []
    for dt in (2e-3, 1e-3):
        scene = Scene(None, None, [Spin(schedule=UP)], [cord, Fixed((1,))], run=RunSettings(substeps=substeps))
        sim = Simulation(scene, method, dt=dt)
        sim.reach(0.15)
        expected = 0.5 * 0.05 * 0.3**2 * (2.0 * math.pi) ** 2 * (4.0**2 - 1.0)
        errors.append(abs(sim.ledger()["motor_work"] - expected))
    assert errors[1] < 1e-3 * expected
    assert errors[1] < 1e-12 or math.log2(errors[0] / errors[1]) > ORDER[method] - 0.7


def test_mass_on_a_stiff_tether_that_is_spun_up_and_stopped() -> None:
    """It takes half its inertia times the square of the rate, and gives it back; the swing is small beside it."""
    found = []
    for schedule in (Schedule((0.1, 8.1), (3.0, 5.0), 0.5), Schedule((0.1, 8.1, 8.3, 16.3), (3.0, 5.0, 5.0, 3.0), 0.5)):
        tether = Tether((0.1, 0.0, 0.0), (0.2, 0.0, 0.0), 1, 1e4, 0.0, tip_mass=0.05, strain_limit=10.0)
        sim = Simulation(Scene(None, None, [Spin(schedule=schedule)], [tether]), "dopri5")
        sim.reach(schedule.times[-1] + 0.1)
        found.append(sim.ledger()["motor_work"])
    gained = 0.5 * 0.05 * 0.2**2 * (2.0 * math.pi) ** 2 * (5.0**2 - 3.0**2)
    assert found[0] == pytest.approx(gained, rel=2e-2)
    assert abs(found[1]) < 1e-2 * gained


@pytest.mark.parametrize("method", METHODS)
def test_free_film_in_steady_turning_needs_no_motor(method: str) -> None:
    sim = Simulation(Scene(Disc(0.1, 2).mesh(), RUBBER, [Springs(), SpringDamping(), Spin(3.0)]), method, dt=2e-5)
    start = sim.velocities.copy()
    start[:, 2] = 0.1 * np.sin(20.0 * sim.positions[:, 0])
    sim.velocities = start
    sim.step(500)
    assert abs(sim.ledger()["motor_work"]) < 1e-6 * abs(sim.energies()["spin"])


def test_hub_at_rest_has_no_motor_work() -> None:
    tether = Tether((0.1, 0.0, 0.0), (0.2, 0.0, 0.0), 2, 17.0, 1e-3, tip_mass=0.05, strain_limit=10.0)
    sim = Simulation(Scene(None, None, [Gravity((0.0, 1.0, 0.0))], [tether]))
    sim.reach(0.1)
    assert sim.ledger()["motor_work"] == 0.0


RISING = Schedule((0.0, 0.06, 0.2), (0.2, 1.5, -1.0), 0.5)
"""Of a load [s, -]."""
LOADS: dict[str, tuple[Any, ...]] = {
    "nothing": (),
    "weight across the axis": (Gravity((0.5, -0.3, -1.0)),),
    "friction of the frame": (MassDamping(2.0),),
    "air at rest": (AirDrag(pressure=1e6),),
    "air that turns": (AirDrag(pressure=1e6, air="turning"),),
    "pressure": (Pressure(0.5),),
    "weight that rises": (Gravity((0.5, -0.3, -1.0), factor=RISING),),
    "sunlight": (SolarPressure(0.84, 0.04, (1.0, 0.5, 2.0), 4e8, back_specular=0.3),),
}


OUTSIDE = {
    "air at rest": "air_drag",
    "pressure": "pressure",
    "sunlight": "solar_pressure",
    "weight that rises": "gravity",
}
"""The law of a load whose work in space is that in the frame and that of its torque."""


@pytest.mark.parametrize("load", LOADS)
@pytest.mark.parametrize(("method", "substeps"), WAYS)
def test_energy_in_inertial_space_is_that_of_motor_and_loads(load: str, method: str, substeps: int) -> None:
    """E - E(0) = motor + works of laws in inertial space: those of loads from outside are their power on the velocities
    in space, of all others that relative to the hub.
    """
    errors, sizes = [], []
    for dt in (2e-4, 1e-4):
        sim = Simulation(flag(*LOADS[load], substeps=substeps, energy_loss=1e3), method, dt=dt)
        start, outside, powers = energy_in_space(sim, rate_of(sim, UP)), 0.0, []
        for k in range(round(0.1 / dt) + 1):
            sim.reach(k * dt)
            powers.append(_torque_from_outside(sim, load) * rate_of(sim, UP))
        # By Simpson's rule, between steps of the method.
        outside = dt / 3.0 * (powers[0] + powers[-1] + 4.0 * sum(powers[1:-1:2]) + 2.0 * sum(powers[2:-1:2]))
        ledger = sim.ledger()
        by_law, weight = ledger["work_by_law"], OUTSIDE.get(load) == "gravity"
        works = math.fsum(work for law, work in by_law.items() if law != "spin" and (weight or law != "gravity"))
        gained = energy_in_space(sim, rate_of(sim, UP)) - start
        errors.append(abs(gained - works - outside - ledger["motor_work"]))
        sizes.append(abs(gained))
    assert abs(ledger["motor_work"]) > 1e-4
    assert errors[1] < 2e-3 * sizes[1]
    assert errors[1] < 2e-5 * sizes[1] or math.log2(errors[0] / errors[1]) > min(ORDER[method], 4) - 1.0


def _torque_from_outside(sim: Simulation, load: str) -> float:
    law = OUTSIDE.get(load)
    if law is None:
        return 0.0
    (x, y, _), (f, g, _) = sim.positions.T, sim.forces(law).T
    return float(np.sum(x * g - y * f))


@pytest.mark.parametrize(
    "load", ["nothing", "weight across the axis", "air at rest", "pressure", "sunlight", "weight that rises"]
)
def test_it_is_the_torque_on_the_hub_times_its_rate(load: str) -> None:
    """Summed by Simpson's rule over the steps; friction of the frame is no load on the hub."""
    dt, count = 5e-5, 2000
    sim = Simulation(flag(*LOADS[load]), "rk4", dt=dt)
    powers = []
    for k in range(count + 1):
        sim.reach(k * dt)
        powers.append(-rate_of(sim, UP) * sim.hub_load().torque[2])
    direct = dt / 3.0 * (powers[0] + powers[-1] + 4.0 * sum(powers[1:-1:2]) + 2.0 * sum(powers[2:-1:2]))
    assert sim.ledger()["motor_work"] == pytest.approx(direct, rel=1e-4)


@pytest.mark.parametrize(("method", "substeps"), WAYS)
def test_its_order_is_that_of_the_method(method: str, substeps: int) -> None:
    """In air at rest, and with weight across the axis."""
    more = (AirDrag(pressure=1e6), Gravity((0.5, -0.3, 0.0)))
    exact = Simulation(flag(*more), "rk4", dt=1e-5)
    exact.reach(0.1)
    known, errors = exact.ledger()["motor_work"], []
    for dt in (2e-4, 1e-4, 5e-5):
        sim = Simulation(flag(*more, substeps=substeps, energy_loss=1e3), method, dt=dt)
        sim.reach(0.1)
        errors.append(abs(sim.ledger()["motor_work"] - known))
    assert errors[-1] < 1e-3 * abs(known)
    assert errors[-1] < 1e-7 * abs(known) or math.log2(errors[0] / errors[-1]) > 2 * (min(ORDER[method], 4) - 0.7)


def spun(*, method: str = "rk4", **run: Any) -> Scene:
    """Spun up in the first of two stages; the second has another rate, air and no friction."""
    stages = (
        Stage("up", 0.05, without=("air_drag",), set={"laws.spin.schedule": Schedule((0.0, 0.05), (1.0, 3.0), 0.5)}),
        Stage("on", 0.05, without=("mass_damping",), scale={"material.youngs_modulus": 2.0}),
    )
    scene = flag(AirDrag(pressure=1e3), MassDamping(5.0), integrator=method, dt=1e-4, frames=3, samples=11, **run)
    return dataclasses.replace(scene, stages=stages)


def test_each_stage_has_its_own_and_the_run_their_sum(tmp_path: Path) -> None:
    sim = Simulation(spun(snapshots=()))
    sim.run(out=tmp_path / "run")
    stages, whole = sim.stages, sim.ledger()["motor_work"]
    assert [stage.motor_work for stage in stages if stage.motor_work is None] == []
    assert whole == math.fsum(stage.motor_work or 0.0 for stage in stages)
    assert stages[0].motor_work is not None
    assert stages[0].motor_work > 1e-4
    summary = read_summary(tmp_path / "run")
    assert [stage["motor_work"] for stage in summary["stages"]] == [stage.motor_work for stage in stages]
    assert summary["energy_balance"]["motor_work"] == whole
    table = read_history(tmp_path / "run")
    assert list(table)[-3:] == ["motor_work", "motor_torque", "motor_power"]
    assert table["motor_work"][[0, -1]].tolist() == [0.0, whole]
    at_boundary = int(np.searchsorted(table["time"], 0.05))
    assert table["motor_work"][at_boundary] == stages[0].motor_work


@pytest.mark.parametrize("method", METHODS)
def test_it_goes_on_from_a_saved_state_with_the_same_bits(method: str, tmp_path: Path) -> None:
    """Within either stage, and at an output between two steps."""
    whole = Simulation(spun(method=method))
    for time in (0.03005, 0.0712):
        whole.reach(time)
        whole.save(tmp_path / "state.npz")
        again = Simulation.restore(tmp_path / "state.npz")
        assert again.ledger() == whole.ledger()
        whole.reach(time + 0.01)
        again.reach(time + 0.01)
        assert again.ledger() == whole.ledger()


def older(state: dict[str, Any], sim: Simulation) -> dict[str, Any]:
    """A state as earlier versions saved it: without the motor's work, among works of the method too."""
    found = {name: value for name, value in state.items() if name not in ("motor_numbers", "stage_motor")}
    numbers, laws = state.get("history_numbers"), len(sim.law_names)
    if numbers is not None:
        copies = {"leapfrog": 1 if sim.scene.run.substeps == 1 else 2, "dopri5": 1}.get(sim.integrator, 1)
        kept = np.ones(len(numbers), dtype=bool)
        kept[[k * (laws + 1) + laws for k in range(copies)]] = False
        if sim.integrator == "dopri5" and len(numbers) > laws + 1:
            kept[-3:] = False
        found["history_numbers"] = numbers[kept]
    return found


@pytest.mark.parametrize(("method", "substeps"), WAYS)
def test_older_state_goes_on_with_the_same_motion_and_an_unknown_work(method: str, substeps: int) -> None:
    scene = whirled(Spin(schedule=UP), MassDamping(1.0), integrator=method, dt=None, substeps=substeps)
    whole = Simulation(scene)
    whole.step(100)
    again = Simulation(scene)
    again.set_state(older(whole.state(), whole))
    assert again.ledger()["motor_work"] is None
    whole.step(50)
    again.step(50)
    assert again.ledger()["motor_work"] is None
    assert np.array_equal(again.positions, whole.positions)
    assert again.ledger()["work_by_law"] == whole.ledger()["work_by_law"]
    again.set_state(again.state())
    again.positions = again.positions
    assert again.ledger()["motor_work"] == 0.0


def test_older_state_of_a_staged_run_knows_the_later_stages(tmp_path: Path) -> None:
    whole = Simulation(spun())
    whole.reach(0.02)
    again = Simulation(spun())
    again.set_state(older(whole.state(), whole))
    for one in (whole, again):
        one.reach(0.1)
    assert again.stages[0].motor_work is None
    assert again.ledger()["motor_work"] is None
    assert again.stages[1].motor_work == whole.stages[1].motor_work
    again.save(tmp_path / "state.npz")
    assert Simulation.restore(tmp_path / "state.npz").stages == again.stages


@pytest.mark.parametrize("lacking", [2, 3])
def test_older_folder_is_resumed_with_its_own_columns(lacking: int, tmp_path: Path) -> None:
    """history.csv then has no columns of the motor's torque and power, or of its work too: the summary says null."""
    out = tmp_path / "run"
    Simulation(spun(snapshots=())).run(until=0.05, out=out)
    path = out / "history.csv"
    lines = [",".join(line.split(",")[:-lacking]) + "\n" for line in path.read_text().splitlines()]
    path.write_text("".join(lines))
    resume(out, until=0.1)
    table = read_history(out)
    assert ("motor_work" in table, "motor_power" in table) == (lacking == 2, False)
    assert table["time"][-1] == 0.1
    assert (read_summary(out)["energy_balance"]["motor_work"] is None) == (lacking == 3)


@pytest.mark.parametrize("numbers", [[1.0], [np.nan, 0.0], [0.0, np.inf], "twice", [[1.0, 2.0]], [True, False]])
def test_damaged_numbers_are_refused(numbers: Any) -> None:
    sim = Simulation(whirled(Spin(3.0)))
    with pytest.raises(Exception, match="motor_numbers"):
        sim.set_state({**sim.state(), "motor_numbers": np.array(numbers)})


@pytest.mark.parametrize("motors", [[1.0, 2.0], [[1.0, np.inf]], [["1", "much"]], [[1.0]]])
def test_damaged_works_of_stages_are_refused(motors: Any) -> None:
    sim = Simulation(spun())
    sim.reach(0.06)
    with pytest.raises(Exception, match="stage_motor"):
        sim.set_state({**sim.state(), "stage_motor": np.array(motors)})


def test_film_of_the_paper_is_held_up_by_the_motor_against_air() -> None:
    """A held plate that turns steadily: the work is that against the air, Omega times its torque."""
    mesh = Strip(0.05, 0.02, 5, 2, (), 0.0).mesh()
    nodes = tuple(range(len(mesh.reference)))
    laws = [Springs(), AirDrag(pressure=1e5), Spin(3.0), Gravity((0.0, 0.0, -1.0))]
    sim = Simulation(Scene(mesh, FILM, laws, [Fixed(nodes)]), "rk4", dt=1e-4)
    (x, y, _), (f, g, _) = sim.positions.T, sim.forces("air_drag").T
    sim.reach(0.5)
    assert sim.ledger()["motor_work"] == pytest.approx(-0.5 * 2.0 * math.pi * 3.0 * np.sum(x * g - y * f), abs=1e-15)


JUMP = Schedule((0.05, 0.05), (2.0, 3.0))
"""Of the rate of the hub [s, Hz]."""


@pytest.mark.parametrize("method", METHODS)
def test_jump_of_the_rate_is_no_work_as_at_a_boundary_of_stages(method: str) -> None:
    """The same within a stage as between two, and after a saved state."""
    stages = (Stage("slow", 0.05, set={"laws.spin.frequency": 2.0}), Stage("fast", 0.05))
    staged = Simulation(whirled(Spin(3.0), MassDamping(1.0), stages=stages), method, dt=1e-4)
    sim = Simulation(whirled(Spin(schedule=JUMP), MassDamping(1.0)), method, dt=1e-4)
    staged.reach(0.1)
    for time in (0.04, 0.0712):
        sim.reach(time)
        again = Simulation(sim.scene, method, dt=1e-4)
        again.set_state(sim.state())
        again.reach(0.1)
    sim.reach(0.1)
    assert sim.ledger()["motor_work"] == pytest.approx(staged.ledger()["motor_work"], rel=1e-9)
    assert again.ledger()["motor_work"] == sim.ledger()["motor_work"] != 0.0


@pytest.mark.parametrize("displaced", [0.0, 0.01])
def test_impulse_on_moved_nodes_is_work_of_the_motor_too(displaced: float) -> None:
    """Omega times the change of their angular momentum, not what a displacement changes."""
    cord = Tether((0.1, 0.0, 0.0), (0.3, 0.0, 0.0), 1, 17.0, 0.0, tip_mass=0.05, strain_limit=10.0)
    turn = Schedule((0.0, 0.05, 0.05, 0.1), (0.0, 0.0, 0.0, 0.5))
    out = Schedule((0.05, 0.05), (0.0, displaced))
    scene = Scene(None, None, [Spin(3.0)], [cord, Moved((1,), x=out, turn=turn)])
    sim = Simulation(scene, "rk4", dt=1e-4)
    sim.reach(0.05)
    omega, speed = 2.0 * math.pi * 3.0, 0.3 * 0.5 / 0.05
    assert sim.ledger()["motor_work"] == pytest.approx(omega * 0.05 * (0.3 + displaced) * speed, rel=1e-9)
