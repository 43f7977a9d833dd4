"""Mesh study: convergence of a sail's deployment under refinement of its mesh.

One scene runs at several densities of its mesh, with the length scales of the paper and with physical ones (see
`length_scales`), from the unperturbed start and from perturbed starts. Finished runs are kept as files, so that an
interrupted study continues. `convergence` evaluates the runs.
"""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from threading import Event

import numpy as np

from membrane_rs._archives import read_arrays
from membrane_rs._arrays import Floats
from membrane_rs._files import made_folder, reading_errors, replacing
from membrane_rs._validation import check_kind, count_of, is_list, number_of, show, texts_of
from membrane_rs.analysis.deployment import Corners
from membrane_rs.errors import InputError, InputTypeError, UnstableError
from membrane_rs.folding.pattern import RowPattern, pattern_of
from membrane_rs.runs import Simulation
from membrane_rs.scene import Scene
from membrane_rs.study.common.density import refuse_numbers
from membrane_rs.study.common.executor import Tell, run_parallel, teller, workers_of
from membrane_rs.study.common.perturbation import SHIFT
from membrane_rs.study.common.run import MOST_MEMBERS, study_case
from membrane_rs.study.common.stages import refuse_stages
from membrane_rs.study.length_scales import FORMS, LengthScales

INTEGRATOR, SHARE = "leapfrog", 0.8
"""The method of all runs, and its step as a share of the stability limit."""
SAMPLE_INTERVAL = 1e-3
"""Time between two points of a curve [s]."""
ENERGY_LOSS = 0.2
"""Allowed energy error of a run: near its stability limit leapfrog has an error of some percent."""
MOST_ROWS = 10**5
"""Rows of cells of a mesh, at most."""
COLUMNS = ("time", "deployment_rate", "phase_difference_deg")


@dataclass(frozen=True)
class MeshRun:
    """One run of the study: its curves and its facts.

    Attributes
    ----------
    form : str
        Name of its length scales.
    rows : int
        Rows of cells from the inner to the outer edge.
    cell : float
        Height of a cell [m].
    member : int
        0: from the unperturbed start; else from a perturbed one.
    node_count : int
        Nodes of the mesh.
    dt : float
        Step [s].
    energy_error : float
        Residual of the energy balance at the end over the reference energy [-]: below zero a loss, above zero a gain.
    seconds : float
        Processor time of the stepping [s].
    stopped : str or None
        When and in which law the run was stopped before its end; None: it was not.
    table : mapping of str to (samples,) float
        "time" [s], "deployment_rate" [-], "phase_difference_deg" [deg].

    Examples
    --------
    >>> from membrane_rs import scenes
    >>> from membrane_rs.study import jobs_of, mesh_study
    >>> run = mesh_study(scenes.load("okuizumi-model-1"), jobs_of([8], ["paper"], 1, 1e-4), "runs", workers=1)[0]
    >>> run.form, run.rows, round(run.cell, 6), run.table["time"][-1].item()
    ('paper', 8, 0.022, 0.0001)
    """

    form: str
    rows: int
    cell: float
    member: int
    node_count: int
    dt: float
    energy_error: float
    seconds: float
    stopped: str | None
    table: Mapping[str, Floats]


@dataclass(frozen=True)
class Job:
    """A run of a mesh study that is to be made.

    Attributes
    ----------
    form : str
        Name of its length scales.
    length_scales : LengthScales
        The length scales themselves.
    rows : int
        Rows of cells from the inner to the outer edge.
    member : int
        0: from the unperturbed start; else from a perturbed one.
    until : float or None
        Time at the end [s]; None: the scene's.

    Examples
    --------
    >>> from membrane_rs.study import jobs_of
    >>> job = jobs_of([8], ["paper"], until=0.1)[0]
    >>> job.name, job.rows, job.until
    ('paper-8-0', 8, 0.1)
    """

    form: str
    length_scales: LengthScales
    rows: int
    member: int = 0
    until: float | None = None

    @property
    def name(self) -> str:
        """For files and messages."""
        return f"{self.form}-{self.rows}-{self.member}"


