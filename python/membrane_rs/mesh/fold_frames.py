"""Frames of a FOLD file: its JSON, what frames inherit from one another, and their arrays, with the place of a fault.

The format: https://github.com/edemaine/fold, specification 1.2. Keys with a colon belong to one program; those of
others are skipped.
"""

from __future__ import annotations

import json
import math
from collections import ChainMap, Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from membrane_rs._arrays import Floats, Ints
from membrane_rs._bounds import check_nodes
from membrane_rs._files import read_text
from membrane_rs._validation import show
from membrane_rs.errors import MeshError, MissingFileError

SPECIFICATIONS = (1, 1.1, 1.2)
"""Versions of the format that are read."""
MOST_BYTES = 2**28
"""A larger file is not read: the lists of its JSON take some twenty times as much memory."""
MOST_FRAMES = 10_000
"""Frames of a file that is read, at most."""
MOST_ANCESTORS = 1000
"""Frames from which one may inherit, one from the other."""
OLD_KEYS = {"edges_foldAngle": "edges_foldAngles", "edges_length": "edges_lengths"}
"""Keys that version 1.0 called otherwise."""
UNITS = {
    "m": (1.0, 1.0), "cm": (1.0, 1e2), "mm": (1.0, 1e3), "um": (1.0, 1e6), "nm": (1.0, 1e9), "in": (127.0, 5e3),
    "pt": (127.0, 3.6e5),
}  # fmt: skip
"""Metres of each unit of a frame, as numerator and denominator, so that 455 mm are the very number 0.455 m."""
LARGEST = 1e100
"""Size of a coordinate, at most: beyond it products of three overflow."""
ASSIGNMENTS = "BMVFUCJ"
"""Letters of `edges_assignment`: border, mountain, valley, flat, unassigned, cut, join."""


