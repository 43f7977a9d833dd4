"""A mesh in a file: saved, loaded, and read from those of other programs."""

from __future__ import annotations

from pathlib import Path

from typing_extensions import Self

from membrane_rs._files import path_of
from membrane_rs.errors import InputError
from membrane_rs.mesh.file import read_mesh, write_mesh
from membrane_rs.mesh.fold_reading import FOLD, FoldFile, read_fold_file
from membrane_rs.mesh.fold_writing import write_fold_file
from membrane_rs.mesh.formats import built, mesh_of_file
from membrane_rs.mesh.meshio_process import BY_SUFFIX


class Stored:
    """What a mesh has to do with files."""

    def save(self, path: str | Path) -> None:
        """Write the mesh into one file, whole or not at all: a numpy archive (.npz), or FOLD (.fold).

        The archive holds the arrays of this class by their names, node sets as "node_set:<name>" and triangle sets as
        "triangle_set:<name>"; `write_fold` describes the other. A scene file names it as `[mesh] file = "mesh.npz"`.

        Parameters
        ----------
        path : path
            Of the file, which ends in .npz or .fold.

        Raises
        ------
        InputError
            A path with another ending; a mesh that FOLD cannot hold.
        OutputError
            It cannot be written.

        Examples
        --------
        >>> import tempfile
        >>> from pathlib import Path
        >>> from membrane_rs import Mesh
        >>> mesh = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     mesh.save(Path(folder) / "mesh.npz")
        ...     Mesh.load(Path(folder) / "mesh.npz")
        Mesh(3 nodes, 1 triangles, 0 crease edges)
        """
        file = path_of(path)
        if file.suffix.lower() == FOLD:
            write_fold_file(file, self)
            return
        if file.suffix != ".npz":
            raise InputError(f"path = {str(file)!r}: must end in .npz or {FOLD}, as a scene file needs it")
        write_mesh(file, self)

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """The mesh that `save` wrote; its `source` is None.

        Parameters
        ----------
        path : path
            Of the file.

        Returns
        -------
        Mesh
            Equal to the one that was saved.

        Raises
        ------
        MissingFileError
            No such file.
        MeshError
            A file that holds no mesh, an array that a mesh does not have, or a mesh that cannot be built.
        InputError, InputTypeError
            No path; a file of another program, which `read` takes.

        Examples
        --------
        See `save`.

        >>> from membrane_rs import Mesh
        >>> Mesh.load("nowhere.npz")
        Traceback (most recent call last):
        membrane_rs.errors.MissingFileError: ...
        """
        file = path_of(path)
        if file.suffix.lower() in BY_SUFFIX:
            raise InputError(
                f"path = {str(file)!r}: is a mesh of another program, which does not say its unit; take "
                'Mesh.read(path, scale="mm"), with its unit'
            )
        found = {**read_fold_file(file, FoldFile()), "source": None} if file.suffix.lower() == FOLD else read_mesh(file)
        return built(cls, file, found)

    @classmethod
    def read(
        cls,
        path: str | Path,
        *,
        scale: float | str | None = None,
        quads: str | None = None,
        merge: float | str | None = None,
        frame: int | None = None,
    ) -> Self:
        """The mesh in a file of another program: FOLD, Gmsh, OBJ, STL, VTU and others that meshio reads; or of `save`.

        Its `source` is a `MeshOrigin`, which says what was done to make the mesh of the file.

        Parameters
        ----------
        path : path
            Of the file; its suffix says of which kind it is.
        scale : float or str
            The unit of its coordinates: "mm", or its length in metres, 0.001. Needed, but for .npz, which is in metres,
            and for FOLD files that name their unit.
        quads : {"shorter", "alternate"}, optional
            How quadrilaterals are split: each by its shorter diagonal, and rectangles alternately, or all so that
            diagonals meet at every other node. Default: "shorter".
        merge : float or str, optional
            Nodes that are not further apart become one [m], or as a text with its unit, "1 um". Default: none do, but
            those of an STL file with equal coordinates, which is how such a file says that triangles are joined.
        frame : int, optional
            Of a FOLD file: the frame whose coordinates are the positions. See `read_fold`.

        Returns
        -------
        Mesh
            In metres, with named groups of the file as node sets and triangle sets, without nodes that no triangle has.

        Raises
        ------
        MissingFileError
            No such file.
        MeshError
            A file that cannot be read, or holds no triangles; cells that cannot be simulated.
        InputError, InputTypeError
            No path, a suffix of no such file, no scale, a value outside its range.

        Examples
        --------
        >>> import tempfile
        >>> from pathlib import Path
        >>> from membrane_rs import Mesh
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     path = Path(folder) / "square.obj"
        ...     _ = path.write_text("v 0 0 0\\nv 50 0 0\\nv 50 50 0\\nv 0 50 0\\nf 1 2 3 4\\n")
        ...     mesh = Mesh.read(path, scale="mm")
        >>> mesh.triangles.tolist(), float(mesh.reference.max())
        ([[0, 1, 2], [0, 2, 3]], 0.05)
        >>> mesh.source.steps[0]
        '1 quadrilateral split into triangles by the rule "shorter"'
        """
        given = {"scale": scale, "quads": quads, "merge": merge, "frame": frame}
        values = {name: value for name, value in given.items() if value is not None}
        return mesh_of_file(cls, path_of(path), values, "Mesh.read")
