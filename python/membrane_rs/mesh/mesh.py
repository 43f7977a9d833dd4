"""What is simulated: nodes, triangles, and how they are folded at the start."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import Self

from membrane_rs._arrays import Floats, Ints
from membrane_rs._files import path_of
from membrane_rs._given_arrays import numeric
from membrane_rs._validation import check_text, show
from membrane_rs.errors import InputError, InputTypeError, MeshError
from membrane_rs.material import Material
from membrane_rs.mesh.audit import audit
from membrane_rs.mesh.crossings import LISTED, Crossings, crossings
from membrane_rs.mesh.file import ARRAYS, read_mesh, write_mesh
from membrane_rs.mesh.findings import Audit
from membrane_rs.mesh.fold_angles import check_fold_angles, fold_angles_of
from membrane_rs.mesh.queries import distinct
from membrane_rs.mesh.triangulation import Triangulation, frozen

LONGEST_NAME = 1000
"""Characters of the name of a node set: archives cut longer ones than some ten thousand."""


class Mesh(Triangulation):
    """A triangulated membrane in its strain-free and in its stowed shape.

    Parameters
    ----------
    reference : (n, 3) float64
        Nodes of the shape without strain [m].
    triangles : (m, 3) int
        Corners of each triangle, all wound the same way.
    positions : (n, 3) float64, optional
        Nodes at the start [m]. Default: the reference.
    creases : (c, 2) int, optional
        Node pairs; each is an edge of exactly two triangles.
    fold_angles : (c,) float, optional
        Fold angle of each crease in `positions` [rad], between -pi and pi, signed as in the FOLD format: seen
        from the side from which triangles run counter-clockwise, valley positive, mountain negative. Where a
        crease is folded by 1 to 179 degrees it must have the sign of `positions`, and agree within 5 degrees. One
        of pi or -pi may be open or interpenetrate by as much as the film bends beside it, up to 45 degrees; in layers
        that lie on each other, at several creases, be open by 45 and interpenetrate by 5. Where it is flat, its sign
        says to which side it will fold; where it is shut, on which side its facets lie; the audit of a scene warns
        where such an angle is neither 0 nor +-pi. Default: taken from `positions`, which must then show no shut crease.
    node_sets : dict of str to (k,) int, optional
        Names for nodes, for instance "corners".
    bridges : (b, 2) int, optional
        Node pairs joined by stiff links of no length.
    source : object, optional
        The folding pattern that made the mesh.

    Raises
    ------
    MeshError
        Wrong shape, nothing in it, NaN or infinite, index out of range, a node twice in one triangle, a
        crease that is no edge between two triangles, lengths that differ, a fold angle that contradicts
        `positions`, a shut crease whose fold angle is left out.
    InputTypeError
        Something that is no number, or no whole number where an index is asked for.

    A mesh is read only, its arrays as well.
    """

    ONCE: ClassVar[tuple[str, ...]] = (*Triangulation.ONCE, "positions", "fold_angles", "source")

    def __init__(
        self,
        reference: ArrayLike,
        triangles: ArrayLike,
        *,
        positions: ArrayLike | None = None,
        creases: ArrayLike | None = None,
        fold_angles: ArrayLike | None = None,
        node_sets: Mapping[str, ArrayLike] | None = None,
        bridges: ArrayLike | None = None,
        source: object = None,
    ) -> None:
        nodes = _points(reference, "reference")
        self.source = source
        n = len(nodes)
        if n == 0:
            raise MeshError("reference has no nodes; a mesh needs at least three")
        corners = _indices(triangles, "triangles", 3, n)
        if len(corners) == 0:
            raise MeshError("triangles is empty; a mesh needs at least one triangle")
        stowed = nodes if positions is None else _fitting(positions, n)
        folded = _indices(_or_empty(creases), "creases", 2, n)
        super().__init__(nodes, corners, folded, _indices(_or_empty(bridges), "bridges", 2, n))
        self.positions: Floats = stowed
        self._node_sets = _node_sets({} if node_sets is None else node_sets, n)
        self._check_creases()
        self.fold_angles: Floats = self._fold_angles(fold_angles)

    @property
    def node_sets(self) -> Mapping[str, Ints]:
        """Node indices by name; read only."""
        return MappingProxyType(self._node_sets)

    def strain(self, positions: ArrayLike | None = None) -> Floats:
        """(e,) strain of each edge, by default in the stowed positions; inf for an edge of no length.

        Raises
        ------
        MeshError, InputTypeError
            Positions that do not fit the mesh.
        """
        points = self.positions if positions is None else self.checked_positions(positions)
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = self.lengths_in(points) / self.edge_lengths
        return np.nan_to_num(ratio, nan=np.inf, posinf=np.inf) - 1.0

    def audit(
        self,
        material: Material | None = None,
        positions: ArrayLike | None = None,
        *,
        springs: bool = True,
        growth: bool = True,
        crossings: bool = True,
    ) -> Audit:
        """Faults and risks of the mesh, in words and numbers.

        Parameters
        ----------
        material : Material, optional
            Default: the polyimide film of the deployment experiments. The signs depend on Poisson's ratio
            only.
        positions : (n, 3) float64, optional
            Where the strain is measured and crossings are counted. Default: the stowed positions.
        springs : bool
            Whether edges are to be springs; False for a film of `Triangles`, which may have obtuse angles.
        growth : bool
            Whether modes that grow by negative springs are computed, which takes some seconds for 50,000 nodes.
        crossings : bool
            Whether triangles that pass through each other are counted, as `Mesh.crossings` does.
        """
        points = self.positions if positions is None else self.checked_positions(positions)
        return audit(self, material, points, self.strain(points), springs=springs, growth=growth, crossings=crossings)

    def crossings(self, positions: ArrayLike | None = None, *, limit: int = LISTED) -> Crossings:
        """Pairs of triangles that pass through each other, counted exactly.

        Parameters
        ----------
        positions : (n, 3) float64, optional
            Nodes [m]. Default: the stowed positions.
        limit : int
            Pairs that are listed at most; all are counted.

        Returns
        -------
        Crossings
            Pairs and numbers. It takes some 0.3 us for each pair of triangles whose boxes overlap, of which there are
            all pairs if all lie at one place; Ctrl-C ends it.

        Raises
        ------
        MeshError, InputTypeError
            Positions that do not fit the mesh.
        InputError
            A limit below 0.
        """
        points = self.positions if positions is None else self.checked_positions(positions)
        return crossings(self.triangles, points, limit)

    def checked_positions(self, positions: ArrayLike) -> Floats:
        """A read-only copy of positions that fit this mesh.

        Raises
        ------
        MeshError, InputTypeError
            Another shape than (n, 3), NaN or infinite, no numbers.
        """
        return _fitting(positions, self.node_count)

    def save(self, path: str | Path) -> None:
        """Write the mesh into one numpy archive (.npz), whole or not at all.

        `membrane_rs.mesh.file` describes the format: the arrays of this class by their names, node sets as
        "node_set:<name>". A scene file names it as `[mesh] file = "mesh.npz"`.

        Raises
        ------
        InputError
            A path that does not end in .npz.
        OutputError
            It cannot be written.
        """
        file = path_of(path)
        if file.suffix != ".npz":
            raise InputError(f"path = {str(file)!r}: must end in .npz, as a scene file needs it")
        write_mesh(file, {name: getattr(self, name) for name in ARRAYS}, self.node_sets)

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """The mesh that `save` wrote; its `source` is None.

        Raises
        ------
        MissingFileError
            No such file.
        MeshError
            A file that holds no mesh, an array that a mesh does not have, or a mesh that cannot be built.
        """
        file = path_of(path)
        arrays, sets = read_mesh(file)
        try:
            return cls(arrays.pop("reference"), arrays.pop("triangles"), node_sets=sets, **arrays)
        except InputError as error:
            raise MeshError(f"{file}: {error}") from None

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Unpickle or copy; arrays are read-only again."""
        self.__dict__.update(state)
        for value in (*state.values(), *state["_node_sets"].values()):
            if isinstance(value, np.ndarray):
                frozen(value)

    def __repr__(self) -> str:
        counts = f"{self.node_count} nodes, {len(self.triangles)} triangles, {len(self.creases)} crease edges"
        return f"Mesh({counts})"

    def _check_creases(self) -> None:
        if len(self.creases) == 0:
            return
        index, known = self.find_edges(self.creases)
        count = np.where(known, self.triangles_per_edge[index], 0)
        bad = np.flatnonzero(count != 2)
        if len(bad):
            raise MeshError(
                f"creases[{bad[0]}] = {self.creases[bad[0]].tolist()} is an edge of {count[bad[0]]} "
                f"triangles ({len(bad)} such creases); a crease is an edge between exactly two triangles"
            )
        unique, first = np.unique(index, return_index=True)
        if len(unique) < len(index):
            twice = np.setdiff1d(np.arange(len(index)), first)[0]
            raise MeshError(f"creases[{twice}] = {self.creases[twice].tolist()} is given twice; give it once")

    def _fold_angles(self, values: ArrayLike | None) -> Floats:
        """The given fold angles, compared with positions, or those of positions."""
        if values is None:
            return frozen(fold_angles_of(self, self.positions))
        array = numeric(values, "fold_angles", "fiu", "angles in radians", MeshError)
        count = len(self.creases)
        if array.shape != (count,):
            raise MeshError(f"fold_angles has shape {array.shape}; it must be ({count},), one angle for each crease")
        angles: Floats = np.array(array, dtype=np.float64)
        bad = np.flatnonzero(~(np.abs(angles) <= np.pi + 1e-12))
        if len(bad):
            raise MeshError(
                f"fold_angles[{bad[0]}] = {angles[bad[0]]} is outside -pi to pi; give it in radians, flat is zero"
            )
        check_fold_angles(self, self.positions, angles)
        return frozen(angles)


