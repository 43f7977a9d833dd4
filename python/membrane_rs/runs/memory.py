"""A run that is kept in memory."""

from __future__ import annotations

from dataclasses import replace

from membrane_rs.check import audit_of_motion
from membrane_rs.check.bodies import inside_at_stage_start
from membrane_rs.errors import InputError
from membrane_rs.results.frame_fields import Frame, FrameFields
from membrane_rs.results.history_table import HistoryTable
from membrane_rs.results.record import RunData
from membrane_rs.results.recorded import Measures
from membrane_rs.results.run_history import RunHistory
from membrane_rs.results.run_summary import RunSummary, add_findings, plain
from membrane_rs.runs.frames import KeptFrames
from membrane_rs.runs.recorder import Recorder
from membrane_rs.runs.request import Request
from membrane_rs.runs.result import Run
from membrane_rs.simulation.stepper import Stepper

MOST_BYTES = 2**32
"""Bytes of all frames of a run, or of its history, beyond which it is not kept in memory."""
COPIES = 3
"""Of the history at the end of a run: as it was recorded, as a table, and as columns."""


class RunMemory(Recorder):
    """An observer that keeps a run in memory: frames as compact copies, the history, the summary. For one run."""

    def __init__(self) -> None:
        self._data, self._summary = RunData(), RunSummary()
        self._frames: list[Frame] = []
        self._history: HistoryTable | None = None
        self._is_prepared = self._is_ended = False

    def asked(self, request: Request) -> Request:
        """A request without pictures."""
        return replace(request, pictures=False)

    def prepare(self, sim: Stepper, request: Request, measures: Measures | None = None) -> None:
        """Note what is known at the start. Raises InputError for more frames or samples than fit into memory."""
        times = request.output_times(sim.time, sim.scene)
        columns, count = len(HistoryTable(sim, measures).columns), sum(times.values())
        if len(times) * columns * COPIES * 8 > MOST_BYTES:
            raise InputError(
                f"samples: {len(times)} of {columns} numbers each are more than {MOST_BYTES / 1e9:.3g} GB in memory, "
                f"with {COPIES} copies of them; ask for fewer"
            )
        size = Frame.of(sim).nbytes
        if count * size > MOST_BYTES:
            raise InputError(
                f"frames: {count} of {size / 1e6:.3g} MB each are {count * size / 1e9:.3g} GB in memory, more than "
                f"{MOST_BYTES / 1e9:.3g} GB; ask for fewer, or give out=, a folder from which they are read one by one"
            )
        self._data.request, self._data.measures = request.as_table(), measures or Measures()
        self._data.summary["audit"] = [finding.as_dict() for finding in audit_of_motion(sim).findings]
        self._summary.start(sim, self._data)
        self._fields = FrameFields(sim)
        self._is_prepared = True

    def start(self, sim: Stepper) -> None:
        """Begin the history."""
        self._summary.relaxed(sim)
        self._history = HistoryTable(sim, self._data.measures)

    def sample(self, sim: Stepper) -> None:
        """Keep a row."""
        if sim.boundaries[-1:] == [sim.time]:
            add_findings(self._data.summary, inside_at_stage_start(sim))
        self._summary.sample(sim)
        if self._history is not None:
            self._history.add(sim)

    def frame(self, sim: Stepper) -> None:
        """Keep a copy of the shape; a state that is not later than the last one is skipped."""
        if not self._frames or sim.time > self._frames[-1].time:
            self._frames.append(Frame.of(sim))
            self._data.frames.append((sim.time, ""))

    def finish(self, sim: Stepper, error: BaseException | None) -> None:
        """Complete the summary."""
        if self._is_ended or not self._is_prepared:
            return
        self._is_ended = True
        history = self._history or HistoryTable(sim, self._data.measures)
        self._data.table = history.table()
        self._summary.finish(sim, error)
        self._summary.close(error)
        self._scene = sim.scene

    def result(self) -> Run | None:
        """The run, once it has ended; None where it was refused before it began."""
        if not self._is_ended:
            return None
        history = RunHistory(self._data.table, self._data.measures.units)
        frames = KeptFrames(self._frames, self._fields, history)
        return Run(self._scene, history, frames, plain(self._data.summary))
