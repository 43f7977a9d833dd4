"""Ensembles: one scene from its own start and from perturbed ones, which show what of its motion is chaos."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from typing_extensions import Unpack

from membrane_rs import scenes
from membrane_rs._arrays import Floats
from membrane_rs._files import made_folder
from membrane_rs._markdown import table as markdown
from membrane_rs._validation import nearest
from membrane_rs.errors import InputError
from membrane_rs.plotting import plot_comparison
from membrane_rs.plotting.ensemble import Band
from membrane_rs.plotting.ensemble import Ensemble as Members
from membrane_rs.plotting.sources import Source
from membrane_rs.scene import Scene
from membrane_rs.study.common.many_runs import Progress
from membrane_rs.study.common.one_run import FINISHED
from membrane_rs.study.common.options import RunOptions, takes_run_options
from membrane_rs.study.common.rows import write_table
from membrane_rs.study.common.sampling import GRID
from membrane_rs.study.sweep_result import Sweep
from membrane_rs.study.sweeping import open_sweep, swept

CURVES = "curves"
"""The file of means and spreads."""
NOTHING = "ensemble: no run has come to its end; see in the table what failed"
NOT_OF_THE_MOTION = ("time", "dt", "steps", "rejected_steps", "evaluations", "wall_time")


@dataclass(frozen=True)
class Ensemble:
    """Runs of one scene from several starts.

    Attributes
    ----------
    runs : Sweep
        The runs, without parameters; `runs.rows` is their table.

    Examples
    --------
    >>> from membrane_rs.study import ensemble
    >>> found = ensemble("spinning-tether", starts=3, until=0.01, samples=3)
    >>> mean, spread = found.statistics()["final_kinetic_energy"]
    >>> spread < 1e-6 * mean
    True
    >>> band = found.band("kinetic_energy")
    >>> band.time.tolist(), bool((band.low <= band.high).all())
    ([0.0, 0.005, 0.01], True)
    >>> print(found.summary().splitlines()[0])
    3 of 3 runs: 3 finished
    >>> figure = found.plot(["kinetic_energy"])
    >>> [path.name for path in found.save("three", ["kinetic_energy"])]
    ['curves.csv', 'ensemble.png']
    """

    runs: Sweep

    @cached_property
    def histories(self) -> list[Mapping[str, Floats]]:
        """The histories of the runs that came to their end: (samples,) arrays by column, each in its unit."""
        return [self.runs.history(row["run"]) for row in self.runs.rows if row["outcome"] == FINISHED]

    @property
    def columns(self) -> list[str]:
        """Columns that have a mean."""
        return [name for name in (self.histories[0] if self.histories else ()) if name != "time"]

    def band(self, column: str, spread: str = "std") -> Band:
        """Mean of a column over the starts, and its spread.

        Parameters
        ----------
        column : str
            One of `columns`.
        spread : {"std", "range"}
            One standard deviation to both sides of the mean, or from the lowest to the highest start.

        Returns
        -------
        Band
            `time` [s], and `mean`, `low` and `high` in the unit of the column, (samples,) each.

        Raises
        ------
        InputError
            No such column, or no run that came to its end.
        """
        if column not in self.columns:
            known = nearest(column, self.columns) if self.columns else "no run has come to its end"
            raise InputError(f"column = {column!r}: is none of the ensemble's; {known}")
        return Members("", [Source("", history) for history in self.histories], spread).band(column)

    def statistics(self) -> dict[str, tuple[float, float]]:
        """Mean and standard deviation over the starts of each number of a row.

        Returns
        -------
        dict of str to (float, float)
            By the name of the number, in its unit; a standard deviation of NaN for one start alone.
        """
        found = {}
        rows = [row for row in self.runs.rows if row["outcome"] == FINISHED]
        for name in dict.fromkeys(name for row in rows for name in row):
            values = [row.get(name) for row in rows]
            numbers = [float(v) for v in values if isinstance(v, int | float) and not isinstance(v, bool)]
            if len(numbers) == len(rows) and name not in (*NOT_OF_THE_MOTION, "run", "start"):
                spread = float(np.std(numbers, ddof=1)) if len(numbers) > 1 else math.nan
                found[name] = float(np.mean(numbers)), spread
        return found

    def summary(self) -> str:
        """How the runs ended, and mean and spread of what their curves show.

        Returns
        -------
        str
            In Markdown.
        """
        rows = [
            (name, f"{mean:.6g}", f"{spread:.2g}")
            for name, (mean, spread) in self.statistics().items()
            if not name.startswith(("lowest_", "highest_", "final_")) or name.endswith(("_rate", "_deg"))
        ]
        return f"{self.runs.summary()}\n\n{markdown(('', 'mean', 'standard deviation'), rows, words=())}"

    def __repr__(self) -> str:
        """Number of runs and how they ended, in a line."""
        return f"Ensemble({self.runs.summary().splitlines()[0]})"

    def plot(self, columns: Sequence[str] | None = None, **options: Any) -> Any:
        """Mean, band and single runs against time.

        Parameters
        ----------
        columns : sequence of str, optional
            A panel for each. Default: the deployment rate and, where a hub turns, the phase difference.
        **options
            As in `membrane_rs.plotting.plot_comparison`: path, title, dpi, style, spread, experiments.

        Returns
        -------
        matplotlib.figure.Figure
            Without pyplot: nothing has to be closed.

        Raises
        ------
        InputError
            No run that came to its end, or no such column.
        OutputError
            `path` cannot be written.
        """
        if not self.histories:
            raise InputError(NOTHING)
        label = f"mean of {len(self.histories)} start{'s' * (len(self.histories) > 1)}"
        return plot_comparison(ensembles={label: self.histories}, columns=columns, **{"members": True, **options})

    def save(self, folder: str | Path, columns: Sequence[str] | None = None, **options: Any) -> list[Path]:
        """Write curves.csv (mean, standard deviation, lowest and highest of each column) and ensemble.png.

        Parameters
        ----------
        folder : path
            Made where it is missing.
        columns : sequence of str, optional
            Of the figure, as for `plot`.
        **options
            As for `plot`.

        Returns
        -------
        list of Path
            The two files.

        Raises
        ------
        InputError, InputTypeError
            No run that came to its end; no path.
        OutputError
            A file cannot be written.
        """
        if not self.histories:
            raise InputError(NOTHING)
        folder = made_folder(folder)
        table: dict[str, Floats] = {}
        for name in self.columns:
            band, widest = self.band(name), self.band(name, "range")
            table |= {"time": band.time, f"{name}_mean": band.mean, f"{name}_std": band.high - band.mean}
            table |= {f"{name}_lowest": widest.low, f"{name}_highest": widest.high}
        rows = [dict(zip(table, map(float, line), strict=True)) for line in zip(*table.values(), strict=True)]
        paths = [folder / f"{CURVES}.csv", folder / "ensemble.png"]
        write_table(paths[0], rows)
        self.plot(columns, path=paths[1], **options)
        return paths


@takes_run_options
def ensemble(
    scene: Scene | str | Path,
    starts: int = 8,
    *,
    table: str | None = None,
    progress: Progress | None = None,
    **options: Unpack[RunOptions],
) -> Ensemble:
    """Run a scene from its own start and from perturbed ones.

    Parameters
    ----------
    scene : Scene, str or path
        A scene, the name of a built-in one, or the path of a scene file.
    starts : int
        Number of runs; the first is from the scene's own start.
    table, progress, until, samples, record, shift, time_limit, executor, jobs, out, overwrite, retry
        As in `sweep`.

    Returns
    -------
    Ensemble
        Rows, histories, mean and spread of the curves.

    Raises
    ------
    InputError, OutputError, ExecutorError
        As `sweep`.

    Examples
    --------
    >>> from membrane_rs.study import ensemble
    >>> found = ensemble("spinning-tether", starts=3, until=0.01, samples=3)
    >>> found.band("kinetic_energy").mean.shape
    (3,)
    """
    chosen = scenes.scene_of(scene)
    design = {"sample": GRID}
    return Ensemble(swept(chosen, [], [{}], starts, design, table=table, progress=progress, options=options))


def open_ensemble(path: str | Path) -> Ensemble:
    """Read the folder of an ensemble, also of one that goes on or was stopped.

    Parameters
    ----------
    path : path
        The folder.

    Returns
    -------
    Ensemble
        As far as its runs were made.

    Raises
    ------
    MissingFileError
        No ensemble there.
    InputError
        A sweep, which varies more than the start.
    InputTypeError
        No path.
    OutputError
        A damaged file.

    Examples
    --------
    >>> from membrane_rs.study import ensemble, open_ensemble
    >>> made = ensemble("spinning-tether", starts=2, until=0.01, samples=3, out="two-starts")
    >>> open_ensemble("two-starts").runs.rows == made.runs.rows
    True
    """
    runs = open_sweep(path)
    if runs.parameters:
        raise InputError(f"{path}: is a sweep of {runs.parameters[0].key}, no ensemble; use open_sweep")
    return Ensemble(runs)
