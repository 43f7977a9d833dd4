"""The folder of many runs: what was asked for, and each run that was made as one file, whole or absent.

request.json       what was asked for, as text: scene, end, samples, measures, and what the study adds
scene.toml         the scene from which all runs depart, and mesh.npz where no pattern made its mesh
runs/<mark>.npz    a run by the mark of its values and its start: its row as JSON, and its history

The same request in the same folder goes on where it was stopped; another one is refused, with the difference.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from membrane_rs._archives import read_arrays
from membrane_rs._files import (
    PART,
    check_unlinked,
    made_folder,
    output_errors,
    read_text,
    reading_errors,
    replacing,
    write_text,
)
from membrane_rs._validation import show
from membrane_rs.errors import MissingFileError, OutputError
from membrane_rs.mesh.file import ARRAYS, SETS
from membrane_rs.results.lock import LOCK, FolderLock
from membrane_rs.scene import Scene
from membrane_rs.scene.scene import SCENE_FILE
from membrane_rs.scene.toml import MESH_FILE, pattern_name, tomllib
from membrane_rs.study.common.one_run import OUTCOMES, RunPoint, RunResult

REQUEST = "request.json"
RUNS = "runs"
OWN_FILES = (REQUEST, SCENE_FILE, MESH_FILE, f"{RUNS}/*.npz")
MOST_REQUEST = 2**28
"""Bytes of a longer request, which is not read: 10^5 values have fewer."""
SHOWN = 4
"""Differences between two requests that an error names."""


class DamagedRequestError(OutputError):
    """The request of a folder cannot be read as JSON."""


class KeptRuns:
    """The folder, locked for one process at a time.

    Parameters
    ----------
    folder :
        It is made, or empty, or that of the same request.
    scene :
        From which all runs depart.
    request :
        What was asked for beside the scene: plain values by name.
    outputs :
        Patterns of further files that are this folder's own.
    overwrite :
        Whether the runs of another request are removed.

    Raises
    ------
    OutputError
        Another request, other files, or another process in the folder; or it cannot be written.
    """

    def __init__(
        self,
        folder: str | Path,
        scene: Scene,
        request: Mapping[str, Any],
        *,
        outputs: Sequence[str] = (),
        overwrite: bool = False,
    ) -> None:
        self.path = made_folder(folder, "out")
        self._own = (*OWN_FILES, *outputs)
        asked = json.loads(json.dumps({"scene": scene.to_toml(), "mesh": mesh_mark(scene), **request}))
        self._lock = FolderLock(self.path)
        if not self._lock.acquire():
            raise OutputError(
                f"cannot write into {self.path}: another process makes runs there; wait for its end, or choose "
                "another folder"
            )
        try:
            self._open(scene, asked, overwrite=overwrite)
        except BaseException:
            self._lock.release()
            raise

    def _open(self, scene: Scene, asked: Mapping[str, Any], *, overwrite: bool) -> None:
        with output_errors(self.path):
            others = {file.name for file in self.path.iterdir()} - {LOCK, REQUEST + PART}
        if others and REQUEST not in others:
            raise OutputError(
                f"cannot write into {self.path}: it is not empty, and holds no {REQUEST}; choose another folder"
            )
        if others and (different := differences(self._there(overwrite=overwrite), asked)):
            if not overwrite:
                more = f"; and {len(different) - SHOWN} more" if len(different) > SHOWN else ""
                raise OutputError(
                    f"{self.path} holds runs of another request: {'; '.join(different[:SHOWN])}{more}. Choose another "
                    "folder, repeat that request to go on with it, or overwrite it (overwrite=True, --overwrite)"
                )
            self._clear()
        elif others and overwrite:
            self._clear()
        with output_errors(self.path):
            (self.path / RUNS).mkdir(exist_ok=True)
        scene.save(self.path)
        write_text(self.path / REQUEST, json.dumps(asked, indent=1) + "\n", synced=True)

    def _there(self, *, overwrite: bool) -> dict[str, Any]:
        """The request of the folder; none where it is damaged and its runs are to be removed."""
        try:
            return read_request(self.path)
        except DamagedRequestError:
            if overwrite:
                return {}
            raise

    def _clear(self) -> None:
        """Remove the files of other runs, the request last: until then the folder is known as theirs."""
        names = [name for pattern in reversed(self._own) for name in (pattern, pattern + PART)]
        files = [file for name in names for file in self.path.glob(name)]
        check_unlinked(self.path, files)
        for file in files:
            with output_errors(file):
                file.unlink(missing_ok=True)

    def get(self, point: RunPoint) -> RunResult | None:
        """A run that was made, or None. Raises OutputError for a damaged file."""
        return kept_run(self.path, point)

    def keep(self, result: RunResult) -> None:
        """Write a run onto the disk, whole or not at all. Raises OutputError."""
        self._lock.check()
        row = {
            "values": dict(result.point.values),
            "start": result.point.start,
            "outcome": result.outcome,
            "message": result.message,
            "facts": dict(result.facts),
            "columns": list(result.history),
        }
        history = np.array(list(result.history.values()), dtype=np.float64)
        with replacing(file_of(self.path, result.point), synced=True) as part, part.open("wb") as file:
            np.savez_compressed(file, row=np.array(json.dumps(row)), history=history)

    def close(self) -> None:
        """Give the folder back."""
        self._lock.release()


def file_of(folder: Path, point: RunPoint) -> Path:
    """Where a folder keeps a run."""
    return folder / RUNS / f"{point_mark(point)}.npz"


def kept_run(folder: Path, point: RunPoint) -> RunResult | None:
    """A run that a folder has, or None. Raises OutputError for a damaged file, and for that of another run."""
    path = file_of(folder, point)
    if not path.is_file():
        return None
    found = read_run(path)
    if point_mark(found.point) != path.stem:
        raise OutputError(f"{path} holds another run than its name says; remove it, and it is made again")
    return replace(found, point=point)


def count_kept(folder: Path) -> int:
    """Number of runs that a folder holds."""
    return sum(1 for _ in (folder / RUNS).glob("*.npz"))


def point_mark(point: RunPoint) -> str:
    """A short mark of values and start, the same for the same bits."""
    text = json.dumps({"values": dict(point.values), "start": point.start}, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def mesh_mark(scene: Scene) -> str | None:
    """A mark of a mesh that a scene's text only names; None for one of a pattern, whose dimensions are in the text."""
    if scene.mesh is None or pattern_name(scene.mesh) is not None:
        return None
    digest = hashlib.sha256()
    for name in ARRAYS:
        digest.update(np.ascontiguousarray(getattr(scene.mesh, name)).tobytes())
    for name, nodes in sorted(scene.mesh.node_sets.items()):
        digest.update(name.encode() + np.ascontiguousarray(nodes).tobytes())
    for name, triangles in sorted(scene.mesh.triangle_sets.items()):
        digest.update(f"{SETS['triangle_sets']}{name}".encode() + np.ascontiguousarray(triangles).tobytes())
    return digest.hexdigest()[:16]


