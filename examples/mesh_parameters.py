"""Which parameters do not belong to one mesh: both sails of the paper on up to four meshes, in three forms.

Finished runs stay in the folder `out` and are not made again; remove it to make all anew. From nothing it takes some
twenty minutes on two cores. With `--write` docs/mesh_parameters.md and its pictures are made anew.
"""

from __future__ import annotations

import argparse
import shutil
import time
from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path

from membrane_rs import scenes
from membrane_rs.study import Calibration, MeshRun, agreeing, calibrate, jobs_of, mesh_study, write_mesh_study
from membrane_rs.study.convergence import CURVES, densities, steps
from membrane_rs.study.lengths import PHYSICAL
from membrane_rs.study.mesh import Job, kept

DOCS = Path(__file__).parent.parent / "docs"
MODELS = ("okuizumi-model-1", "okuizumi-model-2")
PAPERS_ROWS, FINEST = 16, 64
STARTS = {8: 4, 16: 4, 32: 2}
"""Starts of the physical form on each mesh; the others have two on the coarser meshes."""
SHORT = {FINEST: 0.45}
"""The finest mesh costs eight times the next coarser one, so its runs end here [s]: after the trough of the phase."""
TRIANGLES, ALPHA_C = "okuizumi-model-1-triangles", "laws.triangles.buckling_on_creases"


def main() -> None:
    """Run what is not there yet; print and write what came of it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--until", type=float, help="a trial: end here [s], on the coarser meshes only")
    parser.add_argument("--kept", action="store_true", help="tables of the sails' runs that are there; make none")
    parser.add_argument("--jobs", type=int, help="runs at once; default: one on each core")
    parser.add_argument("--out", type=Path, default=Path("out/mesh-parameters"), help="folder of the results")
    parser.add_argument("--write", action="store_true", help="write into docs/")
    options = parser.parse_args()
    began = time.perf_counter()

    texts = {"lengths": lengths()}
    for model in MODELS:
        scene, jobs = scenes.load(model), planned(model, options.until)
        jobs = kept(scene, jobs, options.out / "runs") if options.kept else jobs
        runs = mesh_study(scene, jobs, options.out / "runs", workers=options.jobs, tell=tell)
        folder = options.out / model
        tables = write_mesh_study(runs, folder)
        texts[model] = f"{tables.rstrip()}\n\n{on_the_papers_mesh(runs)}"
        if options.write:
            shutil.copy(folder / "mesh-study.png", DOCS / f"mesh_parameters-{model[-1]}.png")
    texts["triangles"] = calibrated(options.until, options.out / "runs", options.jobs)
    for name, text in texts.items():
        print(f"\n{name}\n\n{text}", flush=True)
        if options.write:
            write(name, text)
    print(f"\n{time.perf_counter() - began:.0f} s")


def planned(model: str, until: float | None) -> list[Job]:
    """What to run of a model, the long runs first."""
    if until is not None:
        return jobs_of([8, 16], members=2, until=until)
    forms = ["paper", "strain"] if model == MODELS[0] else ["paper"]
    jobs = jobs_of([FINEST], ["physical"], until=SHORT)
    jobs += jobs_of([32, 16, 8], ["physical"], STARTS)
    jobs += jobs_of([32, 16, 8], forms, {8: 2, 16: 2})
    return sorted(jobs, key=lambda job: -job.rows)


def lengths() -> str:
    """The lengths that agree with the paper's form on the paper's mesh, and those that were chosen."""
    found = [agreeing(scenes.load(model)) for model in MODELS]
    rows = [f"| | {' | '.join(MODELS)} | chosen |\n| --- | ---: | ---: | ---: |\n"]
    for item in fields(PHYSICAL):
        values = [getattr(each, item.name) for each in (*found, PHYSICAL)]
        rows.append(f"| {item.name} | " + " | ".join(f"{1e3 * value:.2f} mm" for value in values) + " |\n")
    return "".join(rows).rstrip()


def on_the_papers_mesh(runs: Sequence[MeshRun]) -> str:
    """How far the physical form is from the paper's, where they should agree."""
    of = {form: [mesh for mesh in meshes if mesh.rows == PAPERS_ROWS] for form, meshes in densities(runs).items()}
    (step,) = steps([*of["paper"], *of["physical"]])
    rate, phase = CURVES
    return (
        "On the paper's mesh the curves of the physical form and of the paper's are "
        f"{step.distance[rate]:.4f} apart in the rate and {step.distance[phase]:.1f} degrees in the phase; "
        f"{step.noise[rate]:.4f} and {step.noise[phase]:.1f} come from the spread of the starts."
    )


def calibrated(until: float | None, folder: Path, jobs: int | None) -> str:
    """alpha on creases of a film of triangles, from the curves of springs."""
    found: Calibration = calibrate(
        scenes.load(TRIANGLES),
        ALPHA_C,
        (3.0, 1000.0),
        scenes.load(MODELS[0]),
        folder,
        first=(100.0,),
        tries=1 if until is not None else 6,
        until=0.45 if until is None else until,
        workers=jobs,
        tell=tell,
    )
    return f"{found.table().rstrip()}\n\nNearest: {found.best.value:.3g}, misfit {found.best.misfit:.1f}."


def write(name: str, text: str) -> None:
    """Put a text between its two marks in docs/mesh_parameters.md."""
    page = DOCS / "mesh_parameters.md"
    begin, end = f"<!-- {name}: begin -->\n", f"\n<!-- {name}: end -->"
    before, rest = page.read_text(encoding="utf-8").split(begin)
    page.write_text(before + begin + text + end + rest.split(end)[1], encoding="utf-8")


def tell(words: str) -> None:
    """Progress."""
    print(words, flush=True)


if __name__ == "__main__":
    main()
