"""summary.json: what was run, how it went and what the curves show.

At the start:

audit                 what the audit of the scene found, errors first: for each finding its severity ("error",
                      "warning" or "info"), kind, count, message and remedy; behind them what
                      the run found: what began a later stage inside a body, and what its bodies did
scene                 name of the scene
outcome               "running"; at the end "finished", "interrupted", "unstable: ..." or "failed: ...". `read_summary`
                      gives "killed" in place of "running" where no process goes on with the run
process               by which the run goes on, or went on last: pid, host, and start, its time and date
request               what the run was asked for: until [s]; frames and samples, their numbers or times [s] (with
                      stages more are written: those that stages ask for, and one at each boundary); pictures,
                      crossings, whether they are wanted; checkpoint, the seconds of wall time between two checkpoints
resumed               how often the run was resumed in this folder; not there where it was not
counts                size of the scene, as `Scene.counts` gives it
integrator            name of the method; with stages this and the next three are those of the stage in which the run
                      began, and "stages" has the method and the step of each
dt                    [s] step; the first one where the method chooses its steps
stable_dt             [s] stability limit at the start; null where it is infinite
limiting_part         the law and node that set it
start_time            [s] simulated time
until                 [s] simulated time at which it is to end
versions              of membrane_rs, python and numpy; and the platform

At each checkpoint, and at the end:

time                  [s] simulated time
steps                 steps taken
wall_time             [s] spent on the run, without what a killed process did after its last checkpoint
stage, stage_starts   of a scene with stages: name of the present one; wall time at which each began [s]
bodies                of a scene with bodies, what `BodyContacts` has noted of each at the samples: first_contact [s],
                      null where there was none; largest_force on a node [N]; where its friction is stiffest, the step
                      that it needs and the one of the run, friction_step and friction_dt [s], friction_time [s] and
                      friction_node

At the end, too:

rejected_steps        steps rejected because of their error
evaluations           evaluations of the forces
newton_iterations, factorisations, fallbacks    of an implicit method, as in `Motion.statistics`
signal                "SIGINT", "SIGTERM", "SIGHUP", "SIGXCPU", "SIGUSR1" or "SIGUSR2", where one interrupted the run
frames, samples       how many were written
energy_balance        reference_energy [J]; error at the end, lowest_error (loss) and highest_error (gain), each as a
                      fraction of the reference energy; motor_work [J], null where the hub does not turn; changes, what
                      changes of stage and jumps of schedules have put in [J], by name, where there were any
curves                of the deployment rate [-]: initial_rate, final_rate, highest_rate, first_peak_rate,
                      first_peak_time [s]; of the phase difference: final_phase_deg [deg], phase_trough_deg [deg],
                      phase_trough_time [s], zero_crossing_time [s], zero_crossing_rate [-]; null where there is none
crossings             where they were counted: pairs that cross at the first and at the last frame, the most, and
                      time_of_most [s]
stages                of a scene with stages, one entry for each that was reached: what `StageRecord` holds, with
                      wall_time [s] and the curves of its samples
pictures              what drew them: "pyvista", "matplotlib" or "none"
"""

from __future__ import annotations

import json
import math
import platform
import sys
from collections.abc import Callable, Iterable, Mapping
from copy import deepcopy
from dataclasses import asdict
from importlib import metadata
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs._files import path_of, read_text, reading_errors, write_text
from membrane_rs._validation import show
from membrane_rs.errors import Interrupted, MissingFileError, OutputError, UnstableError
from membrane_rs.mesh.findings import Finding
from membrane_rs.results.body_contacts import BodyContacts
from membrane_rs.results.lock import is_locked, this_process
from membrane_rs.results.record import Record
from membrane_rs.results.writer import Writer
from membrane_rs.simulation.stepper import Stepper

SUMMARY = "summary.json"
MOST_SUMMARY = 2**28
"""Bytes of a longer summary, which is not read: lists of 10^7 times have fewer."""
_KINDS: dict[Any, tuple[str, ...]] = {
    int | float: ("time", "start_time", "until", "steps", "wall_time", "resumed"),
    dict: ("process", "request"),
}
"""What some entries are, where they are there."""


