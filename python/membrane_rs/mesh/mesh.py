"""What is simulated: nodes, triangles, and how they are folded at the start."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from types import MappingProxyType
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from membrane_rs._arrays import Floats, Ints
from membrane_rs._html import Card, HasCard, Lines
from membrane_rs.errors import MeshError
from membrane_rs.material import Material
from membrane_rs.mesh.audit import audit
from membrane_rs.mesh.crossings import LISTED, Crossings, crossings
from membrane_rs.mesh.divided import divided, divided_nodes, divided_triangles
from membrane_rs.mesh.findings import Audit
from membrane_rs.mesh.fold_angles import given_fold_angles
from membrane_rs.mesh.given_mesh import fitting, indices_of, or_empty, points_of, sets_of
from membrane_rs.mesh.stored import Stored
from membrane_rs.mesh.triangulation import Triangulation, frozen


class Mesh(HasCard, Stored, Triangulation):
    """A triangulated membrane in its strain-free and in its stowed shape; it is read only, its arrays as well.

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
    triangle_sets : dict of str to (k,) int, optional
        Names for triangles, for instance "film".
    source : object, optional
        The folding pattern that made the mesh; the `MeshOrigin` of one that `read` made.

    Raises
    ------
    MeshError
        Wrong shape, nothing in it, NaN or infinite, index out of range, a node twice in one triangle, a
        crease that is no edge between two triangles, lengths that differ, a fold angle that contradicts
        `positions`, a shut crease whose fold angle is left out.
    InputTypeError
        Something that is no number, or no whole number where an index is asked for.

    Examples
    --------
    A square of two triangles that share a valley fold:

    >>> from membrane_rs import Material, Mesh
    >>> corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    >>> mesh = Mesh(corners, [[0, 1, 2], [0, 2, 3]], creases=[[0, 2]], fold_angles=[0.5], node_sets={"base": [0, 1]})
    >>> mesh.node_count, len(mesh.edges), mesh.node_sets["base"].tolist()
    (4, 5, [0, 1])
    >>> film = Material(3.2e9, 0.34, 1420.0, 7.5e-6)
    >>> mesh.areas().tolist(), round(float(mesh.masses(film).sum()), 5)
    ([0.5, 0.5], 0.01065)
    >>> float(abs(mesh.strain()).max()), mesh.audit(film).ok
    (0.0, True)
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
        triangle_sets: Mapping[str, ArrayLike] | None = None,
        source: object = None,
    ) -> None:
        nodes = points_of(reference, "reference")
        self.source = source
        n = len(nodes)
        if n == 0:
            raise MeshError("reference has no nodes; a mesh needs at least three")
        corners = indices_of(triangles, "triangles", 3, n)
        if len(corners) == 0:
            raise MeshError("triangles is empty; a mesh needs at least one triangle")
        stowed = nodes if positions is None else fitting(positions, n)
        folded = indices_of(or_empty(creases), "creases", 2, n)
        super().__init__(nodes, corners, folded, indices_of(or_empty(bridges), "bridges", 2, n))
        self.positions: Floats = stowed
        self._node_sets = sets_of(node_sets, "node_sets", "node", n)
        self._triangle_sets = sets_of(triangle_sets, "triangle_sets", "triangle", len(corners))
        self._check_creases()
        self.fold_angles: Floats = frozen(given_fold_angles(self, stowed, fold_angles))

    @property
    def node_sets(self) -> Mapping[str, Ints]:
        """Node indices by name; read only."""
        return MappingProxyType(self._node_sets)

    @property
    def triangle_sets(self) -> Mapping[str, Ints]:
        """Triangle indices by name; read only."""
        return MappingProxyType(self._triangle_sets)

    def strain(self, positions: ArrayLike | None = None) -> Floats:
        """(e,) strain of each edge, by default in the stowed positions; inf for an edge of no length.

        Parameters
        ----------
        positions : (n, 3) array_like, optional
            Of the nodes [m]. Default: the stowed positions.

        Returns
        -------
        (e,) float64
            Strain of each edge [-], in the order of `edges`.

        Raises
        ------
        MeshError, InputTypeError
            Positions that do not fit the mesh.

        Examples
        --------
        >>> from membrane_rs.folding import Strip
        >>> mesh = Strip(length=0.1, width=0.01, rows=1, columns=10).mesh()
        >>> float(mesh.strain(1.01 * mesh.reference).max().round(6))
        0.01
        """
        given = None if positions is None else self.checked_positions(positions)
        lengths = self._stowed_lengths if given is None else self._lengths_at(given)
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = lengths / self.edge_lengths
        return np.nan_to_num(ratio, nan=np.inf, posinf=np.inf) - 1.0

    @cached_property
    def _stowed_lengths(self) -> Floats:
        return frozen(self._lengths_at(self.positions))

    def audit(
        self,
        material: Material | None = None,
        positions: ArrayLike | None = None,
        *,
        springs: bool = True,
        growth: bool = True,
        crossings: bool = True,
        stiffness: Floats | None = None,
    ) -> Audit:
        """Faults and risks of the mesh, in words and numbers.

        Parameters
        ----------
        material : Material, optional
            Default: the polyimide film of the deployment experiments. Signs of spring constants depend on Poisson's
            ratio, and on `stiffness`.
        positions : (n, 3) float64, optional
            Of the nodes where the strain is measured and crossings are counted [m]. Default: the stowed positions.
        springs : bool
            Whether edges are to be springs; False for a film of `Triangles`, which may have obtuse angles.
        growth : bool
            Whether modes that grow by negative springs are computed, which takes some seconds for 50,000 nodes.
        crossings : bool
            Whether triangles that pass through each other are counted, as `Mesh.crossings` does.
        stiffness : (m,) float64, optional
            E h of each triangle [N/m], as of `spring_constants`. Default: that of the material.

        Returns
        -------
        Audit
            What was found, errors first.

        Raises
        ------
        MeshError, InputError, InputTypeError
            What does not fit the mesh, or is of a wrong kind.
        """
        points = self.positions if positions is None else self.checked_positions(positions)
        strain = self.strain(positions)
        flags = {"springs": springs, "growth": growth, "crossings": crossings}
        return audit(self, material, points, strain, stiffness=stiffness, **flags)

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

        Examples
        --------
        >>> from membrane_rs.folding import SquareSail
        >>> SquareSail().mesh().crossings().count
        0
        """
        points = self.positions if positions is None else self.checked_positions(positions)
        return crossings(self.triangles, points, limit)

    def divided(self, count: int) -> Mesh:
        """The same mesh with all sides in equal parts, each triangle in count^2 of its own shape.

        New nodes lie on straight lines between the old ones, in the reference and in `positions`: strain and fold
        angles stay as they are. A coarse pattern is thus folded first, with rigid facets, and divided then.

        Parameters
        ----------
        count : int
            Parts of each side, from 1 to 1000.

        Returns
        -------
        Mesh
            Old nodes keep their numbers. A node set takes the new nodes on sides both of whose ends it holds, a
            triangle set the parts of its triangles. Its `source` is None.

        Raises
        ------
        InputError, InputTypeError
            No whole number from 1 to 1000.
        MeshError
            A mesh with bridges; more nodes than fit.

        Examples
        --------
        >>> from membrane_rs.folding import Miura
        >>> sheet = Miura(straight_side=0.02, zigzag_side=0.02, tilt=1.2, columns=6, rows=4).mesh()
        >>> fine = sheet.divided(3)
        >>> fine.node_count, len(fine.creases) == 3 * len(sheet.creases), bool(abs(fine.strain()).max() < 1e-12)
        (247, True, True)
        """
        found = divided(self, count, self.positions, self.fold_angles)
        return Mesh(
            **found,
            node_sets={name: divided_nodes(self, count, nodes) for name, nodes in self._node_sets.items()},
            triangle_sets={name: divided_triangles(count, rows) for name, rows in self._triangle_sets.items()},
        )

    def checked_positions(self, positions: ArrayLike) -> Floats:
        """A read-only copy of positions that fit this mesh.

        Parameters
        ----------
        positions : (n, 3) array_like
            Of the nodes [m].

        Returns
        -------
        (n, 3) float64
            The copy [m].

        Raises
        ------
        MeshError, InputTypeError
            Another shape than (n, 3), NaN or infinite, no numbers.

        Examples
        --------
        >>> from membrane_rs.folding import Strip
        >>> mesh = Strip(length=0.1, width=0.01, columns=10).mesh()
        >>> mesh.checked_positions(2.0 * mesh.reference).shape
        (22, 3)
        """
        return fitting(positions, self.node_count)

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Unpickle or copy; arrays are read-only again."""
        self.__dict__.update(state)
        for value in (*state.values(), *self._node_sets.values(), *self._triangle_sets.values()):
            if isinstance(value, np.ndarray):
                frozen(value)

    def __repr__(self) -> str:
        counts = f"{self.node_count} nodes, {len(self.triangles)} triangles, {len(self.creases)} crease edges"
        return f"Mesh({counts})"

    def _card(self) -> Card:
        """What notebooks show: the mesh without strain."""
        extent = self.reference.max(axis=0) - self.reference.min(axis=0)
        rows: list[tuple[str, object]] = [
            ("nodes", self.node_count),
            ("triangles", len(self.triangles)),
            ("edges", len(self.edges)),
            ("crease edges", len(self.creases)),
            ("extent [m]", " x ".join(f"{side:.4g}" for side in extent)),
            ("area [m2]", float(self.areas().sum())),
            ("node sets", ", ".join(self.node_sets) or "none"),
        ]
        if self.triangle_sets:
            rows.append(("triangle sets", ", ".join(self.triangle_sets)))
        return Card("Mesh", rows, Lines(self.reference, self.boundary_edges, self.creases))

    def _check_creases(self) -> None:
        if len(self.creases) == 0:
            return
        index, known = self._rows_of_edges(self.creases)
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
