"""energy.png: terms of the balance that add up in each stage, and files that open."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from fake_simulation import small_sail
from membrane_rs import Cylinder, Fixed, Schedule, Simulation, Stage, scenes
from membrane_rs.plotting.energy import CHANGES, KINETIC, LEAST, MOTOR, RESIDUAL, draw_energy, since_start, term_changes
from membrane_rs.results import read_history
from membrane_rs.scene import Scene
from PIL import Image

STAGES = (
    Stage("held", 2e-4, without=("creases",)),
    Stage("stiffer", 2e-4, scale={"material.youngs_modulus": 2.0}, without=("hold",)),
    Stage("alone", 2e-4, without=("hold", "bars"), set={"laws.spin.frequency": 2.0}),
)


def staged() -> Scene:
    """A small sail that is let go, with bars that turn."""
    scene = small_sail(snapshots=(), frames=2, samples=31, dt=2e-6, integrator="leapfrog")
    bars = Cylinder("bars", 0.004, centre=(0.09, 0.0, 0.0), copies=4, turn=Schedule((0.0, 4e-4), (0.0, 0.2)))
    return replace(scene, bodies=[bars], parts=[*scene.parts, Fixed((0, 1), name="hold")], stages=STAGES)


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> tuple[Simulation, Path]:
    path = tmp_path_factory.mktemp("runs") / "run"
    sim = Simulation(staged())
    sim.run(out=path)
    return sim, path


def test_terms_of_each_stage_add_up(run: tuple[Simulation, Path]) -> None:
    """Energies have changed by the works and the residual; over the run by what stages put in, too."""
    sim, path = run
    table, whole = read_history(path), 0.0
    for k, stage in enumerate(sim.stages):
        terms = term_changes(table, sim.stages, k)
        gained = math.fsum(value for name, value in terms.items() if name == KINETIC or name.startswith("energy_"))
        gained -= terms[CHANGES]
        works = math.fsum(value for name, value in terms.items() if name.startswith("work_"))
        size = max(abs(value) for value in terms.values())
        assert gained == pytest.approx(works + terms[RESIDUAL], abs=1e-9 * size)
        assert terms[MOTOR] == stage.motor_work != 0.0
        assert terms[CHANGES] == pytest.approx(math.fsum(stage.changes.values()))
        whole += gained + terms[CHANGES]
    assert sim.stages[1].changes
    assert sim.stages[2].changes["kinetic"] != 0.0
    curves = since_start(table)
    total = sum(values[-1] for name, values in curves.items() if name == KINETIC or name.startswith("energy_"))
    assert total - curves[CHANGES][-1] == pytest.approx(whole, rel=1e-9)


def test_picture_has_a_panel_for_each_stage(run: tuple[Simulation, Path], tmp_path: Path) -> None:
    sim, path = run
    with Image.open(path / "energy.png") as picture:
        high = picture.height
        assert picture.width == 1800
        assert len(picture.convert("RGB").getcolors(2**24) or ()) > 50
    draw_energy(read_history(path), tmp_path / "curves.png", "curves alone")
    with Image.open(tmp_path / "curves.png") as picture:
        assert picture.height == 720 < high
    draw_energy(read_history(path), tmp_path / "many.png", stages=list(sim.stages) * 6)
    with Image.open(tmp_path / "many.png") as picture:
        assert picture.height < 3 * high


def test_stages_without_the_motor_and_runs_of_earlier_versions_are_drawn(
    run: tuple[Simulation, Path], tmp_path: Path
) -> None:
    sim, path = run
    table = read_history(path)
    older = {name: column for name, column in table.items() if name != MOTOR}
    stages = [replace(stage, motor_work=None) for stage in sim.stages]
    draw_energy(older, tmp_path / "older.png", stages=stages)
    draw_energy({**table, MOTOR: np.full(len(table["time"]), np.nan)}, tmp_path / "unknown.svg", stages=stages)
    assert "motor" not in (tmp_path / "unknown.svg").read_text()
    assert LEAST < 0.1


def test_scene_at_rest_is_drawn(tmp_path: Path) -> None:
    """All terms are 0."""
    Simulation(scenes.load("single-crease")).run(until=1e-5, out=tmp_path / "run", frames=2, samples=2)
    assert (tmp_path / "run" / "energy.png").is_file()
