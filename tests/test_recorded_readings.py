"""History and frames hold the readings of the laws, as Python gives them."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np
import pytest
from membrane_rs import (
    Creases,
    Fixed,
    Gravity,
    Rectangles,
    Scene,
    Simulation,
    Spin,
    SpoolContact,
    SpringDamping,
    Springs,
    Tether,
    Triangles,
)
from membrane_rs.folding import Strip
from membrane_rs.results import read_history
from membrane_rs.scene.laws import Law
from small_scenes import RUBBER

LAWS: list[Law] = [SpringDamping(), Gravity((1.0, 2.0, -9.81)), Spin(1.0), SpoolContact(0.05, 300.0)]
CORD = Tether((0.06, 0.0, 0.0), (0.045, 0.02, 0.0), 3, 60.0, 0.01, tip_mass=0.02)
"""It leans on the spool, some of its nodes inside."""


@pytest.mark.parametrize("film", [Springs(), Triangles(), Rectangles()], ids=lambda law: law.kind)
def test_each_number_and_field_is_that_of_the_state(film: Law, tmp_path: Path) -> None:
    mesh = Strip(0.1, 0.04, 6, 2, creases=(0.5,)).mesh()
    sim = Simulation(Scene(mesh, RUBBER, [film, *LAWS, Creases(1e3)], [Fixed("start"), CORD]))
    sim.run(0.01, 2, tmp_path / "run", samples=2, pictures=False)
    load, stress, tensions = sim.hub_load(), sim.film_stress(), sim.cord_tensions()
    last = {name: column[-1] for name, column in read_history(tmp_path / "run").items()}
    assert last["hub_force"] == pytest.approx(np.linalg.norm(load.force), rel=1e-12)
    assert last["hub_torque"] == pytest.approx(load.torque[2], rel=1e-12)
    assert last["contact_force"] == pytest.approx(load.contact, rel=1e-12)
    assert last["largest_cord_tension"] == pytest.approx(tensions.max(), rel=1e-12)
    assert last["largest_film_stress"] == pytest.approx(max(stress.principal.max(), 0.0), rel=1e-12)
    # None of them is another one, or nothing.
    assert len({round(float(size), 9) for size in (*load.force, *load.torque)}) == 6
    assert load.contact > 0.0
    assert tensions.max() > tensions.min()
    assert stress.principal.max() > 0.0

    frame = meshio.vtu.read(tmp_path / "run" / "frames" / "frame-0001.vtu")
    of_film, of_lines = ({name: fields[k] for name, fields in frame.cell_data.items()} for k in range(2))
    for name, expected in (
        ("stress_1", stress.principal[:, 0]),
        ("stress_2", stress.principal[:, 1]),
        ("von_mises", stress.von_mises),
        ("stress_direction", stress.directions[:, 0]),
    ):
        assert of_film[name] == pytest.approx(expected, rel=1e-6, abs=1e-6 * np.abs(expected).max())
        assert np.isnan(of_lines[name]).all()
    assert of_lines["tension"][-len(tensions) :] == pytest.approx(tensions, rel=1e-6)
    assert np.isnan(of_lines["tension"][: -len(tensions)]).all()
    assert np.isnan(of_film["tension"]).all()


def test_what_a_scene_does_not_have_is_not_written(tmp_path: Path) -> None:
    mesh = Strip(0.1, 0.04, 6, 2).mesh()
    # Without a law of the film, without cords, and with nothing held.
    Simulation(Scene(mesh, RUBBER, [Gravity()]), dt=1e-4).run(0.001, 2, tmp_path / "run", samples=2, pictures=False)
    history = read_history(tmp_path / "run")
    assert not {"hub_force", "contact_force", "largest_cord_tension", "largest_film_stress"} & history.keys()
    frame = meshio.vtu.read(tmp_path / "run" / "frames" / "frame-0001.vtu")
    assert not {"stress_1", "stress_direction", "von_mises", "tension"} & frame.cell_data.keys()
