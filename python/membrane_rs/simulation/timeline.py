"""Where a staged scene is in its stages, and the record of those that are over: what a saved state holds of them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs._validation import show
from membrane_rs.errors import InputError
from membrane_rs.scene.stage import Stage

BY_DURATION, BY_MEASURE = "duration", "measure"


@dataclass(frozen=True)
class StageRecord:
    """One stage of a run, so far as it has come.

    Attributes
    ----------
    name : str
        Of the stage.
    start, end : float
        Times [s]; the end is the time now while the stage goes on.
    ended_by : str or None
        "duration" or "measure"; None while it goes on.
    integrator : str
        The method.
    dt : float
        Step [s]; the one to be tried next where the method chooses its steps.
    steps, evaluations, rejected_steps : int
        Steps, evaluations of the forces, rejected steps. The rest of a step up to the end of a stage is not counted.
    changes : dict of str to float
        Change of the kinetic energy and of the potential energy of each law at its start, by what the stage changes,
        and at jumps of schedules [J].
    work_by_law : dict of str to float
        Work of each law in this stage [J].
    reference_energy : float
        The largest change of a single term of its energy balance [J].
    error : float
        Residual of its balance, as a share of its reference energy [-].
    motor_work : float or None
        Work of the motor that turns the hub in this stage [J]; None where a saved state of an earlier version lacks it.

    Examples
    --------
    >>> import dataclasses
    >>> from membrane_rs import Simulation, Stage, scenes
    >>> stages = [Stage("first", 0.001), Stage("second", 0.001)]
    >>> sim = Simulation(dataclasses.replace(scenes.load("spinning-tether"), stages=stages))
    >>> sim.run(0.002)
    >>> [(stage.name, stage.end, stage.ended_by) for stage in sim.stages]
    [('first', 0.001, 'duration'), ('second', 0.002, 'duration')]
    """

    name: str
    start: float
    end: float
    ended_by: str | None
    integrator: str
    dt: float
    steps: int
    evaluations: int
    rejected_steps: int
    changes: dict[str, float]
    work_by_law: dict[str, float]
    reference_energy: float
    error: float
    motor_work: float | None = None


@dataclass
class Timeline:
    """The stages of a run, and how far it has come in them."""

    stages: Sequence[Stage]
    laws: list[str]
    """All laws of the core in any stage."""
    potentials: list[str]
    """Those that have a potential in any stage."""
    starts: list[float] = field(default_factory=lambda: [0.0])
    """Of the stages up to the present one [s]."""
    past: list[StageRecord] = field(default_factory=list)
    """Of the stages before the present one."""
    changes: dict[str, float] = field(default_factory=dict)
    """At the start of the present stage [J]."""
    ended_by: str | None = None
    """What ended the last stage, once it is over."""

    @property
    def index(self) -> int:
        """Of the present stage."""
        return len(self.starts) - 1

    @property
    def stage(self) -> Stage:
        """The present one."""
        return self.stages[self.index]

    @property
    def is_last(self) -> bool:
        """Whether no stage comes after the present one."""
        return self.index == len(self.stages) - 1

    @property
    def end(self) -> float:
        """Time at which the present stage ends at the latest [s]."""
        return self._planned(self.index + 1)

    @property
    def last_end(self) -> float:
        """Time at which the last stage ends at the latest [s]."""
        return self._planned(len(self.stages))

    @property
    def latest_end(self) -> float:
        """The same as it was at the start of the first stage [s]."""
        return self.starts[0] + math.fsum(stage.duration for stage in self.stages)

    def _planned(self, count: int) -> float:
        """Latest end of so many stages [s]: durations are summed from the last start that no duration gave."""
        first = max((k + 1 for k, record in enumerate(self.past) if record.ended_by == BY_MEASURE), default=0)
        return self.starts[first] + math.fsum(stage.duration for stage in self.stages[first:count])

    def saved(self) -> dict[str, Any]:
        """As entries of a saved state."""
        past = self.past
        terms = ["kinetic", *self.potentials]
        changes = [record.changes for record in past] + [self.changes]
        return {
            "stage_index": self.index,
            "stage_starts": np.array(self.starts),
            "stage_ended_by_measure": np.array([record.ended_by == BY_MEASURE for record in past], dtype=np.int64),
            "stage_is_over": {None: 0, BY_DURATION: 1, BY_MEASURE: 2}[self.ended_by],
            "stage_counts": np.array(
                [(record.steps, record.evaluations, record.rejected_steps) for record in past], np.int64
            ).reshape(-1, 3),
            "stage_dt": np.array([record.dt for record in past]),
            "stage_changes": _matrix(changes, terms),
            "stage_work": _matrix([record.work_by_law for record in past], self.laws),
            "stage_motor": np.array(
                [(record.motor_work is not None, record.motor_work or 0.0) for record in past], np.float64
            ).reshape(-1, 2),
            "stage_balances": np.array([(record.reference_energy, record.error) for record in past]).reshape(-1, 2),
        }

    def loaded(self, saved: Mapping[str, Any], methods: Sequence[str], *, is_older: bool = False) -> Timeline:
        """The timeline of entries of a saved state, of the same scene; `methods` are those of its stages. An older
        state may lack the work of the motor.

        Raises InputError.
        """
        index = saved.get("stage_index")
        if isinstance(index, bool) or not isinstance(index, int) or not 0 <= index < len(self.stages):
            raise _damaged(f"stage_index = {show(index)}: must be from 0 to {len(self.stages) - 1}")
        terms = ["kinetic", *self.potentials]
        starts = _array(saved, "stage_starts", (index + 1,))
        reasons = _array(saved, "stage_ended_by_measure", (index,))
        counts = _array(saved, "stage_counts", (index, 3), kinds="i")
        steps = _array(saved, "stage_dt", (index,))
        changes = _array(saved, "stage_changes", (index + 1, len(terms)))
        work = _array(saved, "stage_work", (index, len(self.laws)))
        balances = _array(saved, "stage_balances", (index, 2))
        motors = _motors(saved, index, is_older=is_older)
        is_over = saved.get("stage_is_over")
        if not isinstance(is_over, int) or is_over not in (0, 1, 2) or (is_over and index < len(self.stages) - 1):
            raise _damaged(f"stage_is_over = {show(is_over)}: must be 0, 1 or 2, and 0 before the last stage")
        for name, values in (("stage_counts", counts), ("stage_balances", balances[:, 0])):
            if (values < 0).any():
                raise _damaged(f"{name}: holds a value below 0")
        if (steps <= 0).any():
            raise _damaged("stage_dt: holds a step that is not above 0 (s)")
        if not np.isin(reasons, (0, 1)).all():
            raise _damaged("stage_ended_by_measure: holds a value that is neither 0 nor 1")
        made = Timeline(self.stages, self.laws, self.potentials, starts.tolist())
        for k, stage in enumerate(self.stages[:index]):
            end, slack = made.starts[k + 1], 1e-12 * abs(made.starts[k + 1])
            if not made.starts[k] <= end <= made.starts[k] + stage.duration + slack:
                raise _damaged(f"stage_starts[{k + 1}] = {end:g}: is no end of {stage.name!r} (s)")
            made.past.append(
                StageRecord(
                    name=stage.name,
                    start=made.starts[k],
                    end=end,
                    ended_by=BY_MEASURE if reasons[k] else BY_DURATION,
                    integrator=methods[k],
                    dt=float(steps[k]),
                    steps=int(counts[k, 0]),
                    evaluations=int(counts[k, 1]),
                    rejected_steps=int(counts[k, 2]),
                    changes=_named(changes[k], terms),
                    work_by_law=_named(work[k], self.laws),
                    reference_energy=float(balances[k, 0]),
                    error=float(balances[k, 1]),
                    motor_work=motors[k],
                )
            )
        made.changes = _named(changes[index], terms)
        made.ended_by = (None, BY_DURATION, BY_MEASURE)[int(is_over)]
        return made


def summed(present: Mapping[str, Any], past: Sequence[StageRecord], stages: Sequence[StageRecord]) -> dict[str, Any]:
    """What the energy balance says of all stages together: that of the present one, and records of those before it."""
    work: dict[str, float] = {}
    for by_law in (*(record.work_by_law for record in past), present["work_by_law"]):
        for law, joule in by_law.items():
            work[law] = work.get(law, 0.0) + joule
    residual = math.fsum(
        [present["error"] * present["reference_energy"], *(r.error * r.reference_energy for r in past)]
    )
    reference = max([present["reference_energy"], *(record.reference_energy for record in past)])
    motors = [*(record.motor_work for record in past), present["motor_work"]]
    known = [motor for motor in motors if motor is not None]
    by_stage = [(record.name, record.changes) for record in stages]
    return {
        "work": math.fsum(work.values()),
        "work_by_law": work,
        "motor_work": math.fsum(known) if len(known) == len(motors) else None,
        "reference_energy": reference,
        "error": residual / reference if reference > 0.0 else 0.0,
        "changes": {f"{name}: {term}": joule for name, changes in by_stage for term, joule in changes.items()},
    }


def sums(*tables: dict[str, float]) -> dict[str, float]:
    """Sums by name, those that are not 0."""
    names = dict.fromkeys(name for table in tables for name in table)
    found = {name: math.fsum(table.get(name, 0.0) for table in tables) for name in names}
    return {name: value for name, value in found.items() if value != 0.0}


def without_energy(record: StageRecord) -> StageRecord:
    """A record once the energy balance is opened anew."""
    return replace(record, changes={}, work_by_law={}, reference_energy=0.0, error=0.0, motor_work=0.0)


def _matrix(rows: Sequence[Mapping[str, float]], names: Sequence[str]) -> Floats:
    values = [[row.get(name, 0.0) for name in names] for row in rows]
    return np.array(values, dtype=np.float64).reshape(len(rows), len(names))


def _named(row: Floats, names: Sequence[str]) -> dict[str, float]:
    return {name: float(value) for name, value in zip(names, row, strict=True) if value != 0.0}


def _motors(saved: Mapping[str, Any], count: int, *, is_older: bool) -> list[float | None]:
    """The work of the motor in each past stage [J]; None where it is not known, as in states of earlier versions."""
    if is_older and "stage_motor" not in saved:
        return [None] * count
    return [joule if is_known else None for is_known, joule in _array(saved, "stage_motor", (count, 2)).tolist()]


def _array(saved: Mapping[str, Any], name: str, shape: tuple[int, ...], *, kinds: str = "fi") -> Floats:
    array = np.asarray(saved.get(name))
    if array.dtype.kind not in kinds or array.shape != shape:
        what = "numbers" if "f" in kinds else "whole numbers"
        raise _damaged(f"{name}: is no array of {what} of shape {shape}")
    if not np.isfinite(array).all():
        raise _damaged(f"{name}: holds a value that is not finite")
    return array.astype(np.float64) if array.dtype.kind == "f" else array


def _damaged(what: str) -> InputError:
    return InputError(f"saved state: {what}; it is damaged: give one that a simulation gave")


OF_CHECK = ("stage_now", "stage_is_armed", "stage_turned")
OF_STOP = ("stop_now", "stop_side", "stop_turned")
"""Entries of the state of a run that a measure may end, of any scene."""
ENTRIES = (*Timeline([], [], []).saved(), *OF_CHECK, "stage_method", "stage_given_dt")
"""Entries of the state of a staged scene, beside those of a scene without stages."""
