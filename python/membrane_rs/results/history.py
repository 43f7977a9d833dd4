"""history.csv: one line per sample, flushed as it is written, numbers that read back as the same bits.

Its columns are those of `membrane_rs.results.history_table`.
"""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs._files import check_writable, output_errors, path_of, read_text, reading_errors, sync, write_text
from membrane_rs._renamed import RenamedKeys
from membrane_rs._validation import show
from membrane_rs.errors import OutputError
from membrane_rs.results.csv_lines import csv_file, csv_numbers
from membrane_rs.results.history_table import FIRST_COLUMNS, RENAMED, HistoryTable
from membrane_rs.results.record import Record
from membrane_rs.results.writer import Writer
from membrane_rs.simulation.stepper import Stepper

HISTORY = "history.csv"


class History(Writer):
    """Writes history.csv and keeps its rows."""

    own_files = (HISTORY,)

    def start(self, sim: Stepper, record: Record) -> None:
        """Begin the file with the names of its columns."""
        self._begin(sim, record)
        self._open("w")
        self._write(self._history.columns)

    def resume(self, sim: Stepper, record: Record) -> None:
        """Keep the lines up to now, and remove later ones. Raises OutputError where they are not this run's."""
        self._begin(sim, record)
        with reading_errors(self._path, "history of a run"):
            text = read_text(self._path) if self._path.is_file() else ""
        lines = text[: text.rfind("\n") + 1].splitlines(keepends=True)
        if not lines:
            self._open("w")
            self._write(self._history.columns)
            return
        table = read_history(self._path)
        if not self._history.take(list(table)):
            raise OutputError(f"{self._path} holds other columns than this run writes; run the scene again")
        count = int(np.searchsorted(table["time"], sim.time, side="right"))
        self._history.resume(sim, np.stack(list(table.values()), axis=1)[:count])
        record.table = self._history.table()
        write_text(self._path, "".join(lines[: count + 1]))
        self._open("a")

    def _begin(self, sim: Stepper, record: Record) -> None:
        self._record, self._path = record, record.path / HISTORY
        self._history = HistoryTable(sim, record.measures)

    def _open(self, mode: str) -> None:
        with output_errors(self._path):
            check_writable(self._path)
            self._file = self._path.open(mode, encoding="utf-8", newline="")
        self._writer = csv.writer(self._file, lineterminator="\n")

    def sample(self, sim: Stepper) -> None:
        """Write one sample, if it is later than the last one."""
        if self._history.add(sim):
            self._write(self._history.last)

    def finish(self, sim: Stepper, error: BaseException | None) -> None:
        """Give the samples to other outputs, and close the file."""
        self._record.table = self._history.table()
        with output_errors(self._path):
            self._file.close()

    def sync(self) -> None:
        """The lines so far."""
        sync(self._path)

    def _write(self, row: list[str] | list[float]) -> None:
        with output_errors(self._path):
            self._writer.writerow(row)
            self._file.flush()


def read_history(path: Path | str) -> dict[str, Floats]:
    """Read a history.csv, or that of a run's folder: one (samples,) array per column.

    A last line that a killed process left unfinished is dropped; columns of version 0.1 get their new names. The old
    name of a column is still a key, with a DeprecationWarning.

    Parameters
    ----------
    path : path
        Of a history.csv, or of the folder.

    Returns
    -------
    dict of str to (samples,) float64
        By the names of history.csv, each in its unit.

    Raises
    ------
    MissingFileError
        No such file.
    OutputError
        What is no history.csv.
    InputError, InputTypeError
        No path.

    Examples
    --------
    >>> import tempfile
    >>> from membrane_rs import Simulation, scenes
    >>> from membrane_rs.results import read_history
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     run = Simulation(scenes.load("spinning-tether")).run(0.01, 2, folder, samples=3, pictures=False)
    ...     len(read_history(folder)["time"])
    3
    """
    path = path_of(path)
    with reading_errors(path, "history of a run"):
        path = csv_file(path, HISTORY, "history", "name a run's folder or its history.csv")
        columns, values = csv_numbers(path, lambda names: _columns(names, path))
    return RenamedKeys("read_history()", {name: values[:, k] for k, name in enumerate(columns)}, RENAMED)


def _columns(names: list[str], path: Path) -> list[str]:
    """The columns of a file with their present names. Raises OutputError where they are not those of a history."""
    columns = [RENAMED.get(name, name) for name in names]
    if columns[: len(FIRST_COLUMNS)] != list(FIRST_COLUMNS):
        raise OutputError(f"{path} does not begin with the columns {', '.join(FIRST_COLUMNS)}; is it a history.csv?")
    seen: set[str] = set()
    for name in columns:
        if name in seen:
            raise OutputError(f"{path}: has the column {show(name)} twice; run the scene again")
        seen.add(name)
    return columns
