"""Commands that compare many runs of a scene."""

from __future__ import annotations

from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from membrane_rs._extras import need
from membrane_rs._files import check_folder
from membrane_rs._renamed import deprecated
from membrane_rs.cli.application import STUDIES, Json, command, print_json, tell
from membrane_rs.cli.many_runs import Shift
from membrane_rs.cli.options import (
    Integrator,
    Jobs,
    Out,
    Rows,
    SceneArgument,
    Set,
    Until,
    count_option,
    load,
    numbers,
    numeric_option,
    quantity_option,
    refuse_given,
    report_audit,
    whole,
    words,
)

if TYPE_CHECKING:
    from membrane_rs.study import Ablation, WorkPrecision
    from membrane_rs.study.stability import Cell

Methods = Annotated[
    str | None,
    typer.Option("--integrators", "--integrator", help="Methods, separated by commas. Default: all."),
]


STEPS, ERROR, ROWS = 6, 1e-3, "8,16"
"""Defaults of work-precision: steps below the limit, the target error, and the meshes of --mesh."""


@command(STUDIES, example="stability spinning-tether --values 0,0.02 --steps 0.5,1.05 --until 0.001")
def stability(
    scene: SceneArgument,
    *,
    set_: Set = None,
    parameter: Annotated[str, typer.Option(help="The parameter, by its name in the scene file.")] = (
        "laws.spring_damping.ratio"
    ),
    values: Annotated[str, typer.Option(help="Its values, separated by commas.")] = "0,0.02,0.1,0.5,2",
    steps: Annotated[str, typer.Option(help="Steps in multiples of the stability limit, separated by commas.")] = (
        "0.25,0.5,0.75,0.95,1.05,1.5"
    ),
    integrator: Methods = None,
    until: Until = None,
    jobs: Jobs = None,
    out: Out = None,
    json: Json = False,
) -> None:
    """Map the outcome of runs over step and one parameter: fine, inaccurate, energy injected, blown up."""
    from membrane_rs.study.stability import explicit_integrators, stability_map, write_map

    chosen = load(scene, set_)
    folder = _folder(out, f"{chosen.name}-stability")
    need("matplotlib", use="the picture of the study")
    report_audit(chosen)
    names = explicit_integrators(chosen) if integrator is None else words(integrator, "--integrators")
    cells = stability_map(
        chosen,
        parameter,
        numbers(values, "--values", chosen.unit(parameter)),
        methods=names,
        shares=numbers(steps, "--steps"),
        until=until,
        jobs=jobs,
        progress=lambda cell: (tell if json else typer.echo)(_in_words(cell, parameter)),
    )
    for path in write_map(cells, parameter, folder, chosen.name):
        (tell if json else typer.echo)(f"Wrote {path}")
    if json:
        print_json(
            {"scene": chosen.name, "folder": str(folder), "parameter": parameter, "cells": list(map(vars, cells))}
        )


def _in_words(cell: Cell, parameter: str) -> str:
    """A cell of a stability map in a line."""
    place = f"{cell.integrator:<12} {parameter} = {cell.value:<10g}"
    if not cell.dt > 0.0:
        return f"{place} {cell.outcome}: {cell.message}"
    step = f"dt = {cell.dt:.4g} s  ({cell.dt / cell.limit:.2f} of the limit)"
    return f"{place} {step}  {cell.outcome}, t = {cell.time:.4g} s"


@command(STUDIES, example="work-precision spinning-tether --until 0.001 --steps 2 --repeats 1")
def work_precision(
    scene: SceneArgument,
    *,
    set_: Set = None,
    integrators: Methods = None,
    until: Until = None,
    steps: Annotated[int, count_option(help="Steps below the limit, each half the last; as many tolerances.")] = STEPS,
    curves: Annotated[
        bool, typer.Option("--curves/--pointwise", help="Compare rate and phase, not positions.")
    ] = False,
    ensemble: Annotated[
        int | None, count_option(help="Number of runs from perturbed starts. Default: 0; 4 with --curves.")
    ] = None,
    density: Annotated[
        str | None, typer.Option(help="Relative densities of other meshes, such as 0.5,2; with --curves.")
    ] = None,
    softening: Annotated[
        str | None,
        typer.Option(help="Softenings of the film, such as 3,10,30: a line for each, against the film as it is."),
    ] = None,
    shift: Annotated[
        float | None,
        quantity_option(
            "m",
            help="Standard deviation of the coordinates of perturbed starts [m]. Default: 1e-12, or 1e-6 with "
            "--softening.",
        ),
    ] = None,
    error: Annotated[float, numeric_option(help="The target error, to be reached at least cost.")] = ERROR,
    repeats: Annotated[
        int | None, count_option(help="Runs of which the time is the median. Default: 3; 1 with --curves.")
    ] = None,
    budget: Annotated[
        float | None, quantity_option("s", help="Leave out runs that take longer on one core [s].")
    ] = None,
    mesh: Annotated[bool, typer.Option("--mesh", help="Refine the mesh instead of the step: see mesh-study.")] = False,
    rows: Rows = ROWS,
    jobs: Jobs = None,
    out: Out = None,
    json: Json = False,
) -> None:
    """Draw a work-precision diagram: error against cost of each method, over a series of steps."""
    from membrane_rs.study import work_precision as study

    if mesh:
        of_steps = {
            "--integrators": integrators is not None, "--steps": steps != STEPS, "--density": density is not None,
            "--softening": softening is not None, "--shift": shift is not None, "--error": error != ERROR,
            "--repeats": repeats is not None, "--budget": budget is not None,
        }  # fmt: skip
        refuse_given(of_steps, "has no effect with --mesh, which refines the mesh and not the step; leave it out")
        _study_meshes(
            scene, set_, rows=rows, forms=None, ensemble=ensemble or 0, until=until, jobs=jobs, out=out, json=json
        )
        return

    refuse_given({"--rows": rows != ROWS}, "has no effect without --mesh; leave it out, or add --mesh")
    chosen = load(scene, set_)
    folder = _folder(out, f"{chosen.name}-work-precision")
    need("matplotlib", use="the picture of the study")
    report_audit(chosen)
    names = words(integrators, "--integrators") if integrators is not None else None
    meshes = numbers(density, "--density") if density is not None else []
    films = numbers(softening, "--softening") if softening is not None else []
    found = study(
        chosen, names, until, steps=steps, curves=curves, members=ensemble, densities=meshes, softenings=films,
        shift=shift, wanted=error, repeats=repeats, budget=budget, jobs=jobs, progress=tell,
    )  # fmt: skip
    _save(found, folder, json=json)


