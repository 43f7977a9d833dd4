"""The comparison with MuJoCo and Newton: what it needs of itself, and with them installed that all agree."""

from __future__ import annotations

import math
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from marked import MarkedPart
from membrane_rs import Simulation, scenes
from membrane_rs.study.common.run import study_case
from peers import deployment, measure, ours, picture, problem, report, speed, work_precision
from peers.neo_hookean import NeoHookean
from peers.problem import Problem
from peers.program import Program

BENCHMARKS = Path(__file__).parent.parent / "benchmarks"


@pytest.fixture(scope="module")
def small() -> Problem:
    return replace(problem.square(6), until=0.02, instants=10)


def test_the_square_is_whole(small: Problem) -> None:
    mesh = small.mesh
    assert (mesh.node_count, len(mesh.triangles)) == (49, 72)
    assert mesh.areas().sum() == pytest.approx(0.04)
    assert {tuple(corner) for corner in np.abs(mesh.reference[mesh.node_sets["corners"]])} == {(0.1, 0.1, 0.0)}
    # Diagonals alternate: an inner node has four or eight neighbours, in turn.
    neighbours = np.bincount(mesh.edges.ravel(), minlength=49).reshape(7, 7)[1:-1, 1:-1]
    assert sorted(set(neighbours.ravel().tolist())) == [4, 8]
    assert (neighbours[:, 1:] != neighbours[:, :-1]).all()


def test_masses_and_energy_are_those_of_membrane_rs(small: Problem) -> None:
    sim = Simulation(small.scene("triangles"))
    sim.velocities = small.velocities
    np.testing.assert_allclose(sim.masses, small.masses, rtol=1e-14)
    assert sim.energies()["kinetic"] == pytest.approx(small.kinetic_energy(small.velocities), rel=1e-12)
    assert small.masses.sum() == pytest.approx(1000.0 * 2e-4 * 0.04 + 4 * 1e-4)


def test_the_flat_sail_is_model_1_unfolded() -> None:
    sail = problem.sail()
    assert np.ptp(sail.mesh.reference[:, 2]) == 0.0
    assert len(sail.mesh.triangles) == 3456
    assert sail.spin == pytest.approx(2 * math.pi * 3)
    assert sail.masses.sum() > sail.mesh.masses(sail.material).sum()


def test_error_is_one_without_elasticity_and_nought_against_itself(small: Problem) -> None:
    motion = small.rigid * (1.0 + 0.01 * np.arange(1, 11)[:, None, None])
    assert small.error(motion, motion) == 0.0
    assert small.error(small.rigid, motion) == pytest.approx(1.0)
    assert small.error(motion + 0.1 * (motion - small.rigid), motion) == pytest.approx(0.1)


def test_corner_peak_is_found_between_instants(small: Problem) -> None:
    times = (np.arange(10) + 1) * small.interval
    stretch = 0.01 - ((times - 0.0073) / 0.05) ** 2
    found = small.corner_peak(small.rigid * (1.0 + stretch)[:, None, None])
    assert found == pytest.approx((0.01, 0.0073))
    assert all(math.isnan(value) for value in small.corner_peak(small.rigid * (1.0 + times)[:, None, None]))


def test_neo_hookean_forces_are_the_slope_of_the_energy(small: Problem) -> None:
    law = NeoHookean(small)
    rng = np.random.default_rng(5)
    x = small.mesh.reference * [1.02, 0.99, 1.0] + 1e-3 * rng.standard_normal(small.mesh.reference.shape)
    way = rng.standard_normal(x.shape)
    slope = (law.energy(x + 1e-6 * way) - law.energy(x - 1e-6 * way)) / 2e-6
    assert -np.vdot(law.forces(x), way) == pytest.approx(slope, rel=1e-6)
    assert np.abs(law.forces(small.mesh.reference)).max() < 1e-14


def test_neo_hookean_film_is_that_of_membrane_rs_at_small_strain(small: Problem) -> None:
    sim = Simulation(small.scene("triangles"))
    apart = []
    for strain in (1e-3, 1e-4):
        rng = np.random.default_rng(6)
        x = small.mesh.reference + strain * 0.03 * rng.standard_normal((49, 3)) * [1.0, 1.0, 0.0]
        sim.positions = x
        forces = sim.forces("triangles")
        apart.append(np.linalg.norm(NeoHookean(small).forces(x) - forces) / np.linalg.norm(forces))
    assert apart[1] < 1e-3
    assert apart[1] == pytest.approx(apart[0] / 10, rel=0.2)


