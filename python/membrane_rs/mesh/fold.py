"""Meshes in FOLD files, the format of origami programs: crease patterns in, stowed shapes out."""

from __future__ import annotations

from pathlib import Path

from membrane_rs._files import path_of
from membrane_rs._validation import build, check_kind, check_text
from membrane_rs.errors import InputTypeError
from membrane_rs.mesh.fold_reading import FOLD, FoldFile, read_fold_file
from membrane_rs.mesh.fold_writing import write_fold_file
from membrane_rs.mesh.formats import built, with_scale
from membrane_rs.mesh.mesh import Mesh


def read_fold(path: str | Path, *, scale: float | str | None = None, frame: int | None = None) -> Mesh:
    """The mesh of a FOLD file of version 1, 1.1 or 1.2, as any program writes it.

    The reference is the frame of class "creasePattern", the positions those of the first frame of class "foldedForm"
    with the same vertices, edges and faces. A folded form alone is both. Faces are cut into triangles, and wound one
    way. Without faces, they are those between the edges of a plane pattern. Edges that are cuts become boundaries.

    Creases are the edges of assignment M, V or U. Their fold angles are those of the file. Where it has none, they are
    taken from the folded form; in a crease pattern they are 180 degrees.

    Parameters
    ----------
    path : path
        Of the file.
    scale : float or str, optional
        The unit of its coordinates, "mm", or its length in metres, 0.001. For files whose `frame_unit` is no unit of
        length, which need it.
    frame : int, optional
        Frame whose coordinates are the positions; 0 is the key frame. Default: the folded form, where there is one.

    Returns
    -------
    Mesh
        In metres. Node k is vertex k of the file; nodes that a cut has doubled follow. Its `source` is a `MeshOrigin`.

    Raises
    ------
    MissingFileError
        No such file.
    MeshError
        What is no FOLD file, or no film: the message names the file, the frame and the key.
    InputError, InputTypeError
        No path, a scale that is not above 0, a frame that is no whole number.

    Examples
    --------
    See `write_fold`.
    """
    file = path_of(path)
    given = {"scale": scale, "frame": frame}
    values = {name: value for name, value in given.items() if value is not None}
    options = build(FoldFile, with_scale(FoldFile, values, "read_fold", FOLD), "read_fold")
    return built(Mesh, file, read_fold_file(file, options))


def write_fold(path: str | Path, mesh: Mesh, *, title: str = "") -> None:
    """Write a mesh as a FOLD file of version 1.2, whole or not at all.

    The key frame is the film without strain, with its creases; a second one, of class "foldedForm", the positions,
    where they differ. Edges that are no creases are of assignment J, and F where the stowed film is bent at them.
    Node sets and bridges stand in keys of our own. `read_fold` makes the same mesh of it, bit by bit.

    Parameters
    ----------
    path : path
        Of the file.
    mesh : Mesh
        What is written [m].
    title : str
        Of the file.

    Raises
    ------
    MeshError
        Triangles that are wound in opposite senses, or three of them at an edge.
    OutputError
        It cannot be written.
    InputError, InputTypeError
        No path, no mesh, no text.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from membrane_rs.folding import SquareSail
    >>> from membrane_rs.mesh import read_fold, write_fold
    >>> mesh = SquareSail().mesh()
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_fold(Path(folder) / "sail.fold", mesh, title="a sail")
    ...     again = read_fold(Path(folder) / "sail.fold")
    >>> bool((again.positions == mesh.positions).all()), bool((again.fold_angles == mesh.fold_angles).all())
    (True, True)
    """
    file = path_of(path)
    check_kind(mesh, Mesh, "mesh", "a Mesh")
    if not isinstance(title, str):
        raise InputTypeError(f"title = {title!r:.60}: must be a text")
    check_text(title, "title")
    write_fold_file(file, mesh, title)
