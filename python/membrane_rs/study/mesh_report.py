"""The result of a mesh study: tables, curves and a verdict."""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from io import StringIO
from itertools import pairwise
from pathlib import Path
from typing import Any

from membrane_rs._files import made_folder, write_text
from membrane_rs._markdown import table
from membrane_rs.plotting.mesh_study import plot_meshes
from membrane_rs.study.convergence import CURVES, Density, densities, limit, orders, overall_order, run_features, steps
from membrane_rs.study.mesh import COLUMNS, MeshRun

_SHOWN = (
    ("first peak of the rate", "first_peak_rate", ".3f"),
    ("at [s]", "first_peak_time", ".3f"),
    ("trough of the phase [deg]", "phase_trough_deg", ".1f"),
    ("at [s]", "phase_trough_time", ".3f"),
    ("phase back at zero [s]", "zero_crossing_time", ".3f"),
    ("rate there", "zero_crossing_rate", ".3f"),
)


def report(runs: Sequence[MeshRun]) -> str:
    """Tables in Markdown: features of the curves, differences from mesh to mesh, orders; then the verdict."""
    forms = densities(runs)
    return "\n".join([_shown(forms), _stepped(forms), verdict(forms)])


def as_dict(runs: Sequence[MeshRun]) -> dict[str, Any]:
    """The same as numbers: "meshes" with their features, "steps" from mesh to mesh, "orders" by form and curve."""
    forms = densities(runs)
    meshes, between = [], []
    for form, members in forms.items():
        for mesh in members:
            first = mesh.runs[0]
            facts = {"form": form, "rows": mesh.rows, "cell": mesh.cell, "nodes": first.node_count, "dt": first.dt}
            worst = max((run.energy_error for run in mesh.runs), key=abs)
            stopped = [run.stopped for run in mesh.runs if run.stopped]
            features = {key: mesh.feature(key)[0] for key in run_features(first)}
            facts |= {"starts": len(mesh.runs), "until": mesh.until, "energy_error": worst, "stopped": stopped}
            meshes.append(facts | {"features": features})
        for step in steps(members):
            cells = {"form": form, "coarse": step.coarse.cell, "fine": step.fine.cell, "until": step.until}
            between.append({**cells, "distance": step.distance, "noise": step.noise})
    order = {form: {c: overall_order(steps(members), c) for c in CURVES} for form, members in forms.items()}
    return {"meshes": meshes, "steps": between, "orders": order}


def _shown(forms: dict[str, list[Density]]) -> str:
    head = ["form", "cells [mm]", "nodes", "starts", "step [us]", *(name for name, _, _ in _SHOWN), "energy error [%]"]
    body = []
    for meshes in forms.values():
        for mesh in meshes:
            first = mesh.runs[0]
            cells = [_with_spread(*mesh.feature(key), form) for _, key, form in _SHOWN]
            stopped = next((run.stopped for run in mesh.runs if run.stopped), None)
            worst = max((run.energy_error for run in mesh.runs), key=abs)
            energy = f"{100 * worst:+.2f}" if stopped is None else f"stopped {stopped}"
            sizes = [f"{1e3 * mesh.cell:.4g}", f"{first.node_count:,}", str(len(mesh.runs)), f"{1e6 * first.dt:.3g}"]
            body.append([mesh.form, *sizes, *cells, energy])
    return table(head, body)


def _stepped(forms: dict[str, list[Density]]) -> str:
    head = ["form", "cells [mm]", "until [s]", "distance of the rates", "of the phases [deg]", "order, rate", "phase"]
    body = []
    for form, meshes in forms.items():
        found = steps(meshes)
        ps = {c: [math.nan, *orders(found, c)] for c in CURVES}
        for k, step in enumerate(found):
            cells = f"{1e3 * step.coarse.cell:.4g} to {1e3 * step.fine.cell:.4g}"
            values = [
                _with_spread(step.distance[c], step.noise[c], digits)
                for c, digits in zip(CURVES, (".4f", ".1f"), strict=True)
            ]
            body.append([form, cells, f"{step.until:.3g}", *values, *(_number(ps[c][k], ".1f") for c in CURVES)])
    return table(head, body) if body else ""