def read_request(folder: Path) -> dict[str, Any]:
    """What a folder of runs was asked for.

    Raises
    ------
    MissingFileError
        It has none.
    DamagedRequestError
        It is no JSON.
    OutputError
        It cannot be read, or is another program's.
    """
    path = folder / REQUEST
    if not path.is_file():
        raise MissingFileError(f"no {REQUEST} in {folder}; name the folder of a sweep or an ensemble")
    with reading_errors(path, "request of many runs"):
        try:
            found = json.loads(read_text(path, MOST_REQUEST))
        except (ValueError, RecursionError) as error:
            raise DamagedRequestError(
                f"{path} is damaged: {' '.join(str(error).split())}; choose another folder, or remove the runs of this "
                "one and make them again (overwrite=True, --overwrite)"
            ) from error
    if not isinstance(found, dict) or not isinstance(found.get("scene"), str):
        raise OutputError(f"{path} is no request of many runs: it names no scene; choose another folder")
    return found


def read_run(path: Path) -> RunResult:
    """A run from its file. Raises OutputError for a damaged one."""
    try:
        arrays = read_arrays(path)
        row, history = json.loads(str(arrays["row"])), arrays["history"]
        columns, values, facts = row["columns"], row["values"], row["facts"]
        if row["outcome"] not in OUTCOMES or not isinstance(values, dict) or not isinstance(facts, dict):
            raise ValueError("it holds no row of a table")
        if not all(fact is None or isinstance(fact, int | float) for fact in facts.values()):
            raise ValueError("not all of its facts are numbers")
        if history.size and (history.ndim != 2 or len(history) != len(columns)):
            raise ValueError(f"its history has the shape {history.shape}, for {len(columns)} columns")
        table = {str(name): np.asarray(history[k], dtype=np.float64) for k, name in enumerate(columns)}
        return RunResult(RunPoint(values, int(row["start"])), row["outcome"], str(row["message"]), facts, table)
    except (ValueError, KeyError, TypeError, IndexError, RecursionError, FileNotFoundError) as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        raise OutputError(
            f"{path} is no run of a sweep, or damaged: {reason}; remove it, and it is made again"
        ) from None


def differences(there: Mapping[str, Any], here: Mapping[str, Any]) -> list[str]:
    """What differs between two requests, as texts: the values that are there, and those that are given here."""
    old, new = _flat(there), _flat(here)
    return [
        f"{key} = {_shown(old, key)} there, {_shown(new, key)} here"
        for key in dict.fromkeys((*old, *new))
        if _shown(old, key) != _shown(new, key) or old.get(key) != new.get(key)
    ]


def _flat(request: Mapping[str, Any]) -> dict[str, Any]:
    """A request by dotted keys, its scene key by key."""
    table = dict(request)
    try:
        scene = tomllib.loads(str(table.pop("scene", "")))
    except (ValueError, RecursionError):
        scene = {"scene": "damaged"}
    return dict(_leaves(scene, "")) | dict(_leaves(table, ""))


def _leaves(value: Any, place: str) -> Iterator[tuple[str, Any]]:
    if isinstance(value, Mapping):
        for key, item in value.items():
            yield from _leaves(item, f"{place}.{key}" if place else str(key))
    elif isinstance(value, list) and value and all(isinstance(item, Mapping) for item in value):
        for k, item in enumerate(value):
            yield from _leaves(item, f"{place}[{k}]")
    else:
        yield place, value


def _shown(table: Mapping[str, Any], key: str) -> str:
    return show(table[key]) if key in table else "not given"
