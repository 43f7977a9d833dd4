"""The compiled core; use it through `Mesh` and `Simulation`.

Shapes: n nodes, m triangles, e edges. Arrays are C-contiguous or not, of exactly the dtype stated. Numbering is the
caller's, in and out. Raises the package's own errors: MeshError, InputTypeError, InputError, UnstableError.
"""

from typing import Any, Final, final

import numpy as np
from numpy.typing import NDArray

from membrane_rs._core_input import Model, Settings

__all__ = [
    "ContactStatistics",
    "Crossings",
    "EnergyBalance",
    "FilmStates",
    "FilmStress",
    "HubLoad",
    "HubMotion",
    "LinkReadings",
    "MethodFacts",
    "NewtonStatistics",
    "Simulation",
    "StepLimit",
    "crossings",
    "edges",
    "groups",
    "hinge_count",
    "integrators",
    "lumped_masses",
    "rectangle_constants",
    "rectangles",
    "shortest_paths",
    "spring_constants",
]

def edges(triangles: NDArray[np.int64], node_count: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Unique edges (e, 2) of triangles (m, 3), lower node first, sorted; and the three of each triangle, (m, 3), edge k
    opposite corner k.
    """

def spring_constants(
    reference: NDArray[np.float64],
    triangles: NDArray[np.int64],
    stiffness: NDArray[np.float64],
    poisson_ratio: float,
) -> NDArray[np.float64]:
    """Spring constant of each edge by eq. (1), (e,) [N/m], or negative; with E h of each triangle, (m,) [N/m]."""

def rectangles(
    reference: NDArray[np.float64], triangles: NDArray[np.int64], creases: NDArray[np.int64]
) -> NDArray[np.int64]:
    """Corners (r, 4) in turn of the rectangles that pairs of triangles form; from the first to the third is no edge."""

def rectangle_constants(
    reference: NDArray[np.float64],
    triangles: NDArray[np.int64],
    creases: NDArray[np.int64],
    stiffness: NDArray[np.float64],
    poisson_ratio: float,
) -> NDArray[np.float64]:
    """Spring constants of the edges, then of the second diagonals, (e + r,) [N/m]; E h of each triangle, (m,) [N/m]."""

def lumped_masses(
    reference: NDArray[np.float64], triangles: NDArray[np.int64], areal_density: float
) -> NDArray[np.float64]:
    """A third of each triangle's mass on each of its nodes, (n,) [kg]; areal density rho h [kg/m2]."""

def hinge_count(reference: NDArray[np.float64], triangles: NDArray[np.int64], creases: NDArray[np.int64]) -> int:
    """Number of creases (c, 2), after checking that each is an edge with two triangles of one winding."""

def crossings(positions: NDArray[np.float64], triangles: NDArray[np.int64], limit: int) -> Crossings:
    """Crossings of triangles (m, 3) at positions (n, 3) [m]: all counted, the first `limit` listed."""

def groups(links: NDArray[np.int64], node_count: int) -> NDArray[np.int64]:
    """The group that each node is in, (n,), when links (k, 2) tie nodes together; numbered by their lowest nodes."""

def shortest_paths(
    links: NDArray[np.int64],
    lengths: NDArray[np.float64],
    node_count: int,
    starts: NDArray[np.int64],
    begun: NDArray[np.float64],
    longest: float,
) -> NDArray[np.float64]:
    """Length of the shortest path along links (k, 2) to each node from any of the starts (s,), with the length in
    `begun` (s,) that the paths of each start have already, (n,); inf where there is none up to `longest`.
    """

def integrators() -> list[MethodFacts]:
    """What is known of each method, in the order in which they are listed."""

@final
class Crossings:
    """Pairs of triangles by what they have in common."""

    pairs: Final[NDArray[np.int64]]  # The first pairs that cross, (k, 2), ascending.
    count: Final[int]  # Of all that cross: inner points in common, in two planes.
    overlapping: Final[int]  # Of those with inner points in common in one plane.
    touching: Final[int]  # Of those without a common node that have no common point inside of both.
    candidates: Final[int]  # Of those whose bounding boxes have common points.

@final
class MethodFacts:
    """What is known of a method of time integration."""

    name: Final[str]  # The name that scenes use.
    order: Final[int]  # Of the error after a given time.
    evaluations_per_step: Final[int]  # Of the forces.
    evaluations_at_start: Final[int]  # Of the forces, before the first step.
    conserves_energy: Final[bool]  # Whether the energy of an undamped motion stays bounded.
    is_adaptive: Final[bool]  # Whether it can choose its own step.
    imaginary_limit: Final[float]  # Largest stable omega dt of an undamped oscillation.
    real_limit: Final[float]  # Largest stable rate times dt of a pure decay.

@final
class EnergyBalance:
    """The energy balance since the ledger was opened, in joules."""

    @property
    def kinetic(self) -> float:
        """In the turning frame."""

    @property
    def stored(self) -> float:
        """Of all laws that have a potential."""

    @property
    def stored_by_law(self) -> dict[str, float]:
        """Of each law that has a potential."""

    @property
    def work_by_law(self) -> dict[str, float]:
        """Work done on the system by each law that has done some."""

    @property
    def changes(self) -> dict[str, float]:
        """What jumps of schedules have put into the kinetic energy and into that of each law, where it is not 0."""

    @property
    def motor_work(self) -> float | None:
        """Of the motor that turns the hub; None where a state of an earlier version lacks its start."""

    @property
    def reference_energy(self) -> float:
        """The largest single exchange so far."""

    @property
    def residual(self) -> float:
        """Energy that appeared without work done on the system; negative where it was lost."""

    @property
    def error(self) -> float:
        """The residual over the reference energy [-]."""

@final
class StepLimit:
    """The limit of the step at some positions."""

    dt: Final[float]  # The largest stable step [s]; infinite where nothing is stiff.
    largest_frequency: Final[float]  # [rad/s].
    law: Final[str]  # The law that sets the limit.
    node: Final[int]  # The node that moves most in the limiting mode.
    part: Final[str]  # Law and node in words.

@final
class NewtonStatistics:
    """What an implicit method has spent; zeros of others."""

    iterations: Final[int]  # Corrections of Newton's method.
    factorisations: Final[int]  # Of the tangent.
    fallbacks: Final[int]  # Steps, or parts of steps, that were halved.

@final
class ContactStatistics:
    """What contact between layers has spent since the core was made; zeros without it."""

    looked_at: Final[int]  # Pairs, over all steps.
    near: Final[int]  # Of these, such as would have come too near.
    pressed: Final[int]  # Of these, with an impulse.
    rigid: Final[int]  # Steps in which nodes moved as a rigid body.
    checks: Final[int]  # Exact checks for crossings.
    list_time: Final[float]  # Elapsed on lists of pairs [s].
    look_time: Final[float]  # On looking at pairs [s].
    impulse_time: Final[float]  # On impulses, and all that is not listed [s].
    check_time: Final[float]  # On exact checks [s].

@final
class LinkReadings:
    """Readings of s links."""

    strain: Final[NDArray[np.float64]]  # (s,) engineering strain.
    tension: Final[NDArray[np.float64]]  # (s,) elastic tension, negative in compression [N].
    buckled: Final[NDArray[np.bool_]]  # (s,) whether shorter than the critical length.

@final
class FilmStates:
    """States of m triangles with e edges."""

    strain: Final[NDArray[np.float64]]  # (m, 2) principal Green strains, the larger first.
    state: Final[NDArray[np.uint8]]  # (m,) 0 taut, 1 wrinkled, 2 slack.
    buckled: Final[NDArray[np.bool_]]  # (e,) whether shorter than flat beside a triangle that is wrinkled or slack.

@final
class FilmStress:
    """Stress of m triangles."""

    principal: Final[NDArray[np.float64]]  # (m, 2) principal values, the larger first [Pa].
    first: Final[NDArray[np.float64]]  # (m, 3) direction of the larger value.
    second: Final[NDArray[np.float64]]  # (m, 3) direction of the smaller value.

@final
class HubMotion:
    """The motion of the hub. Vectors have components along its axes, but for `centre`."""

    attitude: Final[list[float]]  # Quaternion (w, x, y, z) from components of the hub to those in space.
    centre: Final[list[float]]  # Displacement of its centre of mass in space [m].
    momentum: Final[list[float]]  # Angular momentum, without nodes held on it [kg m2/s]; 0 of a driven hub.
    sail_momentum: Final[list[float]]  # Angular momentum of all nodes [kg m2/s].
    motor_torque: Final[float | None]  # Of the motor of a free hub about its axis [N m].
    state: Final[list[float]]  # All numbers of the motion, with which another simulation may go on.

@final
class HubLoad:
    """What the sail exerts on the hub, in the turning frame."""

    force: Final[list[float]]  # Three components [N].
    torque: Final[list[float]]  # Three components, about the origin [N m].
    contact: Final[float]  # Sum of the magnitudes of the forces of contact on the nodes [N].

@final
class Simulation:
    """A scene in the core's hands; `membrane_rs.Simulation` drives it."""

    def __new__(
        cls,
        model: Model,
        laws: list[tuple[str, dict[str, Any]]],
        integrator: str,
        dt: float | None,
        settings: Settings,
        instructions: str | None = None,
    ) -> Simulation:
        """Assemble a scene.

        laws : kind and parameters of each. dt : the step [s]; None: from the limit of the step, or chosen by the
        method. instructions : "baseline", "avx2" or "avx512"; None: the widest, with the same bits.
        """

    @property
    def time(self) -> float:
        """[s]."""

    @property
    def dt(self) -> float:
        """The step [s]; the one to be tried next, where steps are chosen by their error."""

    def set_dt(self, dt: float) -> None:
        """Change the step [s]; steps are counted anew."""

    @property
    def step_count(self) -> int:
        """Steps since the time from which they are counted."""

    @property
    def evaluation_count(self) -> int:
        """Evaluations of the forces while stepping."""

    @property
    def integrator(self) -> str:
        """Name of the method."""

    @property
    def is_adaptive(self) -> bool:
        """Whether steps are chosen by their error."""

    @property
    def rejected_count(self) -> int:
        """Steps that were rejected because of their error."""

    @property
    def statistics(self) -> NewtonStatistics:
        """What an implicit method has spent."""

    @property
    def contact_statistics(self) -> ContactStatistics:
        """What contact between layers has spent."""

    @property
    def hub_angle(self) -> float:
        """The angle that the hub has turned since t = 0 [rad]."""

    @property
    def hub_rate(self) -> float:
        """Rate at which the hub turns now [rad/s]."""

    def hub(self) -> HubMotion:
        """The motion of the hub."""

    @property
    def instructions(self) -> str:
        """The vector instructions that the kernels run with."""

    def contiguous_shares(self) -> dict[str, float]:
        """By law, the share of its elements in contiguous or split batches."""

    @property
    def slow_laws(self) -> list[str]:
        """Laws that are evaluated once a step, others at each substep."""

    @property
    def law_names(self) -> list[str]:
        """All laws, tethers and bridges among them."""

    def positions(self) -> NDArray[np.float64]:
        """(n, 3) [m]."""

    def velocities(self) -> NDArray[np.float64]:
        """(n, 3) relative to the turning frame [m/s]."""

    def set_motion(self, positions: NDArray[np.float64], velocities: NDArray[np.float64]) -> None:
        """Set positions (n, 3) [m] and velocities (n, 3) [m/s], and open the ledger anew."""

    def start_from(
        self,
        time: float,
        hub: HubMotion,
        positions: NDArray[np.float64],
        velocities: NDArray[np.float64],
        past: tuple[NDArray[np.float64] | None, list[NDArray[np.float64]]],
    ) -> None:
        """Start from a motion at a time [s], with this motion of the hub, and open the ledger anew. Of the past are
        angles of creases [rad], which tell whole turns that positions do not, and shapes (n, 3) [m] whose distances
        layers of the film keep.
        """

    def masses(self) -> NDArray[np.float64]:
        """(n,) [kg]."""

    def forces(self, law: str | None = None) -> NDArray[np.float64]:
        """(n, 3) forces of one law or of all [N]."""

    def energies(self) -> dict[str, float]:
        """Energies [J]: "kinetic", and one for each law that has a potential."""

    def ledger(self) -> EnergyBalance:
        """The energy balance now."""

    def link_readings(self, law: str) -> LinkReadings | None:
        """Readings of the links of a law; None without links."""

    def film_states(self) -> FilmStates | None:
        """States of a film of triangles; None without its law."""

    def film_stress(self) -> FilmStress | None:
        """Stress of the film; None without a law of the film."""

    def largest_film_stress(self) -> float | None:
        """The largest principal stress of the film, at least 0 [Pa]; None without a law of the film."""

    def crease_angles(self) -> NDArray[np.float64] | None:
        """(c,) [rad]: pi flat, 0 shut; None without the law."""

    def layer_shapes(self) -> list[NDArray[np.float64]]:
        """(n, 3) each: positions [m] whose distances layers of the film keep; none without contact between them."""

    def contact_forces(self) -> NDArray[np.float64]:
        """(n, 3) forces of contact that the hub exerts on the nodes [N]."""

    def hub_load(self) -> HubLoad:
        """What the sail exerts on the hub."""

    def limit(self) -> StepLimit:
        """The limit of the step at the current positions."""

    def start_limit(self) -> StepLimit:
        """The same at the start, as it was found when the simulation was made."""

    def step(self, count: int) -> None:
        """Take steps; Ctrl-C stops between two."""

    def reach(self, time: float, seconds: float | None = None) -> bool:
        """Step to a time [s] and show the state there; whether it was reached within about `seconds` of wall time."""

    def time_of_step(self, number: int) -> float:
        """Time at the end of a constant step, by its number, or of a jump of schedules before it [s]."""

    def check(self, is_end: bool) -> None:
        """Look for a fault now, beside the regular checks; at the end of a run in the energy balance too."""

    def progress(self) -> dict[str, Any]:
        """What `resume` continues from with the same bits."""

    def resume(self, saved: dict[str, Any]) -> None:
        """Continue from what `progress` gave."""
