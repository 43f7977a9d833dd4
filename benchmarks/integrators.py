"""The integrators side by side: orders, limits, energy, and the release of model 1. Takes some minutes.

python benchmarks/integrators.py            # prints the tables
python benchmarks/integrators.py --write    # puts them into docs/integrators.md
python benchmarks/integrators.py --only damping    # prints one of them
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from membrane_rs import (
    Gravity,
    MassDamping,
    RunSettings,
    Scene,
    Simulation,
    Spin,
    SpringDamping,
    Tether,
    UnstableError,
    integrators,
    scenes,
)
from membrane_rs._markdown import table
from membrane_rs.scene.laws import Law
from numpy.typing import NDArray
from page import DOCS, MarkedPart, show

PART = MarkedPart(DOCS / "integrators.md", "benchmarks/integrators.py")
Floats = NDArray[np.float64]

OMEGA = 10.0
"""Of 1 kg on a cord of 100 N/m [rad/s]; its weight of 10 N stretches the cord by 0.1 m."""
UNMONITORED = RunSettings(until=1.0, watch=10**9)


def cord(laws: Sequence[Law], axial_stiffness: float = 100.0, run: RunSettings = UNMONITORED) -> Scene:
    """1 kg on a massless cord of 1 m along x."""
    ends = {"start": (0.0, 0.0, 0.0), "end": (1.0, 0.0, 0.0)}
    part = Tether(**ends, segments=1, axial_stiffness=axial_stiffness, linear_density=0.0, tip_mass=1.0)  # type: ignore[arg-type]
    return Scene(None, None, list(laws), [replace(part, strain_limit=1e9)], run=run)


def released(
    scene: Scene, name: str, dt: float | None, position: Sequence[float], velocity: Sequence[float]
) -> Simulation:
    """The mass at `position` (3,) [m] with `velocity` (3,) [m/s]."""
    sim = Simulation(scene, name, dt)
    sim.positions = [[0.0, 0.0, 0.0], list(position)]
    sim.velocities = [[0.0, 0.0, 0.0], list(velocity)]
    return sim


def slope(errors: Callable[[int], float], counts: Sequence[int]) -> float:
    """Order of convergence: the slope of error against step, fitted."""
    found = [errors(count) for count in counts]
    return float(-np.polyfit(np.log(counts), np.log(found), 1)[0])


def smooth_error(name: str, count: int) -> float:
    """Error on a linear oscillator, against its closed form at omega t = 5, after `count` steps [m]."""
    sim = released(cord([Gravity((10.0, 0.0, 0.0))]), name, 0.5 / count, (1.11, 0.0, 0.0), (0.0, 0.0, 0.0))
    sim.step(count)
    exact = (1.1 + 0.01 * math.cos(5.0), -0.01 * OMEGA * math.sin(5.0))
    return math.hypot(sim.positions[1, 0] - exact[0], (sim.velocities[1, 0] - exact[1]) / OMEGA)


def damped_order(name: str) -> float:
    """Order on a mass on a turning hub, with a dashpot of half the critical damping, friction and Coriolis force."""
    laws: list[Law] = [Spin(1.0, 0.1), SpringDamping(0.5), MassDamping(1.0)]
    motion = ((1.4, 0.3, 0.1), (0.5, 1.0, -0.5))

    def end(name: str, count: int) -> Floats:
        sim = released(cord(laws), name, 0.5 / count, *motion)
        sim.step(count)
        place: Floats = sim.positions[1]
        return place

    exact = end("dopri5", 4000)
    return slope(lambda count: float(np.linalg.norm(end(name, count) - exact)), (100, 200, 400))


def bounce(time: float) -> float:
    """Position of the mass that falls from 1.3 m: alternating arcs of a cosine and free flight [m]."""
    taut = math.acos(-0.5) / OMEGA
    speed = 0.2 * OMEGA * math.sin(OMEGA * taut)
    flight = 2 * speed / 10.0
    phase = (time + taut) % (2 * taut + flight)
    if phase < 2 * taut:
        return 1.1 + 0.2 * math.cos(OMEGA * (phase - taut))
    since = phase - 2 * taut
    return 1.0 - speed * since + 5.0 * since * since


def kinked_error(name: str, count: int) -> float:
    """Error on a cord that becomes slack and taut four times: the force has kinks there, as those of buckling and
    contact have. It depends on the place of the kink in the step: root mean square over 24 steps [m].
    """
    squares = []
    for extra in range(24):
        steps = count + extra * count // 48
        sim = released(cord([Gravity((10.0, 0.0, 0.0))]), name, 1.9 / steps, (1.3, 0.0, 0.0), (0.0, 0.0, 0.0))
        sim.step(steps)
        squares.append((sim.positions[1, 0] - bounce(1.9)) ** 2)
    return math.sqrt(float(np.mean(squares)))


def limit(grows: Callable[[float], bool], predicted: float) -> float:
    """The step at which growth sets in, by bisection around the predicted one."""
    low, high = 0.9 * predicted, 1.1 * predicted
    while high / low > 1.001:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if grows(middle) else (middle, high)
    return 0.5 * (low + high)


def imaginary_limit(name: str, predicted: float) -> float:
    """Measured limit of omega dt on an undamped oscillation."""

    def grows(z: float) -> bool:
        scene = cord([Gravity((10.0, 0.0, 0.0))])
        sim = released(scene, name, z / OMEGA, (1.1 + 1e-9, 0.0, 0.0), (0.0, 0.0, 0.0))
        sizes = np.empty(30_000)
        for k in range(len(sizes)):
            sim.step()
            sizes[k] = abs(sim.positions[1, 0] - 1.1)
        # An unstable run ends in oscillations of the slack cord, or in NaN.
        return not bool(sizes[-5000:].max() <= min(1.05 * sizes[:300].max(), 1e-6))

    return limit(grows, predicted)


def real_limit(name: str, predicted: float) -> float:
    """Measured limit of rate times dt on pure friction."""

    def grows(z: float) -> bool:
        scene = cord([MassDamping(1.0)], axial_stiffness=1e-15)
        sim = released(scene, name, z, (1.0, 0.0, 0.0), (0.0, 1e-9, 0.0))
        sim.step(2000)
        return bool(abs(sim.velocities[1, 1]) > 1e-9)

    return limit(grows, predicted)


def energy_error(name: str, oscillations: int) -> float:
    """Worst energy error over the last oscillations of an undamped one, at omega dt = 1/2, as a share of its energy."""
    sim = released(cord([Gravity((10.0, 0.0, 0.0))]), name, 0.5 / OMEGA, (1.15, 0.0, 0.0), (0.0, 0.0, 0.0))
    energy = 0.5 * (OMEGA * 0.05) ** 2
    start = math.fsum(sim.energies().values())
    sim.step(round(oscillations * 4 * math.pi) - 40)
    worst = 0.0
    for _ in range(40):
        sim.step()
        off = (math.fsum(sim.energies().values()) - start) / energy
        worst = off if abs(off) > abs(worst) else worst
    return worst


def facts_table() -> str:
    """Stated and measured properties of each method."""
    head = (
        "method",
        "order",
        "smooth",
        "damped, Coriolis",
        "kinked",
        "evaluations a step",
        r"limit of \|lambda\| dt on the imaginary axis",
        "measured",
        r"limit of \|lambda\| dt on the real axis",
        "measured",
    )
    rows = []
    for name, facts in integrators().items():
        measured = (
            slope(lambda count, name=name: smooth_error(name, count), (50, 100, 200)),  # type: ignore[misc]
            damped_order(name),
            slope(lambda count, name=name: kinked_error(name, count), (400, 800, 1600, 3200)),  # type: ignore[misc]
        )
        orders = (f"{order:.2f}" for order in measured)
        axes = (
            *measured_limit(name, facts.imaginary_limit, imaginary_limit),
            *measured_limit(name, facts.real_limit, real_limit),
        )
        rows.append((name, str(facts.order), *orders, str(facts.evaluations), *axes))
    return table(head, rows)


def measured_limit(name: str, predicted: float, measure: Callable[[str, float], float]) -> tuple[str, str]:
    """The predicted limit, and the measured one of a method with a limit."""
    return (f"{predicted:.3f}", f"{measure(name, predicted):.3f}") if math.isfinite(predicted) else ("none", "-")


def cost_table(smooth: int = 600, kinked: int = 4800) -> str:
    """Errors at equal cost."""
    rows = []
    for name, facts in integrators().items():
        errors = smooth_error(name, smooth // facts.evaluations), kinked_error(name, kinked // facts.evaluations)
        rows.append((name, *(f"{error:.1e}" for error in errors)))
    return table(("error [m]", f"smooth, {smooth:,} evaluations", f"kinked, {kinked:,} evaluations"), rows)


def energy_table() -> str:
    """Energy error of an undamped oscillation."""
    counts = (100, 1000, 10_000, 100_000)
    head = (
        "energy error at omega dt = 0.5, after",
        *(f"{count:,}" for count in counts[:-1]),
        f"{counts[-1]:,} oscillations",
    )
    return table(head, [(name, *(f"{100 * energy_error(name, n):+.3g} %" for n in counts)) for name in integrators()])


def release_table(until: float = 5e-3) -> str:
    """The first 5 ms of the release of model 1, the most demanding: cost and energy error."""
    scene = scenes.load("okuizumi-model-1")
    limits = {name: Simulation(scene, name, 1e-7).stable_dt() for name in integrators()}
    runs: list[tuple[str, str, float | None, float]] = [
        (f"{name}, {share:g} of its limit", name, share * limits[name], 1e-6)
        for name in integrators()
        if math.isfinite(limits[name])
        for share in (0.4, 0.5, 0.8)
    ]
    runs += [
        (f"{name}, {dt / limits['rk4']:.0f} of rk4's limit", name, dt, 1e-6)
        for name in integrators()
        if not math.isfinite(limits[name])
        for dt in (1e-5, 5e-5)
    ]
    runs += [(f"dopri5, tolerance {tolerance:g}", "dopri5", None, tolerance) for tolerance in (1e-3, 1e-4, 1e-5, 1e-6)]
    rows = []
    for label, name, dt, tolerance in runs:
        sim = Simulation(replace(scene, run=replace(scene.run, tolerance=tolerance)), name, dt)
        try:
            sim.run(until=until, frames=2, samples=2)
            reached, count, error = sim.time, sim.step_count, f"{100 * sim.ledger()['error']:+.4f} %"
        except UnstableError as fault:  # the simulation itself is back at the last good check
            reached, count, error = fault.time, fault.step, f"stopped at {1e3 * fault.time:.3f} ms"
        step = 1e6 * (reached / count if dt is None else sim.dt)
        steps = f"{count:,} ({sim.rejected_count:,})"
        rows.append((label, f"{step:.2f}", steps, f"{sim.evaluation_count:,}", error))
    return table(("model 1, first 5 ms", "step [us]", "steps (rejected)", "evaluations", "energy error"), rows)


def relaxation_table() -> str:
    """A crease that relaxes against friction: only its slow motion is of interest."""
    scene = scenes.load("single-crease")
    scene = replace(scene, run=replace(scene.run, energy_loss=10.0))
    until = scene.run.until
    explicit = Simulation(scene, "rk4", 1e-9).stable_dt()

    def run(name: str, dt: float) -> tuple[Simulation, float]:
        sim = Simulation(scene, name, until / math.ceil(until / dt))
        began = time.process_time()
        sim.step(round(until / sim.dt))
        return sim, time.process_time() - began

    exact = run("rk4", 0.1 * explicit)[0].positions
    counted = ("evaluations", "factorisations", "halved steps")
    head = ("single-crease, 0.3 s", "step, of rk4's limit", *counted, "processor [ms]", "error [m]")
    rows = []
    for name, facts in integrators().items():
        has_limit = math.isfinite(facts.imaginary_limit)
        limit = Simulation(scene, name, 1e-9).stable_dt()
        for dt in (0.4 * limit, 0.9 * limit) if has_limit else (1e-4, 3e-4, 1e-3, 2e-3):
            tries = [run(name, dt) for _ in range(3)]
            sim, seconds = tries[0][0], min(seconds for _, seconds in tries)
            error = float(np.abs(sim.positions - exact).max())
            counts = (sim.evaluation_count, sim.statistics["factorisations"], sim.statistics["fallbacks"])
            cells = (*(f"{count:,}" for count in counts), f"{1e3 * seconds:.1f}", f"{error:.1e}")
            rows.append((name, f"{sim.dt / explicit:.2g}", *cells))
    return table(head, rows)


def damping_table() -> str:
    """Reduction of leapfrog's limit by damping: the most that a stabilised method could regain."""
    rows = []
    for name in scenes.for_any_method():
        sim = Simulation(scenes.load(name), "leapfrog", 1e-9)
        found = sim._core.limit()
        limit, omega = found.dt, found.largest_frequency
        rows.append((name, f"{limit:.3g}", f"{limit * omega:.2f}", f"{100 * (1 - limit * omega / 2):.1f} %"))
    return table(("scene", "leapfrog's limit [s]", "omega_max dt [-]", "reduction relative to 2"), rows)