def verdict(forms: dict[str, list[Density]]) -> str:
    """For each form with at least three meshes: whether its curves approach a limit, and which."""
    lines = []
    for form, meshes in forms.items():
        found = steps(meshes)
        if len(found) < 2:
            continue
        p = {c: overall_order(found, c) for c in CURVES}
        shrinking = {c: all(b.distance[c] < a.distance[c] for a, b in pairwise(found)) for c in CURVES}
        over = f"over {len(meshes)} meshes, order {p[CURVES[0]]:.1f} in the rate and {p[CURVES[1]]:.1f} in the phase"
        latest = [orders(found, c)[-1] for c in CURVES]  # of the three finest meshes
        if all(shrinking.values()) and min(*p.values(), *latest) > 0.5:
            trough = limit(meshes, "phase_trough_deg", p[CURVES[1]])
            to = f"; the trough of the phase tends to {trough:.0f} degrees" if math.isfinite(trough) else ""
            last, digits = found[-1], dict(zip(CURVES, (".4f", ".1f"), strict=True))
            size = " and ".join(_with_spread(last.distance[c], last.noise[c], digits[c]) for c in CURVES)
            lost = (
                " (no longer clear of its noise)" if any(last.distance[c] < 2 * last.noise[c] for c in CURVES) else ""
            )
            text = f"approaches a limit: {over}; the last step is {size} degrees{lost}{to}"
        elif all(found[-1].distance[c] >= found[-2].distance[c] for c in CURVES):
            text = f"no limit in sight: {over}"
        else:
            text = f"undecided: {over}"
        lines.append(f"- {form}: {text}.\n")
    return "".join(lines)


def write_mesh_study(runs: Sequence[MeshRun], folder: str | Path) -> str:
    """Write mesh-study.md (tables), mesh-study.png (curves) and mesh-study.csv (the points) into a folder.

    Parameters
    ----------
    runs : sequence of MeshRun
        What `mesh_study` made.
    folder : path
        Where to.

    Returns
    -------
    str
        The tables, in Markdown.

    Raises
    ------
    OutputError
        It cannot be written.
    InputError, InputTypeError
        No path.

    Examples
    --------
    >>> from membrane_rs import scenes
    >>> from membrane_rs.study import jobs_of, mesh_study, write_mesh_study
    >>> runs = mesh_study(scenes.load("okuizumi-model-1"), jobs_of([8], ["paper"], 1, 1e-4), "runs", workers=1)
    >>> write_mesh_study(runs, "study").splitlines()[2][:14]
    '| paper | 22 |'
    """
    folder = made_folder(folder)
    tables = report(runs)
    write_text(folder / "mesh-study.md", tables)
    text = StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["form", "rows", "member", *COLUMNS])
    for run in runs:
        columns = (run.table[name].tolist() for name in COLUMNS)
        writer.writerows([run.form, run.rows, run.member, *point] for point in zip(*columns, strict=True))
    write_text(folder / "mesh-study.csv", text.getvalue())
    plot_study(runs, folder / "mesh-study.png")
    return tables


def plot_study(runs: Sequence[MeshRun], path: Path) -> None:
    """Draw all curves, a column for each form. Raises OutputError where `path` cannot be written."""
    plot_meshes(
        {
            form: [(f"{1e3 * mesh.cell:.3g} mm", [run.table for run in mesh.runs]) for mesh in meshes]
            for form, meshes in densities(runs).items()
        },
        path,
    )


def _number(value: float, form: str) -> str:
    return f"{value:{form}}" if math.isfinite(value) else "-"


def _with_spread(value: float, spread: float, form: str) -> str:
    return _number(value, form) + (f" +- {spread:{form}}" if math.isfinite(spread) else "")
