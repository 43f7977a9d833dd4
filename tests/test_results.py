"""The folder of a run: whole after every frame, read back as written, never at a user's cost."""

from __future__ import annotations

import csv
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any, cast

import meshio
import numpy as np
import pytest
import pyvista
from child_processes import started, wait_until
from fake_simulation import FakeSimulation, run, summary
from membrane_rs import (
    InputError,
    MembraneError,
    MissingFileError,
    OutputError,
    Scene,
    Simulation,
    UnstableError,
    scenes,
)
from membrane_rs.mesh.queries import find_pairs
from membrane_rs.plotting import compare_runs, plot_deployment
from membrane_rs.results import read_frame, read_history, read_pvd, write_frame, write_pvd
from membrane_rs.results.history import History
from membrane_rs.runs import RunFolder
from numpy.testing import assert_array_equal
from PIL import Image

FIRST = [
    "time",
    "deployment_rate",
    "phase_difference_deg",
    "kinetic_energy",
    "stored_energy",
    "energy_error",
]


def test_frame_reads_back_in_meshio_and_pyvista(tmp_path: Path) -> None:
    sim: Any = FakeSimulation()
    sim.velocities = np.random.default_rng(1).normal(size=sim.positions.shape)
    write_frame(tmp_path / "frame.vtu", sim)
    read = meshio.read(tmp_path / "frame.vtu")
    seen: Any = pyvista.read(tmp_path / "frame.vtu")
    triangles, springs = len(sim.assembly.triangles), len(sim.spring_pairs)

    assert_array_equal(read_frame(tmp_path / "frame.vtu"), sim.positions)
    assert_array_equal(seen.points, sim.positions)
    assert_array_equal(read.cells_dict["triangle"], sim.assembly.triangles)
    assert_array_equal(read.cells_dict["line"], sim.spring_pairs)
    assert_array_equal(seen.celltypes, [5] * triangles + [3] * springs)
    for data in (read.point_data, seen.point_data):
        assert_array_equal(data["velocity"], sim.velocities)
        assert_array_equal(data["displacement"], sim.positions - sim.assembly.reference)
    assert_array_equal(seen.cell_data["spring_strain"][triangles:], sim.spring_strains())
    assert_array_equal(read.cell_data_dict["spring_strain"]["line"], sim.spring_strains())
    assert np.isnan(read.cell_data_dict["spring_strain"]["triangle"]).all()
    assert_array_equal(read.cell_data_dict["buckled"]["line"], sim.buckled())
    assert np.isfinite(read.cell_data_dict["triangle_strain"]["triangle"]).all()
    stress = sim.film_stress()
    assert_array_equal(read.cell_data_dict["stress_1"]["triangle"], stress.principal[:, 0].astype(np.float32))
    assert_array_equal(read.cell_data_dict["stress_2"]["triangle"], stress.principal[:, 1].astype(np.float32))
    assert_array_equal(read.cell_data_dict["von_mises"]["triangle"], stress.von_mises.astype(np.float32))
    assert_array_equal(seen.cell_data["stress_direction"][:triangles], stress.directions[:, 0])
    cords = len(sim.cord_tensions())
    assert_array_equal(read.cell_data_dict["tension"]["line"][-cords:], sim.cord_tensions().astype(np.float32))
    assert np.isnan(read.cell_data_dict["tension"]["line"][:-cords]).all()
    assert set(read.cell_data_dict["petal"]["triangle"].tolist()) == {0, 1, 2, 3}


def test_crease_angles_lie_on_their_springs(tmp_path: Path) -> None:
    sim: Any = FakeSimulation()
    write_frame(tmp_path / "frame.vtu", sim)
    angles = meshio.read(tmp_path / "frame.vtu").cell_data_dict["crease_angle"]["line"]
    by_pair = {tuple(sorted(pair)): angle for pair, angle in zip(sim.spring_pairs, angles, strict=True)}
    for crease, angle in zip(sim.assembly.creases.nodes, sim.crease_angles(), strict=True):
        assert by_pair[tuple(sorted(crease))] == angle
    assert np.isfinite(angles).sum() == len(sim.assembly.creases)


def test_pairs_are_found_in_either_direction() -> None:
    pairs = np.array([[5, 2], [0, 1], [3, 4]])
    assert_array_equal(find_pairs(pairs, np.array([[1, 0], [2, 5], [0, 9]])), [1, 0, -1])
    assert_array_equal(find_pairs(pairs, np.zeros((0, 2), dtype=np.int64)), [])


