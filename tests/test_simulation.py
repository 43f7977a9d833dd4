"""Simulation: the same bits on every way to the same instant, stops, locks, and what it tells."""

from __future__ import annotations

import math
import signal
import threading
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from child_processes import SECONDS, wait_until
from membrane_rs import (
    Creases,
    InputError,
    RunSettings,
    Scene,
    Simulation,
    Springs,
    UnstableError,
    scenes,
)
from membrane_rs.scene.laws import LAWS
from small_scenes import FILM, hanging_strip

END = 0.04


def fold_scene() -> Scene:
    """A coarse folded sail, from its guide bars into its wrinkles: the least change of bits shows."""
    from membrane_rs import folding

    whole = scenes.load("okuizumi-model-1")
    mesh = folding.SquareSail(fold_lines=3, rows=4, columns=5).mesh()
    return replace(whole, mesh=mesh, run=RunSettings(until=END, samples=41, frames=5))


def same(a: Simulation, b: Simulation) -> bool:
    """Whether two simulations are in the same state to the last bit."""
    return (
        a.time == b.time
        and (a.positions == b.positions).all()
        and (a.velocities == b.velocities).all()
        and a.ledger()["work_by_law"] == b.ledger()["work_by_law"]
    )


@pytest.fixture(scope="module")
def whole() -> Simulation:
    """A run in one go."""
    sim = Simulation(fold_scene())
    sim.run()
    assert sim.time == pytest.approx(END, rel=1e-12)
    return sim


def test_two_runs_make_the_same_bits(whole: Simulation) -> None:
    again = Simulation(fold_scene())
    again.run()
    assert same(again, whole)
    assert again.ledger() == whole.ledger()
    assert again.evaluation_count == whole.evaluation_count == 4 * whole.step_count


@pytest.mark.parametrize(("frames", "samples"), [(2, 2), (81, 7), ([0.001, 0.0123], 500)])
def test_frames_and_samples_change_no_bit(whole: Simulation, frames: int | list[float], samples: int) -> None:
    again = Simulation(fold_scene())
    again.run(frames=frames, samples=samples)
    assert same(again, whole)


def test_a_run_in_pieces_makes_the_same_bits(whole: Simulation) -> None:
    again = Simulation(fold_scene())
    for until in (0.0, 0.0101, 0.0333, END):
        again.run(until=until)
    assert same(again, whole)
    stepped = Simulation(fold_scene())
    for n in (1, 0, 17, whole.step_count - 18):
        stepped.step(n)
    assert same(stepped, whole)


def test_save_and_restore_continue_with_the_same_bits(whole: Simulation, tmp_path: Path) -> None:
    class SaveOnTheWay:
        def start(self, sim: Simulation) -> None:
            pass

        sample = start

        def frame(self, sim: Simulation) -> None:
            sim.save(tmp_path / f"{sim.step_count}.npz")

        def finish(self, sim: Simulation, error: BaseException | None) -> None:
            assert error is None

    sim = Simulation(fold_scene())
    sim.run(frames=4, observers=[SaveOnTheWay()])
    files = sorted(tmp_path.iterdir())
    assert len(files) == 4
    for file in files:
        again = Simulation.restore(file)
        assert again.dt == whole.dt
        again.run()
        assert same(again, whole)
        assert again.step_count == whole.step_count
        assert again.evaluation_count == whole.evaluation_count
        assert again.ledger()["error"] == whole.ledger()["error"]
        assert again.hub_angle == whole.hub_angle


def test_restore_keeps_what_was_set_by_hand(tmp_path: Path) -> None:
    sim = Simulation(hanging_strip(), dt=1e-4)
    sim.step(10)
    sim.velocities = np.ones((sim.node_count, 3))
    sim.step(3)
    sim.save(tmp_path / "state.npz")
    again = Simulation.restore(tmp_path / "state.npz")
    assert again.dt == 1e-4
    assert same(again, sim)
    for each in (sim, again):
        each.step(500)
    assert same(again, sim)
    assert again.ledger() == sim.ledger()
    assert again.scene.to_toml() == sim.scene.to_toml()


