"""One of many runs: a scene with some of its values set, from one start, as a row of facts and a history.

Whatever goes wrong is a result too, with its reason: the other runs go on. The run is a plain function of a task that
can be pickled, so that a thread, a process or another machine may make it, to the same bits.
"""

from __future__ import annotations

import pickle
import time
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from functools import lru_cache
from typing import Any

from membrane_rs._arrays import Floats
from membrane_rs.errors import InputError, UnstableError
from membrane_rs.results.features import curve_features, energy_balance
from membrane_rs.results.history_table import HistoryTable
from membrane_rs.results.momentum import momentum_error
from membrane_rs.results.recorded import Measures, Recorded, RecordTable, record_table
from membrane_rs.runs import Simulation
from membrane_rs.scene import Scene
from membrane_rs.scene.hub import has_free_hub
from membrane_rs.study.common.perturbation import SHIFT, perturbation

FINISHED, UNSTABLE, REFUSED, FAILED = "finished", "unstable", "refused", "failed"
TIME_LIMIT, CRASHED = "time limit", "crashed"
OUTCOMES = {
    FINISHED: "The run came to its end.",
    UNSTABLE: "The monitor stopped the run.",
    REFUSED: "The scene does not accept the values.",
    FAILED: "Any other error, such as one of a measure.",
    TIME_LIMIT: "The run took more than its share of wall time.",
    CRASHED: "The process that made the run ended without a result, twice.",
}
"""How a run may end."""
NAMED = ("time", "deployment_rate", "phase_difference_deg", "energy_error", "reference_energy", "motor_work")
"""Columns of a history of which `curve_features` and `energy_balance` say what there is to say."""
DETAILS = ("stage", "hub_angle", "energy_", "work_")
"""Beginnings of names of columns of which a row has no numbers, unless they are a user's measures."""

_stopped: set[str] = set()
"""Tickets of runs of this process that are to end."""


@dataclass(frozen=True)
class RunPoint:
    """Which of the runs of a sweep, an ensemble or a calibration.

    Attributes
    ----------
    values : mapping of str to object
        Those that are varied, by dotted key.
    start : int
        0: from the scene's own start; else from a perturbed one.

    Examples
    --------
    >>> from membrane_rs.study import RunPoint
    >>> RunPoint({"laws.creases.stiffness": 10.0}, start=1).values
    {'laws.creases.stiffness': 10.0}
    """

    values: Mapping[str, Any]
    start: int = 0


@dataclass(frozen=True)
class RunSetup:
    """What all runs have in common beside the scene.

    Attributes
    ----------
    until : float or None
        Time at the end [s]. None: the scene's.
    samples : int or None
        Rows of the history, evenly spaced. None: the scene's.
    record : mapping
        Further columns of the history.
    shift : float
        Standard deviation of the perturbation of starts but the first [m].
    time_limit : float or None
        Wall time after which a run is ended [s].
    """

    until: float | None = None
    samples: int | None = None
    record: Recorded = field(default_factory=dict)
    shift: float = SHIFT
    time_limit: float | None = None


@dataclass(frozen=True)
class RunTask:
    """A run to be made: its scene, packed, and all that it depends on. Runs of one `ticket` are stopped together."""

    scene: bytes
    setup: RunSetup
    point: RunPoint
    ticket: str = ""


@dataclass(frozen=True)
class RunResult:
    """What a run has shown.

    Attributes
    ----------
    point : RunPoint
        Which run it was.
    outcome : str
        One of `OUTCOMES`.
    message : str
        What failed and why, empty where nothing did.
    facts : mapping
        Numbers by name: features of the curves, energy balance, final and extreme values, step, cost.
    history : mapping
        (samples,) float64 by column; empty where the run did not begin.
    """

    point: RunPoint
    outcome: str
    message: str = ""
    facts: Mapping[str, float | None] = field(default_factory=dict)
    history: Mapping[str, Floats] = field(default_factory=dict)

    @property
    def is_finished(self) -> bool:
        """Whether the run came to its end."""
        return self.outcome == FINISHED

    def row(self) -> dict[str, Any]:
        """The run as one row of a table."""
        point = {**self.point.values, "start": self.point.start}
        return {**point, "outcome": self.outcome, "message": self.message, **self.facts}


class RunStopped(Exception):  # noqa: N818 - no error
    """A run that is to end without a result."""


class _TimeLimit(Exception):  # noqa: N818 - no error of anyone's
    pass


