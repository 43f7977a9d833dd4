"""Forms of the dashpots compared, for docs/dashpots.md: both sails, a tip on a slack cord, limits of the step.

Takes some minutes on two cores. With `--write` the tables of docs/dashpots.md are replaced.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from marked import DOCS, MarkedPart
from membrane_rs import Gravity, RunSettings, Scene, Simulation, SpringDamping, Tether, scenes
from membrane_rs._markdown import table
from membrane_rs.study.common.run import StudyRun, ensemble, study_case
from scipy.integrate import solve_ivp

PARTS = {name: MarkedPart(DOCS / "dashpots.md", name) for name in ("curves", "thrown-tip", "limits")}
MODELS = ("okuizumi-model-1", "okuizumi-model-2")
END, INSTANTS = 0.8, 400
"""Of the runs of the sails [s]."""
MEMBERS = 2
"""Perturbed starts of each form, beside the unperturbed one."""
FORMS: dict[str, SpringDamping] = {
    "the paper's: mean mass, no limit": SpringDamping(limited="none"),
    "cords limited (the default)": SpringDamping(),
    "cords and film limited": SpringDamping(limited="all"),
    "reduced mass, cords limited": SpringDamping(mass="reduced"),
}
PAPER, DEFAULT = list(FORMS)[:2]
GRAVITY, STIFFNESS, TIP, LENGTH = 9.81, 100.0, 1.0, 1.0
"""Of the thrown tip: m/s2, N/m, kg, m."""
START, SPEED, INSTANT = -0.5, 1.0, 0.4
"""Height below the support [m], velocity upwards [m/s], and time of the reading [s]."""
RAMPS = (0.001, 0.01, 0.1)
"""Elongations over which a ramp brings the dashpot to its full coefficient [m]."""


def main() -> None:
    """Make the tables, or some of them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--only", nargs="+", choices=list(PARTS), default=list(PARTS), help="the tables to make")
    parser.add_argument("--until", type=float, default=END, help="a brief run: end here [s], with fewer scenes")
    parser.add_argument("--jobs", type=int, help="number of parallel runs; default: one on each core")
    parser.add_argument("--write", action="store_true", help="write into docs/")
    options = parser.parse_args()
    began = time.perf_counter()
    models = MODELS if options.until >= END else ()
    makers: dict[str, Callable[[], str]] = {
        "thrown-tip": thrown_tip,
        "limits": lambda: limits(models),
        "curves": lambda: curves(models or MODELS[:1], options.until, options.jobs),
    }
    for name, make in makers.items():
        if name in options.only:
            text = make()
            print(f"{name}\n\n{text}", flush=True)
            if options.write:
                PARTS[name].write(text)
    print(f"{time.perf_counter() - began:.0f} s")


def damped(scene: Scene, damping: SpringDamping) -> Scene:
    """The scene with these dashpots in place of its own, at its own ratio."""
    own = scene.law(SpringDamping)
    law = replace(damping, ratio=own.ratio) if own and damping.ratio else damping
    return replace(scene, laws=[law if each.kind == law.kind else each for each in scene.laws])


def curves(models: Sequence[str], until: float, jobs: int | None) -> str:
    """Distance of the mean curves of each form from those of the paper's, and the spread of each."""
    body = []
    for model in models:
        scene = scenes.load(model)
        means: dict[str, tuple[np.ndarray, np.ndarray]] = {}
        for form, damping in FORMS.items():
            case = study_case(damped(replace(scene, run=replace(scene.run, substeps=4)), damping), until, INSTANTS)
            runs = ensemble(
                case, "leapfrog", Simulation(case.scene, "leapfrog").dt, MEMBERS if until >= END else 0, jobs=jobs
            )
            rate, phase = (np.array([curve(run.completed()) for run in runs]) for curve in (rate_of, phase_of))
            means[form] = rate.mean(axis=0), phase.mean(axis=0)
            spread = [float(np.ptp(each, axis=0).max()) for each in (rate, phase)]
            apart = [float(np.abs(own - paper).max()) for own, paper in zip(means[form], means[PAPER], strict=True)]
            distance = ("-", "-") if form == PAPER else (f"{apart[0]:.3f}", f"{apart[1]:.1f}")
            body.append((model, form, *distance, f"{spread[0]:.3f}", f"{spread[1]:.1f}"))
            print("|", *body[-1], flush=True)
    heads = ("scene", "dashpots", "rate", "phase [deg]", "spread of the rate", "of the phase [deg]")
    return table(heads, body, words=(0, 1))


def rate_of(run: StudyRun) -> np.ndarray:
    """The deployment rate."""
    return run.rate


def phase_of(run: StudyRun) -> np.ndarray:
    """The phase difference [deg]."""
    return run.phase