def test_largest_steps_are_those_predicted(small: Problem) -> None:
    for program in ours.programs(small, "triangles")[:2]:
        assert program.limit_guess
        assert measure.largest_step(program, small) == pytest.approx(program.limit_guess, rel=0.03), program.name


def test_costs_are_read_between_steps() -> None:
    levels = [measure.RefinementLevel(dt, 1, 1.0 / dt, dt**2) for dt in (1.0, 0.5, 0.25)]
    assert work_precision.seconds_at(levels, 0.5**2) == pytest.approx(2.0)
    assert work_precision.seconds_at(levels, 0.3**2) == pytest.approx(1 / 0.3)
    assert work_precision.seconds_at(levels, 10.0) == 1.0
    assert math.isnan(work_precision.seconds_at(levels, 1e-3))
    assert work_precision.measured_order([measure.RefinementLevel(2.0, 1, 0.5, 4.0), *levels]) == pytest.approx(2.0)


def page(drawn: work_precision.WorkPrecision, small: Problem) -> str:
    """The report, with made-up times."""
    names = [("membrane_rs rk4", "triangles"), ("membrane_rs leapfrog", "triangles"), ("membrane_rs rk4", "springs")]
    names += [("membrane_rs leapfrog", "springs"), ("MuJoCo RK4", "triangles"), ("Newton semi-implicit", "springs")]
    steps = (4e-5, 1e-5, 2e-5, 5e-6, 1e-3, 1e-4)
    paces = [speed.Pace(*name, 64, step, 8e-6) for name, step in zip(names, steps, strict=True)]
    apart, spreads = {"rate": 0.01, "phase": 9.0}, {"rate": 0.02, "phase": 8.0}
    done = deployment.Deployment(4.5e-6, 5e-6, 177778, deployment.Timed(5.0, 1e-3), 2e-6, apart, spreads)
    fast = deployment.FastDeployment(4e-5, 4, 10.0, 20000, deployment.Timed(0.5, 2e-3))
    timed = speed.Speed(small, paces, {"rk4": 1e-4, "leapfrog": 2.5e-5}, "avx2", done, fast)
    return report.text(drawn, timed, {"somebody": "1.0"})


def test_the_spread_is_read_from_the_studies() -> None:
    spreads = deployment.spreads(MarkedPart(deployment.STUDIES, "deployment-work-precision").read())
    assert 0.0 < spreads["rate"] < 0.1
    assert 0.0 < spreads["phase"] < 90.0
    with pytest.raises(ValueError, match="make accuracy"):
        deployment.spreads("no chart")


def other(small: Problem) -> Program:
    """A program to take turns with."""
    program: Program = ours.programs(small, "triangles")[0]
    program.start(2e-6)
    return program


def test_the_deployment_is_run_and_compared(small: Problem) -> None:
    done = deployment.deploy(scenes.load("okuizumi-model-1"), other(small), until=5e-3)
    assert done.steps * done.dt == pytest.approx(5e-3)
    assert done.dt == pytest.approx(0.9 * done.limit, rel=0.3)
    assert done.is_within
    assert 0.0 < done.errors["rate"] < 1e-3


