"""The result of a sweep: its rows, the histories of its runs, a figure."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from membrane_rs._arrays import Floats
from membrane_rs._files import path_of
from membrane_rs._validation import show
from membrane_rs.errors import InputError
from membrane_rs.plotting.sweep import Varied, plot_sweep
from membrane_rs.study.common.kept_runs import kept_run
from membrane_rs.study.common.one_run import FINISHED, RunPoint
from membrane_rs.study.common.rows import table_format, to_pandas, write_table
from membrane_rs.study.common.sampling import GRID, is_sampled, sample_count
from membrane_rs.study.common.vary import Parameter

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class Sweep:
    """The runs of a sweep.

    Attributes
    ----------
    parameters : sequence of Parameter
        What was varied.
    points : sequence of RunPoint
        All runs, by values, those of one start after another.
    rows : sequence of dict
        Those that were made, in the same order: "run", its number, the values by key, "start", "outcome", "message",
        and the numbers of the run.
    path : Path or None
        The folder.
    sample : str
        The design.
    units : mapping
        Units of the measures that were recorded.

    Examples
    --------
    >>> from membrane_rs.study import sweep
    >>> found = sweep("spinning-tether", {"laws.spin.frequency": [1.0, 2.0]}, until=0.01, samples=3)
    >>> print(found.summary())
    2 of 2 runs: 2 finished
    >>> found.history(1)["time"].tolist(), found.outcomes(), found.failures()
    ([0.0, 0.005, 0.01], {'finished': 2}, [])
    >>> found.name_of(found.rows[1]), found.to_pandas()["laws.spin.frequency"].tolist()
    ('laws.spin.frequency = 2.0, start 0', [1.0, 2.0])
    >>> figure = found.plot(["final_kinetic_energy"])
    >>> found.save_table("runs.csv")
    """

    parameters: Sequence[Parameter]
    points: Sequence[RunPoint]
    rows: Sequence[Mapping[str, Any]]
    path: Path | None = None
    sample: str = GRID
    units: Mapping[str, str] = field(default_factory=dict)
    _histories: Mapping[int, Mapping[str, Floats]] = field(default_factory=dict, repr=False)

    def history(self, run: int) -> Mapping[str, Floats]:
        """The history of a run.

        Parameters
        ----------
        run : int
            Its number, from 0.

        Returns
        -------
        mapping of str to (samples,) float
            By column, each in its unit; empty where the run did not begin.

        Raises
        ------
        InputError
            No such run, or one that was not made.
        OutputError
            A damaged file.
        """
        if not isinstance(run, int) or not 0 <= run < len(self.points):
            raise InputError(f"run = {show(run)}: must be from 0 to {len(self.points) - 1}")
        if run in self._histories:
            return self._histories[run]
        found = None if self.path is None else kept_run(self.path, self.points[run])
        if found is None:
            raise InputError(f"run = {run}: was not made yet; repeat the sweep to go on with it")
        return found.history

    def to_pandas(self) -> pd.DataFrame:
        """The rows as a table of pandas.

        Returns
        -------
        pandas.DataFrame
            A line for each run; "run", values, "start", "outcome" and "message" come first.

        Raises
        ------
        MissingExtraError
            pandas is not installed.
        """
        return to_pandas(self.rows, self._first())

    def outcomes(self) -> dict[str, int]:
        """Number of runs by outcome.

        Returns
        -------
        dict of str to int
            By "finished", ...
        """
        return dict(Counter(str(row["outcome"]) for row in self.rows))

    def failures(self) -> list[Mapping[str, Any]]:
        """The rows of runs that did not come to their end.

        Returns
        -------
        list of dict
            As `rows` has them.
        """
        return [row for row in self.rows if row["outcome"] != FINISHED]

    def summary(self) -> str:
        """How many runs there are and how they ended, and what failed and why.

        Returns
        -------
        str
            A line, and one for each run that failed.
        """
        counts = ", ".join(f"{count} {outcome}" for outcome, count in self.outcomes().items())
        lines = [f"{len(self.rows)} of {len(self.points)} runs: {counts or 'none made'}{self._repeated()}"]
        for row in self.failures():
            lines.append(f"run {row['run']} ({self.name_of(row)}) {row['outcome']}: {row['message']}")
        return "\n".join(lines)

    def __repr__(self) -> str:
        """Keys, number of runs and how they ended, in a line."""
        varied = ", ".join(parameter.key for parameter in self.parameters) or "starts"
        return f"Sweep({varied}: {self.summary().splitlines()[0]})"

    def name_of(self, row: Mapping[str, Any]) -> str:
        """The values and the start of a run, as text.

        Parameters
        ----------
        row : mapping
            One of `rows`.

        Returns
        -------
        str
            For titles and messages.
        """
        values = [f"{parameter.key} = {row[parameter.key]}" for parameter in self.parameters]
        return ", ".join([*values, f"start {row['start']}"])

    def save_table(self, path: str | Path) -> None:
        """Write the rows as Parquet or CSV, by the ending of `path`.

        Parameters
        ----------
        path : path
            A file that ends in .parquet or .csv.

        Raises
        ------
        InputError, InputTypeError
            Another ending, or no path.
        OutputError
            It cannot be written.
        MissingExtraError
            Parquet without pyarrow.
        """
        path = path_of(path)
        table_format(path.suffix.removeprefix("."))
        write_table(path, self.rows, self._first())

    def plot(self, columns: Sequence[str] | None = None, **options: Any) -> Any:
        """The sweep in one figure: maps over two parameters of a grid, else each number against each parameter.

        Parameters
        ----------
        columns : sequence of str, optional
            Numbers of the rows, a panel for each. Default: up to four in which runs differ.
        **options
            As in `membrane_rs.plotting.plot_comparison`: path, title, dpi, style.

        Returns
        -------
        matplotlib.figure.Figure
            Without pyplot: nothing has to be closed.

        Raises
        ------
        InputError
            No run or no parameter, a column that no run has, no run with a number.
        OutputError
            `path` cannot be written.
        """
        varied = [Varied(one.key, one.unit, one.values, one.is_log) for one in self.parameters]
        return plot_sweep(self.rows, varied, columns, sampled=is_sampled(self.sample), units=self.units, **options)

    def _repeated(self) -> str:
        """What is to be said where samples were rounded to fewer combinations of values."""
        count, found = sample_count(self.sample), len({tuple(point.values.items()) for point in self.points})
        return f" ({count} samples, of which {found} are different)" if found < count else ""

    def _first(self) -> list[str]:
        return ["run", *(parameter.key for parameter in self.parameters), "start", "outcome", "message"]
