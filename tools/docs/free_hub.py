"""Hubs that nothing drives, against closed forms: yo-yo, nutation, momentum, order and cost (docs/free_hub.md).

python tools/docs/free_hub.py [--write] [--only yo-yo ...]
"""

from __future__ import annotations

import math
import time
from dataclasses import replace
from statistics import median
from typing import Any

import numpy as np
from marked import DOCS, MarkedPart, make_parts
from membrane_rs import RunSettings, Scene, Simulation, Spin, scenes
from membrane_rs._arrays import Floats
from membrane_rs._markdown import table
from membrane_rs.scene.hub import has_free_body, hub_of

PAGE = DOCS / "free_hub.md"
NAMES = ("yo-yo", "nutation", "momentum", "order", "cost")
PARTS = {name: MarkedPart(PAGE, f"free-hub-{name}") for name in NAMES}
RADIUS = 0.025
"""Of the spool of the yo-yo [m]."""
SHOWN = (1.0, 2.0, 4.0, 6.0)
"""Free lengths over the radius at which its rate is listed."""
ACROSS, ALONG, ARM, LINK = 61.0, 91.0, 0.8, 6.0
"""Of the nutating body: moments of inertia [kg m2], places of the cords and their length [m]."""
TIMES = np.arange(0.0, 400.0, 0.1)
"""Of the readings of its axis [s]: modes are separated to 1/400 of a turn a second."""
MODEL = "okuizumi-model-1"
INERTIA = 1e-4
"""Of a free hub of the paper's sail, about its own when stowed [kg m2]."""
REPEATS, STEPS = 9, 400
"""Of the times: repeats, and steps in each."""


def main() -> None:
    """Print the tables, and write them into the page."""
    make = {"yo-yo": yo_yo, "nutation": nutation, "momentum": momentum, "order": order, "cost": cost}
    make_parts(__doc__, PARTS, make)


def yo_yo() -> str:
    """The rate of the hub by the free length of its cords, of cords as stiff and as light as said."""
    own = {
        "parts.one.axial_stiffness": 50.0,
        "parts.one.linear_density": scenes.load("yo-yo").value("parts.one.linear_density"),
    }
    light, stiff = own["parts.one.linear_density"], own["parts.one.axial_stiffness"]
    assert isinstance(light, float)
    assert isinstance(stiff, float)
    cases = {
        "the scene": (30, stiff, light),
        "60 segments": (60, stiff, light),
        "EA of 2 N": (30, 2.0, light),
        "cords of a tenth of the masses": (30, stiff, 10.0 * light),
    }
    body = []
    for label, (segments, modulus, density) in cases.items():
        values: dict[str, Any] = {}
        for part in ("one", "other"):
            values |= {
                f"parts.{part}.segments": segments,
                f"parts.{part}.axial_stiffness": modulus,
                f"parts.{part}.linear_density": density,
            }
        f, rate, energy, change = unwound(scenes.load("yo-yo").with_values(values))
        derived = (41.0 - f**2) / (41.0 + f**2)
        listed = [f"{np.interp(at, f, rate):.4f}" for at in SHOWN]
        inside = f <= SHOWN[-1]
        body.append((label, *listed, f"{np.abs(rate - derived)[inside].max():.4f}", f"{energy:.0e}", f"{change:.0e}"))
    closed = [f"{(41.0 - at**2) / (41.0 + at**2):.4f}" for at in SHOWN]
    body.insert(0, ("closed form", *closed, "-", "-", "-"))
    heads = ("cords", *(f"f = {at:g}" for at in SHOWN), "largest error", "energy error", "change of momentum")
    return table(heads, body, words=(0,))


def unwound(scene: Scene) -> tuple[Floats, Floats, float, float]:
    """Free length over radius and rate over that at the start of a yo-yo in time, its largest energy error, and the
    largest change of its angular momentum [-].
    """
    sim = Simulation(scene)
    start, before = sim.hub_rate, sim.angular_momentum().total
    tip = sim.assembly.node_sets["tether-0-end"][0]
    rows = []
    while True:
        sim.reach(sim.time + 1e-3)
        f = math.sqrt(max(0.0, float(np.hypot(*sim.positions[tip, :2]) / RADIUS) ** 2 - 1.0))
        rows.append(
            (f, sim.hub_rate / start, abs(sim.ledger()["error"]), abs(sim.angular_momentum().total / before - 1.0))
        )
        if f > SHOWN[-1]:
            f_of, rate, error, change = np.array(rows).T
            return f_of, rate, float(error.max()), float(change.max())


def modes(mass: float) -> Floats:
    """The modes mu of the tilt in space but for 0, by the equation of the page, with the mass of all tips [kg]."""
    reach = ARM + LINK
    ratio, kappa = reach / LINK, mass * reach**2 * ARM / (2.0 * LINK)
    tilt = np.polymul([-ACROSS, ALONG, kappa], [1.0, -2.0, 1.0 - ratio])
    roots = np.sort(np.roots(np.polyadd(tilt, [kappa * (ratio - 1.0)])).real)
    found: Floats = roots[np.abs(roots) > 1e-6]
    return found


