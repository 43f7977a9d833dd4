"""Loads on a sail whose hub is free in six degrees of freedom, against closed forms (docs/free_hub.md).

python tools/docs/flight.py [--write]
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from marked import DOCS, MarkedPart
from membrane_rs import (
    AirDrag,
    Fixed,
    Gravity,
    Material,
    PointForces,
    RunSettings,
    Scene,
    Simulation,
    SolarPressure,
    Spin,
    Tether,
    Triangles,
)
from membrane_rs._arrays import Floats
from membrane_rs._markdown import table
from membrane_rs.folding import Disc
from membrane_rs.scene.laws.solar_pressure import ASTRONOMICAL_UNIT

PART = MarkedPart(DOCS / "free_hub.md", "free-hub-loads")
DISC = Disc(0.1, rings=4).mesh()
AREA = float(DISC.areas().sum())
RUBBER = Material(youngs_modulus=1e6, poisson_ratio=0.3, density=1000.0, thickness=2e-4)
HUB = 0.02
"""[kg]"""
BODY = Spin(1.0, inertia=4e-5, mass=HUB, transverse_inertia=3e-5)
NEAR = 1e8
"""Distance from the sun at which light moves the sail within a run [m]."""
G = 9.81
PRESSURE = 1e5
"""Of the air [Pa]."""
TORQUE, RATE, ALONG, ACROSS = 0.02, 8.0, 1.0, 0.8
"""Of the body that precesses: torque [N m], turns per second [Hz], moments of inertia [kg m2]."""
TURNS = 10
"""Periods of the nutation."""
METHODS = ("leapfrog", "rk4")


def main() -> None:
    """Print the table, and write it into the page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--write", action="store_true", help="write into docs/")
    options = parser.parse_args()
    cases: dict[str, Callable[[str], tuple[float, float, Simulation]]] = {
        "thrust [m]": thrust,
        "fall [m]": fall,
        "fall in air [m]": fall_in_air,
        "precession [rad]": precession,
    }
    body = []
    for name, case in cases.items():
        found = [case(method) for method in METHODS]
        errors = [f"{abs(seen / derived - 1.0):.0e}" for derived, seen, _ in found]
        energy = [f"{abs(sim.ledger()['error']):.0e}" for *_, sim in found]
        body.append((name, f"{found[0][0]:.4g}", *errors, *energy))
    heads = ("", "closed form", *(f"error, {name}" for name in METHODS), *(f"energy error, {name}" for name in METHODS))
    text = table(heads, body, words=(0,))
    print(text)
    if options.write:
        PART.write(text)


def flown(until: float, method: str, *laws: Any, spin: Spin = BODY) -> Simulation:
    """A disc whose rim the hub holds, after a time [s]."""
    run = RunSettings(until=until, integrator=method)
    sim = Simulation(Scene(DISC, RUBBER, [Triangles(), spin, *laws], [Fixed("rim")], run=run))
    sim.reach(until)
    return sim


def mass(sim: Simulation) -> float:
    """Of hub and sail [kg]."""
    return HUB + float(sim.masses.sum())


def centre(sim: Simulation) -> Floats:
    """(3,) of mass of hub and sail in space [m]."""
    places = sim.positions @ sim.hub_rotation.T + sim.hub_displacement
    found: Floats = (sim.masses @ places + HUB * sim.hub_displacement) / mass(sim)
    return found


def thrust(method: str) -> tuple[float, float, Simulation]:
    """By light on black film along the axis, of which the held rim bounds the projection."""
    until = 0.05
    sim = flown(until, method, SolarPressure(0.0, 0.0, distance=NEAR))
    pressure = 4.56e-6 * (ASTRONOMICAL_UNIT / NEAR) ** 2
    return -0.5 * pressure * AREA / mass(sim) * until**2, float(centre(sim)[2]), sim


def fall(method: str) -> tuple[float, float, Simulation]:
    """In a uniform field."""
    until = 0.05
    sim = flown(until, method, Gravity((0.0, 0.0, -G)))
    return -0.5 * G * until**2, float(centre(sim)[2]), sim


def fall_in_air(method: str) -> tuple[float, float, Simulation]:
    """At rest, along the axis, without spin."""
    until = 0.5
    sim = flown(until, method, Gravity((0.0, 0.0, -G)), AirDrag(PRESSURE), spin=replace(BODY, frequency=0.0))
    density = PRESSURE / (287.0 * 293.0)
    last = math.sqrt(2.0 * mass(sim) * G / (density * AREA))
    return -(last**2) / G * math.log(math.cosh(G * until / last)), float(centre(sim)[2]), sim


def precession(method: str) -> tuple[float, float, Simulation]:
    """By a force fixed in space at the end of a mast."""
    mast = Tether((0.0, 0.0, 0.1), (0.01, 0.0, 0.1), 1, 1.0, 1e-9)
    push = PointForces("tether-0-start", (TORQUE / 0.1, 0.0, 0.0), frame="inertial")
    spin = Spin(RATE, inertia=ALONG, mass=2.0, transverse_inertia=ACROSS)
    until = TURNS * ACROSS / (ALONG * RATE)
    run = RunSettings(until=until, integrator=method, dt=1e-4)
    sim = Simulation(Scene(None, None, [spin, push], [mast, Fixed("tether-0-end")], run=run))
    sim.reach(until)
    return TORQUE / (ALONG * math.tau * RATE) * until, float(np.arcsin(sim.hub_rotation[1, 2])), sim


if __name__ == "__main__":
    main()
