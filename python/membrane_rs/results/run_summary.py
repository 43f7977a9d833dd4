"""The summary of a run, in memory or as summary.json: see `membrane_rs.results.summary` for what is in it."""

from __future__ import annotations

import math
import platform
import sys
from collections.abc import Callable, Iterable, Mapping
from copy import deepcopy
from dataclasses import asdict
from importlib import metadata
from time import perf_counter
from typing import Any

import numpy as np

from membrane_rs.errors import Interrupted, UnstableError
from membrane_rs.mesh.findings import Finding
from membrane_rs.results.body_contacts import BodyContacts
from membrane_rs.results.features import curve_features, energy_balance
from membrane_rs.results.lock import this_process
from membrane_rs.results.momentum import momentum_error
from membrane_rs.results.record import RunData
from membrane_rs.scene.hub import has_free_hub
from membrane_rs.simulation.stepper import Stepper


class RunSummary:
    """Gathers what is known before the first step, and at the end what the run has shown, in `RunData.summary`."""

    _stage_starts: dict[int, float]

    def start(self, sim: Stepper, record: RunData) -> None:
        """Say what is known before the first step."""
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
            **self._momentum(sim),
            **({"stages": self._stages(sim)} if sim.scene.stages else {}),
            "pictures": "none",
        }
        if sim.stopped_by is not None:
            self._record.summary["stopped"] = {"by": sim.stopped_by, "time": sim.time}
        self._contacts.finish(sim, error)
        if error is None:
            add_findings(self._record.summary, self._contacts.findings(sim))

    def close(self, error: BaseException | None) -> None:
        """Say how the run ended, when all outputs have. Raises OutputError."""
        self._record.summary["outcome"] = outcome(error, self._record.summary.get("stopped"))
        if isinstance(error, Interrupted):
            self._record.summary["signal"] = error.name
        self.write()

    def write(self) -> None:
        """Write what is known so far, where it has a file."""

    def sample(self, sim: Stepper) -> None:
        """Note when a stage begins, and what touches the bodies."""
        self._contacts.sample(sim)
        if sim.scene.stages:
            self._stage_starts.setdefault(sim.stage, self._wall_time())

    def _momentum(self, sim: Stepper) -> dict[str, float | None]:
        """The error of the angular momentum, where the hub turns freely."""
        if not has_free_hub(sim.scene):
            return {}
        starts = [record.start for record in sim.stages]
        return {"momentum_error": momentum_error(self._record.table, sim.scene, starts)}

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

    def _begin(self, record: RunData, spent: float, bodies: object = None) -> None:
        self._record, self._began, self._contacts = record, perf_counter() - spent, BodyContacts(bodies)
        self._stage_starts = {}

    def _wall_time(self) -> float:
        return perf_counter() - self._began


def outcome(error: BaseException | None, stopped: Mapping[str, Any] | None = None) -> str:
    """How a run ended, in a word, with the reason of a failure, or what stopped it when."""
    if error is None:
        return "finished" if stopped is None else f"stopped: {stopped['by']}, at {stopped['time']:.9g} s"
    if isinstance(error, KeyboardInterrupt):
        return "interrupted"
    if isinstance(error, UnstableError):
        return f"unstable: {error}"
    return f"failed: {type(error).__name__}: {error}"


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


def plain(value: Any) -> Any:
    """`value` as JSON has it: with numpy's types as Python's, and null for what JSON cannot say."""
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