def nutation() -> str:
    """Modes of the tilt of a body with four masses on cords: derived, and of its axis in a run."""
    body = []
    for each in (0.5, 2.0):
        rate = 1.0
        values: dict[str, Any] = {"laws.spin.tumble": 1e-3 / math.tau}
        for part in ("east", "north", "west", "south"):
            stretched = 1.0 + each * (ARM + LINK) * rate**2 / 2e4
            values |= {f"parts.{part}.tip_mass": each, f"parts.{part}.length": LINK / stretched}
        sim, axis = Simulation(scenes.load("nutating-hub").with_values(values)), []
        before = sim.angular_momentum().in_space
        for instant in TIMES.tolist():
            sim.reach(instant)
            axis.append(complex(*sim.hub_rotation[:2, 2]))
        change = np.linalg.norm(sim.angular_momentum().in_space - before) / np.linalg.norm(before)
        window = np.sin(np.pi * TIMES / TIMES[-1]) ** 2 * (np.array(axis) - np.mean(axis))
        for mode in modes(4.0 * each):
            near = mode + np.linspace(-0.02, 0.02, 401)
            seen = near[np.abs(np.exp(-1j * np.outer(near, TIMES)) @ window).argmax()]
            body.append((f"{each:g}", f"{mode:.4f}", f"{seen:.4f}", f"{change:.0e}"))
    return table(("each mass [kg]", "mu, derived", "mu, of the run", "change of momentum"), body)


def momentum() -> str:
    """Change of angular momentum, and energy error, of free hubs by both methods."""
    body = []
    for name, scene, until in cases():
        for method in ("leapfrog", "rk4"):
            sim = Simulation(replace(scene, run=replace(scene.run, integrator=method, dt=None)))
            before = sim.angular_momentum().in_space
            sim.reach(until)
            after = sim.angular_momentum().in_space
            parts = slice(None) if has_free_body(sim.scene) else slice(2, 3)
            change = np.linalg.norm((after - before - given(scene, until))[parts]) / np.linalg.norm(before[parts])
            steps = round(until / sim.dt)
            error = abs(sim.ledger()["error"])
            body.append((name, method, f"{1e6 * sim.dt:.1f}", f"{steps:,}", f"{change:.0e}", f"{error:.0e}"))
    return table(("scene", "method", "step [us]", "steps", "change of momentum", "energy error"), body, words=(0, 1))


def given(scene: Scene, until: float) -> Floats:
    """(3,) impulse of the torque on a hub on its axis [N m s]."""
    hub = hub_of(scene)
    torque = None if hub is None else hub.torque
    return np.array([0.0, 0.0, 0.0 if torque is None else torque.integral(0.0, until)])


def cases() -> list[tuple[str, Scene, float]]:
    """Scenes with a free hub, and how long they run [s]."""
    sail = freed(INERTIA)
    return [
        ("yo-yo", scenes.load("yo-yo"), 0.3),
        ("free-hub-disc", scenes.load("free-hub-disc"), 0.2),
        ("nutating-hub", scenes.load("nutating-hub"), 100.0),
        (f"{MODEL}, free hub, no air", sail, 0.2),
    ]


def freed(inertia: float | None) -> Scene:
    """The paper's sail from the cross on a free hub [kg m2] without air; None: on a driven one."""
    scene = scenes.load(MODEL)
    laws = [law for law in scene.laws if law.kind not in ("spin", "air_drag")]
    spin = Spin(scene.value("laws.spin.frequency"), inertia=inertia)
    return replace(scene, laws=[*laws, spin], run=RunSettings(until=1.0, integrator="leapfrog"))


def order() -> str:
    """Errors of position and rate against the step, of a taut body with masses on cords."""
    scene = scenes.load("nutating-hub").with_values({"laws.spin.tumble": 0.05})

    def at_end(method: str, dt: float) -> Floats:
        sim = Simulation(replace(scene, run=replace(scene.run, integrator=method, dt=dt)))
        sim.reach(2.0)
        return np.append(sim.positions.ravel(), [sim.hub_rate, *sim.hub_attitude])

    best = at_end("rk4", 2.0**-12)
    body = []
    for exponent in (7, 8, 9):
        row = []
        for method in ("leapfrog", "rk4"):
            errors = [np.abs(at_end(method, 2.0**-k) - best).max() for k in (exponent, exponent + 1)]
            row += [f"{errors[0]:.1e}", f"{math.log2(errors[0] / errors[1]):.2f}"]
        body.append((f"{1e3 * 2.0**-exponent:.2f}", *row))
    return table(("step [ms]", "leapfrog: error", "order", "rk4: error", "order"), body)


def cost() -> str:
    """Time of a step with a free hub over that with a driven one, each pair in turn."""
    body = []
    for method in ("leapfrog", "rk4"):
        pair = [
            Simulation(replace(scene, run=replace(scene.run, integrator=method, dt=1e-6)))
            for scene in (freed(None), freed(INERTIA))
        ]
        times = [[timed(sim) for sim in pair] for _ in range(REPEATS)]
        body.append((method, f"{median(free / driven for driven, free in times):.2f}"))
    return table(("method", "time of a step, over that with a driven hub"), body, words=(0,))


def timed(sim: Simulation) -> float:
    """Processor time of some steps [s]."""
    start = time.process_time()
    sim.step(STEPS)
    return time.process_time() - start


if __name__ == "__main__":
    main()
