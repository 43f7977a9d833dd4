"""Small scenes, and what several tests measure: tangent stiffness, rate of convergence, a clear refusal."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest
from membrane_rs import (
    Fixed,
    Gravity,
    Material,
    MembraneError,
    Mesh,
    Scene,
    Simulation,
    SpringDamping,
    Springs,
    Tether,
)
from membrane_rs.folding import Strip
from membrane_rs.scene.laws import Law
from numpy.typing import NDArray

Floats = NDArray[np.float64]

FILM = Material(3.2e9, 0.34, 1420.0, 7.5e-6)
"""The film of the paper's sails."""
RUBBER = Material(1e6, 1 / 3, 1000.0, 2e-4)
"""Soft, so that steps are long; at nu = 1/3 a net of springs can be as isotropic as the film."""
UNBUCKLED = Springs(buckling=1e12, buckling_on_creases=1e12)
"""Springs whose critical length is below zero: linear in compression too."""


def cord(**changes: Any) -> Tether:
    """One massless spring of 1 m along x with 1 kg at its end."""
    values: dict[str, Any] = {
        "start": (0.0, 0.0, 0.0),
        "end": (1.0, 0.0, 0.0),
        "segments": 1,
        "axial_stiffness": 100.0,
        "linear_density": 0.0,
        "tip_mass": 1.0,
        "strain_limit": 1e6,
    }
    return Tether(**(values | changes))


def patch(**extra: Any) -> Mesh:
    """Two triangles with a crease, off the axis."""
    values: dict[str, Any] = {"creases": [[0, 2]], "fold_angles": [-1.0], "node_sets": {"corners": [1, 3]}}
    points = [[0.1, 0.0, 0.0], [0.2, 0.0, 0.0], [0.2, 0.1, 0.0], [0.1, 0.1, 0.0]]
    return Mesh(points, [[0, 1, 2], [0, 2, 3]], **(values | extra))


def hanging_strip(columns: int = 6, rows: int = 2) -> Scene:
    """A strip of rubber held at one end, which falls: smooth, quick, and it loses energy by its dashpots."""
    mesh = Strip(0.1, 0.04, columns, rows, creases=(0.5,)).mesh()
    laws: list[Law] = [Springs(), SpringDamping(), Gravity((0.0, 0.0, -9.81))]
    return Scene(mesh, RUBBER, laws, [Fixed("start")], name="hanging")


def turned(mesh: Mesh, rotation: Floats) -> Mesh:
    """The same mesh somewhere else: each point x becomes `rotation` x."""
    return Mesh(
        mesh.reference @ rotation.T,
        mesh.triangles,
        positions=mesh.positions @ rotation.T,
        creases=mesh.creases,
        fold_angles=mesh.fold_angles,
        node_sets=mesh.node_sets,
    )


def rotation(axis: Sequence[float], angle: float) -> Floats:
    """(3, 3) rotation about `axis` by `angle` [rad] (Rodrigues)."""
    x, y, z = np.asarray(axis, float) / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    result: Floats = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    return result


def tangent(sim: Simulation, nodes: NDArray[np.int64], axes: Sequence[int], step: float) -> Floats:
    """K = -dF/dx of all laws at the present positions, by central differences of `step` [m]: rows (node,
    axis).
    """
    start = sim.positions
    columns = []
    for node in nodes:
        for axis in axes:
            sides = []
            for sign in (1.0, -1.0):
                moved = start.copy()
                moved[node, axis] += sign * step
                sim.positions = moved
                sides.append(sim.forces()[nodes][:, list(axes)].ravel())
            columns.append((sides[1] - sides[0]) / (2 * step))
    sim.positions = start
    matrix: Floats = np.array(columns).T
    return matrix


def frequencies(sim: Simulation, nodes: NDArray[np.int64], axis: int, step: float) -> Floats:
    """Angular frequencies of small motions of `nodes` along one axis, ascending [rad/s]; growing modes as
    negative.
    """
    roots = 1.0 / np.sqrt(sim.masses[nodes])
    matrix = tangent(sim, nodes, [axis], step) * np.outer(roots, roots)
    squares = np.linalg.eigvalsh(0.5 * (matrix + matrix.T))
    result: Floats = np.sign(squares) * np.sqrt(np.abs(squares))
    return result


def rest(sim: Simulation, nodes: NDArray[np.int64], axes: Sequence[int], step: float, iterations: int = 3) -> None:
    """Move `nodes` along `axes` to where no force is left on them: Newton's method, which a cord on the
    verge of slack, stiff to one side only, sends twice too far at first.
    """
    for _ in range(iterations):
        force = sim.forces()[nodes][:, list(axes)].ravel()
        move = np.linalg.lstsq(tangent(sim, nodes, axes, step), force, rcond=1e-12)[0]
        positions = sim.positions.copy()
        positions[np.ix_(nodes, np.array(axes))] += move.reshape(len(nodes), -1)
        sim.positions = positions


def rates(errors: Sequence[float], ratio: float = 2.0) -> Floats:
    """Measured orders of convergence, from errors on sizes that shrink by `ratio`."""
    found: Floats = np.log(np.abs(errors[:-1]) / np.abs(errors[1:])) / np.log(ratio)
    return found


def period(times: Sequence[float], values: Sequence[float]) -> float:
    """Mean period of an oscillation about zero, from its zero crossings by linear interpolation."""
    t, y = np.asarray(times), np.asarray(values)
    at = np.flatnonzero(np.sign(y[:-1]) != np.sign(y[1:]))
    crossings = t[at] - y[at] * (t[at + 1] - t[at]) / (y[at + 1] - y[at])
    return float(2.0 * (crossings[-1] - crossings[0]) / (len(crossings) - 1))


def refused(action: Callable[[], object], kind: type[Exception], words: str) -> None:
    """The action raises an error of ours that says what was wrong."""
    with pytest.raises(kind, match=words) as caught:
        action()
    assert isinstance(caught.value, MembraneError)
    assert len(str(caught.value)) > 20


def forces_are_slopes(sim: Simulation, kinds: Sequence[str], rel: float) -> None:
    """The forces of laws are minus the slopes of their energies along a random way, on which node 0 stays."""
    start, way = np.array(sim.positions), np.random.default_rng(7).normal(0.0, 1.0, sim.positions.shape)
    way[0] = 0.0
    for kind in kinds:
        expected = -float((sim.forces(kind) * way).sum())
        values: list[float] = []
        for step in (1e-9, -1e-9):
            sim.positions = start + step * way
            values.append(sim.energies()[kind])
        sim.positions = start
        assert (values[0] - values[1]) / 2e-9 == pytest.approx(expected, rel=rel), kind


def irregular(columns: int = 12, rows: int = 6, jitter: float = 0.25) -> Mesh:
    """A flat rectangle of 0.12 x 0.06 m whose inner nodes are displaced in its plane."""
    mesh = Strip(0.12, 0.06, columns, rows).mesh()
    points = np.array(mesh.reference)
    inner = np.setdiff1d(np.arange(len(points)), np.unique(mesh.boundary_edges))
    points[inner, :2] += jitter * 0.01 * np.random.default_rng(5).uniform(-1.0, 1.0, (len(inner), 2))
    return Mesh(points, mesh.triangles)
