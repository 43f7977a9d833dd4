"""Parameters of a scene from measured curves: their values, how far they are known, and what the data leave open.

Sums of squared residuals are minimised over the ranges of the parameters by a trust-region method with bounds
(`scipy.optimize.least_squares`), its Jacobian by central differences that run in parallel; or, where curves are too
rough for differences, by the simplex of Nelder and Mead. Both see means over starts: single starts of a chaotic
deployment differ by more than parameters change them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from typing_extensions import Unpack

from membrane_rs import scenes
from membrane_rs._arrays import Floats
from membrane_rs._renamed import takes_name_of
from membrane_rs._validation import nearest, number_of, show
from membrane_rs.errors import InputError
from membrane_rs.results.experiment import Experiment
from membrane_rs.results.given_experiment import ExperimentLike, experiment_of
from membrane_rs.results.history_table import HistoryTable, column_units
from membrane_rs.results.recorded import Measures, RecordTable, record_table
from membrane_rs.runs import Simulation
from membrane_rs.scene import Scene
from membrane_rs.scene.run_settings import SHORTEST
from membrane_rs.scene.stage import MEASURE_UNITS
from membrane_rs.scene.staging import planned_starts
from membrane_rs.study.calibration.analysis import analysed, jacobian
from membrane_rs.study.calibration.model import BudgetSpent, Curves, FitModel, check_recorded, data_columns
from membrane_rs.study.calibration.result import OUTPUTS, Calibration, calibration_of
from membrane_rs.study.common.many_runs import MOST_RUNS, Progress
from membrane_rs.study.common.one_run import FAILED, TIME_LIMIT
from membrane_rs.study.common.options import RunOptions, many_runs, takes_run_options
from membrane_rs.study.common.vary import Parameter, parameters_of
from membrane_rs.study.scene_match import match_scene

LEAST_SQUARES, NELDER_MEAD = "least-squares", "nelder-mead"
METHODS = (LEAST_SQUARES, NELDER_MEAD)
STEPS = {LEAST_SQUARES: 0.02, NELDER_MEAD: 0.05}
"""Default step of differences, as a share of a range."""
SMALLEST_STEP = 1e-6
NEAR_END = 0.02
"""Values this near to an end of their range, as a share of it, are tried at that end too; and the method with bounds,
whose steps are short beside a bound, begins no nearer to it.
"""


@takes_name_of(match_scene)
@takes_run_options
def calibrate(
    scene: Scene | str | Path,
    data: ExperimentLike,
    vary: Mapping[str, Any],
    *,
    starts: int = 1,
    method: str = LEAST_SQUARES,
    columns: Sequence[str] | None = None,
    uncertainty: Mapping[str, float | str] | None = None,
    step: float | None = None,
    most_runs: int = 500,
    progress: Progress | None = None,
    **options: Unpack[RunOptions],
) -> Calibration:
    """Fit parameters of a scene to measured curves; `match_scene` fits one to the curves of another scene.

    Parameters
    ----------
    scene : Scene, str or path
        A scene, the name of a built-in one, or the path of a scene file. Its own values are the start, or the middle of
        the range where they lie outside.
    data : path, Experiment, mapping or pandas.DataFrame
        Measured curves: "time" and columns of the history, in a CSV file (`results.read_experiment`), as an
        `Experiment`, or as arrays by name, which may be followed by a unit, "hub_torque [mN m]". A column "<name>_std"
        holds standard deviations of another one.
    vary : mapping
        By dotted key a range: "10:1000", or "10:1000:log" for one by its logarithms.
    starts : int
        Runs of each set of values, whose mean is compared: the scene's own start and perturbed ones.
    method : {"least-squares", "nelder-mead"}
        The second where curves are too rough for differences; it needs more runs.
    columns : sequence of str, optional
        Columns of the data that are compared. Default: all.
    uncertainty : mapping, optional
        Standard deviation of each value of a column, by its name, in its unit or as text with one. Default: unknown,
        each column then counts by its own spread.
    step : float, optional
        Of the differences, as a share of the ranges [-]. Default: 0.02; with nelder-mead 0.05.
    most_runs : int
        Runs at most; the best values so far are the result.
    until : float, optional
        Time up to which curves are compared [s], at most that of the last datum. Default: that, or the scene's end if
        it is earlier.
    samples : int, optional
        Rows of each history. Default: the scene's. Curves are linear between them.
    record : mapping or sequence of str, optional
        Measures that the data hold and a history does not, as in `sweep`.
    shift : float
        Standard deviation of the perturbation of each coordinate of a start [m].
    time_limit : float, optional
        Wall time after which a run is ended [s]; its values then count as ones that fail.
    executor, jobs, out, overwrite, retry, progress
        As in `sweep`. Runs that are in the folder are not made again.

    Returns
    -------
    Calibration
        Values, errors, sensitivities, correlations, and what the data do not determine.

    Raises
    ------
    InputError, InputTypeError
        Keys or ranges that the scene does not accept, data without a value in that time or with columns that no run
        records, a method that does not exist, no run that came to its end.
    MissingFileError, OutputError
        No data file; a folder of other runs.

    Examples
    --------
    >>> import numpy as np
    >>> from membrane_rs import run
    >>> from membrane_rs.results import Experiment
    >>> from membrane_rs.study import calibrate
    >>> curve = run("spinning-tether", until=0.05, frames=2).history
    >>> some = slice(None, None, 100)
    >>> data = Experiment("measured", curve["time"][some], {"hub_force": curve["hub_force"][some]}, {"hub_force": "N"})
    >>> found = calibrate("spinning-tether", data, {"laws.spin.frequency": "1:4"}, samples=51, most_runs=60)
    >>> [one.key for one in found.parameters], found.undetermined
    (['laws.spin.frequency'], [])
    """
    chosen = scenes.scene_of(scene)
    if method not in METHODS:
        raise InputError(f"method = {show(method)}: no such method; {nearest(str(method), METHODS)}")
    share = STEPS[method] if step is None else number_of("step", step, "a share of the ranges")
    if not SMALLEST_STEP <= share <= 0.5:
        raise InputError(f"step = {share:g}: must be from {SMALLEST_STEP:g} to 0.5 (a share of the ranges)")
    for name, count, least, most in (("starts", starts, 1, 1000), ("most_runs", most_runs, 1, MOST_RUNS)):
        if isinstance(count, bool) or not isinstance(count, int) or not least <= count <= most:
            raise InputError(f"{name} = {show(count)}: must be a whole number from {least} to {most}")
    parameters = _ranges(chosen, vary)
    wanted = dict(record_table(options.get("record")))
    units = _units(chosen, wanted)
    measured = experiment_of(data, units)
    end = _end(chosen, measured, options.get("until"))
    curves_of_data = data_columns(measured, columns, uncertainty, end)
    check_recorded(curves_of_data, units)
    unused = sum(int(np.isfinite(measured.columns[one.name]).sum()) - len(one.time) for one in curves_of_data)
    wanted |= {one.name: None for one in curves_of_data if one.name in MEASURE_UNITS and one.name not in wanted}
    request = {"kind": "calibration", "vary": {one.key: one.as_table() for one in parameters}}
    options |= {"until": end, "record": wanted}
    with many_runs(chosen, request, OUTPUTS, **options) as runs:
        model = FitModel(runs, parameters, curves_of_data, starts, most_runs, progress)
        first = np.array([_share_of(chosen, one) for one in parameters])
        (begun,) = _first_curves(model, first)
        outcome = _minimised(model, first, method, share)
        best, curves = model.best()
        try:
            model.curves([_at_ends(best)])
            best, curves = model.best()
            known = analysed(model, best, curves, share)
            best, curves = model.best()
        except BudgetSpent:
            known = None
        return calibration_of(
            chosen, model, (first, begun), (best, curves), known, method=method, outcome=outcome, path=runs.path,
            unused=unused,
        )  # fmt: skip


def _ranges(scene: Scene, vary: Mapping[str, Any]) -> list[Parameter]:
    """The parameters, each with a range of numbers. Raises InputError."""
    found = parameters_of(scene, vary, sampled=True)
    if not found:
        raise InputError("vary: names no parameter; give one such as laws.creases.stiffness=1:100:log")
    for one in found:
        if not one.is_range or one.is_whole:
            what = "a whole number, which is not fitted" if one.is_range else "a list"
            raise InputError(
                f"vary {one.key}: is {what}; give a range such as 1:100, or 1:100:log by logarithms "
                "(whole numbers: sweep)"
            )
        if one.key == "run.until":
            raise InputError("vary run.until: runs end where the data end; leave it out")
    return found


def _end(scene: Scene, measured: Experiment, until: float | None) -> float:
    """Time at which the runs end [s]. Raises InputError for data that end before they begin."""
    last = float(measured.time[-1])
    if last < SHORTEST:
        raise InputError(f"{measured.name}: ends at {last:g} s, and runs begin at 0 s; give data of later times")
    if until is not None:
        return min(last, number_of("until", until))
    return min(last, planned_starts(scene.stages)[-1] if scene.stages else scene.run.until)


def _units(scene: Scene, record: RecordTable) -> dict[str, str]:
    """The unit of each column that runs have, or can record. Raises InputError for a measure that none can."""
    own = {name: given[1] if isinstance(given, tuple) else "" for name, given in record.items() if given is not None}
    columns = HistoryTable(Simulation(scene), Measures(record)).columns
    return {**MEASURE_UNITS, **column_units(columns, {}), **own}


def _share_of(scene: Scene, parameter: Parameter) -> float:
    """The scene's own value as a share of the range; the middle where it has none, or lies outside."""
    low, high = parameter.values
    try:
        value = scene.value(parameter.key)
    except InputError:
        return 0.5
    if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high:
        return 0.5
    if parameter.is_log:
        return float(np.log(value / low) / np.log(high / low))
    return float((value - low) / (high - low))


