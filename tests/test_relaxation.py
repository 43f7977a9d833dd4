"""Relaxation: at the instant of the start, whatever depends on time; to rest, or with a warning."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from membrane_rs import (
    AirDrag,
    Creases,
    Fixed,
    Gravity,
    MassDamping,
    Pressure,
    RunSettings,
    Scene,
    Simulation,
    Spin,
    SpringDamping,
    Springs,
    Tether,
    Tethers,
    Triangles,
    scenes,
)
from membrane_rs.folding import Disc, SquareSail, Strip
from membrane_rs.scene.laws import Law
from membrane_rs.simulation.methods import integrators
from membrane_rs.simulation.relaxation import AT_REST, FrozenStepper, held_scene
from small_scenes import RUBBER

ACROSS = Gravity((3.0, -2.0, 1.0))
"""Gravity with a part across the axis, whose direction turns with time."""


def tether(*laws: Law) -> Scene:
    """One spring of 0.3 m from a hub to a tip of 10 g."""
    cord = Tether((0.1, 0.0, 0.0), (0.4, 0.0, 0.0), 1, 50.0, 0.0, tip_mass=0.01)
    return Scene(None, None, [SpringDamping(0.1), *laws], [cord], run=RunSettings(until=0.1))


def disc(film: Law, *laws: Law) -> Scene:
    """A rubber ring that a hub holds."""
    mesh = Disc(0.1, 2, hub_radius=0.03).mesh()
    return Scene(mesh, RUBBER, [film, SpringDamping(0.1), *laws], [Fixed("centre")], run=RunSettings(until=0.1))


def folded(*laws: Law) -> Scene:
    """A bent strip with a crease."""
    mesh = Strip(0.1, 0.04, 6, 2, creases=(0.5,)).mesh()
    return Scene(mesh, RUBBER, [Springs(), SpringDamping(), Creases(1e3), *laws], [Fixed("start")])


def left(sim: Simulation) -> float:
    """Largest net force on a free node, relative to the largest force of one law on a node."""
    free = np.setdiff1d(np.arange(sim.node_count), sim.assembly.fixed)
    laws = [law.kind for law in sim.scene.laws]
    largest = max(float(np.linalg.norm(sim.forces(law)[free], axis=1).max()) for law in laws)
    return float(np.linalg.norm(sim.forces()[free], axis=1).max()) / largest


@pytest.mark.parametrize("acceleration", [0.0, 0.5, -0.5, 1.0])
def test_a_tether_is_relaxed_at_the_rate_of_the_start(acceleration: float) -> None:
    sim = Simulation(tether(Spin(1.0, acceleration)))
    sim.relax(8.0, 8.0)
    tension = 50.0 * float(sim.spring_strains()[0])
    x, y, _ = sim.positions[1]
    omega, change = 2 * math.pi, 2 * math.pi * acceleration
    # About the clamp at (0.1, 0): no net moment of the centrifugal force and of Euler's.
    fx, fy = omega**2 * x + change * y, omega**2 * y - change * x
    assert (x - 0.1) * fy == pytest.approx(y * fx, abs=1e-4 * abs(x * fx))
    assert tension == pytest.approx(0.01 * math.hypot(fx, fy), rel=1e-4)
    assert (sim.time, sim.hub_angle) == (0.0, 0.0)


@pytest.mark.parametrize(
    "scene",
    [
        lambda: tether(Spin(1.0, 3.0), ACROSS),
        lambda: tether(Spin(-2.0, 0.5), MassDamping(1.0)),
        lambda: disc(Springs(), Spin(2.0, 1.0), ACROSS),
        lambda: disc(Triangles(), Spin(3.0, -2.0), ACROSS, Pressure(1.0)),
        lambda: disc(Springs(), Spin(3.0), AirDrag(pressure=1e4)),
        lambda: folded(Spin(2.0, 1.0), ACROSS),
    ],
)
def test_a_relaxed_scene_has_no_net_force_on_a_free_node(scene: Callable[[], Scene]) -> None:
    sim = Simulation(scene())
    sim.relax(8.0, 8.0)
    assert left(sim) < 1e-3


@pytest.mark.parametrize("method", list(integrators()))
def test_so_it_is_by_every_method(method: str) -> None:
    base = tether(Spin(1.0, 1.0), ACROSS)
    sim = Simulation(replace(base, run=replace(base.run, tolerance=1e-7)), method)
    sim.relax(8.0, 8.0)
    assert left(sim) < 1e-3
    sim.step()


def test_nothing_of_the_run_is_frozen() -> None:
    sim = Simulation(tether(Spin(1.0, 0.5), ACROSS))
    sim.relax(8.0, 8.0)
    sim.run(until=0.1)
    assert sim.hub_angle == pytest.approx(2 * math.pi * (0.1 + 0.25 * 0.01))


def test_work_balances_while_the_hub_is_frozen() -> None:
    # Neither the turning of gravity nor the change of Omega is work; the force of Euler is.
    scene = tether(Spin(1.0, 2.0), ACROSS)
    # So short that the error of the method is far below the bound.
    held = FrozenStepper(replace(scene, run=replace(scene.run, dt=1e-3)), "rk4", 0.3)
    angle = held.hub_angle
    held.step(2000)
    assert held.hub_angle == angle == pytest.approx(2 * math.pi * (0.3 + 0.09))
    assert abs(held.ledger()["error"]) < 1e-6
    assert abs(held.ledger()["work_by_law"]["spin"]) > 1e-4
    assert "gravity" not in held.ledger()["work_by_law"]


@pytest.mark.parametrize(("duration", "rate"), [(2.0, 20.0), (0.02, 20.0), (0.2, 1e4), (0.5, 0.1)])
@pytest.mark.parametrize("acceleration", [0.0, 0.5, -0.5])
def test_relaxation_goes_on_until_rest_whatever_the_rate(acceleration: float, duration: float, rate: float) -> None:
    sim = Simulation(tether(Spin(1.0, acceleration), ACROSS))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sim.relax(duration, rate)
    assert left(sim) < AT_REST
    assert not sim.velocities.any()
    assert sim.time == 0.0


@pytest.mark.parametrize("method", list(integrators()))
@pytest.mark.parametrize("name", ["hanging-strip", "spinning-disc", "spinning-tether"])
def test_so_do_built_in_scenes_by_every_method(name: str, method: str) -> None:
    sim = Simulation(scenes.load(name), method)
    sim.relax(0.02, 100.0)
    assert left(sim) < AT_REST


def test_rest_without_any_force_is_rest() -> None:
    sim = Simulation(scenes.load("single-crease"))
    free = np.setdiff1d(np.arange(sim.node_count), sim.assembly.fixed)
    bent = np.linalg.norm(sim.forces("creases")[free], axis=1).max()
    sim.relax(0.02, 100.0)
    assert np.linalg.norm(sim.forces()[free], axis=1).max() < 1e-6 * bent


def test_what_is_at_rest_after_the_duration_is_left_as_it_is() -> None:
    scene = tether(Spin(1.0), ACROSS)
    held = FrozenStepper(held_scene(scene, 8.0), "rk4", 0.0)
    held.reach(8.0)
    sim = Simulation(scene)
    assert sim.relax(8.0, 8.0) == np.linalg.norm(held.velocities, axis=1).max()
    assert (sim.positions == held.positions).all()


@pytest.mark.filterwarnings("ignore::membrane_rs.errors.AuditWarning")
def test_a_scene_without_a_state_of_rest_says_so() -> None:
    words = r"not at rest after 2 s at rate = 20 1/s.* kinetic damping.*node 1 has a net force of .* N.*relax longer"
    with pytest.warns(UserWarning, match=words):
        Simulation(tether(Spin(1.0, 4.0))).relax(2.0, 20.0)
    falling = disc(Springs(), Gravity((0.0, 0.0, -1.0)))
    with pytest.warns(UserWarning, match=r"not at rest after 0\.02 s at rate = 100 1/s and .* s of kinetic damping"):
        Simulation(replace(falling, parts=[])).relax(0.02, 100.0)


def test_a_scene_that_passes_through_its_balance_is_not_at_rest() -> None:
    # A mass on a spring, k = 100 N/m, damped by 1/s, when it first swings through the point where it would hang still.
    cord = Tether((0.0, 0.0, 0.0), (0.0, 0.0, -1.0), 1, 100.0, 0.0, tip_mass=1.0)
    sim = Simulation(Scene(None, None, [Gravity((0.0, 0.0, -9.81))], [cord]))
    rate = math.sqrt(100.0 - 0.25)
    # There it moves at 0.8 m/s, so that relaxation goes on.
    assert sim.relax((math.pi - math.atan2(rate, 0.5)) / rate, 1.0) < 0.1
    assert left(sim) < 0.01


def test_friction_too_weak_for_the_step_is_no_obstacle() -> None:
    # At 1/s a shut crease vibrates until the monitor stops it; kinetic damping brings it to rest from the start.
    sim = Simulation(scenes.load("single-crease"))
    driving = np.abs(sim.forces()).max()
    assert sim.relax(0.1, 1.0) < 1e-3
    assert np.abs(sim.forces()).max() < 1e-3 * driving


def test_guide_bars_hold_the_force_that_drives_the_release() -> None:
    mesh = SquareSail(fold_lines=3, rows=4, columns=4).mesh()
    laws: list[Law] = [Springs(), SpringDamping(), Spin(3.0, 1.0)]
    sim = Simulation(Scene(mesh, RUBBER, laws, [Tethers(segments=2, axial_stiffness=17.0)]))
    start = sim.positions
    sim.relax(0.5, 40.0)
    bars = sim.assembly.node_sets["guide_bars"]
    assert (sim.positions[bars] == start[bars]).all()
    free = np.setdiff1d(np.arange(sim.node_count), [*sim.assembly.fixed, *bars])
    forces = np.linalg.norm(sim.forces(), axis=1)
    assert forces[free].max() < 0.02 * forces[bars].max()
