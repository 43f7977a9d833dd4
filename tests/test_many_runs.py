"""Many runs of one scene: the same bits wherever they are made, kept whole; a crash costs its own run alone."""

from __future__ import annotations

import json
import os
import sys
import threading
import time
from concurrent.futures import Future, ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from membrane_rs import ExecutorError, Gravity, InputError, Mesh, OutputError, Scene, Simulation, Tethers, scenes
from membrane_rs.study.common.kept_runs import REQUEST, differences, point_mark, read_run
from membrane_rs.study.common.many_runs import MOST_RUNS, ManyRuns, Where
from membrane_rs.study.common.one_run import RunPoint, RunResult, RunSetup
from membrane_rs.study.common.perturbation import SHIFT, perturbation
from small_scenes import cord, patch, refused

STIFFNESS = "parts.0.axial_stiffness"
POINTS = [RunPoint({STIFFNESS: value}, start) for value in (50.0, 100.0) for start in (0, 1)]
SETUP = RunSetup(until=0.05, samples=6)


def falling() -> Scene:
    """A mass on a spring, let go: some hundred steps."""
    return Scene(None, None, [Gravity((9.81, 0.0, 0.0))], [cord()], name="falling")


def stiffness(sim: Simulation) -> float:
    part: Any = sim.scene.parts[0]
    return float(part.axial_stiffness)


def dies_at_fifty(sim: Simulation) -> float:
    """As a fault of the memory does: without an error."""
    if stiffness(sim) == 50.0:
        os._exit(9)
    return sim.time


FIRST = "MEMBRANE_RS_TEST_FIRST"
"""The environment variable of a file that is there once a run has died."""


def dies_once(sim: Simulation) -> float:
    file = Path(os.environ[FIRST])
    if not file.exists():
        file.touch()
        os._exit(9)
    return sim.time


def ends_itself(sim: Simulation) -> float:
    return 1.0 / (stiffness(sim) - 50.0)


def bits(result: RunResult) -> dict[str, Any]:
    """All that a run has shown but for its wall time."""
    row = {name: value for name, value in result.row().items() if name != "wall_time"}
    return row | {name: column.tobytes() for name, column in result.history.items()}


@pytest.fixture(scope="module")
def reference() -> list[RunResult]:
    with ManyRuns(falling(), SETUP, jobs=1) as runs:
        return runs.all_results(POINTS)


def test_a_run_is_the_simulation_of_its_scene(reference: list[RunResult]) -> None:
    sim = Simulation(replace(falling(), parts=[cord(axial_stiffness=50.0)]))
    sim.run(0.05, frames=2)
    row = reference[0].row()
    assert (row[STIFFNESS], row["start"], row["outcome"], row["message"]) == (50.0, 0, "finished", "")
    assert (row["time"], row["steps"], row["dt"]) == (0.05, sim.step_count, sim.dt)
    assert row["final_kinetic_energy"] == sim.energies()["kinetic"]
    assert reference[0].history["time"] == pytest.approx(np.linspace(0.0, 0.05, 6), abs=1e-15)


def test_starts_but_the_first_are_perturbed(reference: list[RunResult]) -> None:
    own, other = (result.history["kinetic_energy"] for result in reference[:2])
    assert 0.0 < np.abs(other - own).max() < 1e-9
    sim = Simulation(falling().with_values(POINTS[1].values))
    sim.positions = sim.positions + perturbation(sim.scene, 0)
    sim.run(0.05, frames=2)
    assert reference[1].facts["final_kinetic_energy"] == sim.energies()["kinetic"]
    shifts = perturbation(scenes.load("single-crease"), 3)
    held = scenes.load("single-crease").assemble().fixed
    free = np.delete(shifts, held, axis=0)
    assert len(held)
    assert not shifts[held].any()
    assert 0.7 * SHIFT < free.std() < 1.3 * SHIFT