def tangent_table(steps: int = 5) -> str:
    """Cost of a factorisation of the tangent, with the rest of the Newton iterations."""
    rows = []
    for name in scenes.for_any_method():
        sim = Simulation(scenes.load(name), "generalized_alpha", 1e-6)
        sim.step(1)
        began, before = time.process_time(), sim.statistics["factorisations"]
        sim.step(steps)
        cost = 1e3 * (time.process_time() - began) / (sim.statistics["factorisations"] - before)
        rows.append((name, f"{sim.node_count - len(sim.assembly.fixed):,}", f"{cost:.2f}"))
    return table(("scene", "free nodes", "processor time of a factorisation [ms]"), rows)


TABLES: dict[str, Callable[[], str]] = {
    "facts": facts_table,
    "cost": cost_table,
    "energy": energy_table,
    "release": release_table,
    "relaxation": relaxation_table,
    "tangent": tangent_table,
    "damping": damping_table,
}
"""In the order of the page."""


def main() -> None:
    """Measure, print, and write if asked."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    chosen = parser.add_mutually_exclusive_group()
    chosen.add_argument("--write", action="store_true", help="put the tables into docs/integrators.md")
    chosen.add_argument("--only", nargs="+", choices=TABLES, default=list(TABLES), help="print these tables alone")
    options = parser.parse_args()
    show(PART, "\n".join(TABLES[name]() for name in options.only), write=options.write)


if __name__ == "__main__":
    main()
