"""Beams and plates with closed forms, of a film that bends."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import numpy as np
from membrane_rs import Bending, Fixed, Material, Mesh, Scene, Simulation, Triangles
from membrane_rs._arrays import Floats, Ints
from membrane_rs.folding import Disc, Strip
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.special import iv, jv

Form: TypeAlias = Literal["hinges", "curvature"]
SIZE, SHIFT = 0.1, 1e-8
"""Length of a beam, side of a square and radius of a disc; displacement of the differences [m]."""


def sheet(poisson_ratio: float, thickness: float = 1e-4) -> Material:
    """Thin enough to bend without a stretch."""
    return Material(1e6, poisson_ratio, 1000.0, thickness)


def plate_stiffness(material: Material) -> float:
    """D = E h^3 / (12 (1 - nu^2)) [N m]."""
    return material.youngs_modulus * material.thickness**3 / (12.0 * (1.0 - material.poisson_ratio**2))


def bent(mesh: Mesh, held: Ints, form: Form, film: Material) -> Simulation:
    """A film without wrinkles, held at nodes."""
    laws = [Triangles(compression=1.0), Bending(form=form)]
    return Simulation(Scene(mesh, film, laws, [Fixed(nodes=held.tolist())]))


def stiffness_matrix(sim: Simulation, places: Ints, shift: float = SHIFT) -> Floats:
    """-dF/dx by central differences; places are numbers of components, node by node."""
    start, columns = sim.positions.copy(), []
    for place in places:
        sides = []
        for sign in (1.0, -1.0):
            moved = start.copy()
            moved.flat[place] += sign * shift
            sim.positions = moved
            sides.append(sim.forces().ravel()[places])
        columns.append((sides[1] - sides[0]) / (2.0 * shift))
    sim.positions = start
    return np.asarray(np.array(columns).T, float)


def relative_frequency(mesh: Mesh, held: Ints, form: Form, poisson_ratio: float, known: float) -> float:
    """Lowest frequency of a flat film across itself over known (D / rho h)^(1/2) / SIZE^2 [-]."""
    film = sheet(poisson_ratio)
    sim = bent(mesh, held, form, film)
    free = np.setdiff1d(np.arange(mesh.node_count), held)
    roots = 1.0 / np.sqrt(sim.masses[free])
    matrix = stiffness_matrix(sim, 3 * free + 2) * np.outer(roots, roots)
    square = float(np.linalg.eigvalsh(0.5 * (matrix + matrix.T))[0])
    unit = math.sqrt(plate_stiffness(film) / (film.density * film.thickness)) / SIZE**2
    return math.sqrt(square) / (known * unit)


def narrow_strip(form: Form, cells: int, poisson_ratio: float) -> float:
    """A cantilever one cell wide: with E h^3/12 per width 3.516 (1 - nu^2)^(1/2)."""
    cell = SIZE / cells
    mesh = Strip(SIZE + cell, cell, cells + 1).mesh()
    held = np.flatnonzero(mesh.reference[:, 0] < 1.5 * cell)
    return relative_frequency(mesh, held, form, poisson_ratio, 3.51602 * math.sqrt(1.0 - poisson_ratio**2))


def supported_square(form: Form, cells: int, poisson_ratio: float) -> float:
    """A square on simple supports, 2 pi^2 at any Poisson's ratio."""
    mesh = Strip(SIZE, SIZE, cells, cells).mesh()
    return relative_frequency(mesh, np.unique(mesh.boundary_edges), form, poisson_ratio, 2.0 * math.pi**2)


def clamped_square(form: Form, cells: int, poisson_ratio: float) -> float:
    """A square that is clamped all round, 35.985 at any Poisson's ratio."""
    cell = SIZE / cells
    mesh = Strip(SIZE + 2 * cell, SIZE + 2 * cell, cells + 2, cells + 2).mesh()
    from_centre = np.abs(mesh.reference[:, :2] - mesh.reference[:, :2].mean(axis=0)).max(axis=1)
    held = np.flatnonzero(from_centre > 0.5 * SIZE - 0.1 * cell)
    return relative_frequency(mesh, held, form, poisson_ratio, 35.985)


def supported_disc(form: Form, rings: int, poisson_ratio: float) -> float:
    """A disc on a simple support: the drum without tension. The hinges have a Poisson's ratio of their own."""
    mesh = Disc(SIZE, rings).mesh()
    own = -1.0 / 3.0 if form == "hinges" else poisson_ratio
    return relative_frequency(mesh, mesh.node_sets["rim"], form, poisson_ratio, drum_note(own))


def drum_note(poisson_ratio: float) -> float:
    """lambda^2 of J1/J0 + I1/I0 = 2 lambda/(1 - nu) (Leissa, Vibration of Plates, NASA SP-160, 1969, section 2.1)."""

    def residual(x: float) -> float:
        return float(jv(1, x) / jv(0, x) + iv(1, x) / iv(0, x) - 2.0 * x / (1.0 - poisson_ratio))

    return float(brentq(residual, 0.5, 2.40)) ** 2


