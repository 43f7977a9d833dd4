"""Does a sail's deployment approach a limit as its mesh gets finer?

One scene runs at several densities of its mesh, in the paper's form and with physical lengths (see `lengths`), from the
true start and from starts that are a little off. Finished runs are kept as files, so that a study that was
interrupted goes on where it was. What the runs say together is in `convergence`.
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

from membrane_rs._arrays import Floats
from membrane_rs._files import output_errors, replacing
from membrane_rs._validation import show
from membrane_rs.analysis.deployment import Corners
from membrane_rs.errors import InputError, UnstableError
from membrane_rs.folding.pattern import RowPattern, pattern_of
from membrane_rs.runs import Simulation
from membrane_rs.scene import Scene
from membrane_rs.study.common.executor import Tell, together
from membrane_rs.study.common.run import SHIFT, course
from membrane_rs.study.lengths import FORMS, Lengths

INTEGRATOR, SHARE = "leapfrog", 0.8
"""The method of all runs, and its step as a share of the stability limit."""
SAMPLE_INTERVAL = 1e-3
"""Time between two points of a curve [s]."""
ENERGY_LOSS = 0.2
"""Share of the energy turned over that a run may lose: near its limit leapfrog is off by some percent."""
COLUMNS = ("time", "deployment_rate", "phase_difference_deg")


@dataclass(frozen=True)
class MeshRun:
    """One run of the study: its curves, and how it went."""

    form: str
    rows: int
    """Rows of cells from the inner to the outer edge."""
    cell: float
    """Height of a cell [m]."""
    member: int
    """0: from the true start; else from a shifted one."""
    node_count: int
    dt: float
    """Step [s]."""
    energy_error: float
    """Share of the energy turned over that is missing (below zero) or from nowhere at the end."""
    seconds: float
    """Processor time of the stepping [s]."""
    stopped: str | None
    """The error that ended the run before its time."""
    table: Mapping[str, Floats]
    """(samples,) "time" [s], "deployment_rate", "phase_difference_deg"."""


@dataclass(frozen=True)
class Job:
    """A run to be made."""

    form: str
    lengths: Lengths
    rows: int
    member: int = 0
    until: float | None = None

    @property
    def name(self) -> str:
        """For files and words."""
        return f"{self.form}-{self.rows}-{self.member}"


def jobs_of(
    rows: Sequence[int],
    forms: Sequence[str] | Mapping[str, Lengths] = tuple(FORMS),
    members: int | Mapping[int, int] = 1,
    until: float | Mapping[int, float] | None = None,
) -> list[Job]:
    """Every form on every mesh, from each start; the long runs first.

    Parameters
    ----------
    rows : sequence of int
        Rows of cells from the inner to the outer edge.
    forms : sequence of str, or mapping
        Names out of `FORMS`, or names and lengths.
    members : int, or mapping
        Starts, the true one among them, of all meshes or by their rows (1 where it has none).
    until : float or mapping, optional
        Time at the end [s], of all meshes or by their rows. Default: the scene's.

    Raises
    ------
    InputError
        A form that is not there, less than one start.
    """
    if not isinstance(forms, Mapping):
        unknown = next((form for form in forms if form not in FORMS), None)
        if unknown is not None:
            raise InputError(f"form = {show(unknown)}: must be one of {', '.join(FORMS)}")
        forms = {form: FORMS[form] for form in forms}
    jobs = []
    for count in sorted(set(rows), reverse=True):
        starts = members.get(count, 1) if isinstance(members, Mapping) else members
        end = until.get(count) if isinstance(until, Mapping) else until
        if starts < 1:
            raise InputError(f"members = {starts}: must be 1 or above")
        jobs += [Job(form, lengths, count, member, end) for form, lengths in forms.items() for member in range(starts)]
    return jobs


def mesh_study(
    scene: Scene, jobs: Sequence[Job], folder: str | Path, *, workers: int | None = None, tell: Tell | None = None
) -> list[MeshRun]:
    """Make all runs, several at once; those whose files are in the folder already are read.

    Parameters
    ----------
    scene : Scene
        Its mesh must be of a pattern in rows, such as "square-sail".
    jobs : sequence of Job
        What to run; the long ones first.
    folder : path
        Where the runs are kept. A file counts where the scene, its lengths and the way it was run are the same to
        the last digit; remove the folder to make all anew.
    workers : int, optional
        Runs at once. Default: one on each core.
    tell : callable, optional
        Told in words whenever a run is done.

    Returns
    -------
    list of MeshRun
        By form (those of `FORMS` first), then from coarse to fine, then by member.

    Raises
    ------
    InputError
        A mesh of another pattern, rows that do not fit the strips.
    OutputError
        The folder cannot be written.
    """
    sail = _sail(scene)
    for job in jobs:
        sail.with_rows(job.rows)  # what does not fit is refused before anything runs
    folder = Path(folder)
    with output_errors(folder):
        folder.mkdir(parents=True, exist_ok=True)
    stop = Event()
    runs = together(
        [lambda job=job: _kept(scene, sail, job, folder, stop) for job in jobs],  # type: ignore[misc]
        [f"{scene.name} {job.name}" for job in jobs],
        stop,
        workers=workers,
        tell=tell,
        outcome=lambda run: run.stopped or f"{run.seconds:.0f} s of stepping",
    )
    order = list(dict.fromkeys([*FORMS, *(job.form for job in jobs)]))
    return sorted(runs, key=lambda run: (order.index(run.form), run.rows, run.member))


def kept(scene: Scene, jobs: Sequence[Job], folder: str | Path) -> list[Job]:
    """Those of the jobs whose runs are in the folder already. Raises InputError as `mesh_study` does."""
    sail = _sail(scene)
    return [job for job in jobs if _place(scene, sail, job, Path(folder))[1].is_file()]


def _sail(scene: Scene) -> RowPattern:
    sail = pattern_of(scene.mesh)
    if not isinstance(sail, RowPattern):
        raise InputError(f"scene {scene.name!r}: its mesh is no square sail, whose rows could be varied; take another")
    return sail


def _place(scene: Scene, sail: RowPattern, job: Job, folder: Path) -> tuple[Scene, Path]:
    """What to run for a job, and the file of the run."""
    end = scene.run.until if job.until is None else job.until
    samples = max(2, round(end / SAMPLE_INTERVAL) + 1)
    settings = replace(
        scene.run, until=end, samples=samples, frames=2, snapshots=(), dt=None, integrator=INTEGRATOR,
        energy_loss=ENERGY_LOSS,
    )  # fmt: skip
    finer = job.lengths.of(replace(scene, mesh=sail.with_rows(job.rows).mesh(), run=settings))
    mark = hashlib.sha256(f"{finer.to_toml()}\n{SHARE} {SHIFT} {job.member}".encode()).hexdigest()[:12]
    return finer, folder / f"{scene.name}-{job.name}-{mark}.npz"


def _kept(scene: Scene, sail: RowPattern, job: Job, folder: Path, stop: Event) -> MeshRun:
    """The run out of its file, or made and put there."""
    finer, path = _place(scene, sail, job, folder)
    if path.is_file():
        return _read(path)
    run = _run(job, sail, finer, stop)
    if not stop.is_set():
        _write(path, run)
    return run


class _Curves:
    """Keeps the curves of one run; ends it where it is asked to."""

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
    where = course(scene, None, 1)
    if job.member:
        where = where.shifted(job.member - 1)
    limit = Simulation(where.scene).stable_dt()
    steps = int(np.ceil(where.until / (SHARE * limit)))
    sim = Simulation(where.scene, dt=where.until / steps)
    sim.positions = where.start
    curves, stopped, began = _Curves(stop), None, time.thread_time()
    try:
        sim.run(observers=[curves])
    except UnstableError as error:
        stopped = str(error)
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
    with np.load(path) as data:
        facts = json.loads(str(data["facts"]))
        return MeshRun(**facts, table={name: data[name] for name in COLUMNS})
