"""The paper's three parameters, found again from noisy curves: the table and the figure of docs/calibration.md; and
how often the intervals that a fit gives hold the true values.

The sail is that of model 1 on a coarse mesh, so that a fit takes minutes. The data are one of its runs with the paper's
parameters, from a start that no fit has, with noise; the fits begin elsewhere. Two data sets are used: both curves of
the deployment, and the rate alone.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from marked import DOCS, ROOT, MarkedPart, copy_small
from membrane_rs import Scene, run, scenes
from membrane_rs._arrays import Floats
from membrane_rs._markdown import table
from membrane_rs.results import Experiment
from membrane_rs.study import Calibration, calibrate
from membrane_rs.study.common.many_runs import ManyRuns
from membrane_rs.study.common.one_run import RunPoint, RunSetup

PART = MarkedPart(DOCS / "calibration.md", "calibration.md")
COVERAGE = MarkedPart(DOCS / "calibration.md", "coverage.md")
REPEATS = 40
"""Sets of noisy data, each of which is fitted."""
NORMAL_95 = 1.96
"""Standard deviations to both sides of the mean that hold 95 % of a normal distribution."""
FIGURE = "calibration.png"
COARSE = {"mesh.rows": 8, "mesh.columns": 6}
UNTIL, SAMPLES, EVERY = 0.15, 151, 5
"""Time of the data [s], rows of a run, and rows from one datum to the next."""
NOISE = {"deployment_rate": 0.003, "phase_difference_deg": 0.5}
"""Standard deviations of the data."""
RANGES = {
    "laws.springs.buckling": "10:1000:log",
    "laws.creases.stiffness": "1:100:log",
    "laws.creases.contact_penalty": "10:1000:log",
}
BEGIN = {"laws.springs.buckling": 300.0, "laws.creases.stiffness": 4.0, "laws.creases.contact_penalty": 30.0}
OTHER_START, STARTS, SHIFT, STEP = 9, 3, 1e-7, 0.05
"""The start of the run that the data come from; starts of each set of a fit, their perturbation [m], and the step of
differences. A perturbation of 1e-12 m would not have grown by the end of the data."""
SYMBOLS = dict(zip(RANGES, ("alpha", "beta", "gamma"), strict=True))


def synthetic(scene: Scene) -> Experiment:
    """Both curves of one run, with noise."""
    random = np.random.default_rng(2012)
    with ManyRuns(scene, RunSetup(UNTIL, SAMPLES, shift=SHIFT)) as runs:
        (run,) = runs.all_results([RunPoint({}, OTHER_START)])
    history, rows = run.history, slice(None, None, EVERY)
    time = history["time"][rows]
    curves = {name: history[name][rows] + sigma * random.standard_normal(len(time)) for name, sigma in NOISE.items()}
    return Experiment("synthetic", time, curves, {"deployment_rate": "", "phase_difference_deg": "deg"})


def rows_of(found: Calibration, scene: Scene) -> list[tuple[str, ...]]:
    """The parameters of a fit beside the true ones."""
    data = "both curves" if len(found.columns) == len(NOISE) else "the rate alone"
    rows: list[tuple[str, ...]] = []
    for one in found.parameters:
        verdict = "determined" if one.is_determined else "not determined"
        span = f"{one.low:.3g} to {one.high:.3g}"
        rows.append(
            (data, SYMBOLS[one.key], f"{one.start:g}", f"{scene.value(one.key):g}", f"{one.value:.3g}", span, verdict)
        )
    return rows


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
    data, begin = synthetic(scene), scene.with_values(BEGIN)
    rows: list[tuple[str, ...]] = []
    texts: list[str] = []
    for columns in (list(NOISE), ["deployment_rate"]):
        sigmas = {name: NOISE[name] for name in columns}
        found = calibrate(
            begin, data, RANGES, columns=columns, starts=STARTS, uncertainty=sigmas, samples=SAMPLES, most_runs=300,
            shift=SHIFT, step=STEP,
            out=given.out / "-".join(columns), progress=lambda *now: print(*now[:2], flush=True),
        )  # fmt: skip
        rows += rows_of(found, scene)
        texts.append(
            f"{found.columns[0].name if len(columns) == 1 else 'Both curves'}: misfit {found.first_misfit:.2f} at the "
            f"start, {found.misfit:.2f} at the end, {found.runs} runs."
        )
        texts += found.warnings
        if len(columns) > 1:
            found.plot(given.out / FIGURE, style="paper")
            known = found.table()
    head = ("data", "parameter", "start", "true", "fitted", "one standard deviation", "")
    text = "\n".join(
        [
            table(head, rows, words=(0, 1, 6)),
            "\n".join(f"- {one}" for one in texts),
            "",
            known[known.index("| column") :].partition("\n\n- ")[0],  # `texts` has its warnings
        ]
    )
    print(text)
    if given.write:
        PART.write(text)
        copy_small(given.out / FIGURE, FIGURE)


if __name__ == "__main__":
    main()
