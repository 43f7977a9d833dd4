"""Summaries, tables, names and arguments that are none; a memory or an encoding that is small: errors by name."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from membrane_rs import (
    InputError,
    InputTypeError,
    MassDamping,
    MembraneError,
    Mesh,
    MeshError,
    OutputError,
    Simulation,
    resume,
)
from membrane_rs.mesh import net_moduli
from membrane_rs.plotting import compare_runs, plot_deployment
from membrane_rs.results import deployment_rate, peak_stress, read_history, read_summary, write_frame
from small_scenes import FILM, hanging_strip, patch, refused
from test_hostile_files import TRIANGLE, archive, header

SCENE = hanging_strip()


@pytest.mark.parametrize("count", [9, 33, 65, 100])
def test_an_array_of_many_dimensions(count: int, tmp_path: Path) -> None:
    path = archive(tmp_path / "mesh.npz", reference=header((1,) * count, bytes(8)), triangles=TRIANGLE)
    for reader in (Mesh.load, Simulation.restore):
        refused(lambda reader=reader: reader(path), InputError, f"'reference' has the shape .*{count} dimensions")  # type: ignore[misc]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[" * 100_000, "is no summary of a run: .*recursion"),
        ('{"outcome": ' * 100_000, "is no summary of a run: .*recursion"),
        ("{", "is no summary of a run"),
        ("3", "has no outcome"),
        ('{"outcome": 3}', "has no outcome"),
        ('{"outcome": "finished", "process": [1]}', r"its process is \[1\]"),
        ('{"outcome": "finished", "request": "x"}', "its request is 'x'"),
        ('{"outcome": "finished", "time": "x"}', "its time is 'x'"),
        ('{"outcome": "finished", "wall_time": [3]}', r"its wall_time is \[3\]"),
        ('{"outcome": "finished", "resumed": true}', "its resumed is True"),
    ],
)
def test_a_summary_that_is_none(text: str, words: str, tmp_path: Path) -> None:
    (tmp_path / "summary.json").write_text(text)
    for reader in (read_summary, resume):
        refused(lambda reader=reader: reader(tmp_path), OutputError, words)  # type: ignore[misc]


def test_a_summary_without_end_and_names_that_are_none(tmp_path: Path) -> None:
    with (tmp_path / "summary.json").open("wb") as file:
        file.truncate(20 * 10**9)  # takes no space on the disk
    refused(lambda: read_summary(tmp_path), OutputError, "20000000000 bytes, and at most")
    readers: list[Callable[[Any], object]] = [read_summary, resume]
    for reader in readers:
        refused(lambda reader=reader: reader("x" * 5000), MembraneError, "x{40}")  # type: ignore[misc]
        for wrong in (3, None, b"run", "", "a\0b", ["x"]):
            refused(lambda reader=reader, wrong=wrong: reader(wrong), InputTypeError, "(path|folder) = ")  # type: ignore[misc]


def test_a_sound_folder_is_resumed_in_little_memory(tmp_path: Path) -> None:
    Simulation(hanging_strip()).run(until=0.001, frames=2, samples=3, out=tmp_path / "run", pictures=False)
    words = [sys.executable, "-m", "membrane_rs.cli", "resume", str(tmp_path / "run"), "--until", "0.002"]

    def bounded() -> None:
        resource.setrlimit(resource.RLIMIT_AS, (3 * 10**9, 3 * 10**9))

    few = os.environ | {"OPENBLAS_NUM_THREADS": "1"}
    done = subprocess.run(words, check=False, capture_output=True, text=True, preexec_fn=bounded, env=few)
    assert done.returncode == 0, done.stderr
    assert read_history(tmp_path / "run")["time"][-1] == 0.002


@pytest.mark.parametrize("option", [[], ["--out", "bé中"]], ids=["default", "out"])
def test_a_folder_that_the_encoding_lacks(option: list[str], tmp_path: Path) -> None:
    text = hanging_strip().to_toml()
    name = next(line for line in text.splitlines() if line.startswith("name = "))
    (tmp_path / "scene.toml").write_text(text.replace(name, 'name = "bé中"'), encoding="utf-8")
    words = [sys.executable, "-m", "membrane_rs.cli", "run", "scene.toml", "--until", "0.001", *option]
    ascii_alone = {"PYTHONIOENCODING": "ascii", "LC_ALL": "C", "PYTHONUTF8": "0"}
    done = subprocess.run(words, check=False, capture_output=True, cwd=tmp_path, env=os.environ | ascii_alone)
    shown = " ".join(done.stderr.decode().split())
    assert "fault of membrane_rs" not in shown
    assert done.returncode == 0 or ("PYTHONUTF8=1" in shown and done.returncode == 2)


TABLE: dict[str, Any] = {name: np.arange(3.0) for name in ("time", "deployment_rate", "phase_difference_deg")}


def test_tables_and_labels_that_are_none(tmp_path: Path) -> None:
    path = tmp_path / "curves.png"
    for table, words in (
        ("nosuch", "table = 'nosuch': must be the columns of a history"),
        (None, "table = None: must be the columns"),
        ({}, "has no column 'time'"),
        ({**TABLE, "time": ["a", "b", "c"]}, r"table\['time'\] has dtype"),
        ({**TABLE, "time": np.arange(4.0)}, "lists of equal length"),
        ({**TABLE, "time": np.eye(3)}, "lists of equal length"),
    ):
        refused(lambda table=table: plot_deployment(table, path), InputTypeError, words)  # type: ignore[misc]
    refused(lambda: plot_deployment(TABLE, path, title=3), InputTypeError, "title = 3: must be a text")  # type: ignore[arg-type]
    for dpi in ("x", None, [100], True):
        if dpi is not None:
            refused(lambda dpi=dpi: plot_deployment(TABLE, path, dpi=dpi), InputTypeError, "dpi = .*must be a number")  # type: ignore[misc]
    Simulation(hanging_strip()).run(until=0.001, samples=3, out=tmp_path / "run", pictures=False)
    refused(lambda: compare_runs([tmp_path / "run"], path, dpi="x"), InputTypeError, "dpi = 'x'")  # type: ignore[arg-type]
    for labels in ([3], 3, [None]):
        refused(lambda labels=labels: compare_runs([tmp_path / "run"], path, labels), InputTypeError, "labels = ")  # type: ignore[misc]
    assert not path.exists()


@pytest.mark.parametrize("wrong", [None, "x", 3])
def test_measures_of_what_is_no_simulation(wrong: Any, tmp_path: Path) -> None:
    for measure in (deployment_rate, peak_stress, lambda sim: write_frame(tmp_path / "a.vtu", sim)):
        refused(lambda measure=measure: measure(wrong), InputTypeError, "sim = .*must be a Simulation")  # type: ignore[misc]
    refused(lambda: net_moduli(wrong, FILM), InputTypeError, "mesh = .*must be a Mesh")
    refused(lambda: net_moduli(patch(), wrong), InputTypeError, "material = .*must be a Material")


def test_a_stiffness_that_overflows_is_named_with_its_value() -> None:
    stiff = replace(SCENE, material=replace(FILM, youngs_modulus=1e300))
    damped = replace(SCENE, laws=[*SCENE.laws, MassDamping(rate=1e308)])
    light = replace(SCENE, material=replace(FILM, density=1e-295, youngs_modulus=1e20))
    for scene, words in (
        (stiff, r"material.youngs_modulus = 1e\+300"),
        (damped, r"laws.mass_damping.rate = 1e\+308"),
        (light, r"material.density = 1e-295"),
    ):
        for make in (lambda: Simulation(scene), lambda: Simulation(scene, dt=1e-5).stable_dt()):  # noqa: B023
            refused(make, InputError, f"overflow: .* the value farthest from 1 is {words}: check it")


@pytest.mark.parametrize("name", ["", "a\0b", "\0", "x" * 1001])
def test_a_node_set_that_no_file_can_hold(name: str, tmp_path: Path) -> None:
    refused(
        lambda: patch(node_sets={name: [0]}), InputError, "node_sets: the name .*1 to 1000 characters without a NUL"
    )
    if not name:
        path = archive(tmp_path / "mesh.npz", reference=np.eye(3), triangles=TRIANGLE, **{"node_set:": np.array([0])})
        refused(lambda: Mesh.load(path), MeshError, "mesh.npz: node_sets: the name ''")


@pytest.mark.parametrize("name", ["x" * 1000, "中" * 1000, "a/b\\c", "x.npy", "..", " ", ":"])
def test_a_node_set_of_any_other_name_is_kept(name: str, tmp_path: Path) -> None:
    patch(node_sets={name: [0]}).save(tmp_path / "mesh.npz")
    assert list(Mesh.load(tmp_path / "mesh.npz").node_sets) == [name]


def test_a_run_is_resumed_by_its_summary(tmp_path: Path) -> None:
    Simulation(hanging_strip()).run(until=0.001, frames=2, samples=3, out=tmp_path / "run", pictures=False)
    assert resume(tmp_path / "run" / "summary.json", 0.002).time == 0.002
    words = [sys.executable, "-m", "membrane_rs.cli", "resume", str(tmp_path / "run" / "summary.json")]
    assert "is finished" in subprocess.run(words, check=True, capture_output=True, text=True).stderr


@pytest.mark.parametrize("until", [5e-324, 1e-16, 1e13])
def test_an_end_beyond_the_bounds(until: float) -> None:
    refused(lambda: Simulation(SCENE, "dopri5").run(until=until), InputError, r"until = .*from 1e-15 to 1e\+12")