def _or_empty(pairs: ArrayLike | None) -> ArrayLike:
    return np.empty((0, 2), dtype=np.int64) if pairs is None else pairs


def _points(values: ArrayLike, name: str) -> Floats:
    array = numeric(values, name, "fiu", "numbers, in metres", MeshError)
    if array.ndim != 2 or array.shape[1] != 3:
        raise MeshError(f"{name} has shape {array.shape}; it must be (n, 3), one row x, y, z for each node")
    with np.errstate(over="ignore"):
        points = np.array(array, dtype=np.float64, order="C")
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(bad):
        raise MeshError(
            f"{name}[{bad[0]}] = {points[bad[0]].tolist()} is not finite ({len(bad)} such nodes); "
            "replace NaN and infinite values by numbers"
        )
    return frozen(points)


def _fitting(positions: ArrayLike, node_count: int) -> Floats:
    """A copy of positions, (n, 3) [m], that fit a mesh of so many nodes."""
    points = _points(positions, "positions")
    if len(points) != node_count:
        raise MeshError(f"positions has {len(points)} nodes and reference {node_count}; give one row for each node")
    return points


def _indices(values: ArrayLike, name: str, width: int, node_count: int) -> Ints:
    array = numeric(values, name, "iu", "whole numbers, node indices", MeshError)
    if array.size == 0:
        array = np.empty((0, width), dtype=np.int64)
    if width == 3 and array.shape[1:] == (4,):
        raise MeshError(
            f"{name} has shape {array.shape}: these are quadrilaterals; split each a, b, c, d into the triangles "
            "a, b, c and a, c, d: numpy.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])"
        )
    if array.ndim != 2 or array.shape[1] != width:
        raise MeshError(f"{name} has shape {array.shape}; it must be (k, {width}), node indices in each row")
    _check_range(array, name, node_count)
    rows: Ints = np.array(array, dtype=np.int64, order="C")
    ordered = np.sort(rows, axis=1)
    bad = np.flatnonzero((ordered[:, 1:] == ordered[:, :-1]).any(axis=1))
    if len(bad):
        raise MeshError(
            f"{name}[{bad[0]}] = {rows[bad[0]].tolist()} names a node twice ({len(bad)} such rows); "
            "remove the row or correct it"
        )
    return frozen(rows)


