"""The sails of the paper with a film that bends, on five meshes, by springs and by triangles; and what alpha adds."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from membrane_rs import Scene, Springs, Tethers, Triangles, scenes
from membrane_rs._markdown import table
from membrane_rs.scene.softened import with_softening
from membrane_rs.study import LengthScales, MeshRun, jobs_of, mesh_study
from membrane_rs.study.convergence import CURVES, densities, steps
from membrane_rs.study.length_scales import BENDING, PLATE
from membrane_rs.study.mesh import Job, kept

SOFTENING, SUBSTEPS, SEGMENTS = 10.0, 4, 5
"""In-plane stiffness is divided by, slow laws once in, links of a tether: none sets the step."""
FINEST_SUBSTEPS = 16
"""On the finest mesh, where dashpots set the step: slow laws are evaluated as often as on the next coarser mesh."""
FILMS: dict[str, Springs | Triangles] = {"springs": Springs(), "triangles": Triangles()}
WITHOUT = replace(BENDING, bending=False)
ALPHAS = (1.0, 3.0, 10.0, 30.0, 100.0)
ROWS, FINE, FINEST, PAPERS = (32, 16, 8), 64, 128, 16
"""The finest mesh is for springs alone, half an hour a run; one of triangles takes nearly two hours."""
FINE_UNTIL = 0.45
"""After the trough of the phase [s]."""
FINEST_BRIEFLY = 0.12
"""After the first peak of the rate [s]."""


def quick(model: str, film: str, buckling: float | None = None, substeps: int = SUBSTEPS) -> Scene:
    """A model with a film of springs or of triangles, by long steps; its creases buckle as the film does."""
    scene = scenes.load(model)
    law = FILMS[film] if buckling is None else FILMS[film].with_buckling(buckling)
    laws = [law if each.is_film else each for each in scene.laws]
    parts = [replace(part, segments=SEGMENTS) if isinstance(part, Tethers) else part for part in scene.parts]
    name = f"{model}-{film}" if buckling is None else f"{model}-{film}-alpha-{buckling:g}"
    scene = replace(scene, name=name, laws=laws, parts=parts, run=replace(scene.run, substeps=substeps))
    return with_softening(scene, SOFTENING)


def planned(film: str, form: LengthScales, until: float | None) -> dict[int, list[Job]]:
    """The meshes of one film by substeps, the long runs first."""
    forms = {"bending" if form.bending else "no bending": form}
    if until is not None:
        return {SUBSTEPS: jobs_of([8, PAPERS], forms, until=until)}
    finest, fine = (jobs_of([rows], forms, until=FINE_UNTIL) for rows in (FINEST, FINE))
    coarser = {SUBSTEPS: fine + jobs_of(ROWS, forms, {PAPERS: 2, 32: 2})}
    return {FINEST_SUBSTEPS: finest, **coarser} if film == "springs" else coarser


def bent(
    model: str, folder: Path, *, until: float | None, only_kept: bool, jobs: int | None, tell: Callable[[str], None]
) -> list[MeshRun]:
    """The runs of both films, which stand for the forms of a study, and of springs that do not bend."""
    runs: list[MeshRun] = []
    for film, form in (("springs", BENDING), ("triangles", BENDING), ("springs", WITHOUT)):
        made: list[MeshRun] = []
        for substeps, all_jobs in planned(film, form, until).items():
            scene = quick(model, film, None if form.bending else PLATE, substeps)
            wanted = kept(scene, all_jobs, folder) if only_kept else all_jobs
            made += mesh_study(scene, wanted, folder, workers=jobs, tell=tell) if wanted else []
        runs += [replace(run, form=f"{run.form}, {film}") for run in sorted(made, key=lambda run: run.rows)]
    return runs


def by_alpha(
    model: str,
    folder: Path,
    bending: Sequence[MeshRun],
    *,
    until: float | None,
    jobs: int | None,
    tell: Callable[[str], None],
) -> str:
    """The paper's mesh without bending, by alpha: spread of two starts, distance from 2.75 mm that bend."""
    finest = [mesh for mesh in densities(bending)["bending, springs"] if mesh.rows <= FINE][-1]
    rows = []
    for alpha in ALPHAS:
        scene = quick(model, "springs", alpha)
        end = FINE_UNTIL if until is None else until
        wanted = jobs_of([PAPERS], {f"alpha {alpha:g}": WITHOUT}, 2, end)
        (mesh,) = next(iter(densities(mesh_study(scene, wanted, folder, workers=jobs, tell=tell)).values()))
        (step,) = steps([mesh, finest])
        spread = [mesh.spread(column, step.until) for column in CURVES]
        trough = [float(np.min(run.table["phase_difference_deg"])) for run in mesh.runs]
        rows.append(
            (
                f"{alpha:g}",
                ", ".join(f"{value:.1f}" for value in trough),
                f"{spread[0]:.4f}",
                f"{spread[1]:.2f}",
                f"{step.distance[CURVES[0]]:.4f}",
                f"{step.distance[CURVES[1]]:.1f}",
            )
        )
    head = ("alpha", "troughs of the phase [deg]", "spread of the rates", "of the phases [deg]",
            "distance of the rates", "of the phases [deg]")  # fmt: skip
    return table(head, rows)


def by_substeps(model: str, folder: Path, *, until: float | None, jobs: int | None, tell: Callable[[str], None]) -> str:
    """Springs that bend with as many substeps as on the finest mesh, against those with as many as on the others."""
    meshes = {PAPERS: FINE_UNTIL, 32: FINE_UNTIL, FINE: FINE_UNTIL, FINEST: FINEST_BRIEFLY}
    rows = []
    for count, end in meshes.items() if until is None else [(8, until)]:
        runs = []
        for substeps, last in ((SUBSTEPS, end), (FINEST_SUBSTEPS, end if until is not None else FINE_UNTIL)):
            scene, wanted = quick(model, "springs", None, substeps), jobs_of([count], {"bending": BENDING}, until=last)
            (run,) = mesh_study(scene, wanted, folder, workers=jobs, tell=tell)
            runs.append(replace(run, form=str(substeps)))
        (few,), (many,) = densities(runs).values()
        (step,) = steps([few, many])
        rows.append(
            (
                f"{1e3 * runs[0].cell:.3g}",
                f"{step.until:.2g}",
                *(f"{100 * run.energy_error:+.2f}" for run in runs),
                f"{step.distance[CURVES[0]]:.4f}",
                f"{step.distance[CURVES[1]]:.2f}",
            )
        )
    head = ("cells [mm]", "until [s]", f"energy error, {SUBSTEPS} substeps [%]", f"{FINEST_SUBSTEPS} substeps",
            "distance of the rates", "of the phases [deg]")  # fmt: skip
    return table(head, rows, words=())
