"""history.csv: one line per sample, flushed as it is written, numbers that read back as the same bits.

time                   [s]
deployment_rate        mean radius of the corners over that of the flat sail
phase_difference_deg   [deg] mean angle of the corners relative to the spool
kinetic_energy         [J] in the turning frame
stored_energy          [J] potential energy of all laws
energy_error           (energy now - energy at the start - work done) / reference energy
hub_angle              [rad] turned by the hub so far
reference_energy       [J] the largest change of a single term of the energy balance so far
energy_<law>           [J] one per law with a potential: its potential energy
work_<law>             [J] one per law and body of the scene, and for moved nodes: work done on the system, negative
                       where it takes energy
hub_force              [N] magnitude of the force of the sail on the hub, see `HubLoad`; where nodes are held, or meet a
                       spool
hub_torque             [N m] torque of the sail on the hub about its axis; likewise
contact_force          [N] sum of the magnitudes of the forces between spool and nodes; where nodes meet a spool
largest_cord_tension   [N] elastic tension of the tautest segment; with cords
largest_film_stress    [Pa] largest principal stress, at least 0, see `Motion.film_stress`; with a law of the film
motor_work             [J] work of the motor that turns the hub so far, on the sail; with a hub that turns. It is no
                       term of the balance, which is that of the turning frame

With stages the columns are those of all stages; an energy is 0 where its law is not at work. There are also

stage                  index of the stage; at a boundary that of the stage that begins
energy_of_changes      [J] put in by changes of stage so far: what is stored and moves after one, less what was before

motor_work is the last column, which runs of earlier versions lack.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs._files import check_writable, output_errors, path_of, read_text, reading_errors, sync, write_text
from membrane_rs._renamed import RenamedKeys
from membrane_rs.analysis.deployment import Corners
from membrane_rs.errors import OutputError
from membrane_rs.results.csv_lines import csv_lines
from membrane_rs.results.record import Record
from membrane_rs.results.writer import Writer
from membrane_rs.simulation.measures import PHASE, stowed_turn
from membrane_rs.simulation.stepper import Stepper

HISTORY = "history.csv"
FIRST_COLUMNS = (
    "time",
    "deployment_rate",
    "phase_difference_deg",
    "kinetic_energy",
    "stored_energy",
    "energy_error",
    "hub_angle",
    "reference_energy",
)

OF_STAGES = ("stage", "energy_of_changes")
"""The last columns of a scene with stages."""
MOTOR = "motor_work"
"""The last column of a scene whose hub turns."""
RENAMED = {"energy_turned_over": "reference_energy"}
"""New names of columns by those of version 0.1; files and tables have both."""


class History(Writer):
    """Writes history.csv and keeps its rows."""

    own_files = (HISTORY,)
    columns: list[str]
    rows: list[list[float]]

    def start(self, sim: Stepper, record: Record) -> None:
        """Begin the file with the names of its columns."""
        self._begin(sim, record)
        self._open("w")
        self._write(self.columns)

    def resume(self, sim: Stepper, record: Record) -> None:
        """Keep the lines up to now, and remove later ones. Raises OutputError where they are not this run's."""
        self._begin(sim, record)
        with reading_errors(self._path, "history of a run"):
            text = read_text(self._path) if self._path.is_file() else ""
        lines = text[: text.rfind("\n") + 1].splitlines(keepends=True)
        if not lines:
            self._open("w")
            self._write(self.columns)
            return
        table = read_history(self._path)
        if list(table) == [name for name in self.columns if name != MOTOR]:
            self.columns = list(table)
        if list(table) != self.columns:
            raise OutputError(f"{self._path} holds other columns than this run writes; run the scene again")
        count = int(np.searchsorted(table["time"], sim.time, side="right"))
        self.rows = np.stack(list(table.values()), axis=1)[:count].tolist()
        last = self.rows[-1][FIRST_COLUMNS.index(PHASE)] if self.rows else math.nan
        if math.isfinite(last):
            self._corners = Corners(sim.assembly, math.radians(last))
        record.table = self.table()
        write_text(self._path, "".join(lines[: count + 1]))
        self._open("a")

    def _begin(self, sim: Stepper, record: Record) -> None:
        """Name the columns."""
        self._record, self._path = record, record.path / HISTORY
        self._corners = Corners(sim.assembly, stowed_turn(sim))
        self._energies = list(sim.potential_names)
        bodies = [name for body in sim.scene.bodies for name in (body.name, f"{body.name}_friction")]
        of_parts = dict.fromkeys(part.working_law for part in sim.scene.parts)
        others = [name for name in (*of_parts, *bodies) if name in sim.law_names]
        self._works = [*(law.kind for law in sim.scene.laws), *others]
        self._readings = _readings_of(sim)
        self._of_stages = OF_STAGES if sim.scene.stages else ()
        self.columns = [
            *FIRST_COLUMNS,
            *(f"energy_{name}" for name in self._energies),
            *(f"work_{name}" for name in self._works),
            *self._readings,
            *self._of_stages,
            *((MOTOR,) if any(law.turns_hub for law in sim.scene.laws) else ()),
        ]
        self.rows = []

    def _open(self, mode: str) -> None:
        with output_errors(self._path):
            check_writable(self._path)
            self._file = self._path.open(mode, encoding="utf-8", newline="")
        self._writer = csv.writer(self._file, lineterminator="\n")

    def sample(self, sim: Stepper) -> None:
        """Write one sample.

        A state that is not later than the last one is skipped: an unstable run is set back to its last good state,
        which may have been written already.
        """
        if self.rows and sim.time <= self.rows[-1][0]:
            return
        positions, ledger = sim.positions, sim.ledger()
        row = [
            sim.time,
            self._corners.deployment_rate(positions),
            self._corners.phase_difference(positions),
            ledger["kinetic"],
            ledger["stored"],
            ledger["error"],
            sim.hub_angle,
            ledger["reference_energy"],
            *(ledger["stored_by_law"].get(name, 0.0) for name in self._energies),
            *(ledger["work_by_law"].get(name, 0.0) for name in self._works),
            *_readings(sim, self._readings),
        ]
        if self._of_stages:
            row += [sim.stage, math.fsum(ledger["changes"].values())]
        if self.columns[-1] == MOTOR:
            row.append(math.nan if ledger[MOTOR] is None else ledger[MOTOR])
        # Adding 0 makes 0 of -0, which a reader would take for a sign.
        self.rows.append([float(value) + 0.0 for value in row])
        self._write(self.rows[-1])

    def table(self) -> dict[str, Floats]:
        """The samples so far, one (samples,) array per column."""
        values = np.array(self.rows, dtype=np.float64).reshape(-1, len(self.columns))
        return {name: values[:, k] for k, name in enumerate(self.columns)}

    def finish(self, sim: Stepper, error: BaseException | None) -> None:
        """Give the samples to other outputs, and close the file."""
        self._record.table = self.table()
        with output_errors(self._path):
            self._file.close()

    def sync(self) -> None:
        """The lines so far."""
        sync(self._path)

    def _write(self, row: list[str] | list[float]) -> None:
        with output_errors(self._path):
            self._writer.writerow(row)
            self._file.flush()


