"""A run that is read at instants, with the processor time that it takes."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Sequence

import numpy as np
from membrane_rs import Simulation, UnstableError
from membrane_rs._arrays import Floats

PROGRESS = 60.0
"""Processor time between reports [s]."""


def followed(
    sim: Simulation,
    label: str,
    instants: Iterable[float],
    read: Callable[[], Sequence[float]],
    names: Sequence[str],
    *,
    budget: float = math.inf,
) -> dict[str, Floats]:
    """What is read at instants [s], by names, and "seconds", the processor time up to each.

    There are fewer where the run is stopped, or has taken its budget of processor time [s].
    """
    rows: list[tuple[float, ...]] = []
    seconds, reported = 0.0, 0.0
    try:
        for instant in instants:
            began = time.thread_time()
            sim.reach(instant)
            seconds += time.thread_time() - began
            rows.append((*read(), seconds))
            if seconds > reported + PROGRESS:
                reported = seconds
                print(f"{label}: {sim.time:.3f} s in {seconds:.0f} s", flush=True)
            if seconds >= budget:
                break
    except UnstableError as error:
        print(f"{label}: {error}", flush=True)
    keys = (*names, "seconds")
    return dict(zip(keys, np.array(rows).reshape(-1, len(keys)).T, strict=True))