def jobs_of(
    rows: Sequence[int],
    forms: Sequence[str] | Mapping[str, LengthScales] = tuple(FORMS),
    members: int | Mapping[int, int] = 1,
    until: float | Mapping[int, float] | None = None,
) -> list[Job]:
    """A job for every form, mesh and start; the long runs first.

    Parameters
    ----------
    rows : sequence of int
        Rows of cells from the inner to the outer edge.
    forms : sequence of str, or mapping
        Names of `FORMS`, or names and length scales.
    members : int, or mapping
        Starts, the unperturbed one among them, of all meshes or by their rows (1 for rows without an entry).
    until : float or mapping, optional
        Time at the end [s], of all meshes or by their rows. Default: the scene's.

    Returns
    -------
    list of Job
        For `mesh_study`.

    Raises
    ------
    InputError, InputTypeError
        An unknown form, fewer than one start, what is no list or no number.

    Examples
    --------
    >>> from membrane_rs.study import jobs_of
    >>> len(jobs_of([8, 16], ["paper"], members=2, until=0.1))
    4
    """
    if not is_list(rows):
        raise InputTypeError(f"rows = {show(rows)}: must be a list of whole numbers, rows of cells")
    rows = [count_of("rows", count, 1, MOST_ROWS, "rows of cells") for count in rows]
    if not isinstance(forms, Mapping):
        forms = texts_of("forms", forms, "names of length scales, such as ['paper'], or a table of names and scales")
        unknown = next((form for form in forms if form not in FORMS), None)
        if unknown is not None:
            raise InputError(f"form = {show(unknown)}: must be one of {', '.join(FORMS)}")
        forms = {form: FORMS[form] for form in forms}
    jobs = []
    for count in sorted(set(rows), reverse=True):
        starts = members.get(count, 1) if isinstance(members, Mapping) else members
        end = until.get(count) if isinstance(until, Mapping) else until
        end = None if end is None else number_of("until", end)
        starts = count_of("members", starts, 1, MOST_MEMBERS, "starts of each mesh")
        jobs += [Job(form, scales, count, member, end) for form, scales in forms.items() for member in range(starts)]
    return jobs


def mesh_study(
    scene: Scene, jobs: Sequence[Job], folder: str | Path, *, workers: int | None = None, tell: Tell | None = None
) -> list[MeshRun]:
    """Make all runs in parallel; those whose files are in the folder already are read.

    Parameters
    ----------
    scene : Scene
        Its mesh must be of a pattern in rows, such as "square-sail".
    jobs : sequence of Job
        The runs; the long ones first.
    folder : path
        Folder of the runs. A file is read if scene, length scales, method and step are the same to the last digit;
        remove the folder to repeat all runs.
    workers : int, optional
        Number of parallel runs. Default: one on each core.
    tell : callable, optional
        Called with a line of text after each run.

    Returns
    -------
    list of MeshRun
        By form (those of `FORMS` first), then from coarse to fine, then by start.

    Raises
    ------
    InputError, InputTypeError
        A mesh of another pattern, rows that do not fit the strips, a part or a law that refers to the mesh by numbers,
        no scene, no jobs.
    OutputError
        The folder cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> from membrane_rs import scenes
    >>> from membrane_rs.study import jobs_of, mesh_study
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     runs = mesh_study(scenes.load("okuizumi-model-1"), jobs_of([8], ["paper"], 1, 1e-4), folder, workers=1)
    >>> runs[0].rows, runs[0].stopped
    (8, None)
    """
    if not is_list(jobs) or not all(isinstance(job, Job) for job in jobs):
        raise InputTypeError(f"jobs = {show(jobs)}: must be a list of jobs, such as `jobs_of` makes")
    teller(tell, "tell")
    sail = sail_of(scene)
    for job in jobs:
        sail.with_rows(job.rows)  # refuses rows that do not fit, before anything runs
    workers = workers_of(workers)  # refused before there is a folder
    folder = made_folder(folder)
    stop = Event()
    runs = run_parallel(
        [lambda job=job: _kept(scene, sail, job, folder, stop) for job in jobs],  # type: ignore[misc]
        [f"{scene.name} {job.name}" for job in jobs],
        stop,
        workers=workers,
        tell=tell,
        outcome=lambda run: f"stopped {run.stopped}" if run.stopped else f"{run.seconds:.0f} s of stepping",
    )
    order = list(dict.fromkeys([*FORMS, *(job.form for job in jobs)]))
    return sorted(runs, key=lambda run: (order.index(run.form), run.rows, run.member))


def kept(scene: Scene, jobs: Sequence[Job], folder: str | Path) -> list[Job]:
    """The jobs whose runs are in the folder already. Raises InputError as `mesh_study` does."""
    sail = sail_of(scene)
    return [job for job in jobs if _place(scene, sail, job, Path(folder))[1].is_file()]


