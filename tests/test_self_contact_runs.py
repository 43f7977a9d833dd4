"""Layers that feel each other, in runs: they stay apart, and a run goes on with the same bits."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from membrane_rs import (
    Fixed,
    Gravity,
    Material,
    Mesh,
    RunSettings,
    Scene,
    SelfContact,
    Simulation,
    SpringDamping,
    Springs,
    Stage,
    UnstableError,
    resume,
    run,
)
from membrane_rs.folding import Strip
from membrane_rs.mesh.crossings import crossings
from membrane_rs.scene.law import Law
from membrane_rs.scene.part import Part

FILM = Material(3.2e9, 0.34, 1420.0, 7.5e-6)
SIDE, CELLS, GAP = 0.044, 4, 2e-5


def two_sheets(contact: SelfContact | None, *, others: tuple[Law, ...] = (), parts: tuple[Part, ...] = ()) -> Scene:
    """Two sheets one above the other, the upper one turned."""
    sheet = Strip(SIDE, SIDE, CELLS, CELLS).mesh()
    flat = sheet.reference - sheet.reference.mean(axis=0)
    c, s = np.cos(0.3), np.sin(0.3)
    upper = flat @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]) + [3e-3, 2e-3, GAP]
    count = len(flat)
    mesh = Mesh(
        np.vstack([flat, flat + np.array([1.0, 0.0, 0.0])]),
        np.vstack([sheet.triangles, sheet.triangles + count]),
        positions=np.vstack([flat, upper]),
        node_sets={"lower": np.arange(count), "upper": np.arange(count, 2 * count)},
    )
    laws = [Springs(), *others, *([contact] if contact else [])]
    return Scene(mesh, FILM, laws, parts, name="sheets", run=RunSettings(until=1e-3, integrator="leapfrog"))


def thrown(contact: SelfContact | None, speed: float) -> Simulation:
    """The upper sheet comes down."""
    simulation = Simulation(two_sheets(contact))
    velocities = np.zeros_like(simulation.positions)
    velocities[len(velocities) // 2 :, 2] = -speed
    simulation.velocities = velocities
    return simulation


def test_contact_counts_what_it_spends() -> None:
    free, held = thrown(None, 1.0), thrown(SelfContact(), 1.0)
    for simulation in (free, held):
        simulation.reach(6e-5)
    assert set(free.contact_statistics.values()) == {0}
    spent = held.contact_statistics
    assert spent["looked_at"] > spent["near"] >= spent["pressed"] > 0
    assert min(spent["list_time"], spent["look_time"], spent["impulse_time"]) > 0.0
    held.reach(1.2e-4)
    assert all(later >= spent[name] for name, later in held.contact_statistics.items())
    assert held.contact_statistics["impulse_time"] > spent["impulse_time"]


def crossed(simulation: Simulation) -> int:
    """Pairs of triangles that cross."""
    return crossings(simulation.assembly.triangles, simulation.positions, 0).count


@pytest.mark.parametrize("speed", [0.1, 1.0, 5.0])
def test_sheets_stay_apart_and_share_their_momentum(speed: float) -> None:
    simulation = thrown(SelfContact(crossing_interval=10), speed)
    simulation.reach(simulation.time + 2.0 * GAP / speed)
    assert crossed(simulation) == 0
    mean = simulation.velocities[:, 2].reshape(2, -1).mean(axis=1)
    assert mean == pytest.approx([-0.5 * speed] * 2, rel=0.2)
    assert simulation.ledger()["work_by_law"]["self_contact"] < 0.0
    assert abs(simulation.ledger()["error"]) < 1e-3


def test_without_the_law_they_go_through() -> None:
    simulation = thrown(None, 1.0)
    simulation.reach(1.2 * GAP)
    upper, lower = simulation.positions[::-1, 2].reshape(2, -1)
    assert (upper < lower.mean()).all()


def test_a_saved_run_goes_on_with_the_same_bits(tmp_path: Path) -> None:
    whole, part = thrown(SelfContact(), 1.0), thrown(SelfContact(), 1.0)
    steps = int(1.5 * GAP / whole.dt)
    whole.step(steps)
    part.step(steps - 29)
    part.save(tmp_path / "state.npz")
    part = Simulation.restore(tmp_path / "state.npz")
    part.step(29)
    assert whole.ledger()["work_by_law"]["self_contact"] < 0.0
    np.testing.assert_array_equal(whole.positions, part.positions)
    np.testing.assert_array_equal(whole.velocities, part.velocities)


def test_a_run_folder_goes_on_with_the_same_bits(tmp_path: Path) -> None:
    parts = (Fixed("lower"),)
    scene = two_sheets(SelfContact(), others=(Gravity(), SpringDamping()), parts=parts)
    whole = Simulation(scene)
    whole.reach(3e-3)
    run(scene, 1.5e-3, out=tmp_path / "part", pictures=False)
    part = resume(tmp_path / "part", 3e-3, pictures=False)
    np.testing.assert_array_equal(whole.positions, part.positions)


def test_outputs_do_not_change_the_motion() -> None:
    quiet, shown = thrown(SelfContact(), 1.0), thrown(SelfContact(), 1.0)
    steps = int(1.2 * GAP / quiet.dt)
    quiet.step(steps)
    for step in range(0, steps - 7, 7):
        shown.reach((step + 0.4) * shown.dt)
    shown.reach(quiet.time)
    np.testing.assert_array_equal(quiet.positions, shown.positions)


def test_a_sheet_comes_to_rest_on_another() -> None:
    scene = two_sheets(SelfContact(), others=(Gravity(), SpringDamping()), parts=(Fixed("lower"),))
    simulation = Simulation(scene)
    simulation.reach(0.03)
    upper = simulation.positions[len(simulation.positions) // 2 :, 2]
    assert crossed(simulation) == 0
    assert upper.min() > 0.0


def test_layers_keep_their_distance_into_the_next_stage() -> None:
    contact, parts = SelfContact(), (Fixed("lower"),)
    scene = two_sheets(contact, others=(Gravity((0.0, 0.0, -981.0)), SpringDamping()), parts=parts)
    least = 0.5 * FILM.thickness
    heights = []
    for stages in ([Stage("one", 4e-3)], [Stage("one", 2e-3), Stage("two", 2e-3)]):
        simulation = Simulation(replace(scene, stages=stages))
        simulation.reach(4e-3)
        heights.append(simulation.positions[len(simulation.positions) // 2 :, 2])
    other = Simulation(scene, start=simulation)
    other.reach(other.time + 2e-3)
    heights.append(other.positions[len(other.positions) // 2 :, 2])
    assert [len(shape) for shape in other._core.layer_shapes()] == [len(other.positions)]
    for found in heights:
        assert found.min() == pytest.approx(least, rel=0.05)


def test_an_approach_that_is_too_fast_is_stopped_with_value_and_remedy() -> None:
    simulation = thrown(SelfContact(), 1000.0)
    with pytest.raises(UnstableError, match=r"approach by .* m in a step.*self_contact.*smaller dt"):
        simulation.step(10)