@dataclass(frozen=True)
class Frame:
    """One frame of a file, with all that it inherits."""

    path: Path
    index: int
    values: ChainMap[str, Any]

    def fail(self, place: str, words: str) -> NoReturn:
        """Raise a MeshError that names the file, the frame and the key."""
        raise MeshError(f"{self.path}: frame {self.index}: {place}{words}")

    def get(self, key: str) -> Any:
        """A value, by its present key or that of version 1.0; None without it."""
        value = self.values.get(key)
        return self.values.get(OLD_KEYS[key]) if value is None and key in OLD_KEYS else value

    def has_own(self, key: str) -> bool:
        """Whether it has a value that it does not inherit, or inherits from none."""
        own = self.values.maps[0]
        return len(self.values.maps) == 1 or key in own or OLD_KEYS.get(key) in own

    def words(self, key: str) -> tuple[str, ...]:
        """A list of texts, such as `frame_classes`; empty without it."""
        found = self.get(key)
        if found is None:
            return ()
        if not isinstance(found, list) or not all(isinstance(word, str) for word in found):
            self.fail(key, f" = {show(found)}: must be a list of texts")
        return tuple(found)

    def rows(self, key: str) -> list[Any] | None:
        """A list; None without it."""
        found = self.get(key)
        if found is not None and not isinstance(found, list):
            self.fail(key, f" = {show(found)}: must be a list")
        return found

    def coordinates(self) -> Floats:
        """(n, 3) `vertices_coords`, in the unit of the file."""
        rows = self.rows("vertices_coords")
        if not rows:
            self.fail("vertices_coords", ": is missing; a mesh needs the coordinates of its vertices")
        check_nodes(len(rows), f"{self.path}: frame {self.index}: vertices_coords", "take fewer", MeshError)
        for i, row in enumerate(rows):
            place = f"vertices_coords[{i}]"
            if not isinstance(row, list) or len(row) not in (2, 3):
                self.fail(place, f" = {show(row)}: must be a list of two or three numbers, [x, y] or [x, y, z]")
            for j, number in enumerate(row):
                self._check_number(number, f"{place}[{j}]")
        try:
            points = np.array([(*row, 0.0)[:3] for row in rows], dtype=np.float64)
        except OverflowError:
            self.fail("vertices_coords", ": holds a number of hundreds of digits; shorten it")
        for i in np.flatnonzero((np.abs(points) > LARGEST).any(axis=1))[:1]:
            self.fail(f"vertices_coords[{i}]", f" = {rows[i]}: must be within -{LARGEST:g} and {LARGEST:g}")
        return points

    def polygons(self, vertex_count: int) -> list[list[int]] | None:
        """`faces_vertices`: three vertices or more each, none twice; None without faces."""
        rows = self.rows("faces_vertices")
        if not rows:
            return None
        check_nodes(len(rows) / 2, f"{self.path}: frame {self.index}: faces_vertices", "take fewer", MeshError)
        for i, row in enumerate(rows):
            place = f"faces_vertices[{i}]"
            self._check_indices(row, place, vertex_count)
            if len(row) < 3:
                self.fail(place, f" = {show(row)}: a face has three vertices or more")
            if len(set(row)) < len(row):
                self.fail(place, f" = {show(row)}: names a vertex twice; split a face with a slit or a hole")
        return rows

    def edges(self, vertex_count: int) -> Ints:
        """(e, 2) `edges_vertices`, each pair once; empty without edges."""
        rows = self.rows("edges_vertices") or []
        check_nodes(len(rows) / 4, f"{self.path}: frame {self.index}: edges_vertices", "take fewer", MeshError)
        first: dict[tuple[int, int], int] = {}
        for i, row in enumerate(rows):
            place = f"edges_vertices[{i}]"
            self._check_indices(row, place, vertex_count)
            if len(row) != 2 or row[0] == row[1]:
                self.fail(place, f" = {show(row)}: an edge has two different vertices")
            k = first.setdefault((min(row), max(row)), i)
            if k != i:
                self.fail(place, f" = {show(row)}: is the edge edges_vertices[{k}] again; name it once")
        pairs: Ints = np.array(rows, dtype=np.int64).reshape(-1, 2)
        return pairs

    def assignments(self, edge_count: int) -> list[str] | None:
        """`edges_assignment`, a letter for each edge; None without it."""
        found = self._one_each("edges_assignment", edge_count)
        for i, letter in enumerate(found or []):
            if not isinstance(letter, str) or len(letter) != 1 or letter not in ASSIGNMENTS:
                self.fail(f"edges_assignment[{i}]", f" = {show(letter)}: must be one of {', '.join(ASSIGNMENTS)}")
        return found

    def fold_angles(self, edge_count: int) -> list[float | None] | None:
        """`edges_foldAngle` [degrees], a number or null for each edge; None without it."""
        found = self._one_each("edges_foldAngle", edge_count)
        for i, angle in enumerate(found or []):
            if angle is not None:
                place = f"edges_foldAngle[{i}]"
                self._check_number(angle, place)
                if not -180.0 <= angle <= 180.0:
                    self.fail(place, f" = {show(angle)}: must be from -180 to 180 degrees, valley positive")
        return found

    def lengths(self, edge_count: int) -> list[float] | None:
        """`edges_length`, a number for each edge, in the unit of the file; None without it."""
        found = self._one_each("edges_length", edge_count)
        for i, length in enumerate(found or []):
            self._check_number(length, f"edges_length[{i}]")
            if not length > 0.0:
                self.fail(f"edges_length[{i}]", f" = {show(length)}: must be above 0")
        return found

    def metres(self, scale: float | None) -> tuple[float, float]:
        """Metres of a unit of length, as numerator and denominator: of `frame_unit`, or `scale`."""
        unit = self.get("frame_unit")
        if unit is not None and not isinstance(unit, str):
            self.fail("frame_unit", f" = {show(unit)}: must be a text")
        if unit in UNITS:
            if scale is not None:
                self.fail("frame_unit", f" = {unit!r}: says the unit, beside scale = {scale:g}; leave scale out")
            return UNITS[unit]
        if scale is None:
            said = ": is missing" if unit is None else f" = {show(unit)}: is no unit of length"
            self.fail("frame_unit", f'{said}; give the unit, scale = "mm", or its length in metres, scale = 0.001')
        return scale, 1.0

    def _one_each(self, key: str, count: int) -> list[Any] | None:
        found = self.rows(key)
        if found is not None and len(found) != count:
            self.fail(key, f": has {len(found)} entries, and edges_vertices {count}; give one for each edge")
        return found

    def _check_number(self, value: object, place: str) -> None:
        if type(value) not in (int, float):
            self.fail(place, f" = {show(value)}: must be a number")
        if isinstance(value, float) and not math.isfinite(value):
            self.fail(place, f" = {value}: is beyond the numbers of a computer")

    def _check_indices(self, row: object, place: str, count: int) -> None:
        if not isinstance(row, list):
            self.fail(place, f" = {show(row)}: must be a list of vertices")
        for j, vertex in enumerate(row):
            if type(vertex) is not int:
                self.fail(f"{place}[{j}]", f" = {show(vertex)}: must be a whole number, the index of a vertex")
            if not 0 <= vertex < count:
                self.fail(f"{place}[{j}]", f" = {show(vertex)}: is no vertex; indices run from 0 to {count - 1}")