def interrupted(sim: Simulation, action: Callable[[], object]) -> float:
    """Seconds from the signal, which comes while the core steps, to KeyboardInterrupt in `action`."""
    sent, before = list[float](), sim.step_count

    def send() -> None:
        wait_until(lambda: sim.step_count > before, "the core steps")
        sent.append(time.perf_counter())
        signal.raise_signal(signal.SIGINT)

    sender = threading.Thread(target=send)
    sender.start()
    with pytest.raises(KeyboardInterrupt):
        action()
    late = time.perf_counter() - sent[0]
    sender.join()
    return late


def test_ctrl_c_stops_at_once_and_the_simulation_can_go_on() -> None:
    sim = Simulation(scenes.load("okuizumi-model-1"))
    # Not at the end of the steps, to which it would take days.
    assert interrupted(sim, lambda: sim.step(10**9)) < SECONDS
    assert sim.step_count > 0
    assert np.isfinite(sim.positions).all()
    assert interrupted(sim, lambda: sim.run(until=1000.0, frames=2, samples=2)) < SECONDS
    steps = sim.step_count
    sim.step(7)
    assert sim.step_count == steps + 7
    # The same bits as a run that nobody stopped.
    again = Simulation(scenes.load("okuizumi-model-1"))
    again.step(sim.step_count)
    assert same(again, sim)


def test_the_interpreter_is_free_while_the_core_steps() -> None:
    sim = Simulation(scenes.load("okuizumi-model-1"))
    thread = threading.Thread(target=sim.step, args=(3000,))
    thread.start()
    seen = {sim.step_count}
    while thread.is_alive():
        seen.add(sim.step_count)
        thread.join(0.001)
    assert sim.step_count == 3000
    # With the lock held this loop would see the first step and the last alone.
    assert len(seen - {0, 3000}) > 1


def test_a_step_beyond_the_limit_stops_with_what_went_wrong() -> None:
    limit = Simulation(fold_scene()).stable_dt()
    sim = Simulation(fold_scene(), dt=2 * limit)
    with pytest.raises(UnstableError, match="above the stability limit") as caught:
        sim.step(100_000)
    error = caught.value
    assert isinstance(error, ArithmeticError)
    assert error.step > 0
    assert error.time == pytest.approx(error.step * 2 * limit)
    assert "node" in error.place
    assert error.law in sim.energies() or error.law in LAWS
    assert "use a smaller dt" in str(error)
    # The state is the last good one.
    assert sim.step_count < error.step
    assert np.isfinite(sim.positions).all()
    assert np.isfinite(sim.velocities).all()
    assert np.abs(sim.spring_strains()).max() < 0.5
    assert np.isfinite(list(sim.energies().values())).all()


def test_state_goes_on_with_the_same_bits(whole: Simulation) -> None:
    first, second = Simulation(fold_scene()), Simulation(fold_scene())
    first.step(100)
    limit = second.stable_dt()
    second.set_state(first.state())
    assert second.stable_dt() != limit
    second.step(whole.step_count - 100)
    assert same(second, whole)
    lacking = first.state()
    del lacking["work"]
    with pytest.raises(InputError, match="work is missing"):
        second.set_state(lacking)


@pytest.mark.parametrize("count", [2, 7, 10**17])
@pytest.mark.parametrize("rows", [0, 5])
def test_a_count_of_histories_without_their_vectors_is_refused_before_any_memory_is_taken(
    count: int, rows: int
) -> None:
    sim = Simulation(hanging_strip())
    unfit = {**sim.state(), "history_count": count, "history_vectors": np.zeros((rows, 3))}
    unfit["history_numbers"] = np.zeros(3)
    with pytest.raises(InputError, match=f"history_vectors does not have {count} vectors per node"):
        sim.set_state(unfit)


def test_the_limit_is_that_of_the_shape_now() -> None:
    sim = Simulation(fold_scene())
    before = sim.stable_dt(), sim.limiting_part
    assert before == (sim.stable_dt(), sim.limiting_part)
    sim.positions = 1.5 * sim.positions
    assert sim.stable_dt() != before[0]
    at_start = sim.stable_dt()
    sim.step(50)
    assert sim.stable_dt() != at_start