@command(STUDIES, example="work-precision spinning-tether --until 0.001 --steps 2 --repeats 1", hidden=True)
@wraps(work_precision, assigned=())
def chart(**options: Any) -> None:
    """The old name of work-precision."""
    deprecated("membrane-rs chart", "use membrane-rs work-precision")
    work_precision(**options)


@command(STUDIES, example="ablate spinning-tether --until 0.01 --ensemble 1")
def ablate(
    scene: SceneArgument,
    *,
    set_: Set = None,
    until: Until = None,
    tolerance: Annotated[
        float,
        numeric_option(help="Allowed change: of the rate, of the phase (turns), of the peaks."),
    ] = 0.01,
    ensemble: Annotated[int, count_option(help="Number of runs from perturbed starts; 0: none.")] = 5,
    shift: Shift = None,
    integrator: Integrator = None,
    share: Annotated[float | None, numeric_option(help="Steps in multiples of the stability limit.")] = None,
    dense_until: Annotated[float | None, quantity_option("s", help="End of the run on the denser mesh [s].")] = None,
    jobs: Jobs = None,
    out: Out = None,
    json: Json = False,
) -> None:
    """Leave out each law and part in turn, and write the smallest scene that keeps the tolerance."""
    from membrane_rs.study import ablate as study

    without_starts = {"--shift": ensemble == 0 and shift is not None}
    refuse_given(without_starts, "has no effect without perturbed starts; leave out this or --ensemble 0")
    chosen = load(scene, set_)
    folder = _folder(out, f"{chosen.name}-ablation")
    report_audit(chosen)
    found = study(
        chosen, until, tolerance=tolerance, members=ensemble, integrator=integrator, share=share,
        dense_until=dense_until, jobs=jobs, progress=tell, **({} if shift is None else {"shift": shift}),
    )  # fmt: skip
    _save(found, folder, json=json)


@command(STUDIES, example="mesh-study okuizumi-model-1 --rows 8 --forms paper,strain --until 0.0001")
def mesh_study(
    scene: SceneArgument = "okuizumi-model-1",
    *,
    set_: Set = None,
    rows: Rows = ROWS,
    forms: Annotated[str | None, typer.Option(help="Forms of the parameters, by commas. Default: all.")] = None,
    ensemble: Annotated[int, count_option(help="Number of runs from perturbed starts on each mesh.")] = 0,
    until: Until = None,
    jobs: Jobs = None,
    out: Out = None,
    json: Json = False,
) -> None:
    """Run a square sail at several mesh densities, and measure the order of convergence of its curves."""
    _study_meshes(
        scene,
        set_,
        rows=rows,
        forms=None if forms is None else words(forms, "--forms"),
        ensemble=ensemble,
        until=until,
        jobs=jobs,
        out=out,
        json=json,
    )


def _study_meshes(
    scene: str,
    set_: list[str] | None,
    *,
    rows: str,
    forms: list[str] | None,
    ensemble: int,
    until: float | None,
    jobs: int | None,
    out: Path | None,
    json: bool,
) -> None:
    from membrane_rs.errors import InputError
    from membrane_rs.study import FORMS, jobs_of, write_mesh_study
    from membrane_rs.study import mesh_study as study
    from membrane_rs.study.mesh_report import as_dict

    chosen = load(scene, set_)
    folder = _folder(out, f"{chosen.name}-mesh-study")
    need("matplotlib", use="the picture of the study")
    report_audit(chosen)
    if ensemble < 0:
        raise InputError(f"--ensemble = {ensemble}: must be 0 or above")
    counts = [whole(number, "--rows") for number in numbers(rows, "--rows")]
    made = study(
        chosen, jobs_of(counts, forms or list(FORMS), 1 + ensemble, until), folder / "runs", workers=jobs, tell=tell
    )
    tables = write_mesh_study(made, folder)
    if json:
        print_json({"scene": chosen.name, "folder": str(folder), **as_dict(made)})
        return
    typer.echo(f"{tables}\nResults are in {folder}")


def _folder(out: Path | None, name: str) -> Path:
    """The folder of a study. Raises OutputError where it cannot be written, before the study is made."""
    folder = out or Path("runs") / name
    check_folder(folder)
    return folder


def _save(study: Ablation | WorkPrecision, folder: Path, *, json: bool) -> None:
    study.save(folder)
    if json:
        print_json({"folder": str(folder), **study.as_dict()})
        return
    typer.echo(f"{study.summary()}\nResults are in {folder}")
