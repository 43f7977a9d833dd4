"""The compiled core; use it through `Mesh` and `Simulation`.

Shapes: n nodes, m triangles, e edges. Arrays are C-contiguous or not, of exactly the dtype stated. Numbering is the
caller's, in and out. Raises the package's own errors: MeshError, InputTypeError, InputError, UnstableError.
"""

from typing import Any, final

import numpy as np
from numpy.typing import NDArray

def edges(triangles: NDArray[np.int64], node_count: int) -> NDArray[np.int64]:
    """Unique edges (e, 2) of triangles (m, 3): lower node first, sorted."""

def spring_constants(
    reference: NDArray[np.float64],
    triangles: NDArray[np.int64],
    youngs_modulus: float,
    poisson_ratio: float,
    thickness: float,
) -> NDArray[np.float64]:
    """Spring constant of each edge by eq. (1), (e,) [N/m], in the order of `edges`; it may be negative."""

def lumped_masses(
    reference: NDArray[np.float64], triangles: NDArray[np.int64], areal_density: float
) -> NDArray[np.float64]:
    """A third of each triangle's mass on each of its nodes, (n,) [kg]; areal density rho h [kg/m2]."""

def hinge_count(reference: NDArray[np.float64], triangles: NDArray[np.int64], creases: NDArray[np.int64]) -> int:
    """Number of creases (c, 2), after checking that each is an edge with two triangles of one winding."""

def integrators() -> list[tuple[str, int, int, int, bool, bool, float, float]]:
    """Of each method: name, order, evaluations per step and at the start, whether it keeps energy, whether it
    can choose its own step, limits on the imaginary and the negative real axis.
    """

@final
class Simulation:
    """A scene in the core's hands; `membrane_rs.Simulation` drives it."""

    def __new__(
        cls,
        *,
        positions: NDArray[np.float64],
        velocities: NDArray[np.float64],
        reference: NDArray[np.float64],
        triangles: NDArray[np.int64],
        film: tuple[float, float, float, float] | None,
        negative_springs: str,
        creases: NDArray[np.int64],
        fold_signs: NDArray[np.float64],
        extra_masses: NDArray[np.float64],
        fixed: NDArray[np.int64],
        cord_pairs: NDArray[np.int64],
        cord_stiffness: NDArray[np.float64],
        cord_rest_length: NDArray[np.float64],
        cord_strain_limit: NDArray[np.float64],
        bridges: NDArray[np.int64],
        bridge_stiffness: float,
        contact_nodes: NDArray[np.int64],
        laws: list[tuple[str, dict[str, Any]]],
        integrator: str,
        dt: float | None,
        margin: float,
        watch_interval: int,
        energy_tolerance: float,
        loss_tolerance: float,
        tolerance: tuple[float, float, float],
        spectral_radius: float,
        short_steps: int,
        width: str | None = None,
    ) -> Simulation: ...
    @property
    def time(self) -> float: ...
    @property
    def dt(self) -> float: ...
    def set_dt(self, dt: float) -> None: ...
    @property
    def step_count(self) -> int: ...
    @property
    def evaluation_count(self) -> int: ...
    @property
    def integrator(self) -> str: ...
    @property
    def is_adaptive(self) -> bool: ...
    @property
    def rejected_count(self) -> int: ...
    @property
    def effort(self) -> tuple[int, int, int]: ...
    @property
    def hub_angle(self) -> float: ...
    @property
    def instructions(self) -> str: ...
    def shares_in_runs(self) -> list[tuple[str, float]]: ...
    @property
    def slow_laws(self) -> list[str]: ...
    @property
    def law_names(self) -> list[str]: ...
    def positions(self) -> NDArray[np.float64]: ...
    def velocities(self) -> NDArray[np.float64]: ...
    def set_motion(self, positions: NDArray[np.float64], velocities: NDArray[np.float64]) -> None: ...
    def masses(self) -> NDArray[np.float64]: ...
    def forces(self, law: str | None = None) -> NDArray[np.float64]: ...
    def energies(self) -> tuple[float, list[tuple[str, float]]]: ...
    def ledger(
        self,
    ) -> tuple[float, float, list[tuple[str, float]], list[tuple[str, float]], float, float, float]: ...
    def spring_readings(self, law: str) -> tuple[NDArray[np.float64], NDArray[np.bool_]] | None: ...
    def triangle_readings(self) -> tuple[NDArray[np.float64], NDArray[np.uint8]] | None: ...
    def crease_angles(self) -> NDArray[np.float64] | None: ...
    def limit(self) -> tuple[float, float, str, int, str]: ...
    def step(self, count: int) -> None: ...
    def reach(self, time: float) -> None: ...
    def check(self) -> None: ...
    def progress(self) -> dict[str, Any]: ...
    def resume(self, saved: dict[str, Any]) -> None: ...
