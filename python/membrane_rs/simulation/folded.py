"""Folding of a flat crease pattern: its creases turn by increments to a fraction of their fold angles.

Bars and hinges of finite stiffness stand for the panels, as in Schenk and Guest, Origami folding: a structural
engineering approach, Origami 5 (2011) 291-303, and Ghassaei, Demaine and Gershenfeld, Fast, interactive origami
simulation using GPU computation, Origami 7 (2018) 1151-1166; here the bars are the film's triangles. Each increment
ends at rest, to which kinetic damping leads (`relaxation.py`).

The flat sheet needs no push: there the moments of the creases already act out of its plane, mountains to one side and
valleys to the other, and so choose among the ways to fold.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs._validation import check_kind, count_of, flag_of, number_of
from membrane_rs.errors import InputError, MeshError, UnstableError
from membrane_rs.material import Material
from membrane_rs.mesh import Mesh
from membrane_rs.mesh.fold_angles import FLAT, measured_fold_angles
from membrane_rs.mesh.panels import panels
from membrane_rs.scene import Scene
from membrane_rs.scene.laws import Bending, Creases, Triangles
from membrane_rs.scene.parts import Bridges, CreaseSet
from membrane_rs.scene.run_settings import RunSettings
from membrane_rs.simulation.fold_result import FoldIncrement, FoldResult
from membrane_rs.simulation.relaxation import ANY_LOSS, NO_FORCE, kinetic_damping, largest_force
from membrane_rs.simulation.stepper import Stepper

THICKNESS = 0.03
"""Of the film that is folded, over the mean size of its panels [-]. Strains are about its square, and steps are about
as many as its inverse."""
CONTACT_PENALTY = 4.0
"""Of the creases; more would take shorter steps."""
ON_THE_WAY, AT_THE_END = 0.03, 2e-3
"""Net force on a node over the largest force of a law, at which an increment ends, and the last one."""
MOST_STEPS = 1_000_000
"""Of an increment."""
MOST_INCREMENTS = 1000


def fold(
    mesh: Mesh,
    fraction: float = 1.0,
    *,
    increments: int = 10,
    facet_stiffness: float = 0.3,
    strain_limit: float = 5e-3,
    force: bool = False,
    progress: Callable[[int, int], object] | None = None,
) -> FoldResult:
    """Fold a flat crease pattern by simulation: the start of a scene from any pattern.

    The sheet is at rest in its `reference`, all creases flat, and turns its creases by equal increments to `fraction`
    of its `fold_angles`. Creases of no angle are free. Angles that do not go together, as those of flat origami on
    the way there, are met in the mean, weighted by the lengths of the creases. Panels may bend at the sides of their
    triangles; they hardly stretch. Panels that meet pass through each other. The material of the scene does not matter.

    Parameters
    ----------
    mesh : Mesh
        The pattern; its `positions` do not matter.
    fraction : float
        Of each fold angle [-], above 0 (flat), up to 1 (as the pattern says).
    increments : int
        Equal parts in which it is folded, 1 to 1000.
    facet_stiffness : float
        Bending stiffness of a panel over that of a crease of its size [-], above 0.
    strain_limit : float
        Strain of a side [-] from which on the pattern is refused, above 0.
    force : bool
        Whether a pattern that does not fold so is given all the same, with its `faults`.
    progress : callable, optional
        Called after each increment with how many are done, and with their number.

    Returns
    -------
    FoldResult
        The folded mesh, angles, strain, crossings. The same bits each time.

    Raises
    ------
    InputError, InputTypeError
        A value outside its range, or of a wrong type.
    MeshError
        No creases, or none with an angle; a reference that is not flat at a crease; a pattern that does not fold so,
        with its worst crease.
    KeyboardInterrupt
        Ctrl-C, between two steps.

    Examples
    --------
    >>> import numpy as np
    >>> from membrane_rs import Mesh, fold
    >>> corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    >>> square = Mesh(corners, [[0, 1, 2], [0, 2, 3]], creases=[[0, 2]], fold_angles=[np.pi])
    >>> found = fold(square, 0.5)
    >>> np.degrees(found.mesh.fold_angles).round(3).tolist(), found.largest_strain < 1e-6
    ([90.0], True)
    """
    check_kind(mesh, Mesh, "fold: mesh", "a Mesh")
    fraction = number_of("fold: fraction", fraction, "relative")
    if not 0.0 < fraction <= 1.0:
        raise InputError(f"fold: fraction = {fraction:g}: must be above 0 (flat) and at most 1 (as the pattern says)")
    count = count_of("fold: increments", increments, 1, MOST_INCREMENTS)
    stiffness = _positive("facet_stiffness", facet_stiffness)
    limit = _positive("strain_limit", strain_limit)
    is_forced = flag_of("fold: force", force)
    flat = _flat(mesh)
    positions, theta, path = flat.reference, np.full(len(flat.creases), math.pi), []
    for done in range(1, count + 1):
        part = fraction * done / count
        goal = AT_THE_END if done == count else ON_THE_WAY
        try:
            positions, theta, increment = _increment(_scene(flat, part, stiffness), positions, part, goal)
        except UnstableError as error:
            raise MeshError(
                f"fold: at {part:g} of the pattern's angles {error}; take more increments, or a smaller fraction"
            ) from error
        path.append(increment)
        if progress is not None:
            progress(done, count)
    sides = np.where(flat.fold_angles < 0.0, -1.0, 1.0)
    angles = sides * (math.pi - theta)
    # Free creases have no side.
    angles = np.where(flat.fold_angles == 0.0, angles - 2.0 * math.pi * np.round(angles / (2.0 * math.pi)), angles)
    found = FoldResult(
        _folded(mesh, positions, angles), fraction, flat.fold_angles, _read_only(angles), tuple(path), limit
    )
    if found.faults and not is_forced:
        raise MeshError(f"fold: the pattern does not fold to {fraction:g} of its angles: {found.faults[0]}")
    return found


def _positive(name: str, value: object) -> float:
    number = number_of(f"fold: {name}", value, "relative")
    if not 0.0 < number <= 1e6:
        raise InputError(f"fold: {name} = {number:g}: must be above 0 and at most 1e6")
    return number


def _read_only(array: Floats) -> Floats:
    array.setflags(write=False)
    return array


def _flat(mesh: Mesh) -> Mesh:
    """The mesh in its reference. Raises MeshError where there is nothing to fold, or it is not flat."""
    if not len(mesh.creases):
        raise MeshError("fold: the mesh has no creases; give Mesh.creases, or in a FOLD file edges of M and V")
    if not mesh.fold_angles.any():
        raise MeshError(
            "fold: the fold angles of all creases are 0; give Mesh.fold_angles, pi for a valley that is to be shut and "
            "-pi for a mountain, or in a FOLD file edges of M and V"
        )
    found = measured_fold_angles(mesh, mesh.reference)
    bad = np.flatnonzero(~(np.abs(found) < FLAT))
    if len(bad):
        k = bad[0]
        raise MeshError(
            f"fold: creases[{k}] (nodes {mesh.creases[k, 0]} and {mesh.creases[k, 1]}) is folded by "
            f"{np.degrees(found[k]):.3g} degrees in the reference ({len(bad)} such creases); a pattern is folded from "
            "a flat reference"
        )
    return Mesh(
        mesh.reference, mesh.triangles, creases=mesh.creases, fold_angles=mesh.fold_angles, bridges=mesh.bridges
    )


def _scene(flat: Mesh, fraction: float, facet_stiffness: float) -> Scene:
    """A film whose creases turn to a fraction of their angles, of stiffness 1 per size of a panel."""
    size = math.sqrt(float(flat.areas().sum()) / (int(panels(flat).max()) + 1))
    film = Material(youngs_modulus=1e9, poisson_ratio=0.3, density=1000.0, thickness=THICKNESS * size)
    free = np.flatnonzero(flat.fold_angles == 0.0)
    links = film.youngs_modulus * film.thickness
    return Scene(
        flat,
        film,
        laws=[
            Triangles(compression=1.0, strain_limit=1.0),
            Creases(stiffness=1.0, contact_penalty=CONTACT_PENALTY, length_scale=size, fold_fraction=fraction),
            Bending(stiffness=facet_stiffness),
        ],
        parts=[
            *([CreaseSet(free.tolist(), stiffness=0.0)] if len(free) else []),
            *([Bridges(stiffness=links)] if len(flat.bridges) else []),
        ],
        run=RunSettings(integrator="leapfrog", energy_loss=ANY_LOSS),
    )


def _increment(scene: Scene, start: Floats, fraction: float, goal: float) -> tuple[Floats, Floats, FoldIncrement]:
    """Positions (n, 3) [m] and crease angles (c,) [rad] at rest, from positions at the start."""
    held = Stepper(scene)
    held.positions = start
    floor = NO_FORCE * largest_force(held)
    stops = kinetic_damping(held, math.inf, floor)
    best = next(stops)
    while best.share > goal and held.step_count < MOST_STEPS:
        best = min(best, next(stops), key=lambda remainder: remainder.share)
    held.positions = best.positions
    return best.positions, held.crease_angles(), FoldIncrement(fraction, held.step_count, best.share)


def _folded(mesh: Mesh, positions: Floats, angles: Floats) -> Mesh:
    """The mesh at folded positions, with the fold angles (c,) [rad] that it has there, from -pi to pi: those beyond by
    more than rounding are on the other side.
    """
    beyond = np.abs(angles) > math.pi + FLAT
    shown = np.where(beyond, angles - np.copysign(2.0 * math.pi, angles), np.clip(angles, -math.pi, math.pi))
    return Mesh(
        mesh.reference,
        mesh.triangles,
        positions=positions,
        creases=mesh.creases,
        fold_angles=shown,
        node_sets=mesh.node_sets,
        triangle_sets=mesh.triangle_sets,
        bridges=mesh.bridges,
    )
