"""Forces on nodes: closed forms, both frames, work, torque on a hub, files, and what is refused."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

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
    Springs,
    Stage,
    Tether,
    Triangles,
)
from membrane_rs.check import audit
from membrane_rs.check.redundancy import idle_laws
from membrane_rs.errors import InputError, SceneError
from membrane_rs.folding import Disc, Strip
from methods import METHODS, WAYS
from small_scenes import RUBBER, cord, rotation

STRIP = Strip(0.12, 0.04, 6, 2, creases=(0.5,)).mesh()
FORCE = (2e-3, -1e-3, 3e-3)


def pulled(*laws: Any, nodes: Any = "end", stages: tuple[Stage, ...] = (), **changes: Any) -> Scene:
    """A strip of rubber, held at its start, with a force on each node of its end."""
    forces = PointForces(nodes, FORCE, **changes)
    return Scene(STRIP, RUBBER, [Springs(), forces, *laws], [Fixed("start")], stages=stages)


@pytest.mark.parametrize("method", METHODS)
def test_a_free_mass_is_accelerated(method: str) -> None:
    """x = F t^2/(2 m) and W = F x, on one of two masses on a slack cord."""
    line = Tether((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), 1, 1e-9, 1.0, fixed=False, tip_mass=1.5, strain_limit=1e9)
    scene = Scene(None, None, [PointForces((1,), (0.0, 4.0, 0.0))], [line], run=RunSettings(energy_loss=1e3))
    sim = Simulation(scene, method, 1e-3)
    sim.reach(0.5)
    way = 4.0 / 2.0 * 0.5**2 / 2.0
    assert sim.positions == pytest.approx(np.array([[0.0, 0.0, 0.0], [1.0, way, 0.0]]), abs=1e-8)
    assert sim.ledger()["work_by_law"]["point_forces"] == pytest.approx(4.0 * way, rel=1e-6)
    assert abs(sim.ledger()["error"]) < 1e-6


def test_the_force_is_that_on_each_node_of_the_set_and_on_no_other() -> None:
    sim = Simulation(pulled())
    found = sim.forces("point_forces")
    chosen = STRIP.node_sets["end"]
    assert np.array_equal(found[chosen], np.tile(FORCE, (len(chosen), 1)))
    assert np.abs(np.delete(found, chosen, axis=0)).max() == 0.0
    assert np.array_equal(Simulation(pulled(nodes=chosen[::-1])).forces("point_forces"), found)


def test_a_cord_is_stretched_by_the_force_at_rest() -> None:
    pull = PointForces("tether-0-end", (3.0, 0.0, 0.0))
    sim = Simulation(Scene(None, None, [pull, MassDamping(20.0)], [cord()]))
    sim.reach(3.0)
    assert sim.positions[1, 0] == pytest.approx(1.0 + 3.0 / 100.0, rel=1e-8)


@pytest.mark.parametrize("frame", ["turning", "inertial"])
def test_its_direction_stays_in_its_frame(frame: Any) -> None:
    sim = Simulation(pulled(Spin(2.0, 3.0), frame=frame), "leapfrog")
    for time in (0.0, 0.02, 0.05):
        sim.reach(time)
        turn = rotation([0, 0, 1], -sim.hub_angle) if frame == "inertial" else np.eye(3)
        wanted = turn @ FORCE
        for node in STRIP.node_sets["end"]:
            assert sim.forces("point_forces")[node] == pytest.approx(wanted, abs=1e-15)
    assert sim.hub_angle > 0.5


def test_the_motion_is_the_same_in_the_turning_and_in_the_fixed_frame() -> None:
    """A free strip under forces fixed in space."""
    factor = Schedule((0.0, 0.01), (0.2, 1.5), 0.3)
    laws = [Triangles(compression=1.0), PointForces((0, 5), FORCE, "inertial", factor=factor)]
    sims = [Simulation(Scene(STRIP, RUBBER, [*laws, *spin], []), "rk4", 1e-5) for spin in ((), (Spin(3.0),))]
    resting, turning = sims
    resting.velocities = turning.velocities + 6.0 * math.pi * np.cross([0.0, 0.0, 1.0], turning.positions)
    for sim in sims:
        sim.step(2000)
    seen = turning.positions @ rotation([0, 0, 1], turning.hub_angle).T
    assert np.abs(seen - resting.positions).max() < 1e-11


@pytest.mark.parametrize(("method", "substeps"), WAYS)
@pytest.mark.parametrize("frame", ["turning", "inertial"])
def test_the_balance_closes_in_a_turning_frame(method: str, substeps: int, frame: Any) -> None:
    factor = Schedule((0.0, 0.01, 0.01, 0.02), (0.2, 1.5, -1.0, 2.0), 0.3)
    laws = [Triangles(compression=1.0), Spin(2.0, 10.0), PointForces("end", FORCE, frame, factor=factor)]
    run = RunSettings(substeps=substeps)
    sim = Simulation(Scene(STRIP, RUBBER, laws, [Fixed("start")], run=run), method, 2e-5)
    sim.reach(0.02)
    ledger = sim.ledger()
    assert abs(ledger["work_by_law"]["point_forces"]) > 1e-7
    assert abs(ledger["error"]) < 1e-4


@pytest.mark.parametrize("method", ["leapfrog", "rk4"])
@pytest.mark.parametrize("frame", ["turning", "inertial"])
def test_a_free_hub_takes_the_torque(method: str, frame: Any) -> None:
    """The angular momentum of hub and sail grows by the impulse of the torque, also of forces on what the hub holds."""
    disc = Disc(0.1, 3).mesh()
    nodes = (*disc.node_sets["rim"][:2], 1)
    laws = [Triangles(compression=1.0), Spin(2.0, inertia=1e-4), PointForces(nodes, (3e-3, 1e-3, 0.0), frame)]
    sim = Simulation(Scene(disc, RUBBER, laws, [Fixed("rim")]), method, 2e-5)
    start, torques = sim.angular_momentum().total, []
    for k in range(501):
        sim.step(min(k, 1))
        (x, y, _), (f, g, _) = sim.positions.T, sim.forces("point_forces").T
        torques.append(float(np.sum(x * g - y * f)))
    impulse = 2e-5 / 3.0 * (torques[0] + torques[-1] + 4.0 * sum(torques[1:-1:2]) + 2.0 * sum(torques[2:-1:2]))
    change = sim.angular_momentum().total - start
    assert abs(impulse) > 1e-7
    assert change == pytest.approx(impulse, rel=1e-6)
    assert abs(sim.ledger()["error"]) < 1e-5


def test_it_goes_through_files_and_stages(tmp_path: Path) -> None:
    scene = pulled(frame="inertial", factor=Schedule((0.0, 0.5), (0.0, 1.0)))
    scene.save(tmp_path)
    assert Scene.from_toml(tmp_path / "scene.toml").law(PointForces) == scene.law(PointForces)
    in_units = scene.with_values({"laws.point_forces.force": ["2 mN", "-1 mN", "3 mN"]})
    assert in_units.law(PointForces) == scene.law(PointForces)
    late = (Stage("a", 0.01), Stage("b", 0.01, set={"laws.point_forces.force": (0.0, 0.0, 1e-3)}))
    sim = Simulation(replace(pulled(), stages=late))
    sim.reach(0.015)
    assert sim.forces("point_forces")[STRIP.node_sets["end"][0]].tolist() == [0.0, 0.0, 1e-3]


@pytest.mark.parametrize(
    ("values", "error", "words"),
    [
        ({"nodes": "rim"}, SceneError, r"laws\.point_forces\.nodes = 'rim': no such node set"),
        ({"nodes": (500,)}, SceneError, r"laws\.point_forces\.nodes = .*node 500 is not there"),
        ({"nodes": ()}, InputError, r"PointForces\.nodes = .*at least one node"),
        ({"force": (0.0, math.nan, 0.0)}, InputError, r"PointForces\.force\[1\] = nan: must be finite \(N\)"),
        ({"force": 3.0}, InputError, r"PointForces\.force = 3\.0: must be three numbers"),
        ({"frame": "hub"}, InputError, r"PointForces\.frame = 'hub': must be 'turning' or 'inertial'"),
    ],
)
def test_wrong_values_are_refused_by_name(values: dict[str, Any], error: type[InputError], words: str) -> None:
    given: dict[str, Any] = {"nodes": "end", "force": FORCE} | values
    with pytest.raises(error, match=words):
        Scene(STRIP, RUBBER, [Springs(), PointForces(**given)]).assemble()


def test_what_has_no_effect_and_what_is_hardly_meant_is_said() -> None:
    for law, why in (
        (PointForces("end", (0.0, 0.0, 0.0)), "its force is 0"),
        (PointForces("end", FORCE, factor=Schedule((0.0,), (0.0,))), "its factor is 0"),
    ):
        assert (law.kind, why) in idle_laws(Scene(STRIP, RUBBER, [Springs(), law], [Fixed("start")]))
    strong = Scene(STRIP, RUBBER, [Springs(), PointForces("end", (0.0, 0.0, 500.0))], [Fixed("start")])
    doubts = [found for found in audit(strong, costly=False).warnings if "laws.point_forces.force" in found.message]
    assert ["was 500 mN meant? That is 0.5 N" in doubt.remedy for doubt in doubts] == [True]
