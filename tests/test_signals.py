"""Signals that end a batch job, or close a terminal, end a run as Ctrl-C does: its state is kept, and it is resumed."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import pytest
from child_processes import SECONDS, started, wait_until
from fake_simulation import summary
from membrane_rs import Simulation, scenes
from membrane_rs.errors import Interrupted
from membrane_rs.results.state import State
from membrane_rs.runs import signals
from numpy.testing import assert_array_equal
from observers import At
from small_scenes import hanging_strip

COMMAND = [sys.executable, "-m", "membrane_rs.cli"]
SCENE = scenes.load("single-crease")
ENDING = pytest.mark.parametrize(
    "number",
    [
        signal.SIGINT,
        signal.SIGTERM,
        signal.SIGHUP,
        signal.SIGXCPU,
        signal.SIGUSR1,
        signal.SIGUSR2,
    ],
    ids=lambda n: str(n.name),
)


@ENDING
def test_a_command_ends_by_a_signal_as_by_ctrl_c(tmp_path: Path, number: signal.Signals) -> None:
    words = [*COMMAND, "run", "okuizumi-model-1", "--until", "1000", "--no-pictures", "--out", str(tmp_path / "run")]
    with started(words, stderr=subprocess.PIPE, text=True) as process:
        wait_until((tmp_path / "run" / "frames.pvd").exists, "a frame is written", process)
        process.send_signal(number)
        _, shown = process.communicate(timeout=SECONDS)
    assert process.returncode == 128 + number
    assert "Traceback" not in shown
    assert f"Continue with: membrane-rs resume {tmp_path / 'run'}" in " ".join(shown.split())
    found = summary(tmp_path / "run")
    assert (found["outcome"], found["signal"]) == ("interrupted", number.name)
    assert Simulation.restore(tmp_path / "run" / "state.npz").time == found["time"]


def test_an_ignored_signal_stays_ignored(tmp_path: Path) -> None:
    code = "import signal, sys; signal.signal(signal.SIGHUP, signal.SIG_IGN); sys.argv[0] = 'membrane-rs'; "
    code += "from membrane_rs.cli import main; main()"
    words = [sys.executable, "-c", code, "run", "single-crease", "--no-pictures", "--out", str(tmp_path / "run")]
    with started(words) as process:
        wait_until((tmp_path / "run" / "frames.pvd").exists, "a frame is written", process)
        process.send_signal(signal.SIGHUP)
        assert process.wait(SECONDS) == 0
    assert summary(tmp_path / "run")["outcome"] == "finished"


def test_while_the_start_is_relaxed(tmp_path: Path) -> None:
    text = hanging_strip().to_toml().replace("relax = 0.0", "relax = 1e6")
    (tmp_path / "scene.toml").write_text(text, encoding="utf-8")
    words = [*COMMAND, "run", str(tmp_path / "scene.toml"), "--until", "0.01", "--out", str(tmp_path / "run")]
    with started(words, stderr=subprocess.PIPE, text=True) as process:
        wait_until((tmp_path / "run" / "summary.json").exists, "a summary is written", process)
        process.send_signal(signal.SIGTERM)
        assert process.wait(SECONDS) == 143
    assert summary(tmp_path / "run")["outcome"] == "interrupted"
    assert not Simulation.restore(tmp_path / "run" / "state.npz").is_relaxed


def test_while_pictures_are_drawn(tmp_path: Path) -> None:
    # The signal is sent by the process itself, as it begins to draw the last of its pictures.
    code = "import signal, sys; from membrane_rs.plotting.animation import Animation; draw = Animation.finish; "
    code += "Animation.finish = lambda *words: signal.raise_signal(signal.SIGTERM) or draw(*words); "
    code += "sys.argv[0] = 'membrane-rs'; from membrane_rs.cli import main; main()"
    run = ["run", "single-crease", "--until", "0.02", "--frames", "3", "--out", str(tmp_path / "run")]
    assert subprocess.run([sys.executable, "-c", code, *run], check=False, timeout=SECONDS).returncode == 143
    assert any((tmp_path / "run" / "snapshots").glob("*.png"))
    found = summary(tmp_path / "run")
    assert (found["outcome"], found["signal"]) == ("interrupted", "SIGTERM")
    assert not (tmp_path / "run" / "animation.gif").exists()
    assert subprocess.run([*COMMAND, "resume", str(tmp_path / "run")], check=False).returncode == 0
    assert (tmp_path / "run" / "animation.gif").is_file()
    assert summary(tmp_path / "run")["outcome"] == "finished"


def test_a_signal_in_a_finalizer_is_not_lost() -> None:
    class Finalised:
        def __del__(self) -> None:
            signal.raise_signal(signal.SIGTERM)

    @signals.interruptible()
    def run() -> None:
        Finalised()
        wait_until(lambda: False, "the signal is raised")

    with pytest.raises(Interrupted, match="SIGTERM"):
        run()


@ENDING
def test_in_python_the_run_can_go_on(tmp_path: Path, number: signal.Signals) -> None:
    whole, sim = Simulation(SCENE), Simulation(SCENE)
    whole.run(0.02, frames=9)
    before = signal.getsignal(number)
    with pytest.raises(Interrupted, match=number.name) as caught:
        sim.run(0.02, frames=9, out=tmp_path / "run", observers=[At(4, lambda: signal.raise_signal(number))])
    assert isinstance(caught.value, KeyboardInterrupt)
    assert caught.value.signum == number
    assert signal.getsignal(number) is before
    assert 0.0 < sim.time < 0.02
    sim.run(0.02, frames=9)
    assert_array_equal(sim.positions, whole.positions)


def test_a_second_signal_while_the_run_ends_loses_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    finish = State.finish

    def impatient(self: State, *words: Any) -> None:
        for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP):
            signal.raise_signal(number)
        finish(self, *words)

    monkeypatch.setattr(State, "finish", impatient)
    sim = Simulation(SCENE)
    with pytest.raises(Interrupted, match="SIGTERM"):
        sim.run(0.02, frames=9, out=tmp_path / "run", observers=[At(4, lambda: signal.raise_signal(signal.SIGTERM))])
    assert Simulation.restore(tmp_path / "run" / "state.npz").time == sim.time
    assert summary(tmp_path / "run")["signal"] == "SIGTERM"


def test_a_signal_as_the_run_ends_is_raised_when_all_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    finish = State.finish

    def late(self: State, *words: Any) -> None:
        signal.raise_signal(signal.SIGTERM)
        finish(self, *words)

    monkeypatch.setattr(State, "finish", late)
    with pytest.raises(Interrupted):
        Simulation(SCENE).run(0.01, frames=3, out=tmp_path / "run", pictures=False)
    assert summary(tmp_path / "run")["outcome"] == "finished"


def test_ctrl_c_twice_ends_an_observer_that_does_not_return() -> None:
    def never() -> None:
        signal.raise_signal(signal.SIGINT)
        signal.raise_signal(signal.SIGINT)
        time.sleep(SECONDS)

    began = time.monotonic()
    with pytest.raises(Interrupted):
        Simulation(SCENE).run(0.02, frames=9, observers=[At(4, never)])
    assert time.monotonic() - began < SECONDS / 2


def test_a_handler_of_the_program_is_kept() -> None:
    seen: list[int] = []
    before = signal.signal(signal.SIGTERM, lambda number, _: seen.append(number))
    try:
        Simulation(SCENE).run(0.01, frames=9, observers=[At(4, lambda: signal.raise_signal(signal.SIGTERM))])
    finally:
        signal.signal(signal.SIGTERM, before)
    assert seen == [signal.SIGTERM]


def test_a_run_in_another_thread_touches_no_handler() -> None:
    found: list[Any] = []

    def run() -> None:
        look = At(2, lambda: found.append(signal.getsignal(signal.SIGTERM)))
        Simulation(SCENE).run(0.005, frames=3, observers=[look])

    thread = threading.Thread(target=run)
    thread.start()
    thread.join(SECONDS)
    assert found == [signal.getsignal(signal.SIGTERM)]


def test_held_and_released() -> None:
    seen = list[str]()

    def run() -> None:
        with signals.interruptible(), signals.held():
            os.kill(os.getpid(), signal.SIGTERM)
            with signals.held():
                seen.append("held")
            seen.append("still held")
            with signals.released():
                seen.append("not here")

    with pytest.raises(Interrupted, match="SIGTERM"):
        run()
    assert seen == ["held", "still held"]


def test_further_signals_change_nothing_and_handlers_are_put_back() -> None:
    before = {number: signal.getsignal(number) for number in signals.ENDING}
    seen = list[str]()

    def run() -> None:
        with signals.interruptible():
            try:
                signal.raise_signal(signal.SIGTERM)
            finally:
                signal.raise_signal(signal.SIGINT)
                seen.append("ended in peace")

    with pytest.raises(Interrupted, match="SIGTERM"):
        run()
    assert seen == ["ended in peace"]
    assert {number: signal.getsignal(number) for number in signals.ENDING} == before


def test_a_signal_that_comes_while_handlers_are_put_back_is_raised(monkeypatch: pytest.MonkeyPatch) -> None:
    put, seen = signal.signal, list[int]()

    def late(number: int, handler: Any) -> Any:
        if handler in signals.DEFAULTS and not seen:
            seen.append(number)
            signal.raise_signal(signal.SIGTERM)
        return put(number, handler)

    def run() -> None:
        with signals.interruptible():
            monkeypatch.setattr(signal, "signal", late)

    with pytest.raises(Interrupted, match="SIGTERM"):
        run()
    assert seen
