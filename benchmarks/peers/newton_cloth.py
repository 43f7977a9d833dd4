"""Newton: particles with springs, or with triangles of a neo-Hookean film, on the processor, in single precision.

Its triangles store, per area, mu/2 (tr(F^T F) - 2) + k/2 (J - 1 - mu/k)^2 with k = lambda + mu: at small strain the
film in plane stress with Lame's mu = E h / (2 (1 + nu)) and lambda = E h nu / (1 - nu^2). The semi-implicit solver is
given k for `tri_ka`, VBD lambda, to which it adds mu itself. Its springs are those of membrane_rs.

Contact is off where it can be. Steps are captured once as a graph and replayed, which spares Python's share of the
time; capture and compilation are not timed.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from peers.neo_hookean import lame_parameters
from peers.problem import Floats, Problem
from peers.program import NEWTON_ITERATIONS

wp.config.log_level = wp.LOG_ERROR
import newton  # noqa: E402 (Warp prints a banner on import of newton unless this is set before)

CHUNKS = (20, 2, 1)
"""Steps in a graph; any number of steps is made up of these."""


class Cloth:
    """One solver of Newton on springs or triangles."""

    bits = 32

    def __init__(
        self, problem: Problem, method: str, law: str, limit_guess: float | None, *, plain: bool = False
    ) -> None:
        self.name, self.law, self.limit_guess = f"Newton {method}", law, limit_guess
        self._problem, self._plain = problem, plain
        self._model = _model(problem, law, adds_mu=method == "VBD", grid=method == "XPBD" or plain)
        solver: Any = {
            "semi-implicit": lambda: newton.solvers.SolverSemiImplicit(self._model, enable_tri_contact=False),
            "VBD": lambda: newton.solvers.SolverVBD(self._model, iterations=NEWTON_ITERATIONS),
            "XPBD": lambda: newton.solvers.SolverXPBD(self._model, iterations=NEWTON_ITERATIONS),
        }[method]
        if plain:
            self.name += ", particle contact on, no graph"
        self._solver, self._control = solver(), self._model.control()
        self._now, self._next = self._model.state(), self._model.state()
        self._graphs: dict[int, Any] = {}

    def start(self, dt: float) -> None:
        """Flat, turning; the graph is made for this step."""
        self._dt = dt
        self._steps(2)  # compiles
        self._graphs = {}
        for chunk in () if self._plain else CHUNKS:
            with wp.ScopedCapture(device="cpu") as capture:
                self._steps(chunk)
            self._graphs[chunk] = capture.graph
        self._now.particle_q.assign(self._problem.mesh.reference.astype(np.float32))
        self._now.particle_qd.assign(self._problem.velocities.astype(np.float32))

    def masses(self) -> Floats:
        """As doubles."""
        return np.array(self._model.particle_mass.numpy(), dtype=np.float64)

    def step(self, n: int) -> None:
        """Replays graphs, the longest first."""
        for chunk, graph in self._graphs.items():
            count, n = divmod(n, chunk)
            for _ in range(count):
                wp.capture_launch(graph)
        self._steps(n)

    def motion(self) -> tuple[Floats, Floats]:
        """As doubles."""
        positions, velocities = self._now.particle_q.numpy(), self._now.particle_qd.numpy()
        return np.array(positions, dtype=np.float64), np.array(velocities, dtype=np.float64)

    def _steps(self, n: int) -> None:
        """Leaves the state in the first of the two, where a graph finds it."""
        for _ in range(n):
            self._now.clear_forces()
            self._solver.step(self._now, self._next, self._control, None, self._dt)
            self._now, self._next = self._next, self._now
        if n % 2:
            wp.copy(self._next.particle_q, self._now.particle_q)
            wp.copy(self._next.particle_qd, self._now.particle_qd)
            self._now, self._next = self._next, self._now


def _model(problem: Problem, law: str, *, adds_mu: bool, grid: bool) -> Any:
    mesh, film = problem.mesh, problem.material
    builder = newton.ModelBuilder(gravity=(0.0, 0.0, 0.0))
    # The radius is far below the distance of nodes: where contact cannot be left out, it finds none.
    builder.add_particles(
        mesh.reference.tolist(),
        problem.velocities.tolist(),
        mass=problem.masses.tolist(),
        radius=[1e-2 * float(mesh.edge_lengths.min())] * mesh.node_count,
    )
    if law == "springs":
        for (i, j), stiffness in zip(mesh.edges.tolist(), mesh.spring_constants(film).tolist(), strict=True):
            builder.add_spring(i, j, stiffness, 0.0, 0.0)
    else:
        mu, lame = lame_parameters(problem)
        corners = [column.tolist() for column in mesh.triangles.T]
        count = len(mesh.triangles)
        builder.add_triangles(
            *corners,
            tri_ke=[mu] * count,
            tri_ka=[lame if adds_mu else lame + mu] * count,
            tri_kd=[0.0] * count,
            tri_drag=[0.0] * count,
            tri_lift=[0.0] * count,
        )
    builder.color()
    model = builder.finalize(device="cpu")
    if not grid:
        model.particle_grid = None
    return model


def programs(problem: Problem, law: str, guess: float) -> list[Cloth]:
    """Its solvers for a law; XPBD has springs only. `guess`: the limit of leapfrog [s]."""
    found = [Cloth(problem, "semi-implicit", law, guess), Cloth(problem, "VBD", law, None)]
    return [*found, Cloth(problem, "XPBD", law, guess)] if law == "springs" else found
