"""crossings.csv: how many pairs of triangles pass through each other, one line per frame; see `Crossings`.

time          [s]
crossing      pairs that cross
overlapping   pairs in one plane that overlap
touching      pairs that touch
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs._files import check_writable, output_errors, path_of, reading_errors, sync, write_text
from membrane_rs._known_attributes import KnownAttributes
from membrane_rs._validation import flag_of
from membrane_rs.errors import OutputError
from membrane_rs.mesh.crossings import Crossings, crossings
from membrane_rs.results.csv_lines import csv_lines
from membrane_rs.results.record import Record
from membrane_rs.results.writer import Writer
from membrane_rs.simulation.motion import Motion
from membrane_rs.simulation.stepper import Stepper

CROSSINGS = "crossings.csv"
COLUMNS = ("time", "crossing", "overlapping", "touching")


class CrossingCounts(KnownAttributes):
    """An observer that counts the triangles that pass through each other at each frame of a run.

    Layers do not feel each other, so crossings are a measure of the model, not a fault of the run. A count takes some
    10 to 50 ms for 3,000 triangles. For one run, or for runs that follow each other.

    Parameters
    ----------
    samples : bool
        Count at each sample of the history, of which there are more, in place of the frames.

    Raises
    ------
    InputTypeError
        Neither true nor false.

    Examples
    --------
    >>> from membrane_rs import Simulation, scenes
    >>> from membrane_rs.results import CrossingCounts
    >>> counts = CrossingCounts()
    >>> Simulation(scenes.load("hanging-strip")).run(0.01, frames=2, observers=[counts])
    >>> counts.table()["crossing"].tolist()
    [0.0, 0.0]
    """

    ONCE = ("samples", "rows")

    def __init__(self, *, samples: bool = False) -> None:
        self.samples = flag_of("samples", samples)
        self.rows: list[tuple[float, int, int, int]] = []

    def table(self) -> dict[str, Floats]:
        """The counts so far: "time" [s], "crossing", "overlapping" and "touching", one (frames,) array each.

        Returns
        -------
        dict of str to (frames,) float64
            "time" [s], and numbers of pairs.
        """
        return _table(self.rows)

    def start(self, sim: Motion) -> None:
        """Nothing is counted before the first frame."""

    def sample(self, sim: Motion) -> None:
        """Count where each sample is asked for."""
        if self.samples:
            self._count(sim)

    def frame(self, sim: Motion) -> None:
        """Count, unless each sample is, and this is one."""
        if not self.samples:
            self._count(sim)

    def finish(self, sim: Motion, error: BaseException | None) -> None:
        """Nothing is left to do."""

    def _count(self, sim: Motion) -> None:
        if not self.rows or sim.time > self.rows[-1][0]:
            self.rows.append(_row(sim.time, sim.crossings(limit=0)))


class CrossingsFile(Writer):
    """Counts in the background, from copies, and writes crossings.csv; the summary then has the least and the most."""

    own_files = (CROSSINGS,)
    option = "crossings"

    def start(self, sim: Stepper, record: Record) -> None:
        """Begin the file with the names of its columns."""
        self._begin(record, [])

    def resume(self, sim: Stepper, record: Record) -> None:
        """Keep the lines up to now, and remove later ones. Raises OutputError for a file of something else."""
        if not (record.path / CROSSINGS).is_file():
            self.start(sim, record)
            return
        table = np.stack(list(read_crossings(record.path).values()), axis=1)
        self._begin(record, [(time, *map(int, counts)) for time, *counts in table.tolist() if time <= sim.time])

    def _begin(self, record: Record, rows: list[Sequence[float]]) -> None:
        self._record, self._path = record, record.path / CROSSINGS
        self._rows = rows
        self._last = rows[-1][0] if rows else -np.inf
        write_text(self._path, "".join(map(_line, [COLUMNS, *rows])))

    def frame(self, sim: Stepper) -> None:
        """Copy the positions; a state that is not later than the last one is skipped."""
        time = sim.time
        if time > self._last:
            self._last = time
            triangles, positions = sim.assembly.triangles, sim.positions
            self._record.background.add(lambda: self._add(_row(time, crossings(triangles, positions, 0))))

    def sync(self) -> None:
        """The lines so far."""
        sync(self._path)

    def finish(self, sim: Stepper, error: BaseException | None) -> None:
        """Say in the summary what was counted."""
        counts = [int(row[1]) for row in self._rows]
        if counts:
            most = counts.index(max(counts))
            self._record.summary["crossings"] = {
                "first": counts[0],
                "last": counts[-1],
                "most": counts[most],
                "time_of_most": self._rows[most][0],
            }

    def _add(self, row: Sequence[float]) -> None:
        with output_errors(self._path):
            check_writable(self._path)
            with self._path.open("a", encoding="utf-8", newline="") as file:
                file.write(_line(row))
        self._rows.append(row)


def read_crossings(path: Path | str) -> dict[str, Floats]:
    """Read a crossings.csv, or that of a run's folder: one (frames,) array per column.

    A last line that a killed process left unfinished is dropped.

    Parameters
    ----------
    path : path
        Of a crossings.csv, or of the folder.

    Returns
    -------
    dict of str to (frames,) float64
        "time" [s], and numbers of pairs.

    Raises
    ------
    MissingFileError
        No such file.
    OutputError
        What is no crossings.csv.
    InputError, InputTypeError
        No path.

    Examples
    --------
    >>> import tempfile
    >>> from membrane_rs import Simulation, scenes
    >>> from membrane_rs.results import read_crossings
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     run = Simulation(scenes.load("hanging-strip")).run(0.01, 2, folder, pictures=False, crossings=True)
    ...     read_crossings(folder)["crossing"].tolist()
    [0.0, 0.0]
    """
    path = path_of(path)
    with reading_errors(path, "crossings of a run"):
        path, lines = csv_lines(path, CROSSINGS, "crossings", "run the scene with --crossings")
        if not lines or tuple(lines[0]) != COLUMNS:
            raise OutputError(f"{path} does not have the columns {', '.join(COLUMNS)}; is it a crossings.csv?")
        try:
            return _table([[float(word) for word in line] for line in lines[1:]])
        except ValueError as error:
            raise OutputError(f"{path} holds a line that is no count: {error}; run the scene again") from error


def _table(rows: Sequence[Sequence[float]]) -> dict[str, Floats]:
    values = np.array(rows, dtype=np.float64).reshape(len(rows), len(COLUMNS))
    return {name: values[:, k] for k, name in enumerate(COLUMNS)}


def _row(time: float, found: Crossings) -> tuple[float, int, int, int]:
    return time, found.count, found.overlapping, found.touching


def _line(row: Sequence[object]) -> str:
    return ",".join(map(str, row)) + "\n"
