"""A simulation in one file: the scene as its own files, and the state's numbers, in a numpy archive.

Nothing in it is pickled, so that reading a stranger's file runs nothing. The comment of the archive is the SHA-256 of
all that stands before it; a file without one, such as an archive that another program wrote, is read as well.
"""

from __future__ import annotations

import hashlib
import io
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from membrane_rs._archives import ArchiveError, read_arrays
from membrane_rs._files import replacing
from membrane_rs.errors import InputError, MembraneError, MissingFileError
from membrane_rs.scene import Scene
from membrane_rs.scene.scene import SCENE_FILE
from membrane_rs.scene.toml import MESH_FILE, read_scene
from membrane_rs.simulation.continuation import scene_digest

STATE = "state.npz"
"""The name of a saved state in the folder of a run."""
_SCENE = "scene/"
_RENAMED = {"is_settled": "is_relaxed"}
"""New names of entries by their old ones, which are read too."""


class StateFile:
    """Writes states of one scene, which is worked out once.

    It keeps nothing of the simulation that changes, so that it can write in another thread.
    """

    def __init__(self, scene: Scene) -> None:
        with tempfile.TemporaryDirectory() as folder:
            scene.save(folder)
            self._scene = {
                _SCENE + file.name: np.frombuffer(file.read_bytes(), np.uint8) for file in Path(folder).iterdir()
            }

    def write(self, path: Path, state: dict[str, Any]) -> None:
        """Write scene and state onto the disk, whole or not at all. Raises OutputError."""
        archive = io.BytesIO()
        arrays: dict[str, Any] = self._scene | {name: np.asarray(value) for name, value in state.items()}
        np.savez(archive, **arrays)
        with replacing(path, synced=True) as part:
            part.write_bytes(_sealed(archive.getvalue()))


_COMMENT = b"membrane_rs sha256 "
_END = b"PK\5\6"
_END_LENGTH = 22
"""Bytes at the end of an archive: this mark first, the length of the comment last; only the comment is behind them."""


def _sealed(archive: bytes) -> bytes:
    """An archive without comment, with its checksum as one."""
    comment = _COMMENT + hashlib.sha256(archive).hexdigest().encode()
    return archive[:-2] + len(comment).to_bytes(2, "little") + comment


def _is_damaged(content: bytes) -> bool:
    """Whether the file has a comment, and is not what `_sealed` made."""
    end = content.rfind(_END) + _END_LENGTH
    has_comment = content[end - 2 : end] != b"\0\0"
    return has_comment and content != _sealed(content[: end - 2] + b"\0\0")


def read_state(path: Path, *, motion_alone: bool = False) -> tuple[Scene, dict[str, Any]]:
    """Scene and state of a file that `StateFile` wrote. For the motion alone the scene is read without measures that
    were functions, which no file holds.

    Raises
    ------
    MissingFileError
        No such file.
    InputError
        Not a saved state, or damaged.
    """
    arrays = _arrays(path)
    needed = {"integrator", "dt", "is_adaptive", "is_relaxed", "positions", "velocities", "work", _SCENE + SCENE_FILE}
    missing = sorted(needed - arrays.keys())
    if missing:
        raise InputError(
            f"{path}: holds no {missing[0]!r}, so it is no saved state; give a file that Simulation.save wrote"
        )
    members = (_SCENE + SCENE_FILE, _SCENE + MESH_FILE)
    strange = sorted(name for name in arrays if name.startswith(_SCENE) and name not in members)
    if strange:
        raise InputError(f"{path}: holds {strange[0]!r}, but a saved scene is {' and '.join(members)} alone")
    for name, value in arrays.items():
        if value.dtype.kind == "f" and not np.isfinite(value).all():
            raise InputError(f"{path}: {name!r} holds a value that is not finite; the file is damaged")
    # Restoring a run that chooses its steps looks at dt no more, so it is checked here.
    if arrays["dt"].shape or arrays["dt"].dtype.kind != "f" or not arrays["dt"] > 0:
        raise InputError(f"{path}: 'dt' is no number above 0; the file is damaged")
    for name in ("is_adaptive", "is_relaxed"):
        if arrays[name].shape or arrays[name].dtype.kind != "b":
            raise InputError(f"{path}: {name!r} is neither true nor false; the file is damaged")
    with tempfile.TemporaryDirectory() as folder:
        for name in members:
            if name in arrays:
                (Path(folder) / name.removeprefix(_SCENE)).write_bytes(arrays.pop(name).tobytes())
        try:
            scene = Scene(**vars(read_scene(Path(folder) / SCENE_FILE, without_functions=motion_alone)))
        except MembraneError as error:
            raise InputError(f"{path}: its scene cannot be read: {error}") from None
    state = {name: value.item() if value.ndim == 0 else value for name, value in arrays.items()}
    if motion_alone:
        state["scene_digest"] = scene_digest(scene)
    _complete(path, scene, state)
    return scene, state


NEW = ("hub_phase", "scene_digest", "start_internal_kinetic")
"""Entries that a state of version 0.1 lacks, all of them: a file that lacks one is damaged."""


def _complete(path: Path, scene: Scene, state: dict[str, Any]) -> None:
    """Add what a state of version 0.1 lacks: its hub began at the angle 0, and its scene is the one beside it.

    Where something is held, `start_internal_kinetic` has no part in the residual of the energy balance. Where nothing
    is, it cannot be known any more.
    """
    if any(name in state for name in NEW) or "start_kinetic" not in state:
        return
    if not len(scene.assemble().fixed):
        raise InputError(
            f"{path}: holds no 'start_internal_kinetic', which a scene needs that nothing holds; go on with the "
            "version that wrote it, or start from the positions and velocities in the file"
        )
    state |= {"hub_phase": 0.0, "scene_digest": scene_digest(scene), "start_internal_kinetic": state["start_kinetic"]}


def _arrays(path: Path) -> dict[str, np.ndarray[Any, Any]]:
    """All entries of the archive, checked by its checksum. Raises as `read_state` does."""
    try:
        arrays = {_RENAMED.get(name, name): array for name, array in read_arrays(path).items()}
    except FileNotFoundError:
        raise MissingFileError(
            f"{path}: there is no such saved state; name a run's folder, or a file that Simulation.save wrote"
        ) from None
    except ArchiveError as error:
        raise InputError(f"{path}: is no saved state ({error}); give a file that Simulation.save wrote") from None
    if _is_damaged(path.read_bytes()):
        raise InputError(f"{path}: its checksum is not that of its content; the file is damaged: give another one")
    return arrays
