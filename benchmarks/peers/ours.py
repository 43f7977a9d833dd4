"""membrane_rs."""

from __future__ import annotations

from membrane_rs import Simulation, UnstableError

from peers.problem import Floats, Problem
from peers.program import BlownError


class Ours:
    """One integrator of membrane_rs on springs or triangles, in the inertial frame, in its default configuration."""

    bits = 64

    def __init__(self, problem: Problem, integrator: str, law: str) -> None:
        self.name, self.law = f"membrane_rs {integrator}", law
        self._problem, self._integrator, self._scene = problem, integrator, problem.scene(law)
        self._sim = Simulation(self._scene, integrator=integrator)
        self.limit_guess: float | None = self._sim.stable_dt()

    def start(self, dt: float) -> None:
        """A simulation from the start."""
        self._sim = Simulation(self._scene, integrator=self._integrator, dt=dt)
        self._sim.velocities = self._problem.velocities

    def masses(self) -> Floats:
        """Tips included."""
        return self._sim.masses

    def step(self, n: int) -> None:
        """Raises BlownError where the monitor stops the run."""
        try:
            self._sim.step(n)
        except UnstableError as error:
            raise BlownError(str(error)) from error

    def motion(self) -> tuple[Floats, Floats]:
        """Positions and velocities."""
        return self._sim.positions, self._sim.velocities


def programs(problem: Problem, law: str) -> list[Ours]:
    """The three explicit methods."""
    return [Ours(problem, name, law) for name in ("rk4", "leapfrog", "dopri5")]