def _readings_of(sim: Stepper) -> list[str]:
    """The largest stress and tension, and the load on the hub, as far as the scene has them in any stage."""
    scenes = [sim.scene.staged(k) for k in range(len(sim.scene.stages))] or [sim.scene]
    assemblies, found = [scene.assemble() for scene in scenes], []
    has_contacts = any(len(assembly.contacts) for assembly in assemblies)
    if has_contacts or any(len(assembly.fixed) for assembly in assemblies):
        found = ["hub_force", "hub_torque", *(["contact_force"] if has_contacts else [])]
    if len(sim.assembly.cords):
        found.append("largest_cord_tension")
    if len(sim.assembly.triangles) and any(law.is_film for law in sim.scene.laws):
        found.append("largest_film_stress")
    return found


def _readings(sim: Stepper, names: Sequence[str]) -> list[float]:
    """The readings of these names now."""
    found = {}
    if "hub_force" in names:
        load = sim.hub_load()
        found = {"hub_force": float(np.linalg.norm(load.force)), "hub_torque": float(load.torque[2])}
        found["contact_force"] = load.contact
    if "largest_cord_tension" in names:
        found["largest_cord_tension"] = float(sim.cord_tensions().max())
    if "largest_film_stress" in names:
        found["largest_film_stress"] = sim.largest_film_stress()
    return [found[name] for name in names]


def read_history(path: Path | str) -> dict[str, Floats]:
    """Read a history.csv, or that of a run's folder: one (samples,) array per column.

    A last line that a killed process left unfinished is dropped; columns of version 0.1 get their new names. The old
    name of a column is still a key, with a DeprecationWarning. Raises MissingFileError and OutputError.
    """
    path = path_of(path)
    with reading_errors(path, "history of a run"):
        path, lines = csv_lines(path, HISTORY, "history", "name a run's folder or its history.csv")
        columns = [RENAMED.get(name, name) for name in lines[0]] if lines else []
        if columns[: len(FIRST_COLUMNS)] != list(FIRST_COLUMNS):
            raise OutputError(
                f"{path} does not begin with the columns {', '.join(FIRST_COLUMNS)}; is it a history.csv?"
            )
        try:
            values = np.array(lines[1:], dtype=np.float64).reshape(-1, len(columns))
        except ValueError as error:
            raise OutputError(f"{path} holds a line that is no sample: {error}; run the scene again") from error
    return RenamedKeys("read_history()", {name: values[:, k] for k, name in enumerate(columns)}, RENAMED)