def turned_cantilever(form: Form, cells: int, angle: float) -> float:
    """Frequency of a cantilever twice as long as wide, cut from a lattice of squares along a direction of 0 or 45
    degrees, in units of that of a beam of D [-].
    """
    cell = SIZE / cells
    step = cell if angle == 0.0 else math.sqrt(0.5) * cell
    lattice = Strip(4 * SIZE, 4 * SIZE, round(4 * SIZE / step), round(4 * SIZE / step)).mesh()
    c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    points = (lattice.reference[:, :2] - lattice.reference[:, :2].mean(axis=0)) @ np.array([[c, s], [-s, c]]).T
    # A lattice line through a node in which eight edges meet.
    begin = points[np.argmin(np.abs(points - [-0.5 * SIZE, 0.0]).sum(axis=1))].copy()
    if np.bincount(lattice.edges.ravel())[np.argmin(np.abs(points - begin).sum(axis=1))] != 8:
        begin += [0.0, step]
    middles = points[lattice.triangles].mean(axis=1)
    inside = ((middles > begin - [cell, 0.25 * SIZE]) & (middles < begin + np.array([SIZE, 0.25 * SIZE]))).all(axis=1)
    used, triangles = np.unique(lattice.triangles[inside], return_inverse=True)
    piece = Mesh(lattice.reference[used], triangles.reshape(-1, 3))
    held = np.flatnonzero(points[used, 0] < begin[0] + 0.1 * cell)
    return relative_frequency(piece, held, form, 1 / 3, 3.51602)


@dataclass(frozen=True)
class Loaded:
    """Deflection of the end of a cantilever over its length, across it and along it, and its middle line [m]."""

    across: float
    along: float
    shape: Floats


def elastica(form: Form, cells: int, load: float) -> Loaded:
    """A cantilever of squares one cell wide under P L^2/EI = load at its end, EI that of the narrow strip."""
    # Thicker, since the force of a stretch by rounding would exceed the load of a thin one.
    film, cell = sheet(1 / 3, thickness=5e-4), SIZE / cells
    mesh = Strip(SIZE + cell, cell, cells + 1).mesh()
    start = mesh.reference
    held = np.flatnonzero(start[:, 0] < 1.5 * cell)
    end = mesh.node_sets["end"]
    sim = bent(mesh, held, form, film)
    free = np.setdiff1d(np.arange(mesh.node_count), held)
    places = (3 * free[:, None] + np.arange(3)).ravel()
    force = load * film.youngs_modulus * film.thickness**3 / 12.0 * cell / SIZE**2
    positions = start.copy()
    for share in np.linspace(0.1, 1.0, 10):
        positions = _at_rest(sim, positions, places, end, share * force)
    moved = (positions - start)[end].mean(axis=0) / SIZE
    columns = np.round(start[:, 0] / cell).astype(int)
    line = np.array([positions[columns == column].mean(axis=0) for column in range(1, cells + 2)])
    return Loaded(-float(moved[2]), -float(moved[0]), line - [cell, 0.0, 0.0])


def _at_rest(sim: Simulation, positions: Floats, places: Ints, end: Ints, force: float) -> Floats:
    """The equilibrium under a force at the end, by Newton's method with bounded moves."""
    for _ in range(100):
        sim.positions = positions
        left = sim.forces().copy()
        left[end, 2] -= force / len(end)
        residual = left.ravel()[places]
        if np.abs(residual).max() < 1e-7 * force:
            return positions
        move = np.linalg.solve(stiffness_matrix(sim, places), residual)
        positions = positions.copy()
        positions.flat[places] += move * min(1.0, 0.03 * SIZE / np.abs(move).max())
    raise ArithmeticError(f"no equilibrium under {force:g} N")


def exact_curve(load: float) -> Floats:
    """(n, 2) points (x, w) over L of theta'' = -load cos theta with theta(0) = theta'(1) = 0, by shooting."""

    def along(moment: float) -> Floats:
        def slope(_: float, y: Any) -> list[float]:
            return [y[1], -load * math.cos(y[0]), math.cos(y[0]), math.sin(y[0])]

        places = np.linspace(0.0, 1.0, 201)
        found = solve_ivp(slope, (0.0, 1.0), [0.0, moment, 0.0, 0.0], t_eval=places, rtol=1e-11, atol=1e-13)
        return np.asarray(found.y)

    moment = brentq(lambda moment: along(moment)[1, -1], 0.0, load)
    return np.asarray(along(moment)[2:].T)


def exact_elastica(load: float) -> Loaded:
    """Of the exact curve."""
    curve = exact_curve(load)
    return Loaded(float(curve[-1, 1]), float(1.0 - curve[-1, 0]), curve)


def order(errors: Sequence[float], ratio: float = 2.0) -> float:
    """Of the last two errors, on cells that differ by a ratio."""
    return math.log(abs(errors[-2] / errors[-1])) / math.log(ratio)


CASES: dict[str, tuple[Callable[[Form, int, float], float], tuple[int, int, int]]] = {
    "narrow strip, clamped at one end": (narrow_strip, (10, 20, 40)),
    "square on simple supports": (supported_square, (6, 12, 24)),
    "square, clamped": (clamped_square, (6, 12, 24)),
    "disc on a simple support": (supported_disc, (4, 8, 16)),
}
"""Frequencies over their closed forms, each with cells on three meshes."""
