"""What the dashpots of cords do: a tip thrown up on a slack cord, and the tip of the spinning tether."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
from dashpot_forms import ALL, DEFAULT, FORMS, NONE, PAPER, damped
from kept import kept, slug
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from membrane_rs import Gravity, RunSettings, Scene, Simulation, SpringDamping, Tether, scenes
from membrane_rs._arrays import Floats
from membrane_rs._markdown import table
from membrane_rs.plotting.figure import save_figure
from membrane_rs.study.common.perturbation import SHIFT
from scipy.integrate import solve_ivp

GRAVITY, STIFFNESS, TIP, LENGTH = 9.81, 100.0, 1.0, 1.0
"""Of the tip that is thrown up: m/s2, N/m, kg, m."""
START, SPEED, INSTANT = -0.5, 1.0, 0.4
"""Height below the support [m], velocity upwards [m/s], and time of the reading [s]."""
TIMES = np.linspace(0.0, 1.5, 150001)
"""Instants of the motion, and steps of the simulation [s]."""
OF_TENSION, NEAR = 10, 0.005
"""Instants from one reading of the tension to the next; each is one where the stretch is less than this [m]."""
RAMPS = (0.001, 0.01, 0.1)
"""Elongations over which a ramp brings the dashpot to its full coefficient [m]."""
Tension = Callable[[float, float], float]
"""Tension of the cord [N], of its stretch [m] and its rate [m/s]."""

STEP = 2e-6
"""Of the spinning tether by rk4, for all forms [s]: a fifteenth of the limit."""
STARTS = 3
"""The unperturbed start and perturbed ones."""
SAMPLES = 1000
SLACK = 0.2979
"""Length of the tether without load [m]."""


@dataclass(frozen=True)
class Case:
    """A start of the spinning tether: its own, or slack at rest in the turning frame but for its tip's velocity."""

    name: str
    until: float
    segments: int = 10
    distance: float | None = None
    """Of the tip from the anchor at the start, over the cord's length [-]; None: the scene's own start."""
    throw: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Velocity of the tip in the turning frame [m/s]; that of the cord falls off to 0 at the anchor."""


CASES = (
    Case("spinning, taut", 1.0),
    Case("thrown slack, ten segments", 0.5, distance=0.7, throw=(0.0, 0.0, 2.0)),
    Case("thrown slack, one segment", 0.5, segments=1, distance=0.7, throw=(0.0, 0.0, 2.0)),
)
Curves = Mapping[str, Mapping[str, Sequence[Mapping[str, Floats]]]]
"""By case and form: from each start time [s], tip (k, 3) [m], pull [N], loss [J], angle [deg] and distance [m]."""


def thrown_tip() -> str:
    """A tip thrown up on a slack cord of one segment: its fall, the cord's push, and its bounce."""
    coefficient = 2 * SpringDamping().ratio * math.sqrt(STIFFNESS * TIP / 2)

    def ramp(width: float, stretch: float, rate: float) -> float:
        share = min(max(stretch / width, 0.0), 1.0)
        return STIFFNESS * max(stretch, 0.0) + share**2 * (3 - 2 * share) * coefficient * rate

    body = [simulated("the paper's", FORMS[PAPER]), simulated("limited", FORMS[DEFAULT])]
    body += [integrated(f"ramp over {1e3 * width:g} mm", partial(ramp, width)) for width in RAMPS]
    free = SPEED * INSTANT - GRAVITY * INSTANT**2 / 2
    heads = (
        "dashpot",
        f"moved in {INSTANT:g} s [m]",
        "largest push of the cord [N]",
        "largest stiffness / k",
        "speed after / before the bounce",
    )
    return f"{table(heads, body)}\nIn free fall the tip would move by {free:.3f} m."


def integrated(name: str, tension: Tension) -> tuple[str, ...]:
    """A row of a form that the simulator does not have, by the equation of its one coordinate."""

    def motion(_: float, state: Floats) -> list[float]:
        height, velocity = state
        return [velocity, tension(-height - LENGTH, -velocity) / TIP - GRAVITY]

    found = solve_ivp(motion, (0.0, TIMES[-1]), [START, SPEED], t_eval=TIMES, rtol=1e-10, atol=1e-12, max_step=1e-3)
    return bounce(name, found.y[0], found.y[1], tension)