def test_pvd_reads_back_in_pyvista(tmp_path: Path) -> None:
    run(RunFolder(tmp_path / "run", pictures=False), [0.0, 0.05, 0.1])
    reader: Any = cast(Any, pyvista).get_reader(tmp_path / "run" / "frames.pvd")
    assert reader.time_values == [0.0, 0.05, 0.1]
    reader.set_active_time_value(0.1)
    assert_array_equal(reader.read()[0].points, read_frame(read_pvd(tmp_path / "run" / "frames.pvd")[-1][1]))


def test_folder_is_valid_after_every_frame(tmp_path: Path) -> None:
    path = tmp_path / "deep" / "run"
    sim: Any = FakeSimulation()
    folder = RunFolder(path)
    folder.start(sim)
    assert summary(path)["outcome"] == "running"
    for k in range(3):
        sim.show(0.01 * k, sim.assembly.positions)
        folder.sample(sim)
        folder.frame(sim)
        frames = read_pvd(path / "frames.pvd") if (path / "frames.pvd").exists() else []
        assert [time for time, _ in frames] == [0.01 * n for n in range(len(frames))]
        assert all(len(read_frame(file)) == len(sim.positions) for _, file in frames)
        assert len(read_history(path)["time"]) == k + 1
    folder.finish(sim, KeyboardInterrupt())
    assert [time for time, _ in read_pvd(path / "frames.pvd")] == [0.0, 0.01, 0.02]
    assert not list(path.rglob("*.part"))


def test_folder_of_a_killed_process_can_be_read(tmp_path: Path) -> None:
    path = tmp_path / "run"
    code = (
        "import sys; from membrane_rs import Simulation, scenes; "
        "Simulation(scenes.load('single-crease')).run(200.0, frames=10**6, out=sys.argv[1])"
    )
    with started([sys.executable, "-c", code, str(path)]) as process:  # it goes on until it is killed
        wait_until((path / "frames" / "frame-0020.vtu").exists, "some frames are written", process)
    frames = read_pvd(path / "frames.pvd")
    assert len(frames) >= 20
    assert {read_frame(file).shape for _, file in frames} == {read_frame(frames[0][1]).shape}
    assert len(read_history(path)["time"]) >= len(frames)
    assert summary(path)["outcome"] == "running"


def test_history_keeps_every_bit(tmp_path: Path) -> None:
    times = [0.0, 0.1, 1.0 / 3.0, 0.7000000000000001]
    run(RunFolder(tmp_path / "run", pictures=False), times)
    with (tmp_path / "run" / "history.csv").open(newline="") as file:
        header = next(csv.reader(file))
    assert header[:6] == FIRST
    assert {"energy_springs", "energy_creases", "energy_spin", "work_spring_damping"} < set(header)
    table = read_history(tmp_path / "run")
    assert table["time"].tolist() == times
    assert_array_equal(table["work_spring_damping"], [0.0, -0.1, -0.1, -0.1])
    assert_array_equal(table["energy_springs"], 0.1)


def test_history_of_a_killed_process_ends_at_the_last_whole_line(tmp_path: Path) -> None:
    run(RunFolder(tmp_path / "run", pictures=False), [0.0, 0.1, 0.2])
    file = tmp_path / "run" / "history.csv"
    file.write_text(file.read_text()[:-9])
    assert read_history(file)["time"].tolist() == [0.0, 0.1]


def test_history_of_version_0_1_is_read_by_its_new_names(tmp_path: Path) -> None:
    run(RunFolder(tmp_path / "run", pictures=False), [0.0, 0.1])
    file = tmp_path / "run" / "history.csv"
    new = read_history(file)
    file.write_text(file.read_text().replace("reference_energy", "energy_turned_over"))
    old = read_history(file)
    assert old.keys() == new.keys()
    for table in (new, old):
        with pytest.warns(
            DeprecationWarning, match=r"read_history\(\)\['energy_turned_over'\] is deprecated"
        ) as warned:
            assert_array_equal(table["energy_turned_over"], table["reference_energy"])
        assert [warning.filename for warning in warned] == [__file__]


