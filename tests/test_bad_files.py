"""Files that cannot be written, and saved states that are none: a clear error, and nothing left behind."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from membrane_rs import (
    InputError,
    MissingFileError,
    OutputError,
    RunSettings,
    Simulation,
    integrators,
)
from membrane_rs.folding import Strip
from small_scenes import hanging_strip, refused

SCENE = hanging_strip()


@pytest.fixture
def blocked(tmp_path: Path) -> Path:
    """A file where a folder should be."""
    (tmp_path / "file").write_text("mine")
    return tmp_path / "file"


def test_results_that_cannot_be_written(blocked: Path) -> None:
    sim = Simulation(SCENE)
    refused(lambda: sim.save(blocked / "state.npz"), OutputError, "cannot write .*state.npz: Not a directory")
    refused(lambda: sim.save(blocked.parent), OutputError, "cannot write .*: Is a directory")
    refused(lambda: sim.save(blocked.parent / "no" / "state.npz"), OutputError, "No such file or directory")
    for out in (blocked, blocked / "run"):
        refused(lambda out=out: sim.run(until=0.001, out=out), OutputError, str(out))  # type: ignore[misc]
    assert [path.name for path in blocked.parent.iterdir()] == ["file"]
    assert blocked.read_text() == "mine"
    assert sim.step_count == 0


def test_saved_states_that_are_none(blocked: Path, tmp_path: Path) -> None:
    refused(lambda: Simulation.restore(tmp_path / "none.npz"), MissingFileError, "there is no such saved state")
    with pytest.raises(FileNotFoundError):
        Simulation.restore(tmp_path / "none.npz")
    refused(lambda: Simulation.restore(blocked), InputError, "is no saved state")
    refused(lambda: Simulation.restore(tmp_path), MissingFileError, "there is no such saved state")
    np.savez(tmp_path / "other.npz", a=1)
    refused(
        lambda: Simulation.restore(tmp_path / "other.npz"),
        InputError,
        "give a file that Simulation.save wrote",
    )
    np.savez(tmp_path / "pickled.npz", a=np.array([{}], dtype=object))
    refused(lambda: Simulation.restore(tmp_path / "pickled.npz"), InputError, "is no saved state")


def saved(folder: Path, integrator: str = "rk4") -> Path:
    sim = Simulation(SCENE, integrator)
    sim.step(5)
    sim.save(folder / "state.npz")
    return folder / "state.npz"


def test_saved_states_cut_short(tmp_path: Path) -> None:
    content = saved(tmp_path).read_bytes()
    for length in (0, 1, 10, 100, len(content) // 2, len(content) - 1):
        (tmp_path / "cut.npz").write_bytes(content[:length])
        refused(lambda: Simulation.restore(tmp_path / "cut.npz"), InputError, "cut.npz")


@pytest.mark.parametrize("integrator", integrators())
def test_saved_states_with_one_entry_damaged(tmp_path: Path, integrator: str) -> None:
    arrays = dict(np.load(saved(tmp_path, integrator)))
    assert len(arrays) >= 12
    for name, value in arrays.items():
        others = {key: other for key, other in arrays.items() if key != name}
        # A state without motor_numbers is one of an older version.
        damages = [*([] if name == "motor_numbers" else [None]), np.array([]), np.array([[1.0, 2.0]])]
        if value.dtype.kind in "fi":
            damages += [np.full(value.shape, math.nan), np.array("words")]
        if name in ("dt", "step_count", "evaluation_count"):
            damages += [np.full(value.shape, -1)]
        for damage in damages:
            if damage is not None and damage.shape == value.shape and not value.size:
                continue  # an empty array is kept where the method remembers nothing: this is no damage
            np.savez(tmp_path / "bad.npz", **(others if damage is None else {**others, name: damage}))
            refused(lambda: Simulation.restore(tmp_path / "bad.npz"), InputError, "bad.npz")


@settings(max_examples=80, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 255))
def test_saved_states_with_one_byte_changed(tmp_path_factory: pytest.TempPathFactory, place: int, change: int) -> None:
    folder = tmp_path_factory.mktemp("byte")
    content = bytearray(saved(folder).read_bytes())
    content[place % len(content)] ^= change
    (folder / "bad.npz").write_bytes(content)
    try:
        sim = Simulation.restore(folder / "bad.npz")
    except InputError as error:
        refusal = str(error)
        assert "bad.npz" in refusal
        return
    # A byte of the archive that means nothing, such as a date.
    assert sim.step_count == 5


@pytest.mark.parametrize("member", ["scene/other.toml", "scene/../scene.toml", "scene/", "scene/a/mesh.npz"])
def test_saved_states_with_strange_files(tmp_path: Path, member: str) -> None:
    arrays = {**dict(np.load(saved(tmp_path))), member: np.zeros(3, np.uint8)}
    np.savez(tmp_path / "bad.npz", **arrays)
    refused(lambda: Simulation.restore(tmp_path / "bad.npz"), InputError, "bad.npz: holds 'scene/")


def test_a_state_of_another_scene(tmp_path: Path) -> None:
    arrays = dict(np.load(saved(tmp_path)))
    other = Simulation(replace(SCENE, mesh=Strip(0.1, 0.04, 4, 2).mesh(), run=RunSettings(until=0.1)))
    other.save(tmp_path / "other.npz")
    mixed = {**dict(np.load(tmp_path / "other.npz")), "positions": arrays["positions"]}
    np.savez(tmp_path / "mixed.npz", **mixed)
    refused(
        lambda: Simulation.restore(tmp_path / "mixed.npz"),
        InputError,
        "mixed.npz.*positions has 21 rows but 15",
    )
