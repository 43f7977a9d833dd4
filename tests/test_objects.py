"""A simulation as an object: copied, pickled, read by other threads, its attributes; settings that have no effect."""

from __future__ import annotations

import copy
import os
import pickle
import subprocess
import sys
import threading
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from membrane_rs import (
    InputError,
    InputTypeError,
    Mesh,
    MeshError,
    RunSettings,
    Simulation,
    UnknownAttributeError,
    integrators,
)
from membrane_rs.runs import RunFolder, resume
from small_scenes import hanging_strip, patch, refused

SCENE = hanging_strip()
COPIES: list[Callable[[Any], Any]] = [copy.copy, copy.deepcopy, lambda sim: pickle.loads(pickle.dumps(sim))]


class Counting(Simulation):
    """A class of a user, with an attribute of its own."""

    count = 0


def equal(one: Simulation, other: Simulation) -> bool:
    first, second = one.state(), other.state()
    return first.keys() == second.keys() and all(np.array_equal(first[name], second[name]) for name in first)


@pytest.mark.parametrize("integrator", integrators())
@pytest.mark.parametrize("copied", COPIES, ids=["copy", "deepcopy", "pickle"])
def test_copies_are_independent_and_go_on_with_the_same_bits(copied: Callable[[Any], Any], integrator: str) -> None:
    sim = Counting(SCENE, integrator)
    sim.step(7)
    sim.count = 3
    sim.note = "mine"  # type: ignore[attr-defined]
    other = copied(sim)
    assert (type(other), other.count, other.note) == (Counting, 3, "mine")
    assert equal(sim, other)
    before = sim.positions
    other.step(9)
    assert (sim.positions == before).all()
    assert sim.step_count == 7
    sim.step(9)
    assert equal(sim, other)


@pytest.mark.parametrize("copied", COPIES, ids=["copy", "deepcopy", "pickle"])
def test_copies_of_meshes_and_assemblies_are_read_only(copied: Callable[[Any], Any]) -> None:
    mesh = copied(patch())
    assert mesh.edges.shape == (5, 2)
    assembly = copied(SCENE).assemble()
    arrays = (mesh.reference, mesh.positions, mesh.triangles, mesh.fold_angles, mesh.node_sets["corners"], mesh.edges)
    for array in (*arrays, assembly.positions, assembly.creases.nodes, *assembly.node_sets.values()):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1


def test_other_threads_read_while_one_steps_and_none_steps_beside_it() -> None:
    # In a process of its own, whose end alone ends so many steps.
    code = (
        "import os, threading\n"
        "from membrane_rs import Simulation\n"
        "from small_scenes import hanging_strip\n"
        "sim = Simulation(hanging_strip(), dt=1e-6)\n"
        "start = sim.positions\n"
        "threading.Thread(target=sim.step, args=(10**12,), daemon=True).start()\n"
        "seen = [0.0]\n"
        "while len(seen) < 5:\n"
        "    now, _ = sim.time, (sim.positions.sum(), sim.energies()['kinetic'])\n"
        "    if now != seen[-1]:\n"
        "        seen.append(now)\n"
        "for action in (lambda: sim.step(1), lambda: setattr(sim, 'positions', start)):\n"
        "    try:\n"
        "        action()\n"
        "    except ValueError as error:\n"
        "        print('is being stepped by another thread' in str(error))\n"
        "print(seen == sorted(seen), flush=True)\n"
        "os._exit(0)\n"
    )
    words, here = [sys.executable, "-c", code], {**os.environ, "PYTHONPATH": str(Path(__file__).parent)}
    done = subprocess.run(words, capture_output=True, text=True, check=False, timeout=300, env=here)
    assert (done.returncode, done.stdout.split()) == (0, ["True"] * 3), done.stderr


def test_a_thread_that_has_stepped_leaves_the_simulation_to_others() -> None:
    sim = Simulation(SCENE, dt=1e-6)
    thread = threading.Thread(target=sim.step, args=(1000,))
    thread.start()
    thread.join()
    sim.step(1)
    assert sim.step_count == 1001


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("typo", "Simulation.typo: no such attribute; known are: is_relaxed, positions, velocities"),
        ("position", "did you mean 'positions'"),
        ("velocity", "did you mean 'velocities'"),
        ("masses", "Simulation.masses: is read only"),
        ("spring_pairs", "is read only"),
        ("scene", "is read only; make another simulation"),
    ],
)
def test_an_attribute_that_is_none_is_refused(name: str, words: str) -> None:
    sim = Simulation(SCENE)
    refused(lambda: setattr(sim, name, 3), UnknownAttributeError, words)
    with pytest.raises(AttributeError):
        setattr(sim, name, 3)


def test_an_array_in_place_is_refused() -> None:
    sim = Simulation(SCENE)
    with pytest.raises(ValueError, match="read-only"):
        sim.positions[0] += 1
    with pytest.raises(ValueError, match="read-only"):
        sim.velocities[0] += 1