def test_summary_tells_the_run(tmp_path: Path) -> None:
    run(RunFolder(tmp_path / "run", pictures=False), np.linspace(0.0, 0.8, 81).tolist())
    found = summary(tmp_path / "run")
    expected = {"scene": "small-sail", "outcome": "finished", "dt": 1e-5, "stable_dt": 2e-5, "steps": 80000}
    assert {key: found[key] for key in expected} == expected
    assert found["curves"]["phase_trough_deg"] == pytest.approx(-100.0, abs=0.1)
    assert found["curves"]["zero_crossing_time"] == pytest.approx(np.pi / 4.0, abs=1e-4)
    assert found["energy_balance"]["lowest_error"] == -1e-3
    assert found["counts"]["masses"] > 0
    assert found["versions"]["numpy"] == np.__version__
    assert (tmp_path / "run" / "state.npz").read_bytes() == b"state"


@pytest.mark.parametrize(
    ("error", "outcome", "has_state", "has_pictures"),
    [
        (None, "finished", True, True),
        (KeyboardInterrupt(), "interrupted", True, False),
        (UnstableError("spring 3 is torn"), "unstable: spring 3 is torn", False, True),
        (ZeroDivisionError("oh"), "failed: ZeroDivisionError: oh", False, False),
    ],
)
def test_how_a_run_ended(
    tmp_path: Path, error: BaseException | None, outcome: str, has_state: bool, has_pictures: bool
) -> None:
    run(RunFolder(tmp_path / "run"), [0.0, 0.1], error)
    assert summary(tmp_path / "run")["outcome"] == outcome
    assert (tmp_path / "run" / "state.npz").exists() == has_state
    assert (tmp_path / "run" / "deployment.png").exists() == has_pictures
    assert (tmp_path / "run" / "snapshots" / "turning.png").exists() == has_pictures


def test_an_interrupted_run_whose_state_cannot_be_written_says_so(tmp_path: Path) -> None:
    folder = RunFolder(tmp_path / "run", pictures=False)
    sim: Any = FakeSimulation()
    folder.start(sim)
    folder.sample(sim)
    (tmp_path / "run" / "state.npz").mkdir()
    with pytest.raises(OutputError, match=r"cannot write .*state\.npz: Is a directory"):
        folder.finish(sim, KeyboardInterrupt())


def test_state_that_steps_back_is_passed_over(tmp_path: Path) -> None:
    run(RunFolder(tmp_path / "run", pictures=False), [0.0, 0.1, 0.05], UnstableError("gone"))
    assert read_history(tmp_path / "run")["time"].tolist() == [0.0, 0.1]
    assert [time for time, _ in read_pvd(tmp_path / "run" / "frames.pvd")] == [0.0, 0.1]


def test_folder_taken_away_while_running(tmp_path: Path) -> None:
    sim: Any = FakeSimulation()
    folder = RunFolder(tmp_path / "run")
    folder.start(sim)
    shutil.rmtree(tmp_path / "run" / "frames")
    folder.frame(sim)
    with pytest.raises(OutputError, match="cannot write"):
        folder.finish(sim, None)
    assert summary(tmp_path / "run")["outcome"].startswith("failed: OutputError: cannot write")


class NoRoom:
    """A file on a full disk."""

    def write(self, text: str) -> int:
        return len(text)

    def close(self) -> None:
        raise OSError(28, "No space left on device")


def test_summary_is_closed_where_the_history_cannot_be(tmp_path: Path) -> None:
    for name, error in (("good", None), ("bad", UnstableError("gone"))):
        sim: Any = FakeSimulation()
        folder = RunFolder(tmp_path / name, pictures=False)
        folder.start(sim)
        history = next(writer for writer in folder._writers if isinstance(writer, History))
        history._file.close()
        history._file = cast(Any, NoRoom())
        if error is None:
            with pytest.raises(OutputError, match=r"history\.csv: No space left"):
                folder.finish(sim, error)
        else:
            folder.finish(sim, error)  # the run's own error is the one to tell
    assert summary(tmp_path / "good")["outcome"].startswith("failed: OutputError: cannot write")
    assert summary(tmp_path / "bad")["outcome"] == "unstable: gone"


