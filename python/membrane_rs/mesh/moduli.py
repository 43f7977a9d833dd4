"""Effective elastic moduli of a mesh's net of springs, from uniform strains.

The springs of eq. (1) represent a film exactly in three states of uniaxial stress per triangle, not in every direction.
For a uniform strain e of the flat reference, spring k of length L along n is stretched by L n.e.n + n.(u_j - u_i), with
u the displacement of its nodes beyond the uniform one. Affine, every node follows the strain (u = 0): this has no
effect of the boundary, and is exact where each inner node is a centre of symmetry. Relaxed (homogenised), the nodes of
the boundary follow the strain, and the others rest where no net force is left on them.
The energy per area is e.C.e/2, in the components 11, 22, 12 with the engineering shear strain 2 e_12, and

    1/E(a) = t.S.t,    t = (c^2, s^2, c s),    S = C^-1                                            [m/N]
    1/G(a) = w.S.w,    w = (-2 c s, 2 c s, c^2 - s^2)
    nu(a)  = -E(a) t.S.p,    p = (s^2, c^2, -c s)

with c and s the cosine and sine of the direction a. Each is given relative to the film's own, E_Y h and
E_Y h/(2 (1 + nu)). Springs that buckle are not considered.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from membrane_rs._arrays import Bools, Floats
from membrane_rs._given_arrays import numeric
from membrane_rs._validation import check_kind, flag_of
from membrane_rs.errors import MeshError
from membrane_rs.material import Material
from membrane_rs.mesh.triangulation import Triangulation

Angle: TypeAlias = "float | Floats"

_FLAT = 1e-6
"""Distance from a plane, relative to the size, up to which a reference counts as flat."""
_ISOTROPIC = 1e-3
"""Relative difference of the extremes of E below which a net has no axes of its own."""
_UNBALANCED = 1e-9
"""Net force on a node, relative to that of one spring, from which the inner nodes are relaxed."""
_NO_STIFFNESS = 1e-12
"""Smallest eigenvalue of C, relative to the largest, up to which the net gives way without a force."""
_GRID = np.radians(np.arange(1800) / 10.0)


@dataclass(frozen=True)
class NetModuli:
    """Moduli of a net of springs; angles are those from the x axis of the reference [deg].

    Attributes
    ----------
    stiffness : (3, 3) float64
        C, over E_Y h of the film [-].
    film_poisson_ratio : float
        nu of the film [-].
    is_balanced : bool
        Whether the uniform strain leaves no net force on any inner node, so that relaxation changes nothing.
    local_extremes : tuple of float
        Least and greatest E/E_Y over all directions [-], each as a mean over the surroundings of the inner nodes. On a
        mesh whose cells turn from place to place, as on a disc, the whole hides how these differ.

    Examples
    --------
    >>> from membrane_rs import Material
    >>> from membrane_rs.folding import EquilateralLattice
    >>> from membrane_rs.mesh import net_moduli
    >>> film = Material(3.2e9, 1 / 3, 1420.0, 7.5e-6)
    >>> net = net_moduli(EquilateralLattice(side=0.01, columns=12, rows=12).mesh(), film, relaxed=True)
    >>> net.stiffness.shape, net.film_poisson_ratio
    ((3, 3), 0.3333333333333333)
    >>> bool(net.modulus(30.0) > 0.9), bool(net.shear_modulus(30.0) > 0.8), bool(0.2 < net.poisson_ratio(30.0) < 0.5)
    (True, True, True)
    """

    stiffness: Floats
    film_poisson_ratio: float
    is_balanced: bool
    local_extremes: tuple[float, float]

    def modulus(self, angle: Angle = 0.0) -> Floats:
        """E/E_Y along a direction [deg].

        Parameters
        ----------
        angle : float or array
            Direction, from the x axis of the reference [deg].

        Returns
        -------
        float64 array
            [-], of the shape of `angle`.

        Raises
        ------
        InputTypeError
            No numbers.
        """
        return _modulus(np.linalg.inv(self.stiffness), _radians(angle))

    def shear_modulus(self, angle: Angle = 0.0) -> Floats:
        """G over the film's, of a shear along a direction [deg].

        Parameters
        ----------
        angle : float or array
            Direction, from the x axis of the reference [deg].

        Returns
        -------
        float64 array
            [-], of the shape of `angle`.

        Raises
        ------
        InputTypeError
            No numbers.
        """
        radians = _radians(angle)
        c, s = np.cos(radians), np.sin(radians)
        w = np.stack([-2 * c * s, 2 * c * s, c * c - s * s], axis=-1)
        compliance = np.einsum("...i,ij,...j", w, np.linalg.inv(self.stiffness), w)
        return np.asarray(2.0 * (1.0 + self.film_poisson_ratio) / compliance)

    def poisson_ratio(self, angle: Angle = 0.0) -> Floats:
        """nu of a pull along a direction [deg]; not relative.

        Parameters
        ----------
        angle : float or array
            Direction, from the x axis of the reference [deg].

        Returns
        -------
        float64 array
            [-], of the shape of `angle`.

        Raises
        ------
        InputTypeError
            No numbers.
        """
        radians = _radians(angle)
        c, s = np.cos(radians), np.sin(radians)
        t, p = np.stack([c * c, s * s, c * s], axis=-1), np.stack([s * s, c * c, -c * s], axis=-1)
        compliance = np.linalg.inv(self.stiffness)
        along = np.einsum("...i,ij,...j", t, compliance, t)
        return np.asarray(-np.einsum("...i,ij,...j", t, compliance, p) / along)

    @property
    def extremes(self) -> tuple[float, float]:
        """Least and greatest E/E_Y over all directions [-]."""
        every = _modulus(np.linalg.inv(self.stiffness), _GRID)
        return float(every.min()), float(every.max())

    @property
    def axis(self) -> float:
        """The mesh's own axis [deg], from 0 to 180: the first direction of the greatest E; 0 if E is equal in all."""
        every = _modulus(np.linalg.inv(self.stiffness), _GRID)
        if every.max() - every.min() < _ISOTROPIC * every.max():
            return 0.0
        return float(np.degrees(_GRID[np.flatnonzero(every >= (1.0 - 1e-6) * every.max())[0]]))

    @property
    def is_isotropic(self) -> bool:
        """Whether all moduli, here and in the surroundings of each node, agree with the film's to 1 %."""
        least, greatest = self.local_extremes
        values = [*self.extremes, least, greatest, float(self.shear_modulus(self.axis))]
        return all(abs(value - 1.0) < 0.01 for value in values)