def _node_sets(sets: Mapping[str, ArrayLike], node_count: int) -> dict[str, Ints]:
    if not isinstance(sets, Mapping) or not all(isinstance(name, str) for name in sets):
        raise InputTypeError("node_sets must be a dict from names (str) to lists of node indices")
    for name in sets:
        check_text(name, "node_sets: the name")
        if not 1 <= len(name) <= LONGEST_NAME or "\0" in name:
            raise MeshError(
                f"node_sets: the name {show(name)}: must be 1 to {LONGEST_NAME} characters without a NUL, for files"
            )
    return {name: _node_set(nodes, f"node_sets['{name}']", node_count) for name, nodes in sets.items()}


def _node_set(values: ArrayLike, name: str, node_count: int) -> Ints:
    array = numeric(values, name, "iu", "whole numbers, node indices", MeshError)
    if array.ndim != 1:
        raise MeshError(f"{name} has shape {array.shape}; it must be (k,), a list of node indices")
    _check_range(array, name, node_count)
    nodes: Ints = frozen(np.array(array, dtype=np.int64))
    if len(distinct(nodes)) < len(nodes):
        raise MeshError(f"{name} names a node twice; name it once")
    return nodes


def _check_range(array: NDArray[Any], name: str, node_count: int) -> None:
    if array.size and (array.min() < 0 or array.max() >= node_count):
        bad = np.argwhere((array < 0) | (array >= node_count))[0]
        raise MeshError(
            f"{name}[{', '.join(map(str, bad))}] = {array[tuple(bad)]} is no node; "
            f"indices run from 0 to {node_count - 1}"
        )
