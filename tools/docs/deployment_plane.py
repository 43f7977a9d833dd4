"""Reeling out in the plane: one arm as a cord with a mass at its tip, wound round a spool, reeled out by one bar.

Quasi-static, with b the rate of the bar relative to the hub, v = r_c |b|, the tip at R from the axis:

    tension   T = (Omega + b)^2 m R                             the arm turns at Omega + b
    lead      of the tip over the bar, chi - asin((R sin(chi) - r_b) / r_c): the arm touches the bar, of the radius r_b
              at r_c, and lags by chi = 2 v / (Omega R) behind the radial at the tip, where Coriolis's force
              2 m Omega v balances the tension's component across
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from membrane_rs import Cylinder, MassDamping, Scene, Schedule, Simulation, Spin, SpringDamping, Stage, Tether
from membrane_rs._arrays import Floats
from membrane_rs._markdown import table
from membrane_rs.scene.run_settings import RunSettings

FREQUENCY = 3.0
"""Of the hub [Hz]."""
HUB, LENGTH, SEGMENTS = 0.0264, 0.2069, 75
"""Radius at which the arm is wound, its length [m], and its segments."""
BAR, CLEARANCE, FREE = 0.003, 0.001, 0.022
"""Radius of the bar, its distance from the roll, and what is free of the arm at the start [m]."""
AXIAL_STIFFNESS, LINEAR_DENSITY, TIP = 84.0, 2.53e-3, 0.36e-3
"""A hundredth of the stiffness of all strips of an arm [N], its mass per length [kg/m], the mass at its tip [kg]."""
SETTLE, EASE = 0.3, 0.1
WINDOW = (0.5, 0.9)
"""Share of the reeling out over which means are taken."""
DURATIONS = (0.5, 1.0, 2.0, 4.0, 8.0, 16.0)
COARSER = dict.fromkeys((38, 19), (4.0, 8.0))
"""Durations of an arm of fewer segments; the last are as long as the cells of the sail."""
LOST, RESTLESS = 90.0, 0.2
"""Angle between tip and bar [deg], and share of the freed energy that is kinetic, beyond which an arm is no longer in
order."""


def arm(duration: float, segments: int = SEGMENTS) -> tuple[Scene, float, float]:
    """The scene of a reeling out that lasts `duration` [s], the azimuth of the bar at its start, and its turn [rad]."""
    centre = HUB + BAR + CLEARANCE
    start = (LENGTH - FREE) / HUB
    end = -math.asin(BAR / centre)
    turn = Schedule((0.0, duration), (0.0, end - start), ease=EASE)
    bar = Cylinder(
        "bar", BAR, centre=(centre * math.cos(start), centre * math.sin(start), 0.0), stiffness=200.0, felt_by="edges"
    )
    spool = Cylinder("spool", HUB * (1.0 - 1e-3), stiffness=200.0, felt_by="nodes")
    cord = Tether(
        (HUB, 0.0, 0.0),
        (HUB + LENGTH, 0.0, 0.0),
        segments,
        AXIAL_STIFFNESS,
        LINEAR_DENSITY,
        tip_mass=TIP,
    )
    scene = Scene(
        None,
        None,
        [Spin(FREQUENCY), SpringDamping(), MassDamping(50.0)],
        [cord],
        bodies=[spool, bar],
        stages=[
            Stage("settle", SETTLE),
            Stage("reel out", duration, without=("mass_damping",), set={"bodies.bar.turn": turn}),
        ],
        name=f"arm-{duration:g}s",
        run=RunSettings(integrator="leapfrog"),
    )
    return scene, start, end - start


def wound(count: int) -> Floats:
    """(count, 3) nodes of the arm on the circle [m], counter-clockwise from its root."""
    angle = np.linspace(0.0, LENGTH / HUB, count)
    return np.stack([HUB * np.cos(angle), HUB * np.sin(angle), np.zeros(count)], axis=1)


def reel_out_arm(duration: float, samples: int = 2000, segments: int = SEGMENTS) -> dict[str, Floats]:
    """Settle, reel out, and take means over the window, by name; angles in degrees."""
    scene, start, turn = arm(duration, segments)
    sim = Simulation(scene)
    sim.positions = wound(sim.node_count)
    sim.reach(SETTLE)
    tip, omega, reach = sim.node_count - 1, 2.0 * math.pi * FREQUENCY, HUB + BAR + CLEARANCE
    schedule = sim.stage_scene.bodies[1].turn
    assert schedule is not None
    rows = []
    stored = sim.energies()["spin"]
    for share in np.linspace(0.0, 1.0, samples + 1)[1:]:
        sim.reach(SETTLE + duration * float(share))
        x, y, _ = sim.positions[tip]
        bar = start + schedule.at(sim.time)
        lead = math.degrees(math.remainder(math.atan2(y, x) - bar, 2.0 * math.pi))
        energies = sim.energies()
        freed = stored - energies["spin"]
        radius = math.hypot(x, y)
        pull = float(np.linalg.norm(sim.forces("tethers")[tip])) / (TIP * omega**2 * radius)
        rows.append((share, pull, lead, energies["kinetic"], freed, radius))
    share, pull, lead, kinetic, freed, radius = np.array(rows).T
    inside = (share >= WINDOW[0]) & (share <= WINDOW[1])
    rate = turn / (duration * (1.0 - EASE))
    found = {
        "segment": LENGTH / segments,
        "duration": duration,
        "rate": abs(rate) / omega,
        "tension": pull[inside].mean(),
        "predicted_tension": (1.0 + rate / omega) ** 2,
        "lead": lead[inside].mean(),
        "lead_spread": lead[inside].std(),
        "predicted_lead": lead_of_tip(abs(rate), float(radius[inside].mean()), reach),
        "kinetic": kinetic[inside].mean() / freed[inside].mean(),
        "largest_lead": np.abs(lead).max(),
        "reach": radius[-1],
    }
    return {name: np.array(value, dtype=np.float64) for name, value in found.items()}


def lead_of_tip(rate: float, radius: float, reach: float) -> float:
    """Azimuth of the tip at `radius` [m] less that of the bar at `reach` [m], for a rate of the bar [rad/s] [deg]."""
    chi = 2.0 * reach * rate / (2.0 * math.pi * FREQUENCY * radius)
    return math.degrees(chi - math.asin(min(1.0, (radius * math.sin(chi) - BAR) / reach)))


def plane_table(arms: Sequence[Mapping[str, Floats]]) -> str:
    """The means of each reeling out beside the quasi-static ones."""
    body = []
    for one in arms:
        value = {name: float(array) for name, array in one.items()}
        body.append((
            f"{1e3 * value['segment']:.1f}",
            f"{value['duration']:g}",
            f"{value['rate']:.2f}",
            f"{value['tension']:.3f}",
            f"{value['predicted_tension']:.3f}",
            f"{value['lead']:.1f} +- {value['lead_spread']:.1f}",
            f"{value['predicted_lead']:.1f}",
            f"{100.0 * value['kinetic']:.2g}",
            f"{1e3 * value['reach']:.1f}",
            "in order" if value["largest_lead"] < LOST and value["kinetic"] < RESTLESS else "lost the bar",
        ))  # fmt: skip
    heads = (
        "segments [mm]", "duration [s]", "b/Omega", "tension of the tip", "(1 - b/Omega)^2",
        "tip ahead of the bar [deg]", "predicted [deg]", "kinetic energy [%]", "reach [mm]", "outcome",
    )  # fmt: skip
    return table(heads, body, words=(9,))