def net_moduli(mesh: Triangulation, material: Material, *, relaxed: bool = False, clip: bool = False) -> NetModuli:
    """Moduli of the net of springs that the core makes of a film on this mesh.

    Parameters
    ----------
    mesh : Mesh
        Its reference must be flat.
    material : Material
        The film.
    relaxed : bool
        False: every node follows the uniform strain (affine). True: those of the boundary do, and the others rest where
        no net force is left on them (homogenised); its moduli are the smaller ones.
    clip : bool
        Whether negative spring constants are set to zero, as by `Springs(negative="clip")`. False: they are kept.

    Returns
    -------
    NetModuli
        Relative to those of the film.

    Raises
    ------
    MeshError
        A reference that is not flat, a triangle without area, or a net that has no stiffness against some strain,
        because springs are negative or clipped.
    InputTypeError
        Neither a mesh nor a material.

    Examples
    --------
    >>> from membrane_rs import scenes
    >>> from membrane_rs.mesh import net_moduli
    >>> scene = scenes.load("okuizumi-model-1")
    >>> net = net_moduli(scene.mesh, scene.material)
    >>> net.is_isotropic
    False
    """
    check_kind(mesh, Triangulation, "mesh", "a Mesh")
    check_kind(material, Material, "material", "a Material")
    points, film = _in_plane(mesh.reference), material.youngs_modulus * material.thickness
    constants = mesh.spring_constants(material, clip=clip) / film
    ends, area = points[mesh.edges], float(mesh.areas().sum())
    along = ends[:, 1] - ends[:, 0]
    length = np.linalg.norm(along, axis=1)
    n = along / length[:, None]
    shape = length[:, None] * np.stack([n[:, 0] ** 2, n[:, 1] ** 2, n[:, 0] * n[:, 1]], axis=1)
    stretch = np.zeros_like(shape)
    is_inner = np.zeros(len(points), dtype=np.bool_)
    is_inner[mesh.edges] = True
    is_inner[mesh.boundary_edges] = False
    is_inner[mesh.edges[mesh.triangles_per_edge > 2]] = False
    pull = np.zeros((len(points), 2, 3))
    forces = constants[:, None, None] * n[:, :, None] * shape[:, None, :]
    np.add.at(pull, mesh.edges[:, 0], forces)
    np.add.at(pull, mesh.edges[:, 1], -forces)
    is_balanced = bool(np.abs(pull[is_inner]).max(initial=0.0) <= _UNBALANCED * np.abs(forces).max())
    if flag_of("relaxed", relaxed) and not is_balanced:
        moved = _relaxed(mesh, constants, n, pull, is_inner)
        stretch = np.einsum("ea,eaj->ej", n, moved[mesh.edges[:, 1]] - moved[mesh.edges[:, 0]])
    total = shape + stretch
    stiffness = np.einsum("e,ei,ej->ij", constants, total, total) / area
    least, *_, greatest = np.linalg.eigvalsh(stiffness)
    if least <= _NO_STIFFNESS * greatest:
        raise MeshError("the net of springs has no stiffness in one direction; make no triangle obtuse")
    around = _local_extremes(mesh, points, material, is_inner, (constants > 0.0) | (not clip))
    return NetModuli(stiffness, material.poisson_ratio, is_balanced, around)


