"""What is simulated: nodes, triangles, and how they are folded at the start."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from membrane_rs import _core
from membrane_rs.errors import InputTypeError, MeshError
from membrane_rs.material import Material

if TYPE_CHECKING:
    from membrane_rs.audit import Audit

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

T = TypeVar("T", bound=np.generic)

NO_AREA = 1e-9
"""Height over longest side below which a triangle counts as having no area."""


class Mesh:
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
        Fold angle of each crease at the start [rad], between -pi and pi, signed as in the FOLD format: seen
        from the side from which triangles run counter-clockwise, valley positive, mountain negative.
        Default: zero, which is flat.
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
        crease that is no edge between two triangles, lengths that differ.
    InputTypeError
        Something that is no number, or no whole number where an index is asked for.
    """

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
        self.reference: Floats = _points(reference, "reference")
        self.source = source
        n = len(self.reference)
        if n == 0:
            raise MeshError("reference has no nodes; a mesh needs at least three")
        self.triangles: Ints = _indices(triangles, "triangles", 3, n)
        if len(self.triangles) == 0:
            raise MeshError("triangles is empty; a mesh needs at least one triangle")
        self.positions: Floats = self.reference if positions is None else self.checked_positions(positions)
        self.creases: Ints = _indices(_or_empty(creases), "creases", 2, n)
        self.bridges: Ints = _indices(_or_empty(bridges), "bridges", 2, n)
        self.fold_angles: Floats = _fold_angles(fold_angles, len(self.creases))
        self._node_sets = _node_sets(node_sets or {}, n)
        self._check_creases()

    @property
    def node_count(self) -> int:
        """Number of nodes, n."""
        return len(self.reference)

    @property
    def node_sets(self) -> Mapping[str, Ints]:
        """Node indices by name; read only."""
        return MappingProxyType(self._node_sets)

    @cached_property
    def edges(self) -> Ints:
        """(e, 2) node pairs, the smaller index first, in lexicographic order: one spring each."""
        return _frozen(np.asarray(_core.edges(self.triangles, self.node_count), dtype=np.int64))

    @cached_property
    def triangle_edges(self) -> Ints:
        """(m, 3) index in `edges` of the side opposite to each corner of each triangle."""
        first, second = self.triangles[:, [1, 2, 0]], self.triangles[:, [2, 0, 1]]
        return _frozen(self._find_edges(np.stack([first.ravel(), second.ravel()], axis=1))[0].reshape(-1, 3))

    @cached_property
    def triangles_per_edge(self) -> Ints:
        """(e,) number of triangles that share each edge."""
        count: Ints = np.bincount(self.triangle_edges.ravel(), minlength=len(self.edges)).astype(np.int64)
        return _frozen(count)

    @property
    def boundary_edges(self) -> Ints:
        """(b, 2) the edges of one triangle only."""
        boundary: Ints = self.edges[self.triangles_per_edge == 1]
        return boundary

    @cached_property
    def edge_lengths(self) -> Floats:
        """(e,) lengths of the edges in the reference [m]."""
        return _frozen(self._lengths(self.reference))

    def strain(self, positions: ArrayLike | None = None) -> Floats:
        """(e,) strain of each edge, by default in the stowed positions; inf for an edge of no length.

        Raises
        ------
        MeshError, InputTypeError
            Positions that do not fit the mesh.
        """
        points = self.positions if positions is None else self.checked_positions(positions)
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = self._lengths(points) / self.edge_lengths
        return np.nan_to_num(ratio, nan=np.inf, posinf=np.inf) - 1.0

    def areas(self) -> Floats:
        """(m,) areas of the triangles in the reference [m2]."""
        a, b, c = (self.reference[self.triangles[:, i]] for i in range(3))
        result: Floats = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
        return result

    def spring_constants(self, material: Material) -> Floats:
        """(e,) spring constant of each edge [N/m], the sum over its triangles; it may be negative.

        Raises
        ------
        MeshError
            A triangle without area.
        """
        flat = np.flatnonzero(self.flatness() < NO_AREA)
        if len(flat):
            raise MeshError(
                f"{len(flat)} of {len(self.triangles)} triangles have no area, first triangle {flat[0]} "
                f"(nodes {self.triangles[flat[0]].tolist()}); remove them, or move their nodes apart"
            )
        m = material
        return np.asarray(
            _core.spring_constants(self.reference, self.triangles, m.youngs_modulus, m.poisson_ratio, m.thickness),
            dtype=np.float64,
        )

    def masses(self, material: Material) -> Floats:
        """(n,) mass of each node [kg]: a third of each triangle around it."""
        areal_density = material.density * material.thickness
        return np.asarray(_core.lumped_masses(self.reference, self.triangles, areal_density), dtype=np.float64)

    def flatness(self) -> Floats:
        """(m,) smallest height over longest side of each triangle; 0 without area, 0.87 equilateral."""
        return self._flatness

    def audit(
        self, material: Material | None = None, positions: ArrayLike | None = None, *, springs: bool = True
    ) -> Audit:
        """What is wrong or risky with the mesh, in words and numbers.

        Parameters
        ----------
        material : Material, optional
            Default: the polyimide film of the deployment experiments. The signs depend on Poisson's ratio
            only.
        positions : (n, 3) float64, optional
            Where the strain is measured. Default: the stowed positions.
        springs : bool
            Whether edges are to be springs; False for a film of `Triangles`, which asks less of a mesh.
        """
        from membrane_rs.audit import audit

        return audit(self, material, positions, springs=springs)

    def checked_positions(self, positions: ArrayLike) -> Floats:
        """A read-only copy of positions that fit this mesh.

        Raises
        ------
        MeshError, InputTypeError
            Another shape than (n, 3), NaN or infinite, no numbers.
        """
        points = _points(positions, "positions")
        if points.shape != self.reference.shape:
            raise MeshError(
                f"positions has {len(points)} nodes and reference {self.node_count}; give one row for each node"
            )
        return points

    def __repr__(self) -> str:
        counts = f"{self.node_count} nodes, {len(self.triangles)} triangles, {len(self.creases)} crease edges"
        return f"Mesh({counts})"

    @cached_property
    def _flatness(self) -> Floats:
        longest = self.edge_lengths[self.triangle_edges].max(axis=1)
        ratio: Floats = 2.0 * self.areas() / np.maximum(longest**2, np.finfo(float).tiny)
        return _frozen(np.where(longest > 0.0, ratio, 0.0))

    def _lengths(self, points: Floats) -> Floats:
        difference = points[self.edges[:, 1]] - points[self.edges[:, 0]]
        lengths: Floats = np.sqrt(np.einsum("ij,ij->i", difference, difference))
        return lengths

    def _find_edges(self, pairs: Ints) -> tuple[Ints, Bools]:
        """Index in `edges` of each node pair, and whether it is an edge at all."""
        keys = self.edges[:, 0] * self.node_count + self.edges[:, 1]
        first, second = pairs.T
        wanted = np.minimum(first, second) * self.node_count + np.maximum(first, second)
        index = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
        return index.astype(np.int64), keys[index] == wanted

    def _check_creases(self) -> None:
        if len(self.creases) == 0:
            return
        index, known = self._find_edges(self.creases)
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