def test_a_full_disk_costs_one_line(tmp_path: Path) -> None:
    code = (
        "import resource, sys; resource.setrlimit(resource.RLIMIT_FSIZE, (2048, 2048)); "
        "from membrane_rs.cli import main; "
        "sys.argv[1:] = ['run', 'single-crease', '--until', '0.2', '--frames', '3', '--out', 'f']; main()"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode != 0
    assert "Traceback" not in done.stderr
    assert len([line for line in done.stderr.splitlines() if "cannot write" in line]) == 1
    assert summary(tmp_path / "f")["outcome"].startswith("failed: OutputError: cannot write")


def test_zero_has_no_sign(tmp_path: Path) -> None:
    sim: Any = FakeSimulation()
    sim.stored["tethers"] = sim.hub_angle = -0.0
    folder = RunFolder(tmp_path / "run", pictures=False)
    folder.start(sim)
    folder.sample(sim)
    rows = (tmp_path / "run" / "history.csv").read_text().splitlines()
    assert "-0.0" not in rows[1].split(",")


def test_what_is_not_there_is_named(tmp_path: Path) -> None:
    for read in (read_history, read_pvd, read_frame):
        with pytest.raises(MissingFileError, match="nowhere"):
            read(tmp_path / "nowhere")


@pytest.mark.parametrize("text", ["", "a,b\n1,2\n", "<VTKFile>", "time\x00"])
def test_files_that_are_something_else(tmp_path: Path, text: str) -> None:
    file = tmp_path / "file"
    file.write_text(text)
    for read in (read_history, read_pvd, read_frame):
        with pytest.raises(MembraneError, match="file"):
            read(file)


def test_damaged_frame_is_told(tmp_path: Path) -> None:
    write_frame(tmp_path / "frame.vtu", cast(Any, FakeSimulation()))
    text = (tmp_path / "frame.vtu").read_bytes()
    for damaged in (text[: len(text) // 2], text[:500] + text[504:], text.replace(b"Points", b"Pints")):
        (tmp_path / "frame.vtu").write_bytes(damaged)
        with pytest.raises(OutputError, match="run the scene again"):
            read_frame(tmp_path / "frame.vtu")


def test_pvd_times_keep_every_bit(tmp_path: Path) -> None:
    frames = [(0.1 + 0.2, "frames/a & b.vtu"), (1.0 / 3.0, "c.vtu")]
    write_pvd(tmp_path / "frames.pvd", frames)
    assert read_pvd(tmp_path / "frames.pvd") == [(time, tmp_path / file) for time, file in frames]


def test_curves_are_drawn(tmp_path: Path) -> None:
    for name in ("one", "two"):
        run(RunFolder(tmp_path / name, pictures=False), [0.0, 0.1, 0.2])
    plot_deployment(read_history(tmp_path / "one"), tmp_path / "one.png", "one")
    compare_runs([tmp_path / "one", tmp_path / "two"], tmp_path / "both.png")
    for name, height in {"one.png": 1280, "both.png": 1320}.items():  # the second has a legend above
        with Image.open(tmp_path / name) as image:
            assert image.size == (1400, height)
    with pytest.raises(InputError, match="1 labels for 2 runs"):
        compare_runs([tmp_path / "one", tmp_path / "two"], tmp_path / "c.png", ["only one"])
    with pytest.raises(OutputError, match="cannot write"):
        compare_runs([tmp_path / "one"], tmp_path / "nowhere" / "c.png")


@pytest.mark.parametrize("name", ["spinning-tether", "single-crease"])
def test_a_real_run(tmp_path: Path, name: str, capfd: pytest.CaptureFixture[str]) -> None:
    sim = Simulation(scenes.load(name))
    end = 200 * sim.dt
    sim.run(end, frames=3, samples=5, out=tmp_path / "run")
    table = read_history(tmp_path / "run")
    assert table["time"][-1] == sim.time
    assert [len(read_frame(file)) for _, file in read_pvd(tmp_path / "run" / "frames.pvd")] == [sim.node_count] * 3
    stored = sum(table[f"energy_{law}"] for law in sim.energies() if law != "kinetic")
    np.testing.assert_allclose(stored, table["stored_energy"], rtol=1e-9, atol=1e-18)
    assert_array_equal(Simulation.restore(tmp_path / "run" / "state.npz").positions, sim.positions)
    assert Scene.from_toml(tmp_path / "run" / "scene.toml").name == name
    shown = capfd.readouterr()
    assert (shown.out, shown.err) == ("", "")