@pytest.mark.parametrize("integrator", integrators())
def test_setting_the_motion_keeps_the_clock(integrator: str) -> None:
    sim = Simulation(SCENE, integrator)
    sim.step(5)
    now = sim.time
    sim.positions = sim.positions
    sim.velocities = 0 * sim.velocities
    assert sim.time == now > 0
    sim.step(5)
    assert sim.time > now


def test_options_of_a_run_without_effect(tmp_path: Path) -> None:
    refused(lambda: Simulation(SCENE).run(until=0.001, overwrite=True), InputError, "overwrite = True: without out")
    for values in ({"pictures": False}, {"checkpoint": 5.0}, {"pictures": False, "checkpoint": 0.0}):
        sim = Simulation(SCENE)
        refused(lambda sim=sim, values=values: sim.run(until=0.001, **values), InputError, "without out nothing is")  # type: ignore[misc]
        assert sim.step_count == 0
    sim.run(until=0.001, checkpoint=5.0, observers=[RunFolder(tmp_path / "run", pictures=False)])
    refused(lambda: SCENE.with_values({"run.frames": "8"}), InputError, "must be a whole number")
    refused(lambda: SCENE.with_values({3: 8}), InputTypeError, "key 3: must be a name such as")  # type: ignore[dict-item]
    assert SCENE.with_values({"run.frames": 8.0}).run.frames == 8
    refused(lambda: RunSettings(short_steps=4, substeps=2), InputError, "is the old name of substeps")  # type: ignore[call-arg]


@pytest.mark.parametrize("name", ["frames", "samples"])
def test_given_times_outside_a_run_are_reported(name: str, tmp_path: Path) -> None:
    sim: Any = Simulation(SCENE)
    again: Any = Simulation(SCENE)
    with pytest.warns(UserWarning, match=f"{name}: 2 of the times lie after until = 0.001 s, and are left out: 0.5 s"):
        sim.run(until=0.001, **{name: [0.0005, 0.5, 1.0]})
    with pytest.warns(UserWarning, match=f"{name}: 2 of the times lie before the time now, 0.001 s, .* left out: -1.0"):
        sim.run(until=0.002, **{name: (-1.0, 0.0005, 0.0015)})
    with pytest.warns(UserWarning, match=f"{name}: 1 of the times lie before the time now, 0 s, .* left out: -1.0 s"):
        again.run(until=0.001, out=tmp_path / "run", pictures=False, **{name: np.array([-1.0, 0.0005])})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sim.run(until=0.003, **{name: [0.002, 0.0025, 0.003]})
        resume(tmp_path / "run", 0.002)


MASKED: Any = np.ma.masked_equal(np.eye(3), 1.0)
BAD: list[Any] = [
    MASKED, [list(row) for row in MASKED], np.zeros((3, 3), complex), np.zeros((3, 3), object),
    np.zeros((3, 3), "M8[s]"), np.zeros((3, 3), "m8[s]"), np.zeros((3, 3), "U3"), np.zeros((3, 3), bool),
]  # fmt: skip


@pytest.mark.parametrize("values", BAD, ids=lambda values: str(getattr(values, "dtype", "list")))
def test_arrays_that_would_lose_something_are_refused(values: Any) -> None:
    triangles = [[0, 1, 2]]
    refused(lambda: Mesh(values, triangles), InputTypeError, "reference")
    refused(lambda: Mesh(np.eye(3), triangles, positions=values), InputTypeError, "positions")
    refused(lambda: Mesh(np.eye(3), values), InputTypeError, "triangles")
    refused(lambda: Mesh(np.eye(3), triangles).strain(values), InputTypeError, "positions")
    refused(lambda: setattr(Simulation(SCENE), "positions", values), InputTypeError, "positions")


def test_masks_name_how_to_fill_them_and_none_is_as_no_mask() -> None:
    refused(lambda: Mesh(MASKED, [[0, 1, 2]]), InputTypeError, r"masked entries.*numpy.ma.filled")
    whole: Any = np.ma.masked_array(np.eye(3), mask=False)
    assert (Mesh(whole, [[0, 1, 2]]).reference == np.eye(3)).all()


@pytest.mark.parametrize("order", ["F", "C"])
@pytest.mark.parametrize("dtype", [">f8", "<f8", ">f4", "f2", "g", ">i4", "u1"])
def test_arrays_of_any_layout_are_read_right(dtype: str, order: Any) -> None:
    points: Any = np.array(np.arange(18).reshape(6, 3), dtype, order=order)[::2]
    assert (Mesh(points * 2 % 7, [[0, 1, 2]]).reference == (np.arange(18).reshape(6, 3)[::2] * 2 % 7)).all()


def test_quadrilaterals_are_refused_with_how_to_split_them() -> None:
    points = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    refused(lambda: Mesh(points, [[0, 1, 2, 3]]), MeshError, r"quadrilaterals; split each.*numpy.concatenate")