def rectangle_moduli(material: Material) -> NetModuli:
    """Moduli of a film of `Rectangles`, whose sides are at 0 and 90 degrees; they do not depend on the mesh.

    C_11 = C_22 = 1/(1 - nu^2) and C_33 = 1/(2 (1 + nu)) are those of plane stress. C_12 = 1/(2 (1 + nu)), since the
    diagonals alone couple both strains and shear; the film's is nu/(1 - nu^2).

    Parameters
    ----------
    material : Material
        The film.

    Returns
    -------
    NetModuli
        Relative to those of the film.

    Raises
    ------
    InputTypeError
        No material.

    Examples
    --------
    >>> from membrane_rs import Material
    >>> from membrane_rs.mesh import rectangle_moduli
    >>> net = rectangle_moduli(Material(3.2e9, 0.2, 1420.0, 7.5e-6))
    >>> round(float(net.modulus(0.0)), 3), round(float(net.shear_modulus(0.0)), 3), net.is_isotropic
    (0.875, 1.0, False)
    """
    check_kind(material, Material, "material", "a Material")
    nu = material.poisson_ratio
    along, shear = 1.0 / (1.0 - nu * nu), 0.5 / (1.0 + nu)
    stiffness = np.array([[along, shear, 0.0], [shear, along, 0.0], [0.0, 0.0, shear]])
    every = _modulus(np.linalg.inv(stiffness), _GRID)
    return NetModuli(stiffness, nu, True, (float(every.min()), float(every.max())))


def _in_plane(reference: Floats) -> Floats:
    """(n, 2) nodes in the plane of the reference, the first axis as near to x as it can be."""
    centred = reference - reference.mean(axis=0)
    _, spread, axes = np.linalg.svd(centred, full_matrices=False)
    if spread[2] > _FLAT * spread[0]:
        raise MeshError("the moduli of the net of springs need a flat reference")
    normal = axes[2] * (1.0 if axes[2][np.argmax(np.abs(axes[2]))] > 0 else -1.0)
    first = np.eye(3)[0 if abs(normal[0]) < 0.9 else 1]
    first = first - normal * (first @ normal)
    first /= np.linalg.norm(first)
    return np.asarray(centred @ np.stack([first, np.cross(normal, first)], axis=1))


