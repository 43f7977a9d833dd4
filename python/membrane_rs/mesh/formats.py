"""Files that hold a mesh, by their suffix: what reads each, and what is to be said beside the file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import MISSING, fields
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from membrane_rs._quantities import split
from membrane_rs._validation import build, nearest
from membrane_rs.errors import InputError, MeshError, MissingFileError
from membrane_rs.mesh.file import read_mesh
from membrane_rs.mesh.fold_reading import FOLD, FoldFile, read_fold_file
from membrane_rs.mesh.foreign import ForeignFile, read_foreign
from membrane_rs.mesh.meshio_process import BY_SUFFIX

M = TypeVar("M")


class Format(NamedTuple):
    """A kind of file."""

    options: type | None
    """A checked class of what is to be said beside the file; None where the file says all."""
    read: Callable[[Path, Any], Mapping[str, Any]]
    """Takes the file and its options, and gives what `Mesh` takes, by name."""


FORMATS: Mapping[str, Format] = {
    ".npz": Format(None, read_mesh),
    FOLD: Format(FoldFile, read_fold_file),
    **dict.fromkeys(BY_SUFFIX, Format(ForeignFile, read_foreign)),
}
"""The one list, by suffixes in lower case."""


def is_mesh_file(file: object) -> bool:
    """Whether a name ends as that of a file that holds a mesh."""
    return isinstance(file, str) and Path(file).suffix.lower() in FORMATS


def mesh_of_file(kind: Callable[..., M], path: Path, values: Mapping[str, Any], where: str) -> M:
    """The mesh in a file, with what is said beside the file: `where` names the place of that, "mesh" in scene files.

    Raises
    ------
    MissingFileError
        No such file.
    MeshError
        A file that holds no mesh, or one that cannot be built.
    InputError, InputTypeError
        A suffix of no such file; something wrong beside the file.
    """
    suffix = path.suffix.lower()
    if suffix not in FORMATS:
        raise InputError(f"{path}: its suffix {suffix!r} is that of no mesh file; {nearest(suffix, FORMATS)}")
    checked, read = FORMATS[suffix]
    if checked is None and values:
        raise InputError(
            f"{where}.{next(iter(values))}: no such key beside file; a {suffix} file says all; leave it out"
        )
    options = None if checked is None else build(checked, with_scale(checked, values, where, suffix), where)
    if not path.exists():
        raise MissingFileError(f"{path}: there is no such mesh file; give the path of one")
    return built(kind, path, read(path, options))


def built(kind: Callable[..., M], path: Path, found: Mapping[str, Any]) -> M:
    """A mesh of what a file holds. Raises MeshError, which names the file."""
    try:
        return kind(**found)
    except InputError as error:
        raise MeshError(f"{path}: {error}") from None


def with_scale(checked: type, values: Mapping[str, Any], where: str, suffix: str) -> dict[str, Any]:
    """What is said beside a file, "mm" for the scale as "1 mm". Raises InputError without a scale that is needed."""
    found, scale = dict(values), values.get("scale")
    is_needed = any(entry.name == "scale" and entry.default is MISSING for entry in fields(checked))
    if scale is None and is_needed:
        raise InputError(
            f"{where}.scale: is missing; a {suffix} file does not say in which unit its coordinates are: give the "
            'unit, scale = "mm", or its length in metres, scale = 0.001'
        )
    if isinstance(scale, str) and scale.strip() and split(scale) is None:
        found["scale"] = f"1 {scale.strip()}"
    return found
