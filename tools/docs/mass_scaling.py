"""Selective mass scaling on model 1: what a step by it would cost, beside the softened film (docs/softening.md).

Mass is added to the stretch of each edge alone (Olovsson, Simonsson and Unosson 2005, in the form proportional to the
stiffness): with K the elastic stiffness along the edges and omega_1 its largest frequency,

    M' = M + (f - 1)/omega_1^2 K,        omega'^2 = omega^2 / (1 + (f - 1) omega^2/omega_1^2)

so that the largest frequency falls by f^(1/2) and slow motions keep theirs. Each evaluation then needs M' a = F, which
couples all nodes and changes as they move. The method of conjugate gradients, with the masses as preconditioner, takes
about f^(1/2)/2 ln(2/tolerance) iterations, each with a pass over the edges. The iterations are counted here.

    python tools/docs/mass_scaling.py [--write]
"""

from __future__ import annotations

import argparse
import math
from dataclasses import dataclass

import numpy as np
from marked import DOCS, MarkedPart
from membrane_rs import Simulation, scenes
from membrane_rs._arrays import Floats
from membrane_rs._markdown import table
from scipy.sparse import csr_array, diags_array
from scipy.sparse.linalg import eigsh
from softening_cases import SUBSTEPS

PAGE = DOCS / "softening.md"
PART = MarkedPart(PAGE, "mass-scaling")
SCENE = "okuizumi-model-1"
TIMES = (0.0, 0.05, 0.1, 0.4)
"""States of the deployment whose forces are taken [s]."""
FACTORS = (3.0, 10.0, 30.0)
TOLERANCES = (1e-2, 1e-4)
"""Of the accelerations, in the norm of M'."""
MOST = 1000


@dataclass(frozen=True)
class State:
    """Masses, stiffness along the edges and forces at an instant, without the nodes that are held."""

    masses: Floats
    stiffness: csr_array
    forces: Floats

    @classmethod
    def of(cls, sim: Simulation) -> State:
        """That of a simulation."""
        scene, x = sim.scene, sim.positions
        assert scene.mesh is not None
        assert scene.material is not None
        ends = np.vstack((scene.mesh.edges, sim.assembly.cords.nodes))
        k = np.concatenate((scene.mesh.spring_constants(scene.material), sim.assembly.cords.stiffness))
        span = x[ends[:, 1]] - x[ends[:, 0]]
        direction = span / np.linalg.norm(span, axis=1)[:, None]
        rows = np.repeat(np.arange(len(ends)), 6)
        columns = (3 * np.repeat(ends, 3, axis=1) + np.tile(np.arange(3), 2)).ravel()
        elongation = csr_array(
            (np.hstack((-direction, direction)).ravel(), (rows, columns)), shape=(len(ends), 3 * sim.node_count)
        )
        free = np.ones(sim.node_count, dtype=bool)
        free[sim.assembly.fixed] = False
        chosen = np.repeat(free, 3)
        own = elongation[:, np.flatnonzero(chosen)]
        return cls(np.repeat(sim.masses, 3)[chosen], own.T @ diags_array(k) @ own, sim.forces().ravel()[chosen])

    def largest_square(self) -> float:
        """omega_1^2 [1/s^2]."""
        root = diags_array(1.0 / np.sqrt(self.masses))
        return float(eigsh(root @ self.stiffness @ root, k=1, which="LA", return_eigenvectors=False)[0])

    def scaled(self, factor: float) -> csr_array:
        """M'."""
        return csr_array(diags_array(self.masses) + (factor - 1.0) / self.largest_square() * self.stiffness)


def iterations(matrix: csr_array, masses: Floats, forces: Floats, tolerance: float) -> int:
    """Conjugate gradients for M' a = F from a = F/m until the error is `tolerance` in the norm of M'."""
    exact = solved(matrix, masses, forces, 1e-12)[0]
    scale = math.sqrt(exact @ (matrix @ exact))
    return solved(matrix, masses, forces, tolerance * scale, exact)[1]


def solved(
    matrix: csr_array, masses: Floats, forces: Floats, bound: float, exact: Floats | None = None
) -> tuple[Floats, int]:
    """Solution and number of iterations; the bound is one of the error, or relative of the residual without `exact`."""
    a = forces / masses
    residual = forces - matrix @ a
    z = residual / masses
    p, rho = z.copy(), residual @ z
    first = math.sqrt(forces @ (forces / masses))
    for k in range(MOST):
        size = math.sqrt(rho) / first if exact is None else math.sqrt((a - exact) @ (matrix @ (a - exact)))
        if size <= bound:
            return a, k
        image = matrix @ p
        step = rho / (p @ image)
        a = a + step * p
        residual = residual - step * image
        z = residual / masses
        rho, before = residual @ z, rho
        p = z + rho / before * p
    raise SystemExit(f"no convergence within {MOST} iterations")


def main() -> None:
    """Count the iterations, and write the table."""
    parser = argparse.ArgumentParser(description="Selective mass scaling on model 1.")
    parser.add_argument("--write", action="store_true", help=f"write into {PAGE.name}")
    write = parser.parse_args().write
    scene = scenes.load(SCENE).with_values({"run.integrator": "leapfrog", "run.substeps": SUBSTEPS})
    sim = Simulation(scene)
    states = []
    for time in TIMES:
        if time > 0.0:
            sim.run(until=time, frames=2, samples=2)
        states.append(State.of(sim))
    rows = []
    for factor in FACTORS:
        matrices = [state.scaled(factor) for state in states]
        for tolerance in TOLERANCES:
            found = zip(matrices, states, strict=True)
            counts = [iterations(matrix, state.masses, state.forces, tolerance) for matrix, state in found]
            rows.append((f"{factor:g}", f"{tolerance:g}", f"{math.sqrt(factor):.2f}", *map(str, counts)))
    head = ("f", "tolerance", "longer step", *(f"iterations at {1e3 * time:g} ms" for time in TIMES))
    text = table(head, rows, words=())
    print(text)
    if write:
        PART.write(text)


if __name__ == "__main__":
    main()