class Backwards(ThreadPoolExecutor):
    """Makes the last task first."""

    def __init__(self) -> None:
        super().__init__(1)
        self._tasks: list[tuple[Future[Any], Any, Any]] = []
        self.hold = threading.Timer(0.2, self._begin)
        self.hold.start()

    def submit(self, fn: Any, /, *args: Any, **_: Any) -> Future[Any]:
        future: Future[Any] = Future()
        self._tasks.append((future, fn, args))
        return future

    def _begin(self) -> None:
        for future, fn, args in reversed(self._tasks):
            future.set_result(fn(*args))


@pytest.mark.parametrize("where", ["threads", "processes", "given threads", "given processes", "backwards"])
def test_bits_depend_on_no_executor_order_or_number(where: str, reference: list[RunResult]) -> None:
    context = get_context("spawn")
    made: dict[str, Any] = {
        "given threads": lambda: ThreadPoolExecutor(3),
        "given processes": lambda: ProcessPoolExecutor(2, context),
        "backwards": Backwards,
    }
    executor: Any = made[where]() if where in made else where
    with ManyRuns(falling(), SETUP, executor=executor, jobs=4) as runs:
        found = runs.all_results(POINTS)
    assert [bits(result) for result in found] == [bits(result) for result in reference]
    if not isinstance(executor, str):
        executor.shutdown()


def test_a_process_that_dies_costs_its_own_run_alone(tmp_path: Path) -> None:
    setup = replace(SETUP, record={"time_again": dies_at_fifty})
    with ManyRuns(falling(), setup, executor="processes", jobs=2, folder=tmp_path) as runs:
        found = runs.all_results(POINTS[::2])
    assert [result.outcome for result in found] == ["crashed", "finished"]
    assert "ended without a result" in found[0].message
    assert len(list(tmp_path.glob("runs/*.npz"))) == len(found)