def packed(scene: Scene) -> bytes:
    """A scene as bytes, without what follows from it."""
    return zlib.compress(pickle.dumps({item.name: getattr(scene, item.name) for item in fields(scene)}), 1)


@lru_cache(maxsize=4)
def _unpacked(data: bytes) -> Scene:
    # From this program's own sweep, or from the scheduler that the user has named, never from a file.
    return Scene(**pickle.loads(zlib.decompress(data)))


def stop_runs(ticket: str) -> None:
    """End the runs of a ticket in this process, each within some 0.1 s of stepping."""
    _stopped.add(ticket)


def make_run(task: RunTask) -> RunResult:
    """Make a run. Raises RunStopped where `stop_runs` has ended it."""
    began, curves = time.perf_counter(), _Curves(task.setup.record)
    sim: Simulation | None = None
    outcome, message = FINISHED, ""

    def watch(_: Simulation | None = None) -> None:
        if task.ticket in _stopped:
            raise RunStopped
        limit = task.setup.time_limit
        if limit is not None and time.perf_counter() - began > limit:
            raise _TimeLimit(f"took more than {limit:g} s of wall time")

    try:
        watch()
        scene = _unpacked(task.scene).with_values(task.point.values)
        sim = Simulation(replace(scene, run=replace(scene.run, snapshots=())))
        if scene.run.relax > 0:
            sim.relax()
        if task.point.start:
            # Seeds as in other studies: the first perturbed start has the seed 0.
            sim.positions = sim.positions + perturbation(scene, task.point.start - 1, task.setup.shift)
        watch()
        sim.run(task.setup.until, frames=2, samples=task.setup.samples, observers=[curves], progress=watch)
    except RunStopped:
        raise
    except _TimeLimit as error:
        outcome, message = TIME_LIMIT, str(error)
    except UnstableError as error:
        outcome, message = UNSTABLE, str(error)
    except InputError as error:
        outcome, message = FAILED if curves.has_begun else REFUSED, str(error)
    except (Exception, SystemExit) as error:  # noqa: BLE001 - a fault of ours, or no memory: the other runs go on
        outcome, message = FAILED, f"{type(error).__name__}: {error}"
    message = " ".join(message.split())
    # An unstable simulation is at its last state without a fault, which may be before its last sample.
    history = {} if sim is None else curves.table(sim.time)
    if sim is None or not history or not len(history["time"]):
        return RunResult(task.point, outcome, message)
    facts = _facts(sim, history, record_table(task.setup.record)) | {"wall_time": time.perf_counter() - began}
    return RunResult(task.point, outcome, message, facts, history)


def _facts(sim: Simulation, history: Mapping[str, Floats], record: RecordTable) -> dict[str, float | None]:
    """The numbers of a row."""
    facts: dict[str, float | None] = {"time": sim.time, **curve_features(history)}
    balance = energy_balance(dict(history))
    facts |= {"energy_error": balance.pop("error"), **balance}
    if has_free_hub(sim.scene):
        facts["momentum_error"] = momentum_error(history, sim.scene, [record.start for record in sim.stages])
    for name, column in history.items():
        if name in record or (name not in NAMED and not name.startswith(DETAILS)):
            facts |= {f"final_{name}": float(column[-1]), f"lowest_{name}": float(column.min())}
            facts[f"highest_{name}"] = float(column.max())
    steps = {"dt": sim.dt, "steps": sim.step_count, "rejected_steps": sim.rejected_count}
    return facts | steps | {"evaluations": sim.evaluation_count}


class _Curves:
    """Observer that keeps the history."""

    def __init__(self, record: Recorded) -> None:
        self._record = record
        self._table: HistoryTable | None = None

    @property
    def has_begun(self) -> bool:
        """Whether the run has come to its first step."""
        return self._table is not None

    def start(self, sim: Simulation) -> None:
        self._table = HistoryTable(sim, Measures(self._record))

    def sample(self, sim: Simulation) -> None:
        if self._table is not None:
            self._table.add(sim)

    def frame(self, sim: Simulation) -> None:
        """Keeps no shapes."""

    def finish(self, sim: Simulation, error: BaseException | None) -> None:
        """Has nothing to close."""

    def table(self, until: float) -> dict[str, Floats]:
        """The columns up to a time [s]."""
        table = {} if self._table is None else self._table.table()
        return {name: column[table["time"] <= until].copy() for name, column in table.items()}