def thrown_tip() -> str:
    """A tip thrown up on a slack cord of one segment: its fall, the cord's push, and its bounce."""
    coefficient = 2 * SpringDamping().ratio * math.sqrt(STIFFNESS * TIP / 2)

    def paper(stretch: float, rate: float) -> float:
        return STIFFNESS * max(stretch, 0.0) + coefficient * rate

    def limited(stretch: float, rate: float) -> float:
        elastic = STIFFNESS * max(stretch, 0.0)
        return elastic + min(max(coefficient * rate, -elastic), elastic)

    def ramp(width: float) -> Callable[[float, float], float]:
        def tension(stretch: float, rate: float) -> float:
            share = min(max(stretch / width, 0.0), 1.0)
            return STIFFNESS * max(stretch, 0.0) + share**2 * (3 - 2 * share) * coefficient * rate

        return tension

    forms = [("the paper's", paper, FORMS[PAPER]), ("limited", limited, FORMS[DEFAULT])]
    body = [bounce(name, tension, law) for name, tension, law in forms]
    body += [bounce(f"ramp over {1e3 * width:g} mm", ramp(width), None) for width in RAMPS]
    free = SPEED * INSTANT - GRAVITY * INSTANT**2 / 2
    heads = (
        "dashpot",
        f"moved in {INSTANT:g} s [m]",
        "largest push of the cord [N]",
        "largest stiffness / k",
        "speed after / before the bounce",
    )
    return f"{table(heads, body)}\nIn free fall the tip would move by {free:.3f} m."


def bounce(name: str, tension: Callable[[float, float], float], law: SpringDamping | None) -> tuple[str, ...]:
    """A row: by closed equations of one coordinate, and where there is a law for it by a simulation too."""

    def motion(_: float, state: np.ndarray) -> list[float]:
        height, velocity = state
        return [velocity, tension(-height - LENGTH, -velocity) / TIP - GRAVITY]

    times = np.linspace(0.0, 1.5, 150001)
    found = solve_ivp(motion, (0.0, times[-1]), [START, SPEED], t_eval=times, rtol=1e-10, atol=1e-12, max_step=1e-3)
    height, velocity = found.y
    moved = float(np.interp(INSTANT, times, height)) - START
    if law is not None:
        assert abs(simulated_height(law) - START - moved) < 1e-5
    stretch, rate = -height - LENGTH, -velocity
    taut = np.flatnonzero(stretch > 0.0)
    after = taut[0] + int(np.flatnonzero(stretch[taut[0] :] < 0.0)[0])
    part = slice(taut[0], after)
    pulls = np.array([tension(s, r) for s, r in zip(stretch[part], rate[part], strict=True)])
    before = np.array([tension(s, r) for s, r in zip(stretch[: taut[0]], rate[: taut[0]], strict=True)])
    slope = 1e-7
    stiffness = max(abs(tension(s + slope, r) - tension(s, r)) / slope for s, r in zip(stretch, rate, strict=True))
    push = max(0.0, -float(pulls.min()), -float(before.min()))
    loss = abs(float(velocity[after] / velocity[taut[0]]))
    return name, f"{moved:.3f}", f"{push:.2f}", f"{stiffness / STIFFNESS:.1f}", f"{loss:.4f}"


def simulated_height(law: SpringDamping) -> float:
    """The height of the thrown tip at `INSTANT` [m], by the core."""
    cord = Tether((0, 0, 0), (0, 0, -LENGTH), 1, STIFFNESS * LENGTH, 0.0, tip_mass=TIP, strain_limit=1e6)
    scene = Scene(None, None, [Gravity((0, 0, -GRAVITY)), law], [cord], run=RunSettings(until=INSTANT))
    sim = Simulation(scene, "rk4", dt=1e-4)
    sim.positions = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, START]])
    sim.velocities = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, SPEED]])
    sim.step(round(INSTANT / 1e-4))
    return float(sim.positions[1, 2])


def limits(models: Sequence[str]) -> str:
    """The limit of the step without dashpots and with those of each mass."""
    forms = {
        "none": SpringDamping(0.0),
        "mean mass": SpringDamping(),
        "reduced mass": SpringDamping(mass="reduced"),
    }
    body = []
    for name in ("spinning-tether", *models):
        for method in ("leapfrog", "rk4"):
            base = math.nan
            for form, damping in forms.items():
                sim = Simulation(damped(scenes.load(name), damping), method)
                limit = sim.stable_dt()
                base = limit if form == "none" else base
                body.append((name, method, form, f"{1e6 * limit:.2f}", f"{limit / base:.2f}", sim.limiting_part))
    heads = ("scene", "method", "dashpots", "limit [us]", "relative", "set by")
    return table(heads, body, words=(0, 1, 2, 5))


if __name__ == "__main__":
    main()
