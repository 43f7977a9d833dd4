"""The film of Newton's triangles in double precision: the reference for a program that has single precision only.

With F the deformation gradient of a flat triangle of area A0, Ic = tr(F^T F), J its change of area, k = lambda + mu,

    U = A0 [ mu/2 (Ic - 2) + k/2 (J - 1 - mu/k)^2 ]   [J]

less a constant: Smith, de Goes and Kim, "Stable neo-Hookean flesh simulation" (2018), for a membrane. The integrator
is the classical Runge-Kutta method of order four.
"""

from __future__ import annotations

import numpy as np

from peers.problem import Floats, Problem


def lame_parameters(problem: Problem) -> tuple[float, float]:
    """mu and lambda of the film in plane stress, times its thickness [N/m]."""
    film = problem.material
    stiffness = film.youngs_modulus * film.thickness
    return stiffness / (2 * (1 + film.poisson_ratio)), stiffness * film.poisson_ratio / (1 - film.poisson_ratio**2)


class NeoHookean:
    """The law on a problem's mesh."""

    def __init__(self, problem: Problem) -> None:
        self._problem = problem
        self._mu, lame = lame_parameters(problem)
        self._k = lame + self._mu
        reference = problem.mesh.reference[:, :2]
        a, b, c = (reference[column] for column in problem.mesh.triangles.T)
        self._inverse = np.linalg.inv(np.stack([b - a, c - a], axis=2))
        self._area = problem.mesh.areas()

    def energy(self, positions: Floats) -> float:
        """U [J] of positions (n, 3), 0 at rest."""
        f1, f2 = self._gradient(positions)
        stretch = np.linalg.norm(np.cross(f1, f2), axis=1)
        trace = (f1**2 + f2**2).sum(axis=1)
        shift = self._mu / self._k
        density = self._mu / 2 * (trace - 2) + self._k / 2 * ((stretch - 1 - shift) ** 2 - shift**2)
        return float(self._area @ density)

    def forces(self, positions: Floats) -> Floats:
        """-dU/dx (n, 3) [N]."""
        f1, f2 = self._gradient(positions)
        normal = np.cross(f1, f2)
        stretch = np.linalg.norm(normal, axis=1, keepdims=True)
        normal /= stretch
        pressure = self._k * (stretch - 1) - self._mu
        p1 = self._area[:, None] * (self._mu * f1 + pressure * np.cross(f2, normal))
        p2 = self._area[:, None] * (self._mu * f2 + pressure * np.cross(normal, f1))
        inverse = self._inverse[:, :, :, None]
        b = inverse[:, 0, 0] * p1 + inverse[:, 0, 1] * p2
        c = inverse[:, 1, 0] * p1 + inverse[:, 1, 1] * p2
        nodes = self._problem.mesh.triangles.T.ravel()
        pulls = np.concatenate([b + c, -b, -c])
        count = self._problem.mesh.node_count
        return np.stack([np.bincount(nodes, pulls[:, k], count) for k in range(3)], axis=1)

    def shapes(self, steps: int) -> Floats:
        """(instants, n, 3) the motion by rk4 with so many steps between two instants [m]."""
        dt = self._problem.interval / steps
        x, v = np.array(self._problem.mesh.reference), np.array(self._problem.velocities)
        shapes = []
        for _ in range(self._problem.instants):
            for _ in range(steps):
                v1, a1 = v, self._accelerations(x)
                v2, a2 = v + dt / 2 * a1, self._accelerations(x + dt / 2 * v1)
                v3, a3 = v + dt / 2 * a2, self._accelerations(x + dt / 2 * v2)
                v4, a4 = v + dt * a3, self._accelerations(x + dt * v3)
                x = x + dt / 6 * (v1 + 2 * v2 + 2 * v3 + v4)
                v = v + dt / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
            shapes.append(x)
        return np.stack(shapes)

    def _accelerations(self, positions: Floats) -> Floats:
        return self.forces(positions) / self._problem.masses[:, None]

    def _gradient(self, positions: Floats) -> tuple[Floats, Floats]:
        """The columns of F, (m, 3) each."""
        a, b, c = (positions[column] for column in self._problem.mesh.triangles.T)
        x, y, inverse = b - a, c - a, self._inverse
        return x * inverse[:, 0, :1] + y * inverse[:, 1, :1], x * inverse[:, 0, 1:] + y * inverse[:, 1, 1:]