def read_frames(path: Path) -> list[Frame]:
    """All frames of a file, the key frame first.

    Raises
    ------
    MissingFileError
        No such file.
    MeshError
        No JSON, another version of the format, or frames that inherit from what is no frame.
    """
    table = _json(path)
    if not isinstance(table, dict):
        raise MeshError(f"{path}: is no FOLD file, whose JSON is an object; it holds {show(table)}")
    version = table.get("file_spec")
    if version is not None and (isinstance(version, bool) or version not in SPECIFICATIONS):
        known = ", ".join(map(str, SPECIFICATIONS))
        raise MeshError(f"{path}: file_spec = {show(version)}: is no version of FOLD that is read; these are {known}")
    others = table.get("file_frames", [])
    if not isinstance(others, list) or len(others) >= MOST_FRAMES:
        raise MeshError(f"{path}: file_frames = {show(others)}: must be a list of at most {MOST_FRAMES - 1} frames")
    tables = [table, *others]
    for k, each in enumerate(tables):
        if not isinstance(each, dict):
            raise MeshError(f"{path}: file_frames[{k - 1}] = {show(each)}: must be an object")
    return [Frame(path, k, ChainMap(*_line_of_descent(path, tables, k))) for k in range(len(tables))]


def chosen_frame(frames: list[Frame], index: int) -> Frame:
    """The frame of a number that a user gave. Raises MeshError."""
    if not 0 <= index < len(frames):
        raise MeshError(
            f"{frames[0].path}: frame = {show(index)}: is no frame of this file; they run from 0 to {len(frames) - 1}"
        )
    return frames[index]


def _line_of_descent(path: Path, tables: list[dict[str, Any]], index: int) -> list[dict[str, Any]]:
    """The frame and those that it inherits from, nearest first."""
    line, seen = [index], {index}
    while line[-1] > 0:
        table, place = tables[line[-1]], f"{path}: frame {line[-1]}: "
        inherits = table.get("frame_inherit", False)
        if not isinstance(inherits, bool):
            raise MeshError(f"{place}frame_inherit = {show(inherits)}: must be true or false")
        parent = table.get("frame_parent")
        if parent is None and not inherits:
            break
        if type(parent) is not int or not 0 <= parent < len(tables):
            said = ": is missing beside frame_inherit" if parent is None else f" = {show(parent)}: is no frame"
            raise MeshError(f"{place}frame_parent{said}; frames run from 0 to {len(tables) - 1}")
        if not inherits:
            break
        if parent in seen or len(line) > MOST_ANCESTORS:
            why = "inherits from itself" if parent in seen else f"inherits from more than {MOST_ANCESTORS} frames"
            raise MeshError(f"{place}frame_parent = {parent}: frame {index} {why}; name a frame that stands before")
        line.append(parent)
        seen.add(parent)
    return [tables[k] for k in line]


def _json(path: Path) -> Any:
    """The JSON of a file: no key twice, no NaN."""
    try:
        text = read_text(path, MOST_BYTES)
    except FileNotFoundError:
        raise MissingFileError(f"{path}: there is no such FOLD file; give the path of one") from None
    except UnicodeDecodeError as error:
        raise MeshError(f"{path}: is no UTF-8 text ({error}); a FOLD file is JSON") from None
    except OSError as error:
        raise MeshError(f"{path}: cannot be read ({error.strerror}); give the path of a FOLD file") from None
    try:
        return json.loads(text, object_pairs_hook=_unique(path), parse_constant=_no_constant(path))
    except json.JSONDecodeError as error:
        line = text.splitlines()[error.lineno - 1 : error.lineno] or [""]
        found = show(line[0][max(0, error.colno - 20) : error.colno + 20])
        raise MeshError(
            f"{path}: is no JSON, as a FOLD file is: {error.msg} in line {error.lineno}, column {error.colno}: {found}"
        ) from None
    except RecursionError:
        raise MeshError(f"{path}: is nested too deeply; a FOLD file needs lists in lists and no more") from None
    except ValueError as error:
        if isinstance(error, MeshError):
            raise
        raise MeshError(f"{path}: holds a whole number of thousands of digits ({error}); shorten it") from None


def _unique(path: Path) -> Callable[[list[tuple[str, Any]]], dict[str, Any]]:
    def of(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        table = dict(pairs)
        if len(table) < len(pairs):
            twice = Counter(key for key, _ in pairs).most_common(1)[0][0]
            raise MeshError(f"{path}: {show(twice)} stands twice in one object of its JSON; leave one of them out")
        return table

    return of


def _no_constant(path: Path) -> Callable[[str], NoReturn]:
    def of(name: str) -> NoReturn:
        raise MeshError(f"{path}: holds {name}, which JSON does not have; replace it by a number")

    return of