class Summary(Writer):
    """Writes what is known before the first step, and at the end what the run has shown."""

    own_files = (SUMMARY,)
    _stage_starts: dict[int, float]

    def start(self, sim: Stepper, record: Record) -> None:
        """Write a first summary."""
        self._begin(record, 0.0)
        record.summary |= {
            "scene": sim.scene.name,
            "outcome": "running",
            "process": this_process(),
            "request": record.request,
            "counts": sim.scene.counts(),
            "integrator": sim.integrator,
            "dt": sim.dt,
            "stable_dt": sim.stable_dt(),
            "limiting_part": sim.limiting_part,
            "start_time": sim.time,
            "until": sim.until,
            "versions": versions(),
        }
        self.write()

    def resume(self, sim: Stepper, record: Record) -> None:
        """Take over what the summary said at the start, and say who goes on."""
        before = read_summary(record.path)
        self._begin(record, before.get("wall_time") or 0.0, before.get("bodies"))
        self._stage_starts = dict(enumerate(before.get("stage_starts") or ()))
        at_end = ("signal", "frames", "samples", "energy_balance", "curves", "crossings", "pictures")
        record.summary |= {key: value for key, value in before.items() if key not in at_end} | {
            "outcome": "running",
            "process": this_process(),
            "request": record.request,
            "until": sim.until,
            "resumed": int(before.get("resumed") or 0) + 1,
            "versions": versions(),
        }
        self.write()

    def relaxed(self, sim: Stepper) -> None:
        """Say what has changed since the start was relaxed."""
        if sim.time == self._record.summary["start_time"]:
            self._record.summary |= {"stable_dt": sim.stable_dt(), "limiting_part": sim.limiting_part}
            self.write()

    def at_checkpoint(self, sim: Stepper) -> Callable[[], None]:
        """What adds how far the run has come, for the background."""
        now = self._progress(sim)

        def write() -> None:
            self._record.summary |= now
            self.write()

        return write

    def finish(self, sim: Stepper, error: BaseException | None) -> None:
        """Add how the run went, and what its curves show."""
        table, changes = self._record.table, sim.ledger().get("changes")
        self._record.summary |= self._progress(sim) | {
            "rejected_steps": sim.rejected_count,
            "evaluations": sim.evaluation_count,
            **({key: count for key, count in sim.statistics.items() if any(sim.statistics.values())}),
            "frames": len(self._record.frames),
            "samples": len(table["time"]),
            "energy_balance": energy_balance(table) | ({"changes": changes} if changes else {}),
            "curves": curve_features(table),
            **({"stages": self._stages(sim)} if sim.scene.stages else {}),
            "pictures": "none",
        }
        self._contacts.finish(sim, error)
        if error is None:
            add_findings(self._record.summary, self._contacts.findings(sim))

    def close(self, error: BaseException | None) -> None:
        """Say how the run ended, when all outputs have. Raises OutputError."""
        self._record.summary["outcome"] = outcome(error)
        if isinstance(error, Interrupted):
            self._record.summary["signal"] = error.name
        self.write()

    def write(self) -> None:
        """Write what all outputs have added so far. Raises OutputError."""
        write_summary(self._record.path / SUMMARY, self._record.summary)

    def sample(self, sim: Stepper) -> None:
        """Note when a stage begins, and what touches the bodies."""
        self._contacts.sample(sim)
        if sim.scene.stages:
            self._stage_starts.setdefault(sim.stage, self._wall_time())

    def _stages(self, sim: Stepper) -> list[dict[str, Any]]:
        """The record of each stage, with its wall time and its curves."""
        table, found = self._record.table, []
        for k, record in enumerate(sim.stages):
            rows = (table["time"] >= record.start) & (table["time"] <= record.end)
            start, end = self._stage_starts.get(k), self._stage_starts.get(k + 1, self._wall_time())
            curves = curve_features({name: column[rows] for name, column in table.items()})
            wall_time = None if start is None else end - start
            found.append({**asdict(record), "wall_time": wall_time, "curves": curves})
        return found

    def _bodies(self, sim: Stepper) -> dict[str, Any]:
        """What touched the bodies so far, copied."""
        return {"bodies": deepcopy(self._contacts.bodies)} if sim.scene.bodies else {}

    def _progress(self, sim: Stepper) -> dict[str, Any]:
        """How far the run has come."""
        found: dict[str, Any] = {"time": sim.time, "steps": sim.step_count, "wall_time": self._wall_time()}
        found |= self._bodies(sim)
        if sim.scene.stages:
            found |= {"stage": sim.stage_name, "stage_starts": list(self._stage_starts.values())}
        return found

    def _begin(self, record: Record, spent: float, bodies: object = None) -> None:
        self._record, self._began, self._contacts = record, perf_counter() - spent, BodyContacts(bodies)
        self._stage_starts = {}

    def _wall_time(self) -> float:
        return perf_counter() - self._began


def read_summary(path: Path | str) -> dict[str, Any]:
    """What the summary.json of a run's folder says; its "outcome" is "killed" where it says that the run goes on, but
    no process holds the folder's lock.

    Parameters
    ----------
    path :
        The folder, or its summary.json.

    Raises
    ------
    MissingFileError
        No summary there.
    OutputError
        The file is no summary of a run.
    InputTypeError
        No path.
    """
    path = path_of(path)
    with reading_errors(path, "summary of a run"):
        if path.is_dir():
            path = path / SUMMARY
        if not path.is_file():
            raise MissingFileError(f"no summary at {path}; name a run's folder or its {SUMMARY}")
        try:
            found = json.loads(read_text(path, MOST_SUMMARY))
        except (ValueError, RecursionError) as error:
            raise OutputError(f"{path} is no summary of a run: {error}; run the scene again") from error
        if not isinstance(found, dict) or not isinstance(found.get("outcome"), str):
            raise OutputError(f"{path} is no summary of a run: it has no outcome; run the scene again")
        for kind, names in _KINDS.items():
            for name in names:
                value = found.get(name)
                if value is not None and (not isinstance(value, kind) or isinstance(value, bool)):
                    what = f"its {name} is {show(value)}"
                    raise OutputError(f"{path} is no summary of a run: {what}; run the scene again")
    if found["outcome"] == "running" and not is_locked(path.parent):
        found["outcome"] = "killed"
    return found