def distinct(nodes: Ints) -> Ints:
    """Node indices of any shape, each once, ascending: as `numpy.unique`, but counted, not sorted or hashed."""
    return np.flatnonzero(np.bincount(nodes.ravel()))


def _frozen(array: NDArray[T]) -> NDArray[T]:
    array.setflags(write=False)
    return array


def _or_empty(pairs: ArrayLike | None) -> ArrayLike:
    return np.empty((0, 2), dtype=np.int64) if pairs is None else pairs


def _numeric(values: ArrayLike, name: str, kinds: str, wanted: str) -> NDArray[Any]:
    try:
        array = np.asarray(values)
    except (TypeError, ValueError) as error:
        raise MeshError(f"{name} is no regular array ({error}); give rows of equal length") from None
    if array.size and array.dtype.kind not in kinds:
        raise InputTypeError(f"{name} has dtype {array.dtype}; it must hold {wanted}")
    return array


def _points(values: ArrayLike, name: str) -> Floats:
    array = _numeric(values, name, "fiu", "numbers, in metres")
    if array.ndim != 2 or array.shape[1] != 3:
        raise MeshError(f"{name} has shape {array.shape}; it must be (n, 3), one row x, y, z for each node")
    points = np.array(array, dtype=np.float64)
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(bad):
        raise MeshError(
            f"{name}[{bad[0]}] = {points[bad[0]].tolist()} is not finite ({len(bad)} such nodes); "
            "replace NaN and infinite values by numbers"
        )
    return _frozen(points)


def _indices(values: ArrayLike, name: str, width: int, node_count: int) -> Ints:
    array = _numeric(values, name, "iu", "whole numbers, node indices")
    if array.size == 0:
        array = np.empty((0, width), dtype=np.int64)
    if array.ndim != 2 or array.shape[1] != width:
        raise MeshError(f"{name} has shape {array.shape}; it must be (k, {width}), node indices in each row")
    _check_range(array, name, node_count)
    rows: Ints = np.array(array, dtype=np.int64)
    ordered = np.sort(rows, axis=1)
    bad = np.flatnonzero((ordered[:, 1:] == ordered[:, :-1]).any(axis=1))
    if len(bad):
        raise MeshError(
            f"{name}[{bad[0]}] = {rows[bad[0]].tolist()} names a node twice ({len(bad)} such rows); "
            "remove the row or correct it"
        )
    return _frozen(rows)


def _node_sets(sets: Mapping[str, ArrayLike], node_count: int) -> dict[str, Ints]:
    if not isinstance(sets, Mapping) or not all(isinstance(name, str) for name in sets):
        raise InputTypeError("node_sets must be a dict from names (str) to lists of node indices")
    return {name: _node_set(nodes, f"node_sets['{name}']", node_count) for name, nodes in sets.items()}


def _node_set(values: ArrayLike, name: str, node_count: int) -> Ints:
    array = _numeric(values, name, "iu", "whole numbers, node indices")
    if array.ndim != 1:
        raise MeshError(f"{name} has shape {array.shape}; it must be (k,), a list of node indices")
    _check_range(array, name, node_count)
    nodes: Ints = _frozen(np.array(array, dtype=np.int64))
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


def _fold_angles(values: ArrayLike | None, count: int) -> Floats:
    array = _numeric(np.zeros(count) if values is None else values, "fold_angles", "fiu", "angles in radians")
    if array.shape != (count,):
        raise MeshError(f"fold_angles has shape {array.shape}; it must be ({count},), one angle for each crease")
    angles: Floats = np.array(array, dtype=np.float64)
    bad = np.flatnonzero(~(np.abs(angles) <= np.pi + 1e-12))
    if len(bad):
        raise MeshError(
            f"fold_angles[{bad[0]}] = {angles[bad[0]]} is outside -pi to pi; give it in radians, flat is zero"
        )
    return _frozen(angles)
