"""summary.json: what was run, how it went and what the curves show.

At the start:

audit                 what the audit of the scene found, errors first: for each finding its severity ("error",
                      "warning" or "info"), kind, count, message and remedy; behind them what
                      the run found: what began a later stage inside a body, and what its bodies did
scene                 name of the scene
outcome               "running"; at the end "finished", "stopped: ..." (by what, and when), "interrupted",
                      "unstable: ..." or "failed: ...". `read_summary`
                      gives "killed" in place of "running" where no process goes on with the run
process               by which the run goes on, or went on last: pid, host, and start, its time and date
request               what the run was asked for: until [s]; frames and samples, their numbers or times [s] (with
                      stages more are written: those that stages ask for, and one at each boundary); pictures,
                      crossings, whether they are wanted; checkpoint, the seconds of wall time between two checkpoints;
                      where they were given, every, the interval between samples [s]; record, the units of the measures
                      recorded, by their names; stop, what may end the run early, of a function its name alone
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
stopped               what ended the run before its time, "by", and when, "time" [s]; not there where nothing did
signal                "SIGINT", "SIGTERM", "SIGHUP", "SIGXCPU", "SIGUSR1" or "SIGUSR2", where one interrupted the run
frames, samples       how many were written
energy_balance        reference_energy [J]; error at the end, lowest_error (loss) and highest_error (gain), each as a
                      fraction of the reference energy; motor_work [J], null where the hub does not turn; changes, what
                      changes of stage and jumps of schedules have put in [J], by name, where there were any
momentum_error        where the hub turns freely: error of the angular momentum of hub and sail about the axis, the
                      largest change less the impulse of the torque on the hub, over the largest part, of hub or sail;
                      null while air, pressure, sunlight or point forces exert a torque too
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
from pathlib import Path
from typing import Any

from membrane_rs._files import path_of, read_text, reading_errors, write_text
from membrane_rs._validation import show
from membrane_rs.errors import MissingFileError, OutputError
from membrane_rs.results.lock import is_locked, this_process
from membrane_rs.results.record import Record
from membrane_rs.results.run_summary import RunSummary, plain, versions
from membrane_rs.results.writer import Writer
from membrane_rs.simulation.stepper import Stepper

SUMMARY = "summary.json"
MOST_SUMMARY = 2**28
"""Bytes of a longer summary, which is not read: lists of 10^7 times have fewer."""
_KINDS: dict[Any, tuple[str, ...]] = {
    int | float: ("time", "start_time", "until", "steps", "wall_time", "resumed", "frames", "samples"),
    dict: ("process", "request"),
}
"""What some entries are, where they are there."""


class Summary(RunSummary, Writer):
    """Writes what is known before the first step, and at the end what the run has shown."""

    own_files = (SUMMARY,)

    def start(self, sim: Stepper, record: Record) -> None:  # type: ignore[override]
        """Write a first summary."""
        self._path = record.path / SUMMARY
        super().start(sim, record)

    def resume(self, sim: Stepper, record: Record) -> None:
        """Take over what the summary said at the start, and say who goes on."""
        self._path = record.path / SUMMARY
        before = read_summary(record.path)
        self._begin(record, before.get("wall_time") or 0.0, before.get("bodies"))
        self._stage_starts = dict(enumerate(before.get("stage_starts") or ()))
        at_end = (
            "signal", "stopped", "frames", "samples", "energy_balance", "curves", "momentum_error", "crossings",
            "pictures",
        )  # fmt: skip
        record.summary |= {key: value for key, value in before.items() if key not in at_end} | {
            "outcome": "running",
            "process": this_process(),
            "request": record.request,
            "until": sim.until,
            "resumed": int(before.get("resumed") or 0) + 1,
            "versions": versions(),
        }
        self.write()

    def write(self) -> None:
        """Write what all outputs have added so far. Raises OutputError."""
        write_summary(self._path, self._record.summary)


def read_summary(path: Path | str) -> dict[str, Any]:
    """What the summary.json of a run's folder says; its "outcome" is "killed" where it says that the run goes on, but
    no process holds the folder's lock.

    Parameters
    ----------
    path : path
        The folder, or its summary.json.

    Returns
    -------
    dict of str to object
        As the file has it.

    Raises
    ------
    MissingFileError
        No summary there.
    OutputError
        The file is no summary of a run.
    InputError, InputTypeError
        No path.

    Examples
    --------
    >>> import tempfile
    >>> from membrane_rs import Simulation, scenes
    >>> from membrane_rs.results import read_summary
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     run = Simulation(scenes.load("spinning-tether")).run(0.01, 2, folder, samples=3, pictures=False)
    ...     read_summary(folder)["outcome"]
    'finished'
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


def write_summary(path: Path, summary: dict[str, Any]) -> None:
    """Write `summary` as JSON onto the disk, whole or absent; NaN and infinities become null. Raises OutputError."""
    write_text(path, json.dumps(plain(summary), indent=2, allow_nan=False) + "\n", synced=True)
