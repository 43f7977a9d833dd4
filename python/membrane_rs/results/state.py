"""state.npz: the state of a run at its last checkpoint, at the latest at its end, to go on from."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any

from membrane_rs._files import output_errors
from membrane_rs.results.record import Record
from membrane_rs.results.writer import Writer
from membrane_rs.simulation.checkpoint import STATE, StateFile
from membrane_rs.simulation.stepper import Stepper


class State(Writer):
    """Writes the state while a run goes on, and that of one which finished or was interrupted."""

    own_files = (STATE,)
    is_vital = True  # an interrupted run is to be continued

    def start(self, sim: Stepper, record: Record) -> None:
        """Note the place."""
        self._path = record.path / STATE
        self._scene = sim.scene

    def writing(self, sim: Stepper) -> Callable[[], None]:
        """What writes the state of now, for the background: the simulation may go on meanwhile."""
        state: dict[str, Any] = sim.saved_state()
        return lambda: self._file.write(self._path, state)

    @cached_property
    def _file(self) -> StateFile:
        return StateFile(self._scene)

    def finish(self, sim: Stepper, error: BaseException | None) -> None:
        """Write it."""
        if error is None or isinstance(error, KeyboardInterrupt):
            with output_errors(self._path):
                sim.save(self._path)