class Logged:
    """A program whose steps take a second each, by a clock of its own, more of them in each repeat."""

    def __init__(self, clock: list[float]) -> None:
        self.clock, self.steps = clock, []  # type: ignore[var-annotated]

    def step(self, n: int) -> None:
        """Take n steps."""
        self.steps.append(n)
        self.clock[0] += n * (1.0 + len(self.steps) // 4)


def test_programs_take_turns_and_the_median_ratio_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = [0.0]
    monkeypatch.setattr(deployment, "REPEATS", 3)
    monkeypatch.setattr("peers.deployment.time.process_time", lambda: clock[0])
    monkeypatch.setattr(Simulation, "reach", lambda _, __: clock.__setitem__(0, clock[0] + 0.5))
    logged = Logged(clock)
    case = study_case(scenes.load("spinning-tether"), 0.4, 4)
    found = deployment.in_turns(case, "rk4", 1e-5, logged)  # type: ignore[arg-type]
    assert logged.steps == [deployment.SLICE] * 12
    # Half a second to each of four instants of 0.4 s, and steps of one second to three and more.
    assert found.processor == pytest.approx(4.0)
    assert found.other == pytest.approx((3 * 2.0 + 3.0) / 4)


def test_the_fast_scene_is_run_and_timed_in_turns(small: Problem) -> None:
    done = deployment.deploy_fast(other(small), until=8e-3)
    assert done.steps * done.dt == pytest.approx(8e-3)
    assert done.softening > 1.0
    assert done.substeps > 1
    assert 0.0 < done.timed.other < done.timed.processor


def test_report_and_picture(small: Problem, tmp_path: Path) -> None:
    own: list[Program] = [*ours.programs(small, "triangles"), *ours.programs(small, "springs")]
    drawn = work_precision.measure(small, own, levels=3)
    for refinement in drawn.refinements:
        errors = [level.error for level in refinement.levels]
        assert errors[0] > errors[1] > errors[2] > 0.0, refinement.program.name
    words = page(drawn, small)
    assert "| RK4 step | flat, triangles | MuJoCo RK4, flat, triangles | 18 | 25 | reached |" in words
    assert "| leapfrog step | flat, springs | Newton semi-implicit, flat, springs | 40 | 20 | not reached |" in words
    assert "MuJoCo RK4, flat, triangles: 100 s | 60 | 20 | not reached |" in words
    assert (
        "| okuizumi-model-1-fast, 40.00 us a step: 0.5 s | MuJoCo RK4, flat, triangles: 200 s | 96 | 400 | reached |"
        in words
    )
    assert "**beyond** the spread" in " ".join(words.split())
    assert all(len(line) <= 118 for line in words.splitlines() if not line.startswith(("|", "!")))
    picture.draw(drawn, tmp_path / "chart.png")
    assert (tmp_path / "chart.png").read_bytes().startswith(b"\x89PNG")


def test_without_peers_it_says_what_to_do() -> None:
    code = "import sys; sys.modules['mujoco'] = None; from peers.__main__ import main; sys.exit(main())"
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=BENCHMARKS, capture_output=True, text=True, check=False, timeout=60
    )
    assert done.returncode == 1
    assert "make peers" in done.stderr
    assert "Traceback" not in done.stderr


def test_mujoco_moves_as_membrane_rs_does(small: Problem) -> None:
    pytest.importorskip("mujoco")
    from peers import mujoco_flex

    euler, rk4, discrete = mujoco_flex.programs(small, {"rk4": 1e-3, "leapfrog": 1e-3})
    own_rk4, leapfrog, _ = ours.programs(small, "triangles")
    converged, _ = measure.shapes_of(own_rk4, small, 60)
    assert small.error(measure.shapes_of(rk4, small, 60)[0], converged) < 1e-7
    np.testing.assert_allclose(rk4.masses(), small.masses, rtol=1e-14)
    # From a start without elastic force symplectic Euler takes leapfrog's positions.
    coarse, _ = measure.shapes_of(leapfrog, small, 4)
    assert small.error(measure.shapes_of(euler, small, 4)[0], coarse) < 1e-9
    assert small.error(measure.shapes_of(discrete, small, 40)[0], converged) < 0.5


def test_newton_moves_as_membrane_rs_does(small: Problem) -> None:
    pytest.importorskip("newton")
    from peers import newton_cloth

    for law, converged in (
        ("springs", measure.shapes_of(ours.programs(small, "springs")[0], small, 60)[0]),
        ("neo-Hookean", NeoHookean(small).shapes(20)),
    ):
        cloth = newton_cloth.Cloth(small, "semi-implicit", law, None)
        assert small.error(measure.shapes_of(cloth, small, 25)[0], converged) < 2e-3, law
        np.testing.assert_allclose(cloth.masses(), small.masses, rtol=1e-6)
        # Steps one by one, and in graphs of one, two and twenty, are the same steps.
        plain = newton_cloth.Cloth(small, "semi-implicit", law, None, plain=True)
        for program in (cloth, plain):
            program.start(1e-4)
            program.step(43)
        np.testing.assert_array_equal(cloth.motion()[0], plain.motion()[0])
