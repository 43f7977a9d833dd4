"""A sweep on a cluster of dask: scheduler and workers are processes, and one worker is killed in the middle."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from child_processes import SECONDS, wait_until
from membrane_rs import ExecutorError, InputError, scenes
from membrane_rs.cli import app
from membrane_rs.runs import Simulation
from membrane_rs.study import open_sweep, sweep
from membrane_rs.study.common.cluster import check_workers, cluster
from membrane_rs.study.common.one_run import RunResult
from small_scenes import refused
from typer.testing import CliRunner

Client = pytest.importorskip("distributed").Client

BEGUN = "MEMBRANE_RS_TEST_BEGUN"
"""The environment variable of the folder in which workers note the runs that they begin."""
HELD = "MEMBRANE_RS_TEST_HELD"
"""The environment variable of a worker that comes to the end of no run that it notes: until it is killed."""
VARY = {"laws.spin.frequency": [1.0, 1.5, 2.0, 2.5]}


@dataclass
class Cluster:
    """Address of the scheduler, workers, and the folder of their notes."""

    address: str
    workers: list[subprocess.Popen[bytes]]
    folder: Path


def noted(folder: Path) -> dict[str, int]:
    """The process that has begun a run, by the name of its note."""
    return {file.name: int(file.name.partition("-")[0]) for file in folder.glob("[0-9]*-*")}


def begun(sim: Simulation) -> float:
    """Notes by which process a run is begun."""
    if sim.time == 0.0:
        (Path(os.environ[BEGUN]) / f"{os.getpid()}-{time.monotonic_ns()}").touch()
        if HELD in os.environ:
            time.sleep(1e6)
    return sim.time


@pytest.fixture(scope="module")
def processes(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cluster]:
    """The address of a scheduler, and two workers of one thread each; all of them end with the tests."""
    folder = tmp_path_factory.mktemp("cluster")
    file, started = folder / "scheduler.json", []
    here = {**os.environ, "PYTHONPATH": str(Path(__file__).parent), BEGUN: str(folder)}
    quiet: Any = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "env": here, "cwd": folder}

    def start(command: str, *words: str) -> subprocess.Popen[bytes]:
        line = [sys.executable, "-m", "distributed.cli." + command, "--scheduler-file", str(file), "--no-dashboard"]
        started.append(subprocess.Popen([*line, *words], **quiet))
        return started[-1]

    try:
        start("dask_scheduler", "--host", "127.0.0.1", "--port", "0")
        workers = []
        for name, more in (("a", {HELD: "1"}), ("b", {})):
            here.update(more)
            workers.append(start("dask_worker", "--nthreads", "1", "--no-nanny", "--name", name))
            here.pop(HELD, None)
        wait_until(lambda: file.is_file() and file.read_text().endswith("}"), "the scheduler has begun", started[0])
        address = json.loads(file.read_text())["address"]
        with Client(address, timeout=SECONDS, set_as_default=False) as client:
            client.wait_for_workers(len(workers), timeout=SECONDS)  # one that is killed is to have begun a run
        yield Cluster(address, workers, folder)
    finally:
        for process in reversed(started):
            process.kill()
        for process in started:
            process.wait()


def loops() -> int:
    """Threads of clients of this process."""
    return sum(thread.name == "IO loop" for thread in threading.enumerate())


def rows(found: Any) -> list[dict[str, Any]]:
    return [{name: value for name, value in row.items() if name != "wall_time"} for row in found.rows]


def test_the_command_on_a_cluster(processes: Cluster, tmp_path: Path) -> None:
    words = ["sweep", "spinning-tether", "--vary", "laws.spin.frequency=1,2", "--until", "1ms", "--samples", "3"]
    made = CliRunner().invoke(app, [*words, "--dask", processes.address, "--out", str(tmp_path / "out")])
    assert made.exit_code == 0, made.output
    assert "2 of 2 runs: 2 finished" in made.output


def test_a_killed_worker_loses_no_run_and_makes_none_twice(
    processes: Cluster, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    address, workers = processes.address, processes.workers
    (tmp_path / "here").mkdir()
    options: dict[str, Any] = {"starts": 3, "until": 0.02, "samples": 21, "record": {"begun": (begun, "s")}}

    def kill(done: int, total: int, result: RunResult) -> None:
        assert (total, result.outcome) == (12, "finished")
        if done == 3:
            wait_until(lambda: workers[0].pid in noted(processes.folder).values(), "the other worker has begun a run")
            workers[0].send_signal(signal.SIGKILL)

    with cluster(address) as executor:
        found = sweep(
            "spinning-tether", VARY, out=tmp_path / "out", table="csv", executor=executor, progress=kill, **options
        )
        notes = noted(processes.folder)
    assert workers[0].wait() == -signal.SIGKILL
    # Both have begun runs, and more were begun than there are: one was cut off, and made again by the other.
    assert set(notes.values()) == {worker.pid for worker in workers}
    assert len(notes) > 12
    assert [(row["run"], row["outcome"]) for row in found.rows] == [(k, "finished") for k in range(12)]
    assert len(list((tmp_path / "out" / "runs").iterdir())) == 12
    assert len((tmp_path / "out" / "table.csv").read_text().splitlines()) == 13
    monkeypatch.setenv(BEGUN, str(tmp_path / "here"))
    assert rows(found) == rows(sweep("spinning-tether", VARY, **options)) == rows(open_sweep(tmp_path / "out"))


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:1", "nowhere", "tcp://", "http://["])
def test_no_scheduler(address: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("membrane_rs.study.common.cluster.SECONDS", 0.5)

    def connected() -> None:
        with cluster(address):
            pass

    before = loops()
    refused(connected, InputError, "no scheduler answers there")
    # A client that is left to the garbage collector may close while another one starts, and then neither comes to an
    # end. One that was refused is closed, but for its thread.
    assert loops() - before <= int(address.endswith(":1"))


@pytest.mark.parametrize("address", ["", " ", None, 8786])
def test_no_address(address: Any) -> None:
    """Of an empty one distributed would make a cluster on this machine."""
    with (
        pytest.raises(InputError, match=r"is no address of a scheduler; start one with `dask scheduler`"),
        cluster(address),
    ):
        pass


@pytest.mark.parametrize(
    ("found", "words"),
    [("0.0.1", "the worker tcp://a has membrane_rs 0.0.1"), (ImportError("no"), r"has no membrane_rs \(no\)")],
)
def test_workers_of_another_version(found: object, words: str) -> None:
    class Client:
        def run(self, function: Any, **_: Any) -> dict[str, Any]:
            return {"tcp://b": function(), "tcp://a": found}

    refused(lambda: check_workers(Client()), ExecutorError, words)


def test_a_scheduler_that_ends_before_the_runs_do(monkeypatch: pytest.MonkeyPatch) -> None:
    class Client:
        status = "running"
        run = staticmethod(lambda function, **_: {"tcp://a": function()})
        get_executor = staticmethod(lambda: "executor")

        def __init__(self, *_: Any, **__: Any) -> None:
            pass

        def __enter__(self) -> Client:
            return self

        def __exit__(self, *_: object) -> None:
            pass

    def used(status: str) -> None:
        with cluster("tcp://a:1"):
            Client.status = status
            raise ExecutorError("takes no more runs")

    monkeypatch.setattr("distributed.Client", Client)
    refused(lambda: used("closed"), ExecutorError, "the scheduler at tcp://a:1 is gone; runs that are done are in the")
    with pytest.raises(ExecutorError, match=r"^takes no more runs$"):
        used("running")


def test_scenes_are_sent_small() -> None:
    from membrane_rs.study.common.one_run import packed

    assert len(packed(scenes.load("okuizumi-model-1"))) < 10**5