def simulated(name: str, law: SpringDamping) -> tuple[str, ...]:
    """A row of a form that the simulator has, by the simulator: the motion and the tension."""
    cord = Tether((0, 0, 0), (0, 0, -LENGTH), 1, STIFFNESS * LENGTH, 0.0, tip_mass=TIP, strain_limit=1e6)
    scene = Scene(None, None, [Gravity((0, 0, -GRAVITY)), law], [cord], run=RunSettings(until=TIMES[-1]))
    sim, probe = (Simulation(scene, "rk4", dt=TIMES[1]) for _ in range(2))

    def put(one: Simulation, height: float, velocity: float) -> None:
        one.positions = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, height]])
        one.velocities = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, velocity]])

    def tension(stretch: float, rate: float) -> float:
        put(probe, -LENGTH - stretch, -rate)
        return float(probe.forces("tethers")[1, 2] + probe.forces("spring_damping")[1, 2])

    put(sim, START, SPEED)
    states = np.empty((len(TIMES), 2))
    for row in states:
        row[:] = sim.positions[1, 2], sim.velocities[1, 2]
        sim.step(1)
    return bounce(name, states[:, 0], states[:, 1], tension)


def bounce(name: str, height: Floats, velocity: Floats, tension: Tension) -> tuple[str, ...]:
    """The row of a motion: up to the end of its first bounce."""
    stretch, rate = -height - LENGTH, -velocity
    taut = int(np.flatnonzero(stretch > 0.0)[0])
    after = taut + int(np.flatnonzero(stretch[taut:] < 0.0)[0])
    is_read = np.abs(stretch[:after]) < NEAR
    is_read[::OF_TENSION] = True
    read, slope = np.flatnonzero(is_read), 1e-7
    pulls, bent = (
        np.array([tension(s + more, r) for s, r in zip(stretch[read], rate[read], strict=True)])
        for more in (0.0, slope)
    )
    stiffness = float(np.abs(bent - pulls)[stretch[read] > 0.0].max()) / slope
    moved = float(np.interp(INSTANT, TIMES, height)) - START
    loss = abs(float(velocity[after] / velocity[taut]))
    return name, f"{moved:.3f}", f"{max(0.0, -pulls.min()):.2f}", f"{stiffness / STIFFNESS:.1f}", f"{loss:.4f}"


def tether_curves(folder: Path, until: float | None = None) -> Curves:
    """All runs of the spinning tether, those in `folder` read, the others made; `until` [s] ends them earlier."""
    found: dict[str, dict[str, list[Mapping[str, Floats]]]] = {}
    for case in CASES:
        end = min(case.until, until or case.until)
        for form, damping in FORMS.items():
            for start in range(STARTS):
                file = folder / f"{slug('tether', case.name, form, start, f'{end:g}')}.npz"
                curve = kept(file, partial(tether_run, replace(case, until=end), damping, start))
                found.setdefault(case.name, {}).setdefault(form, []).append(curve)
        print(f"spinning tether, {case.name}", flush=True)
    return found


def tether_run(case: Case, damping: SpringDamping, start: int) -> dict[str, Floats]:
    """Motion of the tip and pull of the cord on the hub, sampled evenly."""
    scene = damped(scenes.load("spinning-tether"), damping)
    part = scene.parts[0]
    assert isinstance(part, Tether)
    assert part.length == SLACK
    run = replace(scene.run, until=case.until, snapshots=())
    scene = replace(scene, parts=[replace(part, segments=case.segments)], run=run)
    sim = Simulation(scene, "rk4", dt=STEP)
    points, velocities = sim.positions, sim.velocities
    anchor, shares = points[0], np.linspace(0.0, 1.0, len(points))
    if case.distance is not None:
        points = anchor + np.outer(shares, [case.distance * SLACK, 0.0, 0.0])
        velocities = np.outer(shares, case.throw)
    shift = SHIFT * np.random.default_rng(start).standard_normal(points.shape) if start else np.zeros(points.shape)
    shift[0] = 0.0
    sim.positions, sim.velocities = points + shift, velocities
    times = np.linspace(0.0, case.until, SAMPLES + 1)
    tip, pull, loss = np.empty((len(times), 3)), np.empty(len(times)), np.empty(len(times))
    for k, time in enumerate(times):
        sim.reach(time)
        now = sim.positions
        along = now[1] - now[0]
        tip[k], loss[k] = now[-1], -sim.ledger()["work"]
        pull[k] = sim.hub_force() @ along / np.linalg.norm(along)
    radial = tip - anchor
    angle = np.degrees(np.arctan2(radial[:, 1], radial[:, 0]))
    distance = np.linalg.norm(radial, axis=1)
    return {"time": times, "tip": tip, "pull": pull, "loss": loss, "angle": angle, "distance": distance}


