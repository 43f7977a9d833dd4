"""Dependence of the parameters on the mesh: both sails of the paper on up to four meshes, in four forms, and bending.

Finished runs are kept in the folder `out` and read again; remove it to repeat all runs, which takes some three hours on
two cores. With `--write` the tables and pictures of docs/mesh_parameters.md are replaced.
"""

from __future__ import annotations

import argparse
import shutil
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from marked import DOCS, MarkedPart
from membrane_rs import Simulation, Springs, scenes
from membrane_rs._markdown import table
from membrane_rs.folding import SquareSail
from membrane_rs.mesh import net_moduli
from membrane_rs.study import MeshRun, SceneMatch, agreeing, jobs_of, match_scene, mesh_study, write_mesh_study
from membrane_rs.study.convergence import CURVES, densities, steps
from membrane_rs.study.length_scales import PHYSICAL
from membrane_rs.study.mesh import INTEGRATOR, SHARE, Job, kept
from mesh_bending import bent, by_alpha, by_substeps

MODELS = ("okuizumi-model-1", "okuizumi-model-2")
NAMES = ("lengths", "forms", "bending", "substeps", "compression", "moduli", "triangles")
BENT = {"bending-1": MODELS[0], "bending-2": MODELS[1]}
PARTS = {
    name: MarkedPart(DOCS / "mesh_parameters.md", name)
    for name in ("lengths", *MODELS, "compression", "moduli", "triangles", *BENT, "alpha", "substeps")
}
PAPERS_ROWS, FINEST = 16, 64
STARTS = {8: 4, 16: 4, 32: 2}
"""Number of starts of the physical form on each mesh; the others have two on the coarser meshes."""
SHORT = {FINEST: 0.45}
"""The finest mesh costs eight times the next coarser one, so its runs end here [s]: after the trough of the phase."""
TRIANGLES, ALPHA_C = "okuizumi-model-1-triangles", "laws.triangles.buckling_on_creases"


def main() -> None:
    """Make the missing runs; print and write the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--until", type=float, help="a brief run: end here [s], on the coarser meshes only")
    parser.add_argument("--kept", action="store_true", help="tables of the kept runs of the sails; make no run")
    parser.add_argument("--jobs", type=int, help="number of parallel runs; default: one on each core")
    parser.add_argument("--out", type=Path, default=Path("out/mesh-parameters"), help="folder of the results")
    parser.add_argument("--only", nargs="+", choices=NAMES, default=NAMES, help="some parts")
    parser.add_argument("--write", action="store_true", help="write into docs/")
    options = parser.parse_args()
    began = time.perf_counter()

    makers: dict[str, Callable[[argparse.Namespace], dict[str, str]]] = {
        "lengths": lambda _: {"lengths": lengths()},
        "forms": forms,
        "bending": bending,
        "substeps": lambda options: {
            "substeps": by_substeps(MODELS[1], options.out / "runs", until=options.until, jobs=options.jobs, tell=tell)
        },
        "compression": lambda options: {"compression": compression(options.until)},
        "moduli": lambda _: {"moduli": moduli()},
        "triangles": lambda options: {"triangles": calibrated(options.until, options.out / "runs", options.jobs)},
    }
    for maker in options.only:
        for name, text in makers[maker](options).items():
            print(f"\n{name}\n\n{text}", flush=True)
            if options.write:
                PARTS[name].write(text)
    print(f"\n{time.perf_counter() - began:.0f} s")


def forms(options: argparse.Namespace) -> dict[str, str]:
    """Both models in each form."""
    texts = {}
    for model in MODELS:
        scene, jobs = scenes.load(model), planned(model, options.until)
        jobs = kept(scene, jobs, options.out / "runs") if options.kept else jobs
        runs = mesh_study(scene, jobs, options.out / "runs", workers=options.jobs, tell=tell)
        tables = published(runs, options.out / model, f"mesh_parameters-{model[-1]}.png", write=options.write)
        texts[model] = f"{tables.rstrip()}\n\n{on_the_papers_mesh(runs)}"
    return texts


def bending(options: argparse.Namespace) -> dict[str, str]:
    """Both models with a film that bends, and model 1 without, by alpha."""
    texts, folder = {}, options.out / "runs"
    for part, model in BENT.items():
        runs = bent(model, folder, until=options.until, only_kept=options.kept, jobs=options.jobs, tell=tell)
        texts[part] = published(runs, options.out / part, f"mesh_parameters-{part}.png", write=options.write)
        if model == MODELS[0]:
            texts["alpha"] = by_alpha(model, folder, runs, until=options.until, jobs=options.jobs, tell=tell)
    return texts


def published(runs: Sequence[MeshRun], folder: Path, picture: str, *, write: bool) -> str:
    """The tables of runs; where `write`, their picture goes into docs/."""
    tables = write_mesh_study(runs, folder)
    if write:
        shutil.copy(folder / "mesh-study.png", DOCS / picture)
    return tables


def planned(model: str, until: float | None) -> list[Job]:
    """The runs of a model, the long ones first."""
    if until is not None:
        return jobs_of([8, 16], members=2, until=until)
    forms = ["paper", "strain"] if model == MODELS[0] else ["paper"]
    jobs = jobs_of([FINEST], ["physical", "tension"], until=SHORT)
    jobs += jobs_of([32, 16, 8], ["physical"], STARTS)
    jobs += jobs_of([32, 16, 8], [*forms, "tension"], {8: 2, 16: 2})
    return sorted(jobs, key=lambda job: -job.rows)


def lengths() -> str:
    """The length scales that agree with the paper's form on the paper's mesh, and the chosen ones."""
    found = [agreeing(scenes.load(model)) for model in MODELS]
    names = ("buckling", "crease", "facet", "damping")
    rows = [(name, *(f"{1e3 * getattr(each, name):.2f} mm" for each in (*found, PHYSICAL))) for name in names]
    return table(("", *MODELS, "chosen"), rows)


def on_the_papers_mesh(runs: Sequence[MeshRun]) -> str:
    """Distance of the physical form from the paper's on the mesh where they should agree."""
    of = {form: [mesh for mesh in meshes if mesh.rows == PAPERS_ROWS] for form, meshes in densities(runs).items()}
    (step,) = steps([*of["paper"], *of["physical"]])
    rate, phase = CURVES
    return (
        "On the paper's mesh the curves of the physical form and of the paper's are "
        f"{step.distance[rate]:.4f} apart in the rate and {step.distance[phase]:.1f} degrees in the phase; "
        f"{step.noise[rate]:.4f} and {step.noise[phase]:.1f} come from the spread of the starts."
    )


