"""Does a sail's deployment approach a limit as its mesh gets finer?

The paper's critical strain, alpha pi^2 h^2/(12 L^2), and its crease stiffness, beta E J L/H, take their lengths
from the mesh: finer, the same alpha and beta are another membrane. Here one scene runs at several densities of its
mesh, in that form and with one physical length in place of both, and the curves are laid side by side.
"""

from __future__ import annotations

import csv
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from io import StringIO
from itertools import pairwise
from pathlib import Path

import numpy as np

from membrane_rs._files import output_errors, write_text
from membrane_rs._validation import show
from membrane_rs.errors import InputError, UnstableError
from membrane_rs.folding import SquareSail
from membrane_rs.laws import Creases, Law, Springs, Triangles
from membrane_rs.observe import Corners, Floats
from membrane_rs.output.mesh_plot import plot_meshes
from membrane_rs.output.report import curve_features
from membrane_rs.scene import Scene
from membrane_rs.simulation import Simulation

FORMS = ("paper", "physical")
"""Lengths from the mesh, or one physical length for the buckling and the creases."""
LENGTH = 0.011
"""The physical length at which both forms agree on the paper's mesh: the height of its cells [m]."""
SAMPLE_INTERVAL = 1e-3
"""Time between two points of a curve [s]."""
COLUMNS = ("time", "deployment_rate", "phase_difference_deg")
_SHOWN = (
    ("first peak of the rate", "first_peak_rate", ".3f"),
    ("at [s]", "first_peak_time", ".3f"),
    ("trough of the phase [deg]", "phase_trough_deg", ".1f"),
    ("at [s]", "phase_trough_time", ".3f"),
    ("phase back at zero [s]", "zero_crossing_time", ".3f"),
    ("rate there", "zero_crossing_rate", ".3f"),
)


@dataclass(frozen=True)
class MeshRun:
    """One run of the study: its curves, and what they say."""

    form: str
    rows: int
    """Rows of cells from the inner to the outer edge."""
    cell: float
    """Height of a cell [m]."""
    node_count: int
    dt: float
    """Step [s]."""
    table: Mapping[str, Floats]
    """(samples,) "time" [s], "deployment_rate", "phase_difference_deg"."""
    energy_error: float
    """Share of the energy turned over that is missing (below zero) or from nowhere at the end."""
    stopped: str | None
    """The error that ended the run before its time."""

    @property
    def features(self) -> dict[str, float | None]:
        """Peak, trough and zero of the curves, None where the run has not come that far."""
        return curve_features(self.table)


class _Curves:
    """Keeps the curves of one run."""

    def __init__(self) -> None:
        self.rows: list[tuple[float, float, float]] = []

    def start(self, sim: Simulation) -> None:
        self._corners = Corners(sim.assembly)

    def sample(self, sim: Simulation) -> None:
        x = sim.positions
        self.rows.append((sim.time, self._corners.deployment_rate(x), self._corners.phase_difference(x)))

    def frame(self, sim: Simulation) -> None:
        """Keeps no shapes."""

    def finish(self, sim: Simulation, error: BaseException | None) -> None:
        """Has nothing to close."""

    def table(self) -> dict[str, Floats]:
        values = np.array(self.rows, dtype=np.float64).reshape(-1, len(COLUMNS))
        return {name: values[:, k] for k, name in enumerate(COLUMNS)}


def mesh_study(
    scene: Scene,
    rows: Sequence[int],
    until: float | None = None,
    forms: Sequence[str] = FORMS,
    length: float = LENGTH,
) -> Iterator[MeshRun]:
    """Run a sail at several mesh densities, in each form; give each run as it ends.

    Parameters
    ----------
    scene : Scene
        Its mesh must be of the pattern "square-sail".
    rows : sequence of int
        Rows of cells from the inner to the outer edge; each a multiple of the number of strips.
    until : float, optional
        Simulated time of each run [s]. Default: the scene's.
    forms : sequence of str
        Of "paper" and "physical".
    length : float
        The physical form's length for buckling and creases [m].

    Raises
    ------
    InputError
        A mesh of another pattern, a form that is not there, rows that do not fit the strips.
    """
    sail = scene.mesh.source if scene.mesh is not None else None
    if not isinstance(sail, SquareSail):
        raise InputError(f"scene {scene.name!r}: its mesh is no square sail, whose rows could be varied; take another")
    unknown = next((form for form in forms if form not in FORMS), None)
    if unknown is not None:
        raise InputError(f"form = {show(unknown)}: must be one of {', '.join(FORMS)}")
    sails = [replace(sail, rows=count) for count in sorted(rows)]
    end = scene.run.until if until is None else until
    samples = max(2, round(end / SAMPLE_INTERVAL) + 1)
    run = replace(scene.run, until=end, samples=samples, frames=2, snapshots=(), dt=None)
    for form in forms:
        laws = _with_lengths(scene.laws, length if form == "physical" else None)
        for finer in sails:
            yield _run(form, finer, replace(scene, mesh=finer.mesh(), laws=laws, run=run))


