"""The paper's three parameters, found again from noisy curves: the tables and the figure of docs/calibration.md; and
how often the intervals that a fit gives hold the true values.

The sail is that of model 1 on a coarse mesh, so that a fit takes minutes. The data are one of its runs with the paper's
parameters, from a start that no fit has, with noise. A rough fit of one start begins elsewhere; fits of several starts
go on from it: to the rate alone, and to both curves of the deployment. Another one, to both with less noise, begins at
the best of a small sweep. What other data would determine follows from the derivatives at the true values.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from marked import DOCS, ROOT, MarkedPart, copy_small
from membrane_rs import Scene, run, scenes
from membrane_rs._arrays import Floats
from membrane_rs._markdown import table
from membrane_rs.results import Experiment
from membrane_rs.study import Calibration, calibrate, sweep
from membrane_rs.study.calibration.analysis import NORMAL_95, UNDETERMINED, analysed
from membrane_rs.study.calibration.model import DataColumn, FitModel
from membrane_rs.study.common.many_runs import ManyRuns
from membrane_rs.study.common.one_run import RunPoint, RunSetup
from membrane_rs.study.common.vary import parameters_of

MEASURED = MarkedPart(DOCS / "calibration.md", "measures.md")
KNOWN = MarkedPart(DOCS / "calibration.md", "determined.md")
FITTED = MarkedPart(DOCS / "calibration.md", "calibration.md")
COVERAGE = MarkedPart(DOCS / "calibration.md", "coverage.md")
REPEATS = 40
"""Sets of noisy data, each of which is fitted."""
FIGURE = "calibration.png"
COARSE = {"mesh.rows": 8, "mesh.columns": 6, "run.integrator": "leapfrog"}
UNTIL, SAMPLES, EVERY = 0.15, 151, 5
"""Time of the data [s], rows of a run, and rows from one datum to the next."""
DATA = {
    "rate": {"deployment_rate": 0.003},
    "rate, phase": {"deployment_rate": 0.003, "phase_difference_deg": 0.5},
    "both, torque": {"deployment_rate": 0.003, "phase_difference_deg": 0.5, "hub_torque": 3e-4},
    "both, accurate": {"deployment_rate": 0.001, "phase_difference_deg": 0.05},
}
"""Standard deviations of data, by column."""
BOTH, TORQUE, ACCURATE = (DATA[name] for name in ("rate, phase", "both, torque", "both, accurate"))
UNITS = {
    "deployment_rate": "",
    "phase_difference_deg": "deg",
    "hub_torque": "N m",
    "hub_force": "N",
    "largest_cord_tension": "N",
}
FITS = (("rate", False), ("rate, phase", False), ("both, accurate", True))
"""Data that are fitted, and whether the fit begins at the best of a sweep."""
RANGES = {
    "laws.springs.buckling": "10:1000:log",
    "laws.creases.stiffness": "1:100:log",
    "laws.creases.contact_penalty": "10:1000:log",
}
ROUGH, SWEPT = 30, 4
"""Runs of the fit by which the others begin, from one start; values of beta and of gamma in the sweep that follows."""
BEGIN = {"laws.springs.buckling": 300.0, "laws.creases.stiffness": 4.0, "laws.creases.contact_penalty": 30.0}
OTHER_START, SHIFT, STEP = 99, 1e-7, 0.1
"""The start of the run that the data come from; the perturbation of starts [m], and the step of differences. A
perturbation of 1e-12 m would not have grown by the end of the data."""
SYMBOLS = dict(zip(RANGES, ("alpha", "beta", "gamma"), strict=True))
MEASURES = tuple(UNITS)
"""Of which the table says how far each parameter changes them."""
APART, MOST_STARTS = 10**0.2, 8
"""Factor to both sides by which a parameter is changed there, twice a tenth of its range in all; and starts."""


def synthetic(scene: Scene) -> Mapping[str, Floats]:
    """The curves of one run."""
    with ManyRuns(scene, RunSetup(UNTIL, SAMPLES, shift=SHIFT)) as runs:
        (run,) = runs.all_results([RunPoint({}, OTHER_START)])
    return {name: run.history[name][::EVERY] for name in ("time", *UNITS)}


def noisy(curves: Mapping[str, Floats], noise: Mapping[str, float]) -> Experiment:
    """Some of the curves with noise of these standard deviations."""
    random = np.random.default_rng(2012)
    columns = {
        name: curves[name] + sigma * random.standard_normal(len(curves["time"])) for name, sigma in noise.items()
    }
    return Experiment("synthetic", curves["time"], columns, {name: UNITS[name] for name in noise})


def fitted(
    begin: Scene, curves: Mapping[str, Floats], noise: Mapping[str, float], starts: int, folder: Path
) -> Calibration:
    """Fit the three parameters to some of the curves with noise."""
    return calibrate(
        begin, noisy(curves, noise), RANGES, starts=starts, uncertainty=noise, samples=SAMPLES, shift=SHIFT, step=STEP,
        most_runs=ROUGH if starts == 1 else 1000, executor="processes", out=folder,
        progress=lambda *now: print(folder.name, *now[:2], flush=True),
    )  # fmt: skip


def best_of_sweep(scene: Scene, curves: Mapping[str, Floats], noise: Mapping[str, float], out: Path) -> Scene:
    """The scene with the pair of beta and gamma whose curves, of one start, are nearest to the data."""
    shares = (np.arange(SWEPT) + 0.5) / SWEPT
    pairs = {one.key: [one.at(share) for share in shares] for one in parameters_of(scene, RANGES, sampled=True)[1:]}
    found = sweep(
        scene, pairs, until=UNTIL, samples=SAMPLES, executor="processes", out=out / "sweep", table="csv"
    )  # fmt: skip
    data = noisy(curves, noise)

    def misfit(k: int) -> float:
        history = found.history(k)
        return sum(
            float(np.sum((history[name][::EVERY] - data.columns[name]) ** 2)) / sigma**2
            for name, sigma in noise.items()
        )

    best = min(range(len(found.rows)), key=misfit)
    return scene.with_values({key: found.rows[best][key] for key in pairs})


def rows_of(name: str, found: Calibration, scene: Scene) -> list[tuple[str, ...]]:
    """The parameters of a fit beside the true ones."""
    rows: list[tuple[str, ...]] = []
    for one in found.parameters:
        values = f"{one.start:.3g}", f"{scene.value(one.key):g}", f"{one.value:.3g}"
        span, verdict = "-", "-"
        if found.analysis is not None:
            span = f"{one.low:.3g} to {one.high:.3g}"
            verdict = "determined" if one.is_determined else "**not determined**"
        rows.append((name, str(starts_of(found)), SYMBOLS[one.key], *values, span, verdict))
    return rows


def starts_of(found: Calibration) -> int:
    """Runs of each set of values."""
    return found.runs // len(found.trials)


def line_of(name: str, found: Calibration) -> str:
    """How a fit went, and how alike beta and gamma change its curves."""
    alike = "" if found.analysis is None else f"; correlation of beta and gamma {found.analysis.correlation[1, 2]:+.2f}"
    misfits = f"misfit {found.first_misfit:.2f} at the start, {found.misfit:.2f} at the end"
    starts = "1 start" if (count := starts_of(found)) == 1 else f"{count} starts"
    return f"- {name}, {starts}: {misfits}, {found.runs} runs{alike}."


def felt(scene: Scene, out: Path) -> str:
    """How far a tenth of each range changes some measures, and starts differ, as a table."""
    time = slice(None, None, EVERY)
    changes: dict[str, list[float]] = {name: [] for name in MEASURES}
    variances: dict[str, list[Floats]] = {name: [] for name in MEASURES}
    for key in RANGES:
        values = [scene.value(key) / APART, scene.value(key) * APART]
        found = sweep(
            scene, {key: values}, starts=MOST_STARTS, until=UNTIL, samples=SAMPLES, shift=SHIFT, executor="processes",
            out=out / f"measures-{SYMBOLS[key]}", table="csv",
        )  # fmt: skip
        histories = [found.history(k) for k in range(len(found.rows))]
        for name in MEASURES:
            low, high = np.array([one[name][time] for one in histories]).reshape(2, MOST_STARTS, -1)
            own = np.var(low, axis=0, ddof=1) + np.var(high, axis=0, ddof=1)
            square = np.mean((high.mean(axis=0) - low.mean(axis=0)) ** 2 - own / MOST_STARTS)
            changes[name].append(0.5 * float(np.sqrt(max(square, 0.0))))
            variances[name].append(own / 2)
    rows = []
    for name in MEASURES:
        unit = f" [{UNITS[name]}]" if UNITS[name] else ""
        noise = [f"{one[name]:g}" if name in one else "-" for one in (TORQUE, ACCURATE)]
        numbers = [float(np.sqrt(np.mean(variances[name]))), *changes[name]]
        rows.append((name + unit, *noise, *(f"{number:.2g}" for number in numbers)))
    changes_of = [f"a tenth of {one}" for one in SYMBOLS.values()]
    return table(("measure", "noise of the data", "of accurate data", "one start", *changes_of), rows)


def determined(scene: Scene, out: Path) -> str:
    """What data determine near the true values, for several numbers of starts, as a table."""
    parameters = parameters_of(scene, RANGES, sampled=True)
    shares = np.full(len(parameters), 0.5)
    time = np.linspace(0.0, UNTIL, SAMPLES)[::EVERY]
    rows: list[tuple[str, ...]] = []
    with ManyRuns(
        scene, RunSetup(UNTIL, SAMPLES, shift=SHIFT), executor="processes", folder=out / "determined"
    ) as runs:
        for name, noise in DATA.items():
            for starts in (MOST_STARTS, MOST_STARTS // 2, MOST_STARTS // 4):
                columns = [
                    DataColumn(one, UNITS[one], time, np.zeros(len(time)), np.full(len(time), sigma), True)
                    for one, sigma in noise.items()
                ]
                model = FitModel(runs, parameters, columns, starts, most_runs=1000)
                (there,) = model.curves([shares])
                found = analysed(model, shares, there, STEP)
                spans = [
                    f"{one.at(0.5 - error):.3g} to {one.at(0.5 + error):.3g}" if error < UNDETERMINED else "open"
                    for one, error in zip(parameters, found.errors, strict=True)
                ]
                rows.append((name, str(starts), *spans, "yes" if found.is_hidden else "no"))
    return table(("data", "starts", *SYMBOLS.values(), "hidden by the spread of starts"), rows, words=(0, 5))


def coverage() -> str:
    """How often 95 % intervals hold the true values, over fits to data with other noise, as a table."""
    true = {"laws.spin.frequency": 3.0, "parts.0.tip_mass": 0.01}
    ranges = {"laws.spin.frequency": "2:5", "parts.0.tip_mass": "0.002:0.05:log"}
    noise = {"phase_difference_deg": 0.05, "largest_cord_tension": 0.01}
    begin = scenes.load("spinning-tether").with_values({"parts.0.segments": 4})
    history = run(begin.with_values(true), UNTIL, samples=SAMPLES, frames=2).history
    every, random = slice(None, None, 10), np.random.default_rng(2012)
    rows: list[tuple[str, ...]] = []
    for given in (noise, None):
        inside, sizes = dict.fromkeys(true, 0), {key: list[float]() for key in true}
        for _ in range(REPEATS):
            data: dict[str, Floats] = {"time": history["time"][every]}
            for name, sigma in noise.items():
                data[name] = history[name][every] + sigma * random.standard_normal(len(data["time"]))
            found = calibrate(begin, data, ranges, samples=SAMPLES, uncertainty=given)
            for one in found.parameters:
                value, high, exact = map(np.log, (one.value, one.high, true[one.key]))
                sizes[one.key].append(float(abs(value - exact) / (high - value)))
                inside[one.key] += sizes[one.key][-1] <= NORMAL_95
        what = "given" if given else "unknown"
        for key, count in inside.items():
            spread = float(np.sqrt(np.mean(np.square(sizes[key]))))
            rows.append((what, key, f"{count} of {REPEATS}", f"{spread:.2f}"))
            print(*rows[-1], flush=True)
    head = ("deviations of the data", "parameter", "95 % interval holds the true value", "RMS error, in those it gives")
    return table(head, rows, words=(0, 1))


def main() -> None:
    """Fit both data sets, print the tables, and write them with `--write`."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--write", action="store_true", help="write docs/calibration.md and its figure")
    options.add_argument("--out", type=Path, default=ROOT / "out" / "calibration")
    options.add_argument("--only", choices=("paper", "coverage"), help="one of the two parts")
    given = options.parse_args()
    if given.only != "paper":
        held = coverage()
        if given.write:
            COVERAGE.write(held)
    if given.only == "coverage":
        return
    scene = scenes.load("okuizumi-model-1").with_values(COARSE)
    parts = {MEASURED: felt(scene, given.out), KNOWN: determined(scene, given.out), FITTED: fits(scene, given.out)}
    for part, text in parts.items():
        print(text)
        if given.write:
            part.write(text)
    if given.write:
        copy_small(given.out / FIGURE, FIGURE)


def fits(scene: Scene, out: Path) -> str:
    """What fits find, as tables; the figure of the rough one is written into `out`."""
    curves = synthetic(scene)
    rough = fitted(scene.with_values(BEGIN), curves, BOTH, 1, out / "rough")
    rough.plot(out / FIGURE, style="paper")
    rows, texts = rows_of("rate, phase", rough, scene), [line_of("rate, phase", rough)]
    for name, is_swept in FITS:
        begin = best_of_sweep(rough.scene, curves, DATA[name], out) if is_swept else rough.scene
        found = fitted(begin, curves, DATA[name], MOST_STARTS, out / name.replace(", ", "-"))
        rows += rows_of(name, found, scene)
        texts += [line_of(name, found), *(f"  - {warning}" for warning in found.warnings)]
    known = found.table()
    columns = known[known.index("| column") :].partition("\n\n- ")[0]  # `texts` has its warnings
    head = ("data", "starts", "parameter", "begins at", "true", "fitted", "one standard deviation", "")
    return "\n".join([table(head, rows, words=(0, 2, 7)), "\n".join(texts) + "\n", columns])


if __name__ == "__main__":
    main()