def _first_curves(model: FitModel, shares: Floats) -> list[Curves]:
    """The curves at the start. Raises InputError where they are none, or too few runs are allowed."""
    try:
        found = model.curves([shares])
    except BudgetSpent:
        raise InputError(f"most_runs = {model.most_runs}: is less than the {model.starts} runs of one set") from None
    if found[0].failure:
        outcomes = {run.outcome for run in found[0].runs}
        remedy = "; give the scene values that run, or ranges around such"
        if TIME_LIMIT in outcomes:
            remedy = "; allow more, and retry (--retry)"
        elif FAILED in outcomes:  # by a measure, whose error says how to mend it
            remedy = ""
        raise InputError(f"the first runs failed: {found[0].failure}{remedy}")
    return found


def _at_ends(shares: Floats) -> Floats:
    """Shares that are near an end of their range, at that end: the method with bounds only comes near."""
    return np.where(shares < NEAR_END, 0.0, np.where(shares > 1.0 - NEAR_END, 1.0, shares))


def _minimised(model: FitModel, first: Floats, method: str, step: float) -> str:
    """Minimise the misfit; how that ended. The model knows all that was tried."""
    from scipy.optimize import least_squares, minimize  # slow to import

    def residuals(shares: Floats) -> Floats:
        return model.curves([np.clip(shares, 0.0, 1.0)])[0].residuals

    def slopes(shares: Floats) -> Floats:
        return jacobian(model, shares, step)

    def square_sum(shares: Floats) -> float:
        return float(np.sum(residuals(shares) ** 2))

    try:
        if method == LEAST_SQUARES:
            inside = np.clip(first, NEAR_END, 1.0 - NEAR_END)
            found: Any = least_squares(residuals, inside, slopes, bounds=(0.0, 1.0), xtol=1e-4, ftol=1e-6, gtol=1e-9)
        else:
            away = np.where(first < 0.5, 0.25, -0.25)
            simplex = np.vstack([first, *(first + row for row in np.diag(away))])
            model.curves(list(simplex))
            bounds = [(0.0, 1.0)] * len(first)
            options: Any = {"initial_simplex": simplex, "xatol": 1e-3, "fatol": np.inf, "maxfev": 10**6}
            found = minimize(square_sum, first, method="Nelder-Mead", bounds=bounds, options=options)
    except BudgetSpent:
        return f"stopped at {model.most_runs} runs (most_runs)"
    return "converged" if found.success else f"stopped: {found.message}"