def compression(until: float | None) -> str:
    """Mean compression in the film of the physical form during deployment, relative to that at buckling."""
    body = []
    for rows in (8, 16, 32) if until is None else (8,):
        scene = scenes.load(MODELS[0])
        film = scene.material
        assert film is not None
        mesh = SquareSail(fold_lines=7, rows=rows).mesh()
        scene = PHYSICAL.of(replace(scene, mesh=mesh, run=replace(scene.run, integrator=INTEGRATOR, energy_loss=0.2)))
        sim = Simulation(scene, dt=SHARE * Simulation(scene).stable_dt())
        creases = np.sort(mesh.creases, axis=1) @ [mesh.node_count, 1]
        is_crease = np.isin(mesh.edges @ [mesh.node_count, 1], creases)
        k, length = mesh.spring_constants(film)[~is_crease], mesh.edge_lengths[~is_crease]
        springs = scene.law("springs")
        assert isinstance(springs, Springs)
        assert PHYSICAL.buckling is not None
        critical = springs.buckling * np.pi**2 * film.thickness**2 / (12 * PHYSICAL.buckling**2)
        weight = k * length**2 / mesh.areas().sum()  # of a strain, in the sum of both principal stress resultants
        readings = []
        for instant in np.arange(0.05, 0.301, 0.01) if until is None else [until]:
            sim.run(until=float(instant), frames=2, samples=2)
            strain = sim.spring_strains()[: len(mesh.edges)][~is_crease]
            borne = np.minimum(np.maximum(-strain, 0.0), critical)
            readings.append([float(weight @ borne), float(np.mean(strain < -critical))])
        (force, buckled), full = np.mean(readings, axis=0), float(weight.sum() * critical)
        values = (f"{force:.2f}", f"{full:.2f}", f"{force / full:.2f}", f"{100 * buckled:.0f} %")
        body.append((f"{176 / rows:.3g}", *values))
    return table(("cells [mm]", "borne [N/m]", "at buckling [N/m]", "share", "springs buckled"), body, words=())


def moduli() -> str:
    """Moduli of the net of springs on each mesh of both models, over the film's."""
    body = []
    for model in MODELS:
        scene = scenes.load(model)
        assert scene.material is not None
        assert scene.mesh is not None
        assert isinstance(scene.mesh.source, SquareSail)
        for rows in (8, PAPERS_ROWS, 32, FINEST):
            net = net_moduli(replace(scene.mesh.source, rows=rows).mesh(), scene.material)
            axis = net.axis
            values = (net.modulus(axis), net.modulus(axis + 45.0), net.shear_modulus(axis), net.poisson_ratio(axis))
            body.append((model, f"{176 / rows:.3g}", *(f"{float(value):.3f}" for value in values)))
    return table(("model", "cells [mm]", "E along 0", "E along 45 degrees", "G", "nu"), body, words=(0,))


def calibrated(until: float | None, folder: Path, jobs: int | None) -> str:
    """alpha on creases of a film of triangles, calibrated against the curves of springs."""
    found: SceneMatch = match_scene(
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


def tell(words: str) -> None:
    """Progress."""
    print(words, flush=True)


if __name__ == "__main__":
    main()
