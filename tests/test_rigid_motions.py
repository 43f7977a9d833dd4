"""The monitor judges a free scene alike at rest, thrown, spun and in a turning frame."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from membrane_rs import (
    AuditWarning,
    Gravity,
    Rectangles,
    RunSettings,
    Scene,
    Simulation,
    Spin,
    SpringDamping,
    Springs,
    Tether,
    Triangles,
    UnstableError,
)
from membrane_rs.folding import Strip
from membrane_rs.scene.laws import Law
from rigid_motions import FAULTY, MOTIONS, SOUND, Kind, verdict
from small_scenes import RUBBER, UNBUCKLED, Floats


@pytest.mark.parametrize("kind", SOUND, ids=lambda kind: str(kind.__name__))
@pytest.mark.parametrize("method", ["rk4", "leapfrog"])
def test_no_motion_stops_a_sound_scene(kind: Kind, method: str) -> None:
    for motion in MOTIONS:
        found = verdict(kind, motion, method, 0, is_compared=False)
        assert found is None or not found.is_stopped, found


@pytest.mark.parametrize("kind", FAULTY, ids=lambda kind: str(kind.__name__))
@pytest.mark.parametrize("method", ["rk4", "leapfrog"])
def test_no_motion_hides_a_fault(kind: Kind, method: str) -> None:
    # Rotation may put a fault right: its tension holds what negative springs drive apart.
    for motion in MOTIONS:
        found = verdict(kind, motion, method, 0)
        turns = motion not in ("at rest", "thrown")
        assert found is None or found.is_stopped or (turns and not found.is_missed), found


def square(*laws: Law, dt: float | None = None, **run: float) -> Simulation:
    """A free square of rubber film."""
    settings = RunSettings(until=100.0, snapshots=(), **run)  # type: ignore[arg-type]
    scene = Scene(Strip(0.1, 0.1, 4, 4).mesh(), RUBBER, list(laws), run=settings)
    return Simulation(scene, dt=dt)


def shaken(share: float, speed: float, size: float) -> Simulation:
    """With random velocities of `size`, at `share` of the stability limit of rk4, thrown at `speed`."""
    sim = square(UNBUCKLED, dt=share * square(UNBUCKLED).stable_dt())
    sim.velocities = size * np.random.default_rng(0).normal(size=(sim.node_count, 3)) + [speed, 0.0, 0.0]
    return sim


@pytest.mark.parametrize(("share", "size"), [(1.02, 1e-3), (0.7, 5e-2)], ids=["gain", "loss"])
def test_the_speed_of_the_whole_changes_neither_verdict_nor_number(share: float, size: float) -> None:
    messages = []
    for speed in (0.0, 1.0, 100.0, 1000.0):
        with pytest.raises(UnstableError) as caught:
            shaken(share, speed, size).step(5000)
        messages.append((caught.value.step, str(caught.value).split(" J")[0].split(": ")[1]))
    assert len(set(messages)) == 1, messages


@pytest.mark.parametrize("method", ["rk4", "leapfrog", "dopri5", "generalized_alpha"])
@pytest.mark.parametrize(("segments", "stiffness"), [(2, 17.0), (8, 17.0), (8, 0.1)])
def test_a_cord_at_rest_in_space_is_followed_from_a_turning_hub(method: str, segments: int, stiffness: float) -> None:
    cord = Tether((0.2, 0.0, 0.0), (0.5, 0.0, 0.0), segments, stiffness, 1e-4, fixed=False)
    with pytest.warns(AuditWarning, match="nothing holds the scene"):
        sim = Simulation(Scene(None, None, [Spin(2.0)], [cord]), method)
    velocities = np.zeros_like(sim.positions)
    velocities[:, 1] = -4.0 * np.pi * sim.positions[:, 0]
    sim.velocities = velocities
    sim.reach(0.3)
    radii = np.hypot(*sim.positions[:, :2].T)
    np.testing.assert_allclose(radii, sim.scene.assemble().positions[:, 0], rtol=1e-3)


@pytest.mark.parametrize("rate", [20.0, 30.0, 50.0])
@pytest.mark.parametrize("share", [1.03, 1.1])
def test_a_fast_rotation_hides_no_growth(rate: float, share: float) -> None:
    # Without damping no error of its work is allowed: a share of the rotation's energy would hide all the vibration.
    sim = square(Springs(), dt=share * square(Springs()).stable_dt())
    sim.positions = sim.positions * [1.003, 0.999, 1.0]
    spun(sim, np.array([0.0, 0.0, rate]))
    with pytest.raises(UnstableError, match="spurious gain"):
        sim.reach(0.5)


def spun(sim: Simulation, rates: Floats) -> Simulation:
    sim.velocities = np.cross(rates, sim.positions - sim.masses @ sim.positions / sim.masses.sum())
    return sim


@pytest.mark.parametrize("ratio", [0.0, 0.02, 0.1, 0.2])
@pytest.mark.parametrize("law", [Springs(), Triangles(), Rectangles()], ids=lambda law: str(law.kind))
def test_a_sound_flight_that_turns_is_not_stopped(law: Law, ratio: float) -> None:
    sim = square(law, *([SpringDamping(ratio)] if ratio else []))
    spun(sim, np.array([1.5, -2.5, 20.0]))
    before = sim.energies()["kinetic"]
    sim.step(round(3.0 / sim.dt))
    # Its widening and the vibration about it are a thousandth.
    assert sim.energies()["kinetic"] == pytest.approx(before, rel=3e-3)


@pytest.mark.parametrize("speed", [0.0, 1.0, 1000.0])
def test_a_scene_without_exchange_has_no_energy_error(speed: float) -> None:
    sim = square(Springs(), SpringDamping())
    sim.velocities = np.tile([speed, 0.3 * speed, 0.0], (sim.node_count, 1))
    sim.step(2000)
    ledger = sim.ledger()
    assert ledger["error"] == 0.0
    assert ledger["reference_energy"] < 1e-15 * max(ledger["kinetic"], 1.0)


def test_the_reference_energy_of_a_falling_film_is_not_that_of_its_fall() -> None:
    # The default step damps part of the noise.
    sim = square(Springs(), SpringDamping(), Gravity((0.0, 0.0, -9.81)), energy_loss=1.0)
    sim.velocities = 1e-3 * np.random.default_rng(0).normal(size=(sim.node_count, 3))
    sim.step(500)
    ledger = sim.ledger()
    assert ledger["kinetic"] > 1e-4
    assert 0.0 < ledger["reference_energy"] < 1e-8
    assert -0.5 < ledger["error"] < 0.0


def vibrating(speed: float, distance: float, tolerance: float = 1e-5) -> Simulation:
    """A film that is stretched and thrown, after 20 ms of steps chosen by their error."""
    run = RunSettings(until=1.0, snapshots=(), tolerance=tolerance)
    sim = Simulation(Scene(Strip(0.1, 0.1, 4, 4).mesh(), RUBBER, [UNBUCKLED], run=run), "dopri5")
    about = sim.positions - sim.positions.mean(axis=0)
    sim.positions = sim.positions + np.array([distance, 0.0, 0.0])
    sim.velocities = about * [1.0, -1.0, 0.0] + [speed, 0.0, 0.0]
    sim.reach(0.02)
    return sim


@pytest.mark.parametrize(("speed", "distance"), [(100.0, 0.0), (1000.0, 0.0), (0.0, 100.0), (100.0, 1000.0)])
def test_the_tolerance_of_a_step_does_not_grow_with_the_flight_of_the_whole(speed: float, distance: float) -> None:
    exact, rest, flown = vibrating(0.0, 0.0, 1e-9), vibrating(0.0, 0.0), vibrating(speed, distance)

    def apart(one: Simulation, other: Simulation) -> list[float]:
        own = [(sim.positions, sim.velocities) for sim in (one, other)]
        return [float(np.abs((a - a.mean(axis=0)) - (b - b.mean(axis=0))).max()) for a, b in zip(*own, strict=True)]

    assert flown.step_count == rest.step_count
    for found, allowed in zip(apart(flown, exact), apart(rest, exact), strict=True):
        assert found < 1.1 * allowed
    assert flown.ledger()["error"] == pytest.approx(rest.ledger()["error"], rel=1e-2)


def test_a_restart_goes_on_with_the_same_balance() -> None:
    whole, first = (shaken(0.4, 100.0, 1e-4) for _ in range(2))
    whole.step(40)
    first.step(15)
    second = shaken(0.4, 100.0, 1e-4)
    second.set_state(first.state())
    second.step(25)
    assert second.ledger() == whole.ledger()


def test_the_table_has_no_false_stop_and_no_missed_fault() -> None:
    text = (Path(__file__).parents[1] / "docs" / "rigid_motions.md").read_text(encoding="utf-8")
    totals = [line for line in text.splitlines() if line.startswith("| **all")]
    assert len(totals) == 2
    assert all([cell.strip() for cell in line.split("|")[-3:-1]] == ["0", "0"] for line in totals)