def test_a_run_whose_process_died_is_made_once_more(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(FIRST, str(tmp_path / "first"))
    with ManyRuns(falling(), replace(SETUP, record={"odd": dies_once}), executor="processes", jobs=1) as runs:
        assert runs.all_results(POINTS[:1])[0].is_finished
    assert (tmp_path / "first").exists()


def test_what_fails_is_a_row_that_says_why() -> None:
    setup = replace(SETUP, record={"odd": ends_itself})
    points = [*POINTS[::2], RunPoint({STIFFNESS: -1.0}), RunPoint({"run.dt": 0.19}), RunPoint({"laws.creases.up": 1})]
    with ManyRuns(falling(), setup) as runs:
        found = runs.all_results(points)
    assert [result.outcome for result in found] == ["failed", "finished", "refused", "finished", "refused"]
    assert "raised ZeroDivisionError: float division by zero" in found[0].message
    assert found[1].facts["final_odd"] == 0.02
    assert "axial_stiffness = -1.0: must be" in found[2].message
    assert found[2].history == {}
    with ManyRuns(falling(), replace(SETUP, record={"odd": lambda _: sys.exit(3)})) as runs:
        assert [(one.outcome, one.message) for one in runs.all_results(POINTS[:2])] == [("failed", "SystemExit: 3")] * 2
    with ManyRuns(falling(), RunSetup(until=2.0, samples=6)) as runs:
        (unstable,) = runs.all_results([RunPoint({"run.dt": 0.29})])
    assert unstable.outcome == "unstable"
    assert unstable.message.startswith("stopped at t = ")
    assert unstable.history["time"][-1] == unstable.facts["time"]


def test_a_run_ends_at_its_limit_of_wall_time_and_may_be_made_again(tmp_path: Path) -> None:
    slow = RunSetup(until=1000.0, samples=3, time_limit=0.3)
    point = RunPoint({"run.dt": 1e-6})
    with ManyRuns(falling(), slow, folder=tmp_path) as runs:
        (found,) = runs.all_results([point])
    assert (found.outcome, "more than 0.3 s of wall time" in found.message) == ("time limit", True)
    assert 0.3 < (found.facts["wall_time"] or 0.0) < 300.0, "the run would take hours"
    for retry, least in ((False, 0.0), (True, 0.3)):
        began = time.perf_counter()
        with ManyRuns(falling(), slow, folder=tmp_path, retry=retry) as runs:
            assert runs.all_results([point])[0].outcome == "time limit"
        assert time.perf_counter() - began >= least


def test_runs_that_are_kept_are_read(tmp_path: Path, reference: list[RunResult]) -> None:
    with ManyRuns(falling(), SETUP, folder=tmp_path / "new" / "folder") as runs:
        runs.all_results(POINTS[:2])
        written = {path: path.stat().st_mtime_ns for path in (tmp_path / "new/folder/runs").iterdir()}
        again = runs.all_results(POINTS)
    assert [bits(result) for result in again] == [bits(result) for result in reference]
    assert all(path.stat().st_mtime_ns == at for path, at in written.items())
    assert len(list((tmp_path / "new/folder/runs").iterdir())) == len(POINTS)


def test_another_request_in_a_folder_is_refused_with_the_difference(tmp_path: Path) -> None:
    with ManyRuns(falling(), SETUP, folder=tmp_path, request={"kind": "sweep"}) as runs:
        runs.all_results(POINTS[:1])
    other = replace(falling(), parts=[cord(tip_mass=2.0)])

    def opened(scene: Scene, setup: RunSetup, **more: Any) -> None:
        with ManyRuns(scene, setup, folder=tmp_path, **more):
            pass

    words = r"parts\[0\].tip_mass = 1.0 there, 2.0 here; kind = 'sweep' there, not given here"
    refused(lambda: opened(other, SETUP), OutputError, words)
    refused(lambda: opened(falling(), replace(SETUP, samples=7), request={"kind": "sweep"}), OutputError, "samples = 6")
    assert len(list(tmp_path.glob("runs/*.npz"))) == 1
    (tmp_path / "notes.txt").write_text("mine")
    opened(other, SETUP, overwrite=True)
    assert not list(tmp_path.glob("runs/*.npz"))
    assert (tmp_path / "notes.txt").read_text() == "mine"


def test_an_overwrite_removes_nothing_behind_a_link(tmp_path: Path) -> None:
    folder, elsewhere = tmp_path / "sweep", tmp_path / "elsewhere"
    with ManyRuns(falling(), SETUP, folder=folder) as runs:
        runs.all_results(POINTS[:1])
    (folder / "runs").rename(elsewhere)
    (folder / "runs").symlink_to(elsewhere)

    def overwritten() -> None:
        with ManyRuns(falling(), replace(SETUP, samples=7), folder=folder, overwrite=True):
            pass

    refused(overwritten, OutputError, f"{folder / 'runs'} is a link to {elsewhere}")
    assert len(list(elsewhere.glob("*.npz"))) == 1
    assert (folder / "request.json").is_file()
    with ManyRuns(falling(), SETUP, folder=folder) as runs:  # nothing is removed where the request is the same
        runs.all_results(POINTS[:2])
    assert len(list(elsewhere.glob("*.npz"))) == 2
    (folder / "runs").unlink()
    folder.rename(tmp_path / "moved")
    folder.symlink_to("moved")  # the folder itself may be one
    overwritten()


def test_the_arrays_of_a_mesh_are_part_of_a_request(tmp_path: Path) -> None:
    film = scenes.load("single-crease").material

    def scene(mesh: Mesh) -> Scene:
        return Scene(mesh, film, parts=[Tethers([0])], name="own-mesh")

    with ManyRuns(scene(patch()), SETUP, folder=tmp_path):
        pass
    assert (tmp_path / "mesh.npz").is_file()
    with pytest.raises(OutputError, match="mesh = "), ManyRuns(scene(patch(fold_angles=[-1.01])), folder=tmp_path):
        pass


def test_differences_of_damaged_requests() -> None:
    found = differences({"scene": "= ="}, {"scene": "a = 1"})
    assert found == ["scene = 'damaged' there, not given here", "a = not given there, 1 here"]


@pytest.mark.parametrize("damage", [b"", b"PK\x03\x04", b"no archive"])
def test_a_damaged_file_is_named(damage: bytes, tmp_path: Path) -> None:
    with ManyRuns(falling(), SETUP, folder=tmp_path) as runs:
        runs.all_results(POINTS[:1])
        (path,) = tmp_path.glob("runs/*.npz")
        path.write_bytes(damage)
        refused(lambda: runs.all_results(POINTS[:1]), OutputError, f"{path.name} is no run of a sweep")
    other = tmp_path / "runs" / f"{point_mark(POINTS[1])}.npz"
    with ManyRuns(falling(), SETUP, folder=tmp_path) as runs:
        path.unlink()
        runs.all_results(POINTS[:1])
        path.rename(other)
        refused(lambda: runs.all_results(POINTS[1:2]), OutputError, "holds another run than its name says")
    for row in ("[]", '{"outcome": "good"}', "null", "{"):
        np.savez(path, row=np.array(row), history=np.zeros((0, 0)))
        refused(lambda: read_run(path), OutputError, "remove it, and it is made again")


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"facts": {"steps": "many"}}, "not all of its facts are numbers"),
        ({"facts": {"steps": [1, {"a": 2}]}}, "not all of its facts are numbers"),
        ({"columns": ["time"]}, r"its history has the shape \(\d+, 6\), for 1 columns"),
        ({"outcome": "splendid"}, "holds no row"),
    ],
)
def test_a_run_that_was_tampered_with_is_refused(changes: dict[str, Any], words: str, tmp_path: Path) -> None:
    with ManyRuns(falling(), SETUP, folder=tmp_path) as runs:
        runs.all_results(POINTS[:1])
    (path,) = tmp_path.glob("runs/*.npz")
    kept = dict(np.load(path))
    np.savez(path, row=np.array(json.dumps(json.loads(str(kept["row"])) | changes)), history=kept["history"])
    refused(lambda: read_run(path), OutputError, f"damaged: .*{words}")


