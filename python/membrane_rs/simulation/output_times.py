"""The times at which a run calls its observers."""

from __future__ import annotations

import operator
from collections.abc import Sequence

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs._validation import number_of, show
from membrane_rs.errors import InputError, InputTypeError
from membrane_rs.scene.run_settings import MOST_INSTANTS
from membrane_rs.scene.stage import Stage

SAME_TIME = 1e-12
"""Times that differ by less than this share are one."""


def output_times(
    now: float,
    end: float,
    frames: int | Sequence[float],
    samples: int | Sequence[float],
    snapshots: Sequence[float],
    *,
    stages: Sequence[Stage] = (),
    starts: Sequence[float] = (),
) -> list[tuple[float, bool]]:
    """Times [s] from `now` to `end`, both among them, and whether each is that of a frame.

    Parameters
    ----------
    now, end : float
        Time now and at the end [s]; both are frames.
    frames, samples : int or sequence of float
        How many, evenly spaced from time 0 to the end, or their times [s]. Those outside the run are left out.
    snapshots : sequence of float
        Further times [s], of no frame.
    stages : sequence of Stage
        Of the scene: those with frames or samples of their own have these in place of the ones above.
    starts : sequence of float
        When the first of the stages began [s], as many as are known; the others are taken to begin as planned.

    Raises
    ------
    InputTypeError, InputError
        Neither a whole number nor a list of times; fewer than 2, or more than 10^7.
    """
    # By rank: of times that are one, the first of the lowest rank is taken.
    lists = [(np.array([now, end]), True), (np.array([number_of("snapshots", t) for t in snapshots]), False)]
    spans = _spans(stages, starts)
    for name, wanted, is_frame in (("frames", frames, True), ("samples", samples, False)):
        lists.append((_times_of_stages(_times_of(wanted, end, name), spans, name), is_frame))
    times = np.concatenate([times for times, _ in lists]).astype(np.float64)
    flags = np.concatenate([np.full(len(times), flag) for times, flag in lists])
    rank = np.arange(len(times))
    inside = (times >= now) & (times <= end)
    times, flags, rank = times[inside], flags[inside], rank[inside]
    order = np.argsort(times, kind="stable")
    times, flags, rank = times[order], flags[order], rank[order]
    first = np.flatnonzero(np.r_[True, np.diff(times) > SAME_TIME * np.abs(times[1:])])
    best = np.minimum.reduceat(rank, first)
    chosen = times[np.isin(rank, best)]
    return list(zip(chosen.tolist(), np.logical_or.reduceat(flags, first).tolist(), strict=True))


def is_same_time(one: float, other: float) -> bool:
    """Whether two times [s] are one."""
    return abs(one - other) <= SAME_TIME * abs(one)


def with_boundaries(times: Sequence[tuple[float, bool]], boundaries: Sequence[float]) -> dict[float, bool]:
    """Output times with the boundaries [s] of stages among them, each of them a frame, and in place of what is the
    same time.
    """
    left = [(time, flag) for time, flag in times if not any(is_same_time(time, bound) for bound in boundaries)]
    return dict(sorted([*left, *((bound, True) for bound in boundaries)]))


def _spans(stages: Sequence[Stage], starts: Sequence[float]) -> list[tuple[Stage, float, float]]:
    """Each stage with its start and its end [s]: those that are known, and else as planned."""
    bounds = list(starts) or [0.0]
    for stage in stages[len(bounds) - 1 :]:
        bounds.append(bounds[-1] + stage.duration)
    return list(zip(stages, bounds, bounds[1:], strict=False))


def _times_of_stages(times: Floats, spans: Sequence[tuple[Stage, float, float]], name: str) -> Floats:
    """Times of a run [s], in each stage that has a number of its own in place of those inside it.

    They follow from its start alone, so that they are the same once it is over.
    """
    for stage, start, end in spans:
        count = getattr(stage, name)
        if count is not None:
            own = start + np.linspace(0.0, stage.duration, count)
            own = np.array([float(f"{time:.12g}") for time in own[1:-1]])
            kept = times[(times < start) | (times > end)]
            times = np.concatenate([kept, [start], own[(own > start) & (own < end)], [end]])
    return times


def _times_of(wanted: int | Sequence[float], end: float, name: str) -> Floats:
    """Given times, or evenly spaced ones; the latter to twelve digits, so that they are round where they should be."""
    is_scalar = isinstance(wanted, np.ndarray) and wanted.ndim == 0
    if isinstance(wanted, Sequence | np.ndarray) and not isinstance(wanted, str | bytes) and not is_scalar:
        return np.array([number_of(name, t) for t in wanted], dtype=np.float64)
    try:
        count = operator.index("" if isinstance(wanted, bool | np.bool_) else wanted)  # type: ignore[arg-type]
    except TypeError:
        raise InputTypeError(f"{name} = {show(wanted)}: must be a whole number or a list of times (s)") from None
    if not 2 <= count <= MOST_INSTANTS:
        raise InputError(f"{name} = {show(count)}: must be from 2 to {MOST_INSTANTS}, or a list of times (s)")
    return np.array([*(float(f"{time:.12g}") for time in np.linspace(0.0, end, count)[:-1]), end])