def sail_of(scene: Scene) -> RowPattern:
    """The pattern in rows of a scene of a mesh study. Raises InputError and InputTypeError."""
    check_kind(scene, Scene, "scene", "a Scene")
    refuse_stages(scene)
    refuse_numbers(scene, "mesh study")
    sail = pattern_of(scene.mesh)
    if not isinstance(sail, RowPattern):
        raise InputError(
            f"scene {scene.name!r}: its mesh has no pattern in rows, such as 'square-sail'; a mesh study varies rows"
        )
    return sail


def _place(scene: Scene, sail: RowPattern, job: Job, folder: Path) -> tuple[Scene, Path]:
    """The scene of a job, and the file of its run."""
    end = scene.run.until if job.until is None else job.until
    samples = max(2, round(end / SAMPLE_INTERVAL) + 1)
    settings = replace(
        scene.run, until=end, samples=samples, frames=2, snapshots=(), dt=None, integrator=INTEGRATOR,
        energy_loss=ENERGY_LOSS,
    )  # fmt: skip
    finer = job.length_scales.of(replace(scene, mesh=sail.with_rows(job.rows).mesh(), run=settings))
    mark = hashlib.sha256(f"{finer.to_toml()}\n{SHARE} {SHIFT} {job.member}".encode()).hexdigest()[:12]
    return finer, folder / f"{scene.name}-{job.name}-{mark}.npz"


def _kept(scene: Scene, sail: RowPattern, job: Job, folder: Path, stop: Event) -> MeshRun:
    """The run, read from its file or made and written there."""
    finer, path = _place(scene, sail, job, folder)
    if path.is_file():
        return _read(path)
    run = _run(job, sail, finer, stop)
    if not stop.is_set():
        _write(path, run)
    return run


class _Curves:
    """Observer that keeps the curves of one run, and ends it once `stop` is set."""

    def __init__(self, stop: Event) -> None:
        self.rows: list[tuple[float, float, float]] = []
        self._stop = stop

    def start(self, sim: Simulation) -> None:
        self._corners = Corners(sim.assembly)

    def sample(self, sim: Simulation) -> None:
        if self._stop.is_set():
            raise KeyboardInterrupt
        x = sim.positions
        self.rows.append((sim.time, self._corners.deployment_rate(x), self._corners.phase_difference(x)))

    def frame(self, sim: Simulation) -> None:
        """Keeps no shapes."""

    def finish(self, sim: Simulation, error: BaseException | None) -> None:
        """Has nothing to close."""

    def table(self) -> dict[str, Floats]:
        values = np.array(self.rows, dtype=np.float64).reshape(-1, len(COLUMNS))
        return {name: values[:, k] for k, name in enumerate(COLUMNS)}


def _run(job: Job, sail: RowPattern, scene: Scene, stop: Event) -> MeshRun:
    case = study_case(scene, None, 1)
    if job.member:
        case = case.perturbed(job.member - 1)
    limit = Simulation(case.scene).stable_dt()
    steps = int(np.ceil(case.until / (SHARE * limit)))
    sim = Simulation(case.scene, dt=case.until / steps)
    sim.positions = case.start
    curves, stopped, began = _Curves(stop), None, time.thread_time()
    try:
        sim.run(observers=[curves])
    except UnstableError as error:
        stopped = f"at {error.time:.4g} s ({error.law})"
    return MeshRun(
        form=job.form,
        rows=job.rows,
        cell=sail.with_rows(job.rows).row_height,
        member=job.member,
        node_count=sim.node_count,
        dt=sim.dt,
        energy_error=sim.ledger()["error"],
        seconds=time.thread_time() - began,
        stopped=stopped,
        table=curves.table(),
    )


def _write(path: Path, run: MeshRun) -> None:
    facts = {name: value for name, value in asdict(run).items() if name != "table"}
    with replacing(path) as part, part.open("wb") as file:
        np.savez_compressed(
            file,
            facts=np.array(json.dumps(facts)),
            time=run.table["time"],
            deployment_rate=run.table["deployment_rate"],
            phase_difference_deg=run.table["phase_difference_deg"],
        )


def _read(path: Path) -> MeshRun:
    with reading_errors(path, "run of a mesh study"):
        data = read_arrays(path)
        facts = json.loads(str(data["facts"]))
        return MeshRun(**facts, table={name: data[name] for name in COLUMNS})
