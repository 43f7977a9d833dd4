"""Sweeps: runs of one scene over values of its parameters, each from one or several starts, as one table."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

from typing_extensions import Unpack

from membrane_rs import scenes
from membrane_rs._arrays import Floats
from membrane_rs._files import path_of, reading_errors
from membrane_rs._validation import show
from membrane_rs.errors import InputError, InputTypeError
from membrane_rs.scene import Scene
from membrane_rs.study.common.kept_runs import kept_run, read_request
from membrane_rs.study.common.many_runs import MOST_RUNS, Progress, units_of
from membrane_rs.study.common.one_run import RunPoint, RunResult
from membrane_rs.study.common.options import RunOptions, many_runs, takes_run_options
from membrane_rs.study.common.rows import table_format
from membrane_rs.study.common.sampling import GRID, is_sampled, points_of, sample_count
from membrane_rs.study.common.vary import Parameter, parameters_of
from membrane_rs.study.sweep_result import Sweep

TABLE, FIGURE = "table", "sweep"
NOTHING_VARIED = "give one to vary, such as laws.creases.stiffness, or starts above 1"
RULED_BY: Mapping[str, Literal["until", "samples"]] = {"run.until": "until", "run.samples": "samples"}
"""Options in whose place the values of a scene are, by their keys."""
MOST_IN_MEMORY = 10_000
"""Runs of a sweep without a folder: their histories take some 100 kB each."""
OUTPUTS = (f"{TABLE}.*", f"{FIGURE}.png")


@takes_run_options
def sweep(
    scene: Scene | str | Path,
    vary: Mapping[str, Any],
    *,
    starts: int = 1,
    sample: str = GRID,
    seed: int = 0,
    table: str | None = None,
    progress: Progress | None = None,
    **options: Unpack[RunOptions],
) -> Sweep:
    """Run a scene for all combinations, or samples, of some of its values.

    Parameters
    ----------
    scene : Scene, str or path
        A scene, the name of a built-in one, or the path of a scene file.
    vary : mapping
        By dotted key (see `Scene.with_values`) a list of values, or a text as on the command line: "1,3,10",
        "5 um:10 um:6", "10:1000:log5"; for samples "10:1000" or "10:1000:log".
    starts : int
        Runs for each combination: the first from the scene's own start, others from perturbed ones.
    sample : str
        "grid": all combinations. "lhs:20": a Latin hypercube of so many samples. "sobol:32": a Sobol sequence.
    seed : int
        Of the samples.
    table : {"parquet", "csv"}, optional
        Format of the table in the folder. Default: Parquet where pyarrow is installed, else CSV.
    progress : callable, optional
        Called with the number of runs that are done, that of all, and the last one.
    until : float, optional
        Time at the end [s]. Default: the scene's.
    samples : int, optional
        Rows of each history. Default: the scene's.
    record : mapping or sequence of str, optional
        Measures: by the name of a column a function of the simulation, or a tuple of that and its unit, as in
        `membrane_rs.run`; or names of known ones, such as ["largest_speed"].
    shift : float
        Standard deviation of the perturbation of each coordinate of a start [m].
    time_limit : float, optional
        Wall time after which a run is ended [s].
    executor : Executor, "threads" or "processes"
        Where runs are made: an executor of `concurrent.futures` (also distributed's `Client.get_executor()`), or this
        machine.
    jobs : int, optional
        Runs at a time. Default: one for each core; 1000 in an executor of the caller.
    out : path, optional
        Folder of the runs and their table. With the same request it is gone on with. Default: nothing is written.
    overwrite : bool
        Whether the runs of another request in the folder are removed.
    retry : bool
        Whether runs that crashed or ran out of time are made again.

    Returns
    -------
    Sweep
        Rows and histories. They depend neither on the executor nor on the order of runs.

    Raises
    ------
    InputError, InputTypeError
        Keys or values that the scene does not accept one by one, all at once; no run, or too many.
    OutputError
        A folder of another request, or one that cannot be written.
    ExecutorError
        An executor that takes no more runs.
    KeyboardInterrupt
        Ctrl-C; runs that are done are kept in the folder.

    Examples
    --------
    >>> from membrane_rs.study import sweep
    >>> found = sweep("spinning-tether", {"laws.spin.frequency": [1.0, 2.0]}, until=0.01, samples=3)
    >>> [(row["laws.spin.frequency"], row["outcome"]) for row in found.rows]
    [(1.0, 'finished'), (2.0, 'finished')]
    """
    chosen = scenes.scene_of(scene)
    sampled = is_sampled(sample)
    parameters = parameters_of(chosen, vary, sampled=sampled)
    values = points_of(parameters, sample, seed)
    if not parameters and starts == 1:
        raise InputError(f"vary: names no value, so that all there is is one run; {NOTHING_VARIED}")
    for key, option in RULED_BY.items():
        if options.get(option) is not None and any(parameter.key == key for parameter in parameters):
            raise InputError(f"vary {key}: {option} = {options[option]} rules it in all runs; leave one of them out")
    design = {"sample": sample, **({"seed": seed} if sampled else {})}
    return swept(chosen, parameters, values, starts, design, table=table, progress=progress, options=options)


def swept(
    scene: Scene,
    parameters: Sequence[Parameter],
    values: Sequence[Mapping[str, Any]],
    starts: int,
    design: Mapping[str, Any],
    *,
    table: str | None,
    progress: Progress | None,
    options: RunOptions,
) -> Sweep:
    """Run a scene for combinations of values, each from so many starts; `design` says how they were chosen."""
    points = with_starts(values, starts)
    out = options.get("out")
    if out is None and len(points) > MOST_IN_MEMORY:
        raise InputError(f"{len(points):,} runs: at most {MOST_IN_MEMORY:,} are kept in memory; give out=, a folder")
    request = {
        "kind": "sweep",
        "vary": {parameter.key: parameter.as_table() for parameter in parameters},
        **design,
        "starts": starts,
        "points": [list(point.values()) for point in values],
    }
    ending = None if out is None else table_format(table)
    rows: dict[int, Mapping[str, Any]] = {}
    histories: dict[int, Mapping[str, Floats]] = {}

    def found() -> Sweep:
        kept = [rows[k] for k in sorted(rows)]
        return Sweep(parameters, points, kept, runs.path, design["sample"], units_of(runs.setup), histories)

    with many_runs(scene, request, OUTPUTS, **options) as runs:
        try:
            for k, result in runs.results(points, progress):
                rows[k] = {"run": k, **result.row()}
                if out is None:
                    histories[k] = result.history
        except KeyboardInterrupt:
            if runs.path is not None:  # of runs that were kept, one may not have come as far as here
                rows |= {k: {"run": k, **result.row()} for k, result in _made(runs.path, points) if k not in rows}
            raise
        finally:
            if runs.path is not None and ending is not None and rows:
                found().save_table(runs.path / f"{TABLE}.{ending}")
    return found()


def with_starts(values: Sequence[Mapping[str, Any]], starts: int) -> list[RunPoint]:
    """A run for each combination of values and each start. Raises InputError and InputTypeError."""
    if isinstance(starts, bool) or not isinstance(starts, int):
        raise InputTypeError(f"starts = {show(starts)}: must be a whole number")
    if starts < 1:
        raise InputError(f"starts = {show(starts)}: must be 1 or above; the first is the scene's own")
    if len(values) * starts > MOST_RUNS:
        raise InputError(
            f"{len(values):,} combinations of values from {starts:,} starts are {len(values) * starts:,} runs: must be "
            f"at most {MOST_RUNS:,}; give fewer values or starts"
        )
    return [RunPoint(point, start) for point in values for start in range(starts)]


def open_sweep(path: str | Path) -> Sweep:
    """Read the folder of a sweep, also of one that goes on or was stopped.

    Parameters
    ----------
    path : path
        The folder.

    Returns
    -------
    Sweep
        As far as its runs were made.

    Raises
    ------
    MissingFileError
        No sweep there.
    OutputError
        A damaged file.
    InputError, InputTypeError
        No path.

    Examples
    --------
    >>> from membrane_rs.study import open_sweep, sweep
    >>> made = sweep("spinning-tether", {"laws.spin.frequency": [1.0, 2.0]}, until=0.01, samples=3, out="two-runs")
    >>> open_sweep("two-runs").rows == made.rows
    True
    """
    folder = path_of(path)
    request = read_request(folder)
    with reading_errors(folder, "folder of a sweep"):
        parameters = [
            Parameter(
                str(key),
                str(entry["unit"]),
                tuple(map(_plain, entry["values"])),
                bool(entry["is_range"]),
                bool(entry["is_log"]),
            )
            for key, entry in request["vary"].items()
        ]
        starts, keys = int(request["starts"]), [parameter.key for parameter in parameters]
        values = [dict(zip(keys, map(_plain, point), strict=True)) for point in request["points"]]
        try:
            points = with_starts(values, starts)
            sample_count(request["sample"])
        except InputError as error:
            raise ValueError(str(error)) from None
        rows = [{"run": k, **result.row()} for k, result in _made(folder, points)]
        return Sweep(parameters, points, rows, folder, str(request["sample"]), dict(request["record"]))


def _made(folder: Path, points: Sequence[RunPoint]) -> Iterator[tuple[int, RunResult]]:
    for k, point in enumerate(points):
        if (found := kept_run(folder, point)) is not None:
            yield k, found


def _plain(value: Any) -> Any:
    """A value of a request, where lists stand for tuples."""
    return tuple(map(_plain, value)) if isinstance(value, list) else value
