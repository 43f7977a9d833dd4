"""Cords that are slack at the start become taut later: the default step resolves the bounce that nothing foretells."""

from __future__ import annotations

from math import pi, sin

import numpy as np
import pytest
from membrane_rs import Gravity, RunSettings, Scene, Simulation, SpringDamping, integrators
from membrane_rs.scene.laws import Law
from small_scenes import cord

OMEGA = 10.0
"""Of 1 kg on 100 N/m [rad/s]."""
START = 0.5
"""Distance of the tip from the held end of its cord of 1 m [m]."""
LAWS: dict[str, list[Law]] = {
    "free": [],
    "damped": [SpringDamping(0.02)],
    "falling": [Gravity((0.0, 0.0, -1.0))],
    "falling and damped": [Gravity((0.0, 0.0, -1.0)), SpringDamping(0.02)],
}


def thrown(velocity: tuple[float, float, float], laws: list[Law], method: str, segments: int = 1) -> Simulation:
    """The tip on its slack cord, at its default step."""
    part = cord(segments=segments, linear_density=0.0 if segments == 1 else 0.1)
    sim = Simulation(Scene(None, None, laws, [part], run=RunSettings(until=100.0)), method)
    sim.positions = START * sim.positions
    velocities = np.zeros_like(sim.positions)
    velocities[-1] = velocity
    sim.velocities = velocities
    return sim


def bounce(time: float, speed: float) -> float:
    """Position along the line of the throw [m]: free flight, half a vibration of the taut cord, and back."""
    since = time - (1.0 - START) / speed
    if since < 0.0:
        return START + speed * time
    count, own = divmod(since, pi / OMEGA + 2.0 / speed)
    beyond = speed / OMEGA * sin(OMEGA * own) if own < pi / OMEGA else -speed * (own - pi / OMEGA)
    return (1.0 + beyond) * (-1.0 if count % 2 else 1.0)


def assert_balanced(sim: Simulation, kinetic: float) -> None:
    """Within 2 % of the larger of the kinetic energy at the start [J] and of the largest exchange."""
    ledger = sim.ledger()
    exchange = float(ledger["reference_energy"])
    assert abs(float(ledger["error"]) * exchange) < 0.02 * max(exchange, kinetic)


@pytest.mark.parametrize("method", integrators())
@pytest.mark.parametrize("speed", [0.1, 1.0, 10.0])
def test_a_thrown_tip_bounces_as_in_the_closed_form(method: str, speed: float) -> None:
    sim = thrown((speed, 0.0, 0.0), [], method)
    for time in np.linspace(0.0, 3.0 * (pi / OMEGA + 2.0 / speed), 61)[1:].tolist():
        sim.reach(time)
        assert sim.positions[1, 0] == pytest.approx(bounce(time, speed), abs=0.01 * (1.0 + speed / OMEGA)), time
    assert_balanced(sim, 0.5 * speed**2)


@pytest.mark.parametrize("method", integrators())
@pytest.mark.parametrize("laws", LAWS.values(), ids=LAWS)
@pytest.mark.parametrize("velocity", [(0.1, 0.0, 0.0), (1.0, 0.3, 0.0), (0.0, 3.0, 1.0), (-5.0, 2.0, 0.0)])
def test_a_thrown_tip_keeps_its_energy_balance(
    method: str, laws: list[Law], velocity: tuple[float, float, float]
) -> None:
    sim = thrown(velocity, laws, method)
    sim.run(until=10.0, frames=2)
    assert_balanced(sim, 0.5 * float(np.square(velocity).sum()))


@pytest.mark.parametrize("method", ["rk4", "leapfrog"])
@pytest.mark.parametrize("laws", [LAWS["free"], LAWS["damped"]], ids=["free", "damped"])
@pytest.mark.parametrize("segments", [2, 5])
def test_a_tip_thrown_on_several_segments_keeps_its_energy_balance(method: str, laws: list[Law], segments: int) -> None:
    sim = thrown((1.0, 0.3, 0.1), laws, method, segments)
    kinetic = float(sim.ledger()["kinetic"])
    sim.run(until=3.0, frames=2)
    assert_balanced(sim, kinetic)