def tether_table(curves: Curves) -> str:
    """The tip's distance from its motion with the paper's form, the pull on the hub, the energy taken by dashpots."""
    body = []
    for case, forms in curves.items():
        paper = mean_tip(forms[PAPER])
        check_same(forms[DEFAULT][0], forms[ALL][0])
        for form, runs in forms.items():
            apart = 1e3 * float(np.linalg.norm(mean_tip(runs) - paper, axis=1).max())
            spread = 1e3 * max(float(np.linalg.norm(a["tip"] - b["tip"], axis=1).max()) for a in runs for b in runs)
            pull, loss = runs[0]["pull"], 1e3 * runs[0]["loss"]
            is_slack = runs[0]["distance"][1:] < SLACK
            taken = float(loss[-1]) + 0.0, float(np.diff(loss)[is_slack].sum()) + 0.0
            values = (f"{spread:.2f}", f"{pull.max():.3f}", f"{pull.min():.3f}", *(f"{each:.2g}" for each in taken))
            body.append((case, form, "-" if form == PAPER else f"{apart:.2f}", *values))
    heads = (
        "start",
        "dashpots",
        "tip apart [mm]",
        "spread [mm]",
        "largest pull on the hub [N]",
        "least [N]",
        "taken by dashpots [mJ]",
        "of it slack [mJ]",
    )
    return table(heads, body, words=(0, 1))


def check_same(one: Mapping[str, Floats], other: Mapping[str, Floats]) -> None:
    """Raise AssertionError where two runs differ in a bit: a scene without film has no dashpots of it to limit."""
    for key, values in one.items():
        assert np.array_equal(values, other[key]), key


def mean_tip(runs: Sequence[Mapping[str, Floats]]) -> Floats:
    """(k, 3) the mean motion of the tip [m]."""
    return np.asarray(np.mean([run["tip"] for run in runs], axis=0))


def tether_picture(curves: Curves, path: Path) -> None:
    """A column for each case: motion of the tip above, pull on the hub below, a line for each form."""
    figure = Figure(figsize=(5.0 * len(curves) + 0.6, 6.4), layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(2, len(curves), sharex="col", squeeze=False)
    looks = dict(zip(FORMS, ("C3", "C0", "C9", "C2", "C1", "0.6"), strict=True))
    for (case, forms), (above, below) in zip(curves.items(), panels.T, strict=True):
        if case == CASES[0].name:
            motion = "angle"
            above.set_ylabel("Angle of the tip [deg]")
        else:
            motion = "distance"
            above.set_ylabel("Distance from the anchor [m]")
            above.axhline(SLACK, color="k", linestyle=":", linewidth=1.0)
        for form, runs in forms.items():
            style = "--" if form == ALL else "-"
            look = {"color": looks[form], "linewidth": 1.2, "linestyle": style, "zorder": 1 if form == NONE else 2}
            above.plot(runs[0]["time"], runs[0][motion], label=form, **look)
            below.plot(runs[0]["time"], runs[0]["pull"], **look)
        above.set_title(case)
        below.set_ylabel("Pull on the hub [N]")
        below.set_xlabel("Time [s]")
        for axes in (above, below):
            axes.grid(color="0.9")
            axes.set_axisbelow(True)
            axes.margins(x=0.0)
            axes.spines[["top", "right"]].set_visible(False)
    figure.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=3, frameon=False)
    save_figure(figure, path)
