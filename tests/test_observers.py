"""Observers are told what a run does, and all of them how it ended."""

from __future__ import annotations

import numpy as np
import pytest
from membrane_rs import Simulation, UnstableError, scenes

SCENE = scenes.load("single-crease")


def test_a_run_that_stops_itself_tells_its_observers() -> None:
    seen: list[str] = []

    class Recorder:
        def start(self, sim: Simulation) -> None:
            seen.append("start")

        def sample(self, sim: Simulation) -> None:
            assert np.isfinite(sim.positions).all()
            seen.append("sample")

        def frame(self, sim: Simulation) -> None:
            seen.append("frame")

        def finish(self, sim: Simulation, error: BaseException | None) -> None:
            seen.append(type(error).__name__)

    with pytest.raises(UnstableError):
        Simulation(SCENE, dt=2 * Simulation(SCENE).stable_dt()).run(observers=[Recorder()])
    assert seen[:3] == ["start", "sample", "frame"]
    assert seen[-3:] == ["sample", "frame", "UnstableError"]


class Finisher:
    """An observer that notes how it was told the end, and may fail at the start or at the end."""

    def __init__(self, seen: list[tuple[str, str]], name: str, start: str = "", finish: str = "") -> None:
        self._seen, self._name, self._start, self._finish = seen, name, start, finish

    def start(self, sim: Simulation) -> None:
        if self._start:
            raise OSError(self._start)

    def sample(self, sim: Simulation) -> None: ...

    def frame(self, sim: Simulation) -> None: ...

    def finish(self, sim: Simulation, error: BaseException | None) -> None:
        self._seen.append((self._name, str(error)))
        if self._finish:
            raise ValueError(self._finish)


def test_all_observers_finish_where_one_of_them_fails() -> None:
    seen: list[tuple[str, str]] = []
    first, second, third = Finisher(seen, "a"), Finisher(seen, "b", finish="no room"), Finisher(seen, "c")
    with pytest.raises(ValueError, match="no room"):
        Simulation(SCENE).run(0.001, observers=[first, second, third])
    assert seen == [("a", "None"), ("b", "None"), ("c", "None")]


def test_observers_that_have_started_finish_where_another_cannot_start() -> None:
    seen: list[tuple[str, str]] = []
    with pytest.raises(OSError, match="no room"):
        Simulation(SCENE).run(0.001, observers=[Finisher(seen, "a"), Finisher(seen, "b", start="no room")])
    assert seen == [("a", "no room")]