def test_a_spring_over_its_bound_stops_the_run() -> None:
    scene = replace(hanging_strip(), laws=[Springs(strain_limit=1e-4), *hanging_strip().laws[1:]])
    with pytest.raises(UnstableError, match=r"stretched by .* %, over its bound of 0\.010 %") as caught:
        Simulation(scene).run(until=0.2)
    assert caught.value.law == "springs"
    assert caught.value.place.startswith("between nodes ")


def test_the_default_step_is_below_the_limit_and_fits_round_times() -> None:
    for name in scenes.names():
        scene = scenes.load(name)
        if scene.run.dt is not None:
            continue
        sim, high = Simulation(scene), Simulation(scene, "rk4")
        assert sim.dt <= 0.4 * sim.stable_dt() * (1 + 1e-9)
        # Of cords under load the error of leapfrog may bound its step before stability does.
        assert high.dt > 0.2 * high.stable_dt()
        assert (count := (0.1 if sim.dt < 1e-3 else 1.0) / sim.dt) == pytest.approx(round(count), abs=1e-6)
        assert sim.limiting_part.split()[0] in sim.energies() or sim.limiting_part.split()[0] in LAWS


@pytest.mark.parametrize("name", ["okuizumi-model-1-fast", "okuizumi-stage-1", "hanging-strip"])
def test_the_limit_is_that_of_the_start_until_something_moves(name: str) -> None:
    sim = Simulation(scenes.load(name))
    searched = sim._core.limit()
    found = sim.stable_dt(), sim.limiting_node, sim.limiting_part.partition(" (in ")[0]
    assert found == (searched.dt, searched.node, searched.part)
    sim.positions = 1.001 * sim.positions
    assert sim.stable_dt() == sim._core.limit().dt != searched.dt
    again = Simulation(sim.scene, start=sim)
    assert again.stable_dt() == again._core.limit().dt == sim.stable_dt()


def test_measured_limit_is_the_predicted_one() -> None:
    # The tallest frequency of a net with nothing slack: just below it stays, just above it goes.
    laws = [Springs(buckling=1e9, buckling_on_creases=1e9)]
    # So near the limit RK4 takes most of what white noise holds.
    scene = replace(hanging_strip(), laws=laws, run=RunSettings(energy_loss=2.0))
    limit = Simulation(scene).stable_dt()
    kick = 1e-9 * np.random.default_rng(1).normal(size=(len(scene.assemble().positions), 3))
    kick[:, 2] = 0.0
    quiet, loud = Simulation(scene, dt=0.99 * limit), Simulation(scene, dt=1.02 * limit)
    for sim in (quiet, loud):
        sim.velocities = kick
    quiet.step(20_000)
    assert np.abs(quiet.positions - scene.assemble().positions).max() < 1e-9
    with pytest.raises(UnstableError):
        loud.step(20_000)


def test_settling_holds_the_guide_bars_and_brings_the_sail_to_rest() -> None:
    scene = fold_scene()
    sim = Simulation(scene)
    start, bars = sim.positions, sim.assembly.node_sets["guide_bars"]
    before = sim.energies()["springs"] + sim.energies()["creases"]
    speed = sim.relax(duration=0.3, rate=50.0)
    # Half a second would take it to the next decade; the free ends are what still swings.
    assert speed < 0.05
    assert (sim.positions[bars] == start[bars]).all()
    assert np.abs(sim.positions - start).max() > 1e-5
    assert sim.energies()["springs"] + sim.energies()["creases"] < before
    assert (sim.time, sim.step_count, np.abs(sim.velocities).max()) == (0.0, 0, 0.0)
    assert sim.is_relaxed
    assert len(sim.assembly.fixed) == 4  # the bars are open again
    sim.step()
    with pytest.raises(InputError, match="before the first step"):
        sim.relax(0.1, 50.0)


def test_a_run_settles_first_if_the_scene_says_so() -> None:
    base = fold_scene()
    scene = replace(base, run=RunSettings(until=1e-3, samples=2, relax=0.01, relax_rate=100.0))
    ran, by_hand = Simulation(scene), Simulation(scene)
    ran.run()
    by_hand.relax()
    by_hand.run()
    assert ran.is_relaxed
    assert same(ran, by_hand)


