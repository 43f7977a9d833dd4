"""Forms of the dashpots compared, for docs/dashpots.md: both sails, cords that become slack, limits of the step.

Finished runs are kept in the folder `out` and read again; remove it to repeat them, which takes some minutes on two
cores. With `--write` the tables and pictures of docs/dashpots.md are replaced.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from threading import Event

import numpy as np
from dashpot_forms import ALL, DEFAULT, FORMS, PAPER, REDUCED, damped
from dashpots_of_cords import tether_curves, tether_picture, tether_table, thrown_tip
from kept import kept, slug
from marked import DOCS, MarkedPart
from membrane_rs import Simulation, SpringDamping, scenes
from membrane_rs._arrays import Floats
from membrane_rs._markdown import table
from membrane_rs.plotting.mesh_study import plot_meshes
from membrane_rs.study.common.executor import run_parallel
from membrane_rs.study.common.run import StudyCase, run_case, study_case

PARTS = {name: MarkedPart(DOCS / "dashpots.md", name) for name in ("thrown-tip", "tether", "curves", "limits")}
MODELS = ("okuizumi-model-1", "okuizumi-model-2")
END, INSTANTS = 0.8, 400
"""Of the runs of the sails [s]."""
STARTS = 3
"""The unperturbed start and perturbed ones, of each form."""
OF_SAILS = (PAPER, DEFAULT, ALL, REDUCED)
RATE, PHASE = "deployment_rate", "phase_difference_deg"
Curves = Mapping[str, Mapping[str, Sequence[Mapping[str, Floats]]]]
"""By model and form: the histories from each start."""


def main() -> None:
    """Make the tables and pictures, or some of them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--only", nargs="+", choices=list(PARTS), default=list(PARTS), help="the tables to make")
    parser.add_argument("--until", type=float, default=END, help="a brief run: end here [s], no limits of sails")
    parser.add_argument("--jobs", type=int, help="number of parallel runs; default: one on each core")
    parser.add_argument("--out", type=Path, default=Path("out/dashpots"), help="folder of the results")
    parser.add_argument("--write", action="store_true", help="write into docs/")
    options = parser.parse_args()
    began = time.perf_counter()
    brief = options.until < END

    def tether(picture: Path) -> str:
        found = tether_curves(options.out, options.until if brief else None)
        tether_picture(found, picture)
        return tether_table(found)

    def sails(picture: Path) -> str:
        found = curves(options.until, options.out, options.jobs)
        plot_meshes({model: list(forms.items()) for model, forms in found.items()}, picture, legend="dashpots")
        return curves_table(found)

    makers: dict[str, Callable[[Path], str]] = {
        "thrown-tip": lambda _: thrown_tip(),
        "tether": tether,
        "curves": sails,
        "limits": lambda _: limits(() if brief else MODELS),
    }
    options.out.mkdir(parents=True, exist_ok=True)
    for name in options.only:
        picture = options.out / f"dashpots-{name}.png"
        PARTS[name].publish(makers[name](picture), picture, write=options.write)
    print(f"{time.perf_counter() - began:.0f} s")


def curves(until: float, folder: Path, workers: int | None) -> Curves:
    """The histories of both sails with each form."""
    stop = Event()
    keys, names, jobs = [], [], []
    for model in MODELS:
        for form in OF_SAILS:
            scene = scenes.load(model)
            scene = damped(replace(scene, run=replace(scene.run, substeps=4)), FORMS[form])
            case = study_case(scene, until, INSTANTS)
            dt = Simulation(case.scene, "leapfrog").dt
            for start in range(STARTS):
                file = folder / f"{slug(model, form, start, f'{until:g}')}.npz"
                one = case.perturbed(start) if start else case
                keys.append((model, form))
                names.append(file.stem)
                jobs.append(lambda one=one, dt=dt, file=file: kept(file, lambda: history(one, dt, stop)))
    found: dict[str, dict[str, list[Mapping[str, Floats]]]] = {}
    tables = run_parallel(jobs, names, stop, workers=workers, tell=lambda words: print(words, flush=True))
    for (model, form), run in zip(keys, tables, strict=True):
        found.setdefault(model, {}).setdefault(form, []).append(run)
    return found


def history(case: StudyCase, dt: float, stop: Event) -> dict[str, Floats]:
    """The curves of one run. Raises KeyboardInterrupt where `stop` ended it early."""
    run = run_case(case, "leapfrog", dt, stop=stop).completed()
    if stop.is_set():
        raise KeyboardInterrupt
    return {"time": run.times, RATE: run.rate, PHASE: run.phase}


def curves_table(found: Curves) -> str:
    """Distance of the mean curves of each form from those of the paper's, and the spread of each."""
    body = []
    for model, forms in found.items():
        for form, runs in forms.items():
            all_starts = {column: np.array([run[column] for run in runs]) for column in (RATE, PHASE)}
            spread = [float(np.ptp(each, axis=0).max()) for each in all_starts.values()]
            apart = [
                float(np.abs(each.mean(axis=0) - np.mean([run[column] for run in forms[PAPER]], axis=0)).max())
                for column, each in all_starts.items()
            ]
            distance = ("-", "-") if form == PAPER else (f"{apart[0]:.3f}", f"{apart[1]:.1f}")
            body.append((model, form, *distance, f"{spread[0]:.3f}", f"{spread[1]:.1f}"))
    heads = ("scene", "dashpots", "rate", "phase [deg]", "spread of the rate", "of the phase [deg]")
    return table(heads, body, words=(0, 1))


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
