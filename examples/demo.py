"""Deploy a sail from the roll to the flat square, and both sails of the paper from the cross, side by side.

Leaves in the folder `out`:

    okuizumi-whole/                         a results folder: pictures, frames for ParaView, curves
    okuizumi-model-1/, okuizumi-model-2/    the same for the sails of the paper
    comparison.png                          deployment rate and phase difference of these two
    summary.md                              the table that is printed at the end
"""

from __future__ import annotations

import argparse
import json
import os
import time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from membrane_rs import Simulation, scenes
from membrane_rs.plotting import compare_runs

WHOLE = "okuizumi-whole"
MODELS = ("okuizumi-model-1", "okuizumi-model-2")


def deploy(name: str, until: float | None, folder: Path, pictures: bool) -> Path:
    """Run one built-in scene into `folder`, and report each tenth of its duration; until None: to its own end."""
    sim = Simulation(scenes.load(name))
    until = sim.planned_end if until is None else until
    began, reported = time.perf_counter(), 0

    def progress(sim: Simulation) -> None:
        nonlocal reported
        tenth = int(10 * sim.time / until + 1e-9)
        if tenth > reported:
            reported = tenth
            spent = time.perf_counter() - began
            print(f"{name}: {sim.time:.3f} of {until:g} s, after {spent:.0f} s", flush=True)

    sim.run(until=until, out=folder, overwrite=True, pictures=pictures, progress=progress)
    return folder


def read_summary(folder: Path) -> dict[str, Any]:
    """summary.json of a results folder."""
    summary: dict[str, Any] = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    return summary


def table(summaries: list[dict[str, Any]]) -> str:
    """The summaries as a table in Markdown; a dash where a run ended before."""

    def cell(summary: dict[str, Any], part: str, key: str, form: str, scale: float) -> str:
        value = summary[part][key] if part else summary[key]
        return "-" if value is None else format(scale * value, form)

    rows = (
        ("masses, as the paper counts", "counts", "masses", ",d", 1),
        ("springs", "counts", "springs", ",d", 1),
        ("elements", "counts", "elements", ",d", 1),
        ("step [us]", "", "dt", ".3f", 1e6),
        ("largest stable step [us]", "", "stable_dt", ".3f", 1e6),
        ("steps", "", "steps", ",d", 1),
        ("simulated time [s]", "", "time", ".3f", 1),
        ("deployment rate at the start", "curves", "initial_rate", ".3f", 1),
        ("first peak of the rate", "curves", "first_peak_rate", ".3f", 1),
        ("at [s]", "curves", "first_peak_time", ".3f", 1),
        ("trough of the phase difference [deg]", "curves", "phase_trough_deg", ".1f", 1),
        ("at [s]", "curves", "phase_trough_time", ".3f", 1),
        ("phase back at zero, at [s]", "curves", "zero_crossing_time", ".3f", 1),
        ("deployment rate there", "curves", "zero_crossing_rate", ".3f", 1),
        ("energy error at the end [%]", "energy_balance", "error", "+.3f", 100),
        ("lowest energy error (loss) [%]", "energy_balance", "lowest_error", "+.3f", 100),
        ("highest energy error (gain)", "energy_balance", "highest_error", "+.1e", 1),
    )
    names = " | ".join(summary["scene"] for summary in summaries)
    lines = [f"| | {names} |", "|---|" + "---:|" * len(summaries)]
    for label, *where in rows:
        cells = [cell(summary, *where) for summary in summaries]  # type: ignore[arg-type]
        lines.append(f"| {label} | " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def main() -> None:
    """Run the scenes at once, each in a process of its own, and compare both models."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--until", type=float, help="simulated time [s]; default: to the end of each scene")
    parser.add_argument("--out", type=Path, default=Path("out"), help="folder of the results")
    parser.add_argument("--no-pictures", action="store_true", help="curves and frames only")
    options = parser.parse_args()

    folders = [options.out / name for name in (WHOLE, *MODELS)]
    began = time.perf_counter()
    with ProcessPoolExecutor(min(len(folders), os.cpu_count() or 1), mp_context=get_context("spawn")) as pool:
        runs = [pool.submit(deploy, folder.name, options.until, folder, not options.no_pictures) for folder in folders]
        for run in runs:
            run.result()
    labels = ["model 1 (7 fold lines)", "model 2 (3 fold lines)"]
    compare_runs(folders[1:], options.out / "comparison.png", labels)
    text = table([read_summary(folder) for folder in folders[1:]])
    (options.out / "summary.md").write_text(text, encoding="utf-8")
    print(f"\n{text}\nAll runs and their pictures took {time.perf_counter() - began:.0f} s.")
    for folder in folders:
        print(f"{folder}: snapshots/, animation.gif, deployment.png, frames.pvd, history.csv")
    print(f"{options.out}: comparison.png, summary.md")


if __name__ == "__main__":
    main()