def _relaxed(mesh: Triangulation, constants: Floats, n: Floats, pull: Floats, is_inner: Bools) -> Floats:
    """(nodes, 2, 3) displacements beyond the uniform ones that leave no net force on inner nodes, for each strain."""
    from scipy.sparse import coo_matrix, eye_array
    from scipy.sparse.linalg import splu

    number = np.full(len(is_inner), -1)
    number[is_inner] = np.arange(is_inner.sum())
    blocks = constants[:, None, None] * n[:, :, None] * n[:, None, :]
    rows, columns, values = [], [], []
    for i, j, sign in ((0, 0, 1.0), (1, 1, 1.0), (0, 1, -1.0), (1, 0, -1.0)):
        a, b = number[mesh.edges[:, i]], number[mesh.edges[:, j]]
        both = (a >= 0) & (b >= 0)
        for p in range(2):
            for q in range(2):
                rows.append(2 * a[both] + p)
                columns.append(2 * b[both] + q)
                values.append(sign * blocks[both, p, q])
    size = 2 * int(is_inner.sum())
    entries = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
    matrix = coo_matrix(entries, shape=(size, size)).tocsc()
    # A node that no spring holds in one direction stays there.
    matrix = matrix + 1e-12 * float(abs(matrix).max()) * eye_array(size)
    moved = np.zeros_like(pull)
    moved[is_inner] = splu(matrix.tocsc()).solve(pull[is_inner].reshape(size, 3)).reshape(-1, 2, 3)
    return moved


def _local_extremes(
    mesh: Triangulation, points: Floats, material: Material, is_inner: Bools, is_used: Bools
) -> tuple[float, float]:
    """Means over the inner nodes, by area, of the extremes of E/E_Y of the triangles around each, without relaxation;
    over all nodes where none is inner. Edges that are not used have no stiffness in either of their triangles.
    """
    count = len(mesh.triangles)
    alone = np.arange(3 * count, dtype=np.int64).reshape(-1, 3)
    corners = Triangulation(mesh.reference[mesh.triangles.ravel()], alone, np.empty((0, 2), int), np.empty((0, 2), int))
    constants = corners.spring_constants(material) / (material.youngs_modulus * material.thickness)
    constants[corners.triangle_edges[~is_used[mesh.triangle_edges]]] = 0.0
    ends = points[mesh.triangles.ravel()][corners.edges]
    along = ends[:, 1] - ends[:, 0]
    t = np.stack([along[:, 0] ** 2, along[:, 1] ** 2, along[:, 0] * along[:, 1]], axis=1)
    by_edge = constants[:, None, None] * t[:, :, None] * t[:, None, :] / (along**2).sum(axis=1)[:, None, None]
    by_triangle = np.zeros((count, 3, 3))
    np.add.at(by_triangle, corners.edges[:, 0] // 3, by_edge)
    areas = mesh.areas()
    by_node, area = np.zeros((len(points), 3, 3)), np.zeros(len(points))
    for corner in mesh.triangles.T:
        np.add.at(by_node, corner, by_triangle)
        np.add.at(area, corner, areas)
    chosen = np.flatnonzero(is_inner if is_inner.any() else area > 0.0)
    stiffness = by_node[chosen] / area[chosen, None, None]
    sound = np.linalg.eigvalsh(stiffness)[:, 0] > 0.0
    if not sound.any():
        return np.nan, np.nan
    compliance, weights = np.linalg.inv(stiffness[sound]), area[chosen][sound]
    least, greatest = np.full(len(weights), np.inf), np.full(len(weights), -np.inf)
    for angle in _GRID[::20]:
        modulus = _modulus(compliance, angle)
        least, greatest = np.minimum(least, modulus), np.maximum(greatest, modulus)
    return float(np.average(least, weights=weights)), float(np.average(greatest, weights=weights))


def _radians(angle: Angle) -> Floats:
    """Directions [rad]. Raises InputTypeError for no numbers [deg]."""
    return np.asarray(np.radians(numeric(angle, "angle", "fiu", "numbers (deg)")))


def _modulus(compliance: Any, radians: Angle) -> Floats:
    """1/(t.S.t) along a direction, of one or many S (..., 3, 3)."""
    c, s = np.cos(radians), np.sin(radians)
    t = np.stack([c * c, s * s, c * s], axis=-1)
    return np.asarray(1.0 / np.einsum("...i,...ij,...j", t, compliance, t))