def _with_lengths(laws: Sequence[Law], length: float | None) -> list[Law]:
    """The laws with the lengths of buckling and creases set, or left to the mesh."""
    changed: list[Law] = []
    for law in laws:
        if isinstance(law, Springs | Triangles):
            changed.append(replace(law, buckling_length=length))
        elif isinstance(law, Creases):
            changed.append(replace(law, length_scale=length))
        else:
            changed.append(law)
    return changed


def _run(form: str, sail: SquareSail, scene: Scene) -> MeshRun:
    curves, stopped = _Curves(), None
    sim = Simulation(scene)
    try:
        sim.run(observers=[curves])
    except UnstableError as error:
        stopped = str(error)
    return MeshRun(
        form,
        sail.strips * sail.rows_per_strip,
        sail.strip_height / sail.rows_per_strip,
        sim.node_count,
        sim.dt,
        curves.table(),
        sim.ledger()["error"],
        stopped,
    )


def distances(coarse: MeshRun, fine: MeshRun) -> tuple[float, float]:
    """Root mean square distance of two runs' curves over the time that both cover: rate, and phase [deg]."""
    end = min(coarse.table["time"][-1], fine.table["time"][-1])
    times = np.linspace(0.0, end, 2001)
    found = []
    for column in COLUMNS[1:]:
        a, b = (np.interp(times, run.table["time"], run.table[column]) for run in (coarse, fine))
        found.append(float(np.sqrt(np.mean((a - b) ** 2))))
    return found[0], found[1]


def report(runs: Sequence[MeshRun]) -> str:
    """Two tables in Markdown: what the curves show, and how far each is from that of the next coarser mesh."""
    names = ["form", "cells [mm]", "nodes", "step [us]", *(name for name, _, _ in _SHOWN), "energy error [%]"]
    body = []
    for run in runs:
        values = [run.features[key] for _, key, _ in _SHOWN]
        cells = ["-" if v is None else f"{v:{form}}" for v, (_, _, form) in zip(values, _SHOWN, strict=True)]
        energy = f"{100 * run.energy_error:+.3f}" if run.stopped is None else f"stopped: {run.stopped}"
        head = [run.form, f"{1e3 * run.cell:.4g}", f"{run.node_count:,}", f"{1e6 * run.dt:.3g}"]
        body.append([*head, *cells, energy])
    pairs = [(a, b) for a, b in pairwise(runs) if a.form == b.form]
    steps = []
    for a, b in pairs:
        rate, phase = distances(a, b)
        end = min(a.table["time"][-1], b.table["time"][-1])
        meshes = f"{1e3 * a.cell:.4g} to {1e3 * b.cell:.4g}"
        steps.append([a.form, meshes, f"{end:.3g}", f"{rate:.4f}", f"{phase:.2f}"])
    text = _markdown(names, body)
    if steps:
        head = ["form", "cells [mm]", "until [s]", "distance of the rates", "of the phases [deg]"]
        text += "\n" + _markdown(head, steps)
    return text


def write_mesh_study(runs: Sequence[MeshRun], folder: str | Path) -> None:
    """Write mesh-study.md (tables), mesh-study.png (curves) and mesh-study.csv (the points) into a folder.

    Raises OutputError where it cannot be written.
    """
    folder = Path(folder)
    with output_errors(folder):
        folder.mkdir(parents=True, exist_ok=True)
    write_text(folder / "mesh-study.md", report(runs))
    text = StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["form", "rows", *COLUMNS])
    for run in runs:
        columns = (run.table[name].tolist() for name in COLUMNS)
        writer.writerows([run.form, run.rows, *point] for point in zip(*columns, strict=True))
    write_text(folder / "mesh-study.csv", text.getvalue())
    forms = dict.fromkeys(run.form for run in runs)
    plot_meshes(
        {form: [(f"{1e3 * run.cell:.3g} mm", run.table) for run in runs if run.form == form] for form in forms},
        folder / "mesh-study.png",
    )


def _markdown(head: Sequence[str], body: Sequence[Sequence[str]]) -> str:
    lines = [head, ["---"] + ["---:"] * (len(head) - 1), *body]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)