def folder_of_run(path: Path) -> Path:
    """The folder of a run that is named by its summary.json; any other path as it is."""
    return path.parent if path.name == SUMMARY and not path.is_dir() else path


def outcome(error: BaseException | None) -> str:
    """How a run ended, in a word, with the reason of a failure."""
    if error is None:
        return "finished"
    if isinstance(error, KeyboardInterrupt):
        return "interrupted"
    if isinstance(error, UnstableError):
        return f"unstable: {error}"
    return f"failed: {type(error).__name__}: {error}"


LEAST_PHASE = 1e-6
"""Phase difference below which corners do not turn but by rounding [deg]."""


def curve_features(table: Mapping[str, Floats]) -> dict[str, float | None]:
    """What the paper's Figs. 14 to 17 are read for; None where the run has not come that far.

    The trough is the lowest phase difference; the first peak of the rate is the highest rate before the
    trough; the zero crossing is the first rise of the phase through zero after the trough, interpolated.

    `table` holds (samples,) arrays "time" [s], "deployment_rate" and "phase_difference_deg".
    """
    time, rate, phase = (table[name] for name in ("time", "deployment_rate", "phase_difference_deg"))
    names = ("first_peak_rate", "first_peak_time", "phase_trough_deg", "phase_trough_time")
    after = ("zero_crossing_time", "zero_crossing_rate")
    features: dict[str, float | None] = dict.fromkeys((*names, *after))
    known = np.flatnonzero(np.isfinite(rate) & np.isfinite(phase))
    if not len(known):
        return features
    time, rate, phase = time[known], rate[known], phase[known]
    features |= {
        "initial_rate": float(rate[0]),
        "final_rate": float(rate[-1]),
        "highest_rate": float(rate.max()),
        "final_phase_deg": float(phase[-1]),
    }
    last = len(time) - 1
    trough = int(np.argmin(phase))
    peak = int(np.argmax(rate[: trough + 1]))
    if 0 < peak < last:
        features |= {"first_peak_rate": float(rate[peak]), "first_peak_time": float(time[peak])}
    if 0 < trough < last and phase[trough] < -LEAST_PHASE:
        features |= {"phase_trough_deg": float(phase[trough]), "phase_trough_time": float(time[trough])}
        rises = np.flatnonzero((phase[trough:-1] < 0.0) & (phase[trough + 1 :] >= 0.0))
        if len(rises):
            k = trough + int(rises[0])
            part = -phase[k] / (phase[k + 1] - phase[k])
            features["zero_crossing_time"] = float(time[k] + part * (time[k + 1] - time[k]))
            features["zero_crossing_rate"] = float(rate[k] + part * (rate[k + 1] - rate[k]))
    return features


def energy_balance(table: dict[str, Floats]) -> dict[str, float | None]:
    """Reference energy [J]; the energy error at the end, the lowest (loss) and the highest (gain); the work of the
    motor [J], None where the hub does not turn, or it is not known.
    """
    error, reference = table["energy_error"], table["reference_energy"]
    if not len(error):
        return dict.fromkeys(("reference_energy", "error", "lowest_error", "highest_error", "motor_work"))
    motor = table.get("motor_work")
    return {
        "reference_energy": float(reference[-1]),
        "error": float(error[-1]),
        "lowest_error": float(error.min()),
        "highest_error": float(error.max()),
        "motor_work": None if motor is None or math.isnan(motor[-1]) else float(motor[-1]),
    }


def versions() -> dict[str, str]:
    """Versions of what took part in the numbers, and the machine's kind."""

    def version(name: str) -> str:
        try:
            return metadata.version(name)
        except metadata.PackageNotFoundError:
            return "unknown"

    return {
        "membrane_rs": version("membrane-rs"),
        "python": sys.version.split()[0],
        "numpy": version("numpy"),
        "platform": platform.platform(),
    }


def add_findings(summary: dict[str, Any], findings: Iterable[Finding]) -> None:
    """Add to the audit in a summary what a run has found, each finding once."""
    known = summary.setdefault("audit", [])
    found = [finding.as_dict() for finding in findings]
    known += [finding for finding in found if finding not in known]


def write_summary(path: Path, summary: dict[str, Any]) -> None:
    """Write `summary` as JSON onto the disk, whole or absent; NaN and infinities become null. Raises OutputError."""
    write_text(path, json.dumps(plain(summary), indent=2, allow_nan=False) + "\n", synced=True)


def plain(value: Any) -> Any:
    """`value` with numpy's types as Python's, and null for what JSON cannot say."""
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