def test_folders_that_cannot_be_used(tmp_path: Path) -> None:
    def opened(folder: Path) -> ManyRuns:
        return ManyRuns(falling(), SETUP, folder=folder)

    (tmp_path / "notes.txt").write_text("mine")
    refused(lambda: opened(tmp_path), OutputError, f"is not empty, and holds no {REQUEST}")
    refused(lambda: opened(tmp_path / "notes.txt" / "x"), OutputError, "cannot write")
    with opened(tmp_path / "one"):
        refused(lambda: opened(tmp_path / "one"), OutputError, "another process makes runs there")
    (tmp_path / "two").mkdir()
    (tmp_path / "two" / REQUEST).write_text("[1]")
    refused(lambda: opened(tmp_path / "two"), OutputError, "it names no scene; choose another folder$")
    refused(lambda: ManyRuns(falling(), SETUP, folder=tmp_path / "two", overwrite=True), OutputError, "names no scene")


@pytest.mark.parametrize("damage", [b"", b'{"scene": "a =', b"\xff\x00", b"[" * 10**5])
def test_overwriting_makes_the_runs_of_a_damaged_request_again(damage: bytes, tmp_path: Path) -> None:
    with ManyRuns(falling(), SETUP, folder=tmp_path) as runs:
        runs.all_results(POINTS[:1])
    whole = (tmp_path / REQUEST).read_bytes()
    (tmp_path / REQUEST).write_bytes(damage)
    refused(
        lambda: ManyRuns(falling(), SETUP, folder=tmp_path), OutputError, r"is damaged: .*; choose.*\(overwrite=True"
    )
    assert list(tmp_path.glob("runs/*.npz"))
    with ManyRuns(falling(), SETUP, folder=tmp_path, overwrite=True) as runs:
        assert not list(tmp_path.glob("runs/*.npz"))
        assert (tmp_path / REQUEST).read_bytes() == whole
        runs.all_results(POINTS[:1])


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"jobs": 0}, "jobs = 0: must be from 1 to"),
        ({"jobs": 10**6}, "from 1 to 1,000"),
        ({"jobs": True}, "whole number"),
        ({"executor": "dask"}, "must be 'threads', 'processes' or an executor"),
        ({"setup": RunSetup(until=-1.0)}, "until = -1.0"),
        ({"setup": RunSetup(until=float("nan"))}, "until = nan"),
        ({"setup": RunSetup(samples=1)}, "samples = 1: must be from 2"),
        ({"setup": RunSetup(samples=True)}, "whole number"),
        ({"setup": RunSetup(shift=0.0)}, "shift = 0.0: must be above 0"),
        ({"setup": RunSetup(time_limit=0.0)}, "time_limit = 0.0: must be above 0"),
        ({"setup": RunSetup(record={"rate": stiffness})}, r"record\['rate'\]: final_rate or highest_rate is another"),
        ({"setup": RunSetup(record={"time": stiffness})}, "is the name of a column that each history has"),
        ({"setup": RunSetup(record={"a": 1})}, "must be a function of the simulation"),  # type: ignore[dict-item]
        ({"setup": RunSetup(record={"a": lambda sim: sim.time}), "executor": "processes"}, "top level of a module"),
    ],
)
def test_wrong_input(changes: dict[str, Any], words: str) -> None:
    refused(lambda: ManyRuns(falling(), **changes), InputError, words)


