"""Curves of several runs and experiments, each against one of them: a table of differences and a figure.

Two curves are compared over the time that both cover, at the samples of the one that has fewer there (of the reference
where they have as many); the other is interpolated linearly between its own samples. Measured values, where they are
few, are thus compared as they are. At each of these instants the difference is d = curve - reference.

rms       sqrt(mean(d^2))
share     rms over the range of the reference, largest less smallest value, in that time
mean      mean(d)
largest   the d of the largest magnitude, and its time
peak      the value of the largest magnitude of each, among its own samples in that time, and its time
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs._validation import nearest, show, texts_of
from membrane_rs.errors import InputError
from membrane_rs.plotting.deployment import turns
from membrane_rs.results.experiment import DEVIATION
from membrane_rs.study.compared_curves import Compared, Curves, read_curves
from membrane_rs.study.comparison_result import DEFAULTS, Comparison, Difference

ALL = "all"
"""In place of names of columns: each that the reference shares with another one."""
BOOKKEEPING = ("stage",)
"""Columns that are no measured or computed quantity."""


def compare(
    curves: Sequence[Compared] | Mapping[str, Compared],
    columns: Sequence[str] | str | None = None,
    *,
    reference: str | None = None,
    labels: Sequence[str] | None = None,
) -> Comparison:
    """Compare curves of runs and experiments with those of one of them.

    Parameters
    ----------
    curves : sequence or mapping
        Two or more: runs, folders of runs, and measured curves: CSV files as `membrane_rs.results.read_experiment`
        reads them, `Experiment`, arrays by name, tables of pandas. A mapping gives each its label. Measured values are
        converted to the units of the runs.
    columns : sequence of str, or "all", optional
        Names of columns. Default: those of the experiments; without any, the deployment rate and, where a hub turns,
        the phase difference. "all": each that the reference shares with another.
    reference : str, optional
        Label of the one with which the others are compared. Default: the first.
    labels : sequence of str, optional
        One for each. Default: names of folders and files.

    Returns
    -------
    Comparison
        Differences, as a table and as numbers, and the figure.

    Raises
    ------
    InputError
        Fewer than two; a column, label or unit that does not fit; curves that share no time.
    InputTypeError
        What has no curves.
    MissingFileError, OutputError
        A folder or file that is not there, or cannot be read.

    Examples
    --------
    >>> import membrane_rs
    >>> from membrane_rs.study import compare
    >>> runs = {f"{dt:g} s": membrane_rs.run("spinning-tether", 0.01, dt=dt) for dt in (1e-5, 2e-5)}
    >>> found = compare(runs, ["kinetic_energy"])
    >>> found.reference, found.difference("2e-05 s", "kinetic_energy").share < 1e-6
    ('1e-05 s', True)
    """
    given = read_curves(curves, labels)
    first = _reference(given, reference)
    chosen = _columns(given, first, columns)
    differences = []
    for column in chosen:
        for other in given:
            if other is not first and column in other.table:
                difference = _difference(other, first, column)
                differences += [difference] if difference is not None else []
    if not differences:
        raise InputError(
            f"{first.label}: shares no time with another curve in {', '.join(chosen)}; compare curves of the same time"
        )
    return Comparison(first.label, tuple(chosen), tuple(differences), tuple(given))


def _reference(given: Sequence[Curves], wanted: str | None) -> Curves:
    """The curves of a label. Raises InputError."""
    if wanted is None:
        return given[0]
    for curves in given:
        if curves.label == wanted:
            return curves
    raise InputError(f"reference = {show(wanted)}: is no label; {nearest(str(wanted), [c.label for c in given])}")


def _columns(given: Sequence[Curves], reference: Curves, wanted: Sequence[str] | str | None) -> list[str]:
    """The columns that are compared, in their order. Raises InputError."""
    shared = [c for c in reference.columns if any(c in other.table for other in given if other is not reference)]
    if wanted is not None and not (isinstance(wanted, str) and wanted == ALL):
        wanted = texts_of("columns", wanted, f"a list of names of columns, or {ALL!r}")
        for name in wanted:
            if name not in shared:
                what = "is in no other curve" if name in reference.table else f"is not in {reference.label}"
                raise InputError(f"columns: {show(name)} {what}; {nearest(name, shared) if shared else 'none is'}")
        if not wanted:
            raise InputError("columns = []: must name one or more, or be left out")
        return list(dict.fromkeys(wanted))
    measured = [name for curves in given if curves.is_measured for name in curves.columns]
    usual = dict.fromkeys(name for name in measured if not _is_uncertainty(name, measured)) or DEFAULTS
    found = [
        name
        for name in shared
        if (wanted == ALL or name in usual)
        and name not in BOOKKEEPING
        and not _is_uncertainty(name, measured)
        and _is_known(given, reference, name)
    ]
    if not found:
        if shared:
            hint = f"it shares {', '.join(shared)}"
        else:
            hint = nearest(next(iter(usual)), {c for other in given if other is not reference for c in other.columns})
        raise InputError(f"{reference.label}: shares no values of {', '.join(usual)} with another; {hint}")
    return found


def _is_uncertainty(name: str, columns: Sequence[str]) -> bool:
    """Whether a column holds the standard deviations of another one."""
    return name.endswith(DEVIATION) and name.removesuffix(DEVIATION) in columns


def _is_known(given: Sequence[Curves], reference: Curves, name: str) -> bool:
    """Whether the reference and another one have values of a column, which for the phase are more than rounding."""
    if name == DEFAULTS[1] and not any(turns(each.table) for each in given if name in each.table):
        return False
    others = [other for other in given if other is not reference and name in other.table]
    return len(reference.curve(name)[0]) > 0 and any(len(other.curve(name)[0]) for other in others)


def _difference(curves: Curves, reference: Curves, column: str) -> Difference | None:
    """The difference in a column; None where both share no time."""
    one, other = curves.curve(column), reference.curve(column)
    if not len(one[0]) or not len(other[0]):
        return None
    start, end = max(one[0][0], other[0][0]), min(one[0][-1], other[0][-1])
    near, far = _within(one, start, end), _within(other, start, end)
    instants = near[0] if 0 < len(near[0]) < len(far[0]) or not len(far[0]) else far[0]
    if not len(instants):
        return None
    values = np.interp(instants, *other)
    d = np.interp(instants, *one) - values
    worst = int(np.argmax(np.abs(d)))
    largest = float(d[worst])
    rms = abs(largest) * float(np.sqrt(np.mean((d / largest) ** 2))) if largest else 0.0
    extent = float(np.ptp(far[1])) if len(far[1]) else 0.0
    peaks = [_peak(*some) for some in (near, far)]
    return Difference(
        label=curves.label,
        column=column,
        unit=reference.table.units[column],
        instants=len(instants),
        start=float(start),
        end=float(end),
        rms=rms,
        share=rms / extent if extent > 0.0 else float("nan"),
        mean=float(np.mean(d)),
        largest=largest,
        largest_time=float(instants[worst]),
        peak=peaks[0][1],
        peak_time=peaks[0][0],
        reference_peak=peaks[1][1],
        reference_peak_time=peaks[1][0],
    )


def _within(curve: tuple[Floats, Floats], start: float, end: float) -> tuple[Floats, Floats]:
    """The samples from `start` to `end` [s]."""
    inside = (curve[0] >= start) & (curve[0] <= end)
    return curve[0][inside], curve[1][inside]


def _peak(time: Floats, values: Floats) -> tuple[float, float]:
    """Time [s] and value of the largest magnitude; NaN without samples."""
    if not len(time):
        return float("nan"), float("nan")
    k = int(np.argmax(np.abs(values)))
    return float(time[k]), float(values[k])