def test_forces_of_a_law_by_name_class_or_value() -> None:
    sim = Simulation(fold_scene())
    by_name = sim.forces("creases")
    assert by_name.shape == (sim.node_count, 3)
    law = sim.scene.law("creases")
    assert law is not None
    for other in (Creases, Creases(stiffness=3.0), law):
        assert (sim.forces(other) == by_name).all()
    names = [law.kind for law in sim.scene.laws] + ["tethers"]
    total = np.sum([sim.forces(name) for name in names], axis=0)
    assert sim.forces() == pytest.approx(total, abs=1e-12 * np.abs(total).max())


def test_energies_and_ledger() -> None:
    sim = Simulation(fold_scene())
    start = sum(sim.energies().values())
    zero = sim.ledger()
    names = ("kinetic", "stored", "work", "reference_energy", "error", "stored_by_law", "work_by_law", "motor_work")
    assert zero.keys() == set(names)
    assert (zero["kinetic"], zero["work"], zero["error"], zero["reference_energy"]) == (0.0, 0.0, 0.0, 0.0)
    sim.run(until=0.01)
    energies, ledger = sim.energies(), sim.ledger()
    assert set(energies) == {"kinetic", "springs", "creases", "spin", "spool_contact", "tethers"}
    v = sim.velocities
    assert energies["kinetic"] == pytest.approx(0.5 * np.sum(sim.masses[:, None] * v * v), rel=1e-12)
    assert ledger["kinetic"] == energies["kinetic"]
    assert ledger["stored"] == pytest.approx(sum(energies.values()) - energies["kinetic"], rel=1e-12)
    assert ledger["work"] == pytest.approx(sum(ledger["work_by_law"].values()), rel=1e-12)
    assert set(ledger["work_by_law"]) == {"spring_damping", "air_drag"}
    assert all(work < 0 for work in ledger["work_by_law"].values())
    missing = sum(energies.values()) - start - ledger["work"]
    assert ledger["error"] == pytest.approx(missing / ledger["reference_energy"], rel=1e-6)
    assert -0.01 < ledger["error"] < 1e-5


def test_the_energy_error_falls_as_the_order_says() -> None:
    # RK4 on a smooth motion: the amplitude's loss goes with dt^5 in a given time, its energy with it.
    errors = []
    for dt in (2e-4, 1e-4):
        sim = Simulation(hanging_strip(), dt=dt)
        sim.step(round(0.02 / dt))
        errors.append(abs(sim.ledger()["error"]))
    assert errors[0] > 1e-12
    assert 3.0 < math.log2(errors[0] / errors[1]) < 6.0


def test_setting_positions_opens_the_ledger_anew() -> None:
    sim = Simulation(hanging_strip())
    sim.step(20)
    sim.positions = sim.positions
    assert sim.ledger()["work"] == 0.0
    assert sim.ledger()["error"] == 0.0
    assert sim.time > 0


def test_arrays_are_copies_and_held_nodes_stay() -> None:
    sim = Simulation(hanging_strip())
    for read in (sim.positions, sim.velocities, sim.masses):
        with pytest.raises(ValueError, match="read-only"):
            read[0] += 9.0
    sim.positions.copy()[:] = 9.0
    assert (sim.positions == sim.scene.assemble().positions).all()
    sim.velocities = np.ones((sim.node_count, 3))
    held = sim.assembly.fixed
    assert (sim.velocities[held] == 0).all()
    before = sim.positions[held]
    sim.step(50)
    assert (sim.positions[held] == before).all()


def test_what_is_read_off_the_elements() -> None:
    sim = Simulation(fold_scene())
    count = len(sim.spring_pairs)
    assert sim.spring_strains().shape == sim.buckled().shape == (count,)
    ends = sim.positions[sim.spring_pairs]
    assert sim.masses.sum() == pytest.approx(
        sim.scene.assemble().extra_masses.sum() + sim.scene.mesh.masses(FILM).sum()  # type: ignore[union-attr]
    )
    assert np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).min() > 0
    angles = sim.crease_angles()
    assert angles.shape == (len(sim.assembly.creases),)
    assert np.abs(angles).max() < 0.2  # folded shut
    flat = Simulation(hanging_strip())
    assert np.isnan(flat.crease_angles()).all()
    assert flat.hub_angle == 0.0
    sim.run(until=0.01)
    assert sim.hub_angle == pytest.approx(2 * math.pi * 3.0 * 0.01)