def test_no_runs_and_too_many() -> None:
    with ManyRuns(falling()) as runs:
        refused(lambda: runs.all_results([]), InputError, "0 runs: must be 1 to")
        many = POINTS[:1] * (MOST_RUNS + 1)
        refused(lambda: runs.all_results(many), InputError, "100,001 runs: must be 1 to 100,000")


def test_executors_of_the_caller_that_break() -> None:
    pool = ThreadPoolExecutor(1)
    pool.shutdown()
    with pytest.raises(ExecutorError, match="takes no more runs"), ManyRuns(falling(), executor=pool) as runs:
        runs.all_results(POINTS)
    context, odd = get_context("spawn"), replace(SETUP, record={"odd": lambda sim: sim.time})
    setup = replace(SETUP, record={"time_again": dies_at_fifty})
    with ProcessPoolExecutor(1, context) as broken, ManyRuns(falling(), setup, executor=broken) as runs:
        refused(lambda: runs.all_results(POINTS), ExecutorError, "go on with a new executor, or with executor=")
    with ProcessPoolExecutor(1, context) as unable, ManyRuns(falling(), odd, executor=unable) as runs:
        refused(lambda: runs.all_results(POINTS), InputError, "top level of a module")
    with ManyRuns(falling(), odd) as runs:
        assert runs.all_results(POINTS[:1])[0].facts["final_odd"] == 0.05


@pytest.mark.parametrize("where", ["threads", "given"])
def test_an_interrupt_ends_runs_soon_and_keeps_those_that_are_done(where: str, tmp_path: Path) -> None:
    slow = [RunPoint({"run.dt": 1e-6}), RunPoint({"run.dt": 2e-6})]
    pool = ThreadPoolExecutor(2)

    def interrupt(*_: Any) -> None:
        raise KeyboardInterrupt

    began = time.perf_counter()
    executor: Where = pool if where == "given" else "threads"
    setup = RunSetup(until=1000.0, samples=3)
    with (
        pytest.raises(KeyboardInterrupt),
        ManyRuns(falling(), setup, executor=executor, jobs=3, folder=tmp_path) as runs,
    ):
        runs.all_results([RunPoint({"run.dt": 1e-2}), *slow], interrupt)
    pool.shutdown()
    assert time.perf_counter() - began < 300.0, "the runs would take hours"
    (path,) = tmp_path.glob("runs/*.npz")
    assert read_run(path).is_finished


def test_runs_are_not_written_into_a_folder_that_was_replaced(tmp_path: Path) -> None:
    folder = tmp_path / "runs"

    def replace_folder(*_: Any) -> None:
        folder.rename(tmp_path / "before")
        (folder / "runs").mkdir(parents=True)

    with ManyRuns(falling(), SETUP, folder=folder) as runs:
        refused(lambda: runs.all_results(POINTS, replace_folder), OutputError, "while this run went on")
    assert list((folder / "runs").iterdir()) == []
