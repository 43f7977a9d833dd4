"""Observers that several tests give to a run."""

from __future__ import annotations

from collections.abc import Callable

from membrane_rs import Simulation


class At:
    """An observer that acts at its `count`-th frame."""

    def __init__(self, count: int, act: Callable[[], object]) -> None:
        self._left, self._act = count, act

    def start(self, sim: Simulation) -> None: ...

    def sample(self, sim: Simulation) -> None: ...

    def frame(self, sim: Simulation) -> None:
        self._left -= 1
        if self._left == 0:
            self._act()

    def finish(self, sim: Simulation, error: BaseException | None) -> None: ...
