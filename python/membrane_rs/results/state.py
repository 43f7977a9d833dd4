"""state.npz: the state of a run at its end, to go on from."""

from __future__ import annotations

from membrane_rs._files import output_errors
from membrane_rs.results.record import Record
from membrane_rs.results.writer import Writer
from membrane_rs.simulation.stepper import Stepper

STATE = "state.npz"


class State(Writer):
    """Writes the state of a run that finished or was interrupted."""

    own_files = (STATE,)
    is_vital = True  # an interrupted run is to be continued

    def start(self, sim: Stepper, record: Record) -> None:
        """Note the place."""
        self._path = record.path / STATE

    def finish(self, sim: Stepper, error: BaseException | None) -> None:
        """Write it."""
        if error is None or isinstance(error, KeyboardInterrupt):
            with output_errors(self._path):
                sim.save(self._path)
