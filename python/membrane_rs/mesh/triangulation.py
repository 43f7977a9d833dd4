"""What follows from nodes and triangles alone: edges, lengths, areas, spring constants and masses."""

from __future__ import annotations

from functools import cached_property
from typing import ClassVar, TypeVar

import numpy as np
from numpy.typing import NDArray

from membrane_rs import _core
from membrane_rs._arrays import Bools, Floats, Ints
from membrane_rs._given_arrays import numeric
from membrane_rs._known_attributes import KnownAttributes
from membrane_rs._validation import check_kind, flag_of
from membrane_rs.errors import InputError, MeshError
from membrane_rs.material import Material

T = TypeVar("T", bound=np.generic)

NO_AREA = 1e-9
"""Height over longest side below which a triangle counts as having no area."""


class Triangulation(KnownAttributes):
    """Nodes joined by triangles, with creases and bridges between some: plain arrays that `Mesh` has checked.

    Parameters
    ----------
    reference : (n, 3) float64
        Nodes of the shape without strain [m].
    triangles : (m, 3) int64
        Corners of each triangle.
    creases, bridges : (c, 2), (b, 2) int64
        Node pairs.
    """

    ONCE: ClassVar[tuple[str, ...]] = ("reference", "triangles", "creases", "bridges")

    def __init__(self, reference: Floats, triangles: Ints, creases: Ints, bridges: Ints) -> None:
        self.reference: Floats = reference
        self.triangles: Ints = triangles
        self.creases: Ints = creases
        self.bridges: Ints = bridges

    @property
    def node_count(self) -> int:
        """Number of nodes, n."""
        return len(self.reference)

    @cached_property
    def edges(self) -> Ints:
        """(e, 2) node pairs, the smaller index first, in lexicographic order: one spring each."""
        return frozen(self._connectivity[0])

    @cached_property
    def triangle_edges(self) -> Ints:
        """(m, 3) index in `edges` of the side opposite to each corner of each triangle."""
        return frozen(self._connectivity[1])

    @cached_property
    def _connectivity(self) -> tuple[Ints, Ints]:
        """The edges, and those of each triangle."""
        return _core.edges(self.triangles, self.node_count)

    @cached_property
    def triangles_per_edge(self) -> Ints:
        """(e,) number of triangles that share each edge."""
        count: Ints = np.bincount(self.triangle_edges.ravel(), minlength=len(self.edges)).astype(np.int64)
        return frozen(count)

    @cached_property
    def boundary_edges(self) -> Ints:
        """(b, 2) the edges of one triangle only."""
        boundary: Ints = self.edges[self.triangles_per_edge == 1]
        return frozen(boundary)

    @cached_property
    def edge_lengths(self) -> Floats:
        """(e,) lengths of the edges in the reference [m]."""
        return frozen(self._lengths_at(self.reference))

    def areas(self) -> Floats:
        """(m,) areas of the triangles in the reference [m2].

        Returns
        -------
        (m,) float64
            [m2]
        """
        areas: Floats = self._areas.copy()
        return areas

    @cached_property
    def _areas(self) -> Floats:
        with np.errstate(over="ignore", invalid="ignore"):  # see `_check_sizes`
            along, across = self.sides_along_axes(self.reference)
            normal = [along[i] * across[j] - along[j] * across[i] for i, j in ((1, 2), (2, 0), (0, 1))]
            areas: Floats = 0.5 * np.sqrt(normal[0] ** 2 + normal[1] ** 2 + normal[2] ** 2)
        return frozen(areas)

    def spring_constants(self, material: Material, *, clip: bool = False, stiffness: Floats | None = None) -> Floats:
        """(e,) spring constant of each edge [N/m], the sum over its triangles.

        It may be negative, unless `clip` sets negative ones to zero, as `Springs(negative="clip")` does.

        Parameters
        ----------
        material : Material
            The film.
        clip : bool
            Whether negative ones are set to zero.
        stiffness : (m,) float64, optional
            E h of each triangle [N/m], as `Scene.membrane_stiffness` gives it for a film with regions. Default: that of
            the material.

        Returns
        -------
        (e,) float64
            [N/m], in the order of `edges`.

        Raises
        ------
        MeshError
            A triangle without area, or too large for a number to hold it.
        InputError, InputTypeError
            No material; a stiffness that is not one number, 0 or above, for each triangle.

        Examples
        --------
        >>> from membrane_rs import Material
        >>> from membrane_rs.folding import Strip
        >>> film = Material(3.2e9, 0.34, 1420.0, 7.5e-6)
        >>> bool((Strip(length=0.1, width=0.01, columns=10).mesh().spring_constants(film) > 0.0).all())
        True
        """
        check_kind(material, Material, "material", "a Material")
        flat = np.flatnonzero(self.flatness() < NO_AREA)
        if len(flat):
            raise MeshError(
                f"{len(flat)} of {len(self.triangles)} triangles have no area, first triangle {flat[0]} "
                f"(nodes {self.triangles[flat[0]].tolist()}); remove them, or move their nodes apart"
            )
        self._check_sizes()
        film = self._membrane_stiffness(material, stiffness), material.poisson_ratio
        constants = np.asarray(_core.spring_constants(self.reference, self.triangles, *film), dtype=np.float64)
        return np.maximum(constants, 0.0) if flag_of("clip", clip) else constants

    def find_rectangles(self) -> Ints:
        """The rectangles that the triangles form in pairs, each with a common longest side that is no crease.

        Returns
        -------
        (r, 4) int64
            Corners in turn. The diagonal from the first to the third is no edge of the mesh, the other one is.

        Raises
        ------
        MeshError
            Triangles that are no halves of rectangles, to 1e-3 of the diagonal; with the first one, and why.

        Examples
        --------
        >>> from membrane_rs.folding import Strip
        >>> Strip(length=0.1, width=0.01, columns=10).mesh().find_rectangles()[:2].tolist()
        [[2, 3, 1, 0], [2, 4, 5, 3]]
        """
        return np.asarray(_core.rectangles(self.reference, self.triangles, self.creases), dtype=np.int64)

    def rectangle_constants(self, material: Material, *, stiffness: Floats | None = None) -> Floats:
        """Spring constants of the film as `Rectangles` [N/m], each the sum over the rectangles at it.

        Parameters
        ----------
        material : Material
            The film.
        stiffness : (m,) float64, optional
            E h of each triangle [N/m], as of `spring_constants`; a rectangle of two films has their mean.

        Returns
        -------
        (e + r,) float64
            [N/m], of the edges in their order, then of the second diagonals in the order of `find_rectangles`.

        Raises
        ------
        MeshError
            As `find_rectangles`, or sides so different that a constant is negative.
        InputError, InputTypeError
            No material; a stiffness that is not one number, 0 or above, for each triangle.

        Examples
        --------
        >>> from membrane_rs import Material
        >>> from membrane_rs.folding import Strip
        >>> film = Material(1.0, 1 / 3, 1.0, 1.0)
        >>> Strip(length=1.0, width=1.0, columns=1).mesh().rectangle_constants(film).round(3).tolist()
        [0.375, 0.375, 0.375, 0.375, 0.375, 0.375]
        """
        check_kind(material, Material, "material", "a Material")
        film = self._membrane_stiffness(material, stiffness), material.poisson_ratio
        return np.asarray(_core.rectangle_constants(self.reference, self.triangles, self.creases, *film))

    def _membrane_stiffness(self, material: Material, stiffness: Floats | None) -> Floats:
        """(m,) E h of each triangle [N/m]. Raises InputError, InputTypeError."""
        count = len(self.triangles)
        if stiffness is None:
            return np.full(count, material.youngs_modulus * material.thickness)
        given = np.asarray(numeric(stiffness, "stiffness", "fiu", "numbers: E h of each triangle (N/m)"), np.float64)
        if given.shape != (count,):
            raise InputError(f"stiffness has shape {given.shape}; it must be ({count},): a number a triangle (N/m)")
        wrong = np.flatnonzero(~(given >= 0.0))
        if len(wrong):
            raise InputError(f"stiffness[{wrong[0]}] = {given[wrong[0]]:g}: must be 0 or greater (N/m)")
        return given

    def _check_sizes(self) -> None:
        """A MeshError where a triangle is too large for a number to hold its area."""
        large = np.flatnonzero(~np.isfinite(self._areas))
        if len(large):
            corners = self.triangles[large[0]]
            farthest = float(np.abs(self.reference[corners]).max())
            raise MeshError(
                f"{len(large)} of {len(self.triangles)} triangles are too large for a number to hold their area, first "
                f"triangle {large[0]} (nodes {corners.tolist()}), which reaches to {farthest:g} m; give lengths in "
                "metres"
            )

    def masses(self, material: Material) -> Floats:
        """(n,) mass of each node [kg]: a third of each triangle around it.

        Parameters
        ----------
        material : Material
            The film.

        Returns
        -------
        (n,) float64
            [kg]

        Raises
        ------
        MeshError
            A triangle without area, or too large for a number to hold it.
        InputTypeError
            No material.
        """
        check_kind(material, Material, "material", "a Material")
        self._check_sizes()
        areal_density = material.density * material.thickness
        return np.asarray(_core.lumped_masses(self.reference, self.triangles, areal_density), dtype=np.float64)

    def flatness(self) -> Floats:
        """(m,) smallest height over longest side of each triangle; 0 without area, 0.87 equilateral.

        Returns
        -------
        (m,) float64
            [-]

        Examples
        --------
        >>> from membrane_rs.folding import Strip
        >>> Strip(length=0.1, width=0.01, columns=10).mesh().flatness().min().round(2).item()
        0.5
        """
        return self._flatness

    @cached_property
    def _flatness(self) -> Floats:
        longest = np.maximum.reduce([self.edge_lengths[edges] for edges in self.triangle_edges.T])
        with np.errstate(over="ignore", invalid="ignore"):
            ratio: Floats = 2.0 * self._areas / np.maximum(longest**2, np.finfo(float).tiny)
        return frozen(np.where(longest > 0.0, ratio, 0.0))

    def lengths_in(self, points: Floats) -> Floats:
        """(e,) lengths of the edges where nodes lie at `points` (n, 3) [m].

        Parameters
        ----------
        points : (n, 3) float64
            [m]

        Returns
        -------
        (e,) float64
            [m]

        Raises
        ------
        InputError, InputTypeError
            No numbers, or another number of points than the mesh has nodes.

        Examples
        --------
        >>> from membrane_rs.folding import Strip
        >>> mesh = Strip(length=0.1, width=0.01, columns=10).mesh()
        >>> bool((mesh.lengths_in(mesh.reference) == mesh.edge_lengths).all())
        True
        """
        points = numeric(points, "points", "fiu", "numbers: x, y, z of each node (m)")
        if points.shape != (self.node_count, 3):
            raise InputError(f"points has shape {points.shape}; it must be ({self.node_count}, 3): a row a node")
        return self._lengths_at(points)

    def sides_along_axes(self, points: Floats) -> tuple[list[Floats], list[Floats]]:
        """The sides from the first corner of each triangle to its second and to its third one, axis by axis.

        Parameters
        ----------
        points : numpy.ndarray
            (n, 2) or (n, 3) places of the nodes [m].

        Returns
        -------
        tuple of list of numpy.ndarray
            (m,) for each axis, to the second and to the third corner [m].

        Examples
        --------
        >>> from membrane_rs import scenes
        >>> mesh = scenes.load("spinning-disc").mesh
        >>> along, across = mesh.sides_along_axes(mesh.reference)
        >>> len(along) == len(across) == 3
        True
        """
        a, b, c = (np.ascontiguousarray(corner) for corner in self.triangles.T)
        places = [np.ascontiguousarray(along) for along in points.T]
        first = [place[a] for place in places]
        along, across = ([place[end] - start for place, start in zip(places, first, strict=True)] for end in (b, c))
        return along, across

    def _lengths_at(self, points: Floats) -> Floats:
        first, second = (np.ascontiguousarray(ends) for ends in self.edges.T)
        with np.errstate(over="ignore", invalid="ignore"):
            along = map(np.ascontiguousarray, points.T)
            x, y, z = ((place[second] - place[first]) ** 2 for place in along)
            lengths: Floats = np.sqrt((x + z) + y)
        return lengths

    def find_edges(self, pairs: Ints) -> tuple[Ints, Bools]:
        """Index in `edges` of each node pair, and whether it is an edge at all.

        Parameters
        ----------
        pairs : (k, 2) int
            Nodes.

        Returns
        -------
        indices : (k,) int
            In `edges`; of no meaning where it is none.
        is_edge : (k,) bool
            Whether it is one.

        Raises
        ------
        InputError, InputTypeError
            No pairs of whole numbers, or a node that the mesh has not.

        Examples
        --------
        >>> import numpy as np
        >>> from membrane_rs.folding import Strip
        >>> mesh = Strip(length=0.1, width=0.01, columns=10).mesh()
        >>> index, is_edge = mesh.find_edges(np.array([mesh.edges[3], [0, 21]]))
        >>> index[0].item(), is_edge.tolist()
        (3, [True, False])
        """
        pairs = numeric(pairs, "pairs", "iu", "whole numbers, node indices")
        if pairs.ndim != 2 or pairs.shape[1] != 2:
            raise InputError(f"pairs has shape {pairs.shape}; it must be (k, 2): the two nodes of each pair")
        if len(pairs) and not 0 <= pairs.min() <= pairs.max() < self.node_count:
            wrong = int(pairs.min()) if pairs.min() < 0 else int(pairs.max())
            raise InputError(f"pairs: node {wrong}: must be from 0 to {self.node_count - 1}")
        return self._rows_of_edges(pairs)

    def _rows_of_edges(self, pairs: Ints) -> tuple[Ints, Bools]:
        keys = self.edges[:, 0] * self.node_count + self.edges[:, 1]
        first, second = pairs.T
        wanted = np.minimum(first, second) * self.node_count + np.maximum(first, second)
        index = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
        return index.astype(np.int64), keys[index] == wanted


def frozen(array: NDArray[T]) -> NDArray[T]:
    """The array itself, made read-only."""
    array.setflags(write=False)
    return array
