"""The sails of the paper with a film that bends, on four meshes, by springs and by triangles; and what alpha adds."""

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
FILMS: dict[str, Springs | Triangles] = {"springs": Springs(), "triangles": Triangles()}
WITHOUT = replace(BENDING, bending=False)
ALPHAS = (1.0, 3.0, 10.0, 30.0, 100.0)
ROWS, FINEST, PAPERS = (32, 16, 8), 64, 16
FINEST_UNTIL = 0.45
"""After the trough of the phase [s]."""


def quick(model: str, film: str, buckling: float | None = None) -> Scene:
    """A model with a film of springs or of triangles, by long steps; its creases buckle as the film does."""
    scene = scenes.load(model)
    law = FILMS[film] if buckling is None else FILMS[film].with_buckling(buckling)
    laws = [law if each.is_film else each for each in scene.laws]
    parts = [replace(part, segments=SEGMENTS) if isinstance(part, Tethers) else part for part in scene.parts]
    name = f"{model}-{film}" if buckling is None else f"{model}-{film}-alpha-{buckling:g}"
    scene = replace(scene, name=name, laws=laws, parts=parts, run=replace(scene.run, substeps=SUBSTEPS))
    return with_softening(scene, SOFTENING)


def planned(form: LengthScales, until: float | None) -> list[Job]:
    """The meshes of one film, the long runs first."""
    name = "bending" if form.bending else "no bending"
    if until is not None:
        return jobs_of([8, PAPERS], {name: form}, until=until)
    jobs = jobs_of([FINEST], {name: form}, until=FINEST_UNTIL)
    return jobs + jobs_of(ROWS, {name: form}, {PAPERS: 2, 32: 2})


def bent(
    model: str, folder: Path, *, until: float | None, only_kept: bool, jobs: int | None, tell: Callable[[str], None]
) -> list[MeshRun]:
    """The runs of both films, which stand for the forms of a study, and of springs that do not bend."""
    runs: list[MeshRun] = []
    for film, form in (("springs", BENDING), ("triangles", BENDING), ("springs", WITHOUT)):
        scene, wanted = quick(model, film, None if form.bending else PLATE), planned(form, until)
        wanted = kept(scene, wanted, folder) if only_kept else wanted
        made = mesh_study(scene, wanted, folder, workers=jobs, tell=tell) if wanted else []
        runs += [replace(run, form=f"{run.form}, {film}") for run in made]
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
    """The paper's mesh without bending, by alpha: spread of two starts, distance from the finest film that bends."""
    finest = densities(bending)["bending, springs"][-1]
    rows = []
    for alpha in ALPHAS:
        scene = quick(model, "springs", alpha)
        end = FINEST_UNTIL if until is None else until
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
