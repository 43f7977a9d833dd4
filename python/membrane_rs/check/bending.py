"""Whether the form of bending suits the mesh, and whether the film has the same wrinkles twice."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from membrane_rs._arrays import Bools
from membrane_rs.mesh import Finding, Mesh
from membrane_rs.scene import Scene
from membrane_rs.scene.laws import Bending, Rectangles, Springs, Triangles

SUITED = 0.9
"""Share of the film, and of its inner nodes, that a lattice needs."""
RIGHT, REGULAR = np.cos(np.radians(85.0)), np.cos(np.radians([75.0, 45.0]))
"""Cosines of the largest angle of a right triangle at most, and of the angles of a nearly equilateral one."""
MOST_LEGS = 2.0
"""Ratio of the squares of the legs of a right triangle above which its hinges are not those of a plate."""
MOST_BUCKLING = 1.5
"""Above 1/(1 - nu^2), the plate's own, at every Poisson's ratio."""


def form_of_bending(scene: Scene) -> Iterator[Finding]:
    """A form that does not represent a plate on this mesh."""
    mesh, law = scene.mesh, scene.law(Bending)
    if mesh is None or law is None:
        return
    is_right, is_regular = _shapes(mesh)
    areas = mesh.areas() / mesh.areas().sum()
    right, regular = float(areas[is_right].sum()), float(areas[is_regular].sum())
    if law.form == "curvature":
        if right > 0.5:
            yield _warning(
                f"laws.bending.form = 'curvature' on a mesh of right triangles, {100 * right:.0f} % of the film, is "
                "too stiff in twist, however fine the mesh",
                'take form = "hinges", which suits right triangles whose diagonals alternate'
                if scene.material is None or scene.material.youngs_modulus_across is None
                else "take a mesh of nearly equilateral triangles: hinges represent a film of one modulus alone",
            )
    elif right + regular < SUITED:
        others = 100 * (1.0 - right - regular)
        yield _warning(
            f"laws.bending.form = 'hinges' on a mesh of which {others:.0f} % is neither of right triangles with legs "
            "of similar length nor of equilateral ones, on which alone hinges represent a plate",
            'take form = "curvature"',
        )
    elif right > 0.5 and (share := _alternating(mesh)) < SUITED:
        yield _warning(
            f"laws.bending.form = 'hinges' on right triangles whose diagonals do not alternate: 4 or 8 edges meet in "
            f"{100 * share:.0f} % of the inner nodes alone",
            'turn every second diagonal, or take form = "curvature"',
        )


def wrinkles_twice(scene: Scene) -> Iterator[Finding]:
    """A film that bends, and whose buckling parameter represents the wrinkles that its mesh resolves."""
    if scene.law(Bending) is None:
        return
    for kind in (Springs, Rectangles, Triangles):
        law = scene.law(kind)
        for name in ("buckling", "buckling_on_creases") if law is not None else ():
            if (alpha := getattr(law, name)) > MOST_BUCKLING:
                yield _warning(
                    f"laws.{kind.kind}.{name} = {alpha:g} beside laws.bending: the film resists the same wrinkles "
                    "twice, by its bending and by its buckling force",
                    f"take laws.{kind.kind}.{name} from 0 to 1, or leave laws.bending out",
                )


def _warning(message: str, remedy: str) -> Finding:
    return Finding("warning", "bending", 1, message, remedy)


def _shapes(mesh: Mesh) -> tuple[Bools, Bools]:
    """Whether each triangle is a right one with legs of similar length, and whether it is nearly equilateral."""
    points = mesh.reference[mesh.triangles]
    squares = np.sort(((np.roll(points, 1, axis=1) - points) ** 2).sum(axis=2), axis=1)
    a, b, c = squares.T
    least, most = (a + b - c) / (2.0 * np.sqrt(a * b)), (b + c - a) / (2.0 * np.sqrt(b * c))
    is_right = (np.abs(least) < RIGHT) & (b < MOST_LEGS * a)
    return np.asarray(is_right), np.asarray((least > REGULAR[0]) & (most < REGULAR[1]))


def _alternating(mesh: Mesh) -> float:
    """Share of the inner nodes in which 4 or 8 edges meet; 1 without inner nodes."""
    counts = np.bincount(mesh.edges.ravel(), minlength=mesh.node_count)
    inner = np.setdiff1d(np.unique(mesh.triangles), np.unique(mesh.boundary_edges))
    return float(np.isin(counts[inner], (4, 8)).mean()) if len(inner) else 1.0
