"""What a run was asked for: kept in its folder, so that it can be resumed from there alone."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs._validation import number_of, show
from membrane_rs._warning import warn
from membrane_rs.errors import InputError, InputTypeError, OutputError
from membrane_rs.scene import Scene
from membrane_rs.scene.run_settings import MOST_INSTANTS
from membrane_rs.scene.stage import MEASURES
from membrane_rs.simulation.output_times import SAME_TIME, output_times, with_boundaries

CHECKPOINT = 10.0
"""Seconds of wall time between two checkpoints, unless the caller says otherwise."""
Instants = int | Sequence[float]
"""How many, evenly spaced from time 0 to the end, or their times [s]."""


_WHERE_GIVEN = ("every", "record", "known", "stop")
"""What a table of a request leaves out where it is empty."""


@dataclass(frozen=True)
class Request:
    """Until when a run goes [s], at which instants it shows frames and samples, and what is written beside those."""

    until: float
    frames: Instants
    samples: Instants
    pictures: bool = True
    crossings: bool = False
    checkpoint: float = CHECKPOINT
    every: float | None = None
    """Interval between two samples [s], in place of their number."""
    record: Mapping[str, str] = field(default_factory=dict)
    """Units of the measures that are recorded, by their names."""
    known: Sequence[str] = ()
    """Those of them that are no functions of a user."""
    stop: str | Mapping[str, Any] | None = None
    """What may end the run before its time; of a function its name alone."""

    def __post_init__(self) -> None:
        """Lists and arrays of times as plain lists."""
        for name in ("frames", "samples"):
            object.__setattr__(self, name, _plain(getattr(self, name), name))
        seconds = number_of("checkpoint", self.checkpoint)
        if seconds < 0:
            raise InputError(f"checkpoint = {seconds}: must be at least 0 (s of wall time between two checkpoints)")
        object.__setattr__(self, "checkpoint", seconds)
        if self.every is not None:
            object.__setattr__(self, "every", _interval(self.every, self.until))
        if not isinstance(self.record, Mapping) or not all(isinstance(unit, str) for unit in self.record.values()):
            raise InputTypeError(f"record = {show(self.record)}: must be a table of names and units")
        recorded = set(self.record) & set(MEASURES)
        if not isinstance(self.known, Sequence) or not recorded.issuperset(self.known):
            raise InputTypeError(f"known = {show(self.known)}: must be names of known measures that are recorded")
        if not isinstance(self.stop, str | Mapping | None):
            raise InputTypeError(f"stop = {show(self.stop)}: must be a text or a table")

    @property
    def sample_times(self) -> Instants:
        """The samples, as a run takes them."""
        if self.every is None:
            return self.samples
        count = math.floor(self.until / self.every * (1.0 + SAME_TIME))
        return [float(f"{k * self.every:.12g}") for k in range(count + 1)]

    @property
    def frame_times(self) -> Instants:
        """The frames, as a run takes them. Each is a sample too, so that with an interval between samples those that
        are evenly spaced stand at the nearest sample.
        """
        if self.every is None or not isinstance(self.frames, int) or not 2 <= self.frames <= MOST_INSTANTS:
            return self.frames
        return [*self._at_samples(np.linspace(0.0, self.until, self.frames)[:-1], self.until), self.until]

    def instants(self, scene: Scene) -> dict[str, Any]:
        """Frames, samples and snapshots, as a run takes them. With an interval between samples the pictures are of
        samples.
        """
        snapshots = scene.run.snapshots if self.every is None else ()
        return {"frames": self.frame_times, "samples": self.sample_times, "snapshots": snapshots}

    def _at_samples(self, times: Sequence[float] | Floats, until: float) -> list[float]:
        """Times before `until` [s] moved to the nearest multiple of the interval between samples, each once."""
        every = self.every or 1.0
        counts = np.unique(np.rint(np.asarray(times) / every)).tolist()
        moved = [float(f"{count * every:.12g}") for count in counts]
        return [time for time in moved if time < until * (1.0 - SAME_TIME)]

    @classmethod
    def of(cls, summary: Mapping[str, Any], where: str) -> Request:
        """What a summary says. Raises OutputError, which names `where`."""
        try:
            return cls(**summary["request"])
        except (KeyError, TypeError, ValueError) as error:
            raise OutputError(
                f"{where} does not say what the run was asked for ({type(error).__name__}: {error}); continue its "
                "state.npz into a folder of its own, or run the scene again"
            ) from None

    def as_table(self) -> dict[str, Any]:
        """The same as a table."""
        table = asdict(self)
        return {name: value for name, value in table.items() if value or name not in _WHERE_GIVEN}

    def output_times(self, start: float, scene: Scene, starts: Sequence[float] = ()) -> dict[float, bool]:
        """The instants [s] that a run from `start` on shows, and whether each is a frame. `starts` are those of the
        stages so far, all but the first of them boundaries, at which a frame is shown.

        Raises InputError and InputTypeError for instants that are none.
        """
        times = output_times(start, self.until, **self.instants(scene), stages=scene.stages, starts=starts)
        return with_boundaries(times, [bound for bound in starts[1:] if bound >= start])

    def warn_of_unshown(self, now: float) -> None:
        """Warn of given times [s] that lie outside the run from `now` to its end, and so are not shown."""
        first, last = now - SAME_TIME * abs(now), self.until + SAME_TIME * abs(self.until)
        for name in ("frames", "samples"):
            times = getattr(self, name)
            for place, left_out in (
                (f"before the time now, {now:.6g} s", [time for time in _listed(times) if time < first]),
                (f"after until = {self.until:.6g} s", [time for time in _listed(times) if time > last]),
            ):
                if left_out:
                    what = f"{name}: {len(left_out)} of the times lie {place}, and are left out: {left_out[0]} s"
                    warn(what)

    def warn_of_fewer(self, asked: object) -> None:
        """Warn of frames, if a caller has asked for them, that are more than the samples at an interval, and so are not
        all shown.
        """
        if asked is None:
            return
        shown = self.frame_times
        if isinstance(self.frames, int) and not isinstance(shown, int) and len(shown) < self.frames:
            what = f"a frame is a sample, of which every = {self.every} s gives fewer; {len(shown)} are kept"
            warn(f"frames = {self.frames}: {what}")

    def until_later(self, until: float) -> Request:
        """The same to another end: instants after the old one continue with the spacing before it.

        A list of times is not continued; an end is an instant always.
        """
        frames = self._extended(self.frames, until)
        if self.every is not None and isinstance(self.frames, int):
            later = self._at_samples([time for time in frames if self.until < time < until], until)
            known = [time for time, _ in output_times(0.0, self.until, self.frame_times, [], []) if time < until]
            frames = [*known, *(time for time in later if time > self.until), until]
        return replace(self, until=until, frames=frames, samples=self._extended(self.samples, until))

    def _extended(self, instants: Instants, until: float) -> list[float]:
        known = [time for time, _ in output_times(0.0, self.until, instants, [], [])]
        after: list[float] = []
        if isinstance(instants, int):
            spacing = self.until / (instants - 1)
            count = (until - self.until) / spacing
            if count > MOST_INSTANTS:
                raise InputError(f"until = {until} s: that is {count:.1e} instants; give an earlier time")
            after = [float(f"{self.until + k * spacing:.12g}") for k in range(1, int(count + 1e-9) + 1)]
        return [time for time in (*known, *after) if time < until] + [until]


def _interval(every: Any, until: float) -> float:
    """An interval between samples [s], checked."""
    seconds = number_of("every", every)
    if seconds <= 0.0:
        raise InputError(f"every = {seconds} s: must be above 0, such as 1e-3 (s between two samples)")
    if until / seconds > MOST_INSTANTS:
        raise InputError(f"every = {seconds} s: that is {until / seconds:.1e} samples; give a longer interval")
    return seconds


def _listed(instants: Any) -> list[float]:
    """Times where they are given one by one."""
    return instants if isinstance(instants, list) else []


def _plain(instants: Any, name: str) -> Any:
    """Times as a list of floats, a number as Python's; anything else as it is, for `march` to check."""
    is_scalar = isinstance(instants, np.ndarray) and instants.ndim == 0
    if isinstance(instants, Sequence | np.ndarray) and not isinstance(instants, str | bytes) and not is_scalar:
        if len(instants) > MOST_INSTANTS:
            raise InputError(f"{name} = {show(instants)}: must be at most {MOST_INSTANTS} times")
        return [number_of(name, time) for time in instants]
    return int(instants) if isinstance(instants, np.integer) else instants
