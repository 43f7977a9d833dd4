"""summary.json: what was run, how it went and what the curves show.

At the start:

scene                 name of the scene
outcome               "running"; at the end "finished", "interrupted", "unstable: ..." or "failed: ..."
counts                size of the scene, as `Scene.counts` gives it
integrator            name of the method
dt                    [s] step; the first one where the method chooses its steps
stable_dt             [s] stability limit at the start; null where it is infinite
limiting_part         the law and node that set it
start_time            [s] simulated time
until                 [s] simulated time at which it is to end
versions              of membrane_rs, python and numpy; and the platform

At the end, too:

time                  [s] simulated time
steps                 steps taken
rejected_steps        steps rejected because of their error
evaluations           evaluations of the forces
newton_iterations, factorisations, fallbacks    of an implicit method, as in `Motion.statistics`
wall_time             [s]
frames, samples       how many were written
energy_balance        reference_energy [J]; error at the end, lowest_error (loss) and highest_error (gain), each as a
                      fraction of the reference energy
curves                of the deployment rate [-]: initial_rate, final_rate, highest_rate, first_peak_rate,
                      first_peak_time [s]; of the phase difference: final_phase_deg [deg], phase_trough_deg [deg],
                      phase_trough_time [s], zero_crossing_time [s], zero_crossing_rate [-]; null where there is none
pictures              what drew them: "pyvista", "matplotlib" or "none"
"""

from __future__ import annotations

import json
import math
import platform
import sys
from collections.abc import Mapping
from importlib import metadata
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs._files import write_text
from membrane_rs.errors import UnstableError
from membrane_rs.results.record import Record
from membrane_rs.results.writer import Writer
from membrane_rs.simulation.stepper import Stepper

SUMMARY = "summary.json"


class Summary(Writer):
    """Writes what is known before the first step, and at the end what the run has shown."""

    own_files = (SUMMARY,)

    def start(self, sim: Stepper, record: Record) -> None:
        """Write a first summary."""
        self._record, self._began = record, perf_counter()
        record.summary |= {
            "scene": sim.scene.name,
            "outcome": "running",
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

    def finish(self, sim: Stepper, error: BaseException | None) -> None:
        """Add how the run went, and what its curves show."""
        table = self._record.table
        self._record.summary |= {
            "outcome": outcome(error),
            "time": sim.time,
            "steps": sim.step_count,
            "rejected_steps": sim.rejected_count,
            "evaluations": sim.evaluation_count,
            **({key: count for key, count in sim.statistics.items() if any(sim.statistics.values())}),
            "wall_time": perf_counter() - self._began,
            "frames": len(self._record.frames),
            "samples": len(table["time"]),
            "energy_balance": energy_balance(table),
            "curves": curve_features(table),
            "pictures": "none",
        }
        self.write()

    def write(self) -> None:
        """Write what all outputs have added so far. Raises OutputError."""
        write_summary(self._record.path / SUMMARY, self._record.summary)


def outcome(error: BaseException | None) -> str:
    """How a run ended, in a word, with the reason of a failure."""
    if error is None:
        return "finished"
    if isinstance(error, KeyboardInterrupt):
        return "interrupted"
    if isinstance(error, UnstableError):
        return f"unstable: {error}"
    return f"failed: {type(error).__name__}: {error}"


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
    if 0 < trough < last:
        features |= {"phase_trough_deg": float(phase[trough]), "phase_trough_time": float(time[trough])}
        rises = np.flatnonzero((phase[trough:-1] < 0.0) & (phase[trough + 1 :] >= 0.0))
        if len(rises):
            k = trough + int(rises[0])
            part = -phase[k] / (phase[k + 1] - phase[k])
            features["zero_crossing_time"] = float(time[k] + part * (time[k + 1] - time[k]))
            features["zero_crossing_rate"] = float(rate[k] + part * (rate[k + 1] - rate[k]))
    return features


def energy_balance(table: dict[str, Floats]) -> dict[str, float | None]:
    """Reference energy [J]; the energy error at the end, the lowest (loss) and the highest (gain)."""
    error, reference = table["energy_error"], table["reference_energy"]
    if not len(error):
        return dict.fromkeys(("reference_energy", "error", "lowest_error", "highest_error"))
    return {
        "reference_energy": float(reference[-1]),
        "error": float(error[-1]),
        "lowest_error": float(error.min()),
        "highest_error": float(error.max()),
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


def write_summary(path: Path, summary: dict[str, Any]) -> None:
    """Write `summary` as JSON, whole or not at all; NaN and infinities become null. Raises OutputError."""
    write_text(path, json.dumps(_plain(summary), indent=2, allow_nan=False) + "\n")


def _plain(value: Any) -> Any:
    """`value` with numpy's types as Python's, and null for what JSON cannot say."""
    if isinstance(value, dict):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if isinstance(value, np.ndarray | np.generic):
        return _plain(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
