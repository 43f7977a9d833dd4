"""A scene in motion: reading and setting its state."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from membrane_rs import _core
from membrane_rs._arrays import Floats, Ints
from membrane_rs._given_arrays import numeric
from membrane_rs._known_attributes import KnownAttributes
from membrane_rs._renamed import Renamed
from membrane_rs._validation import check_text, number_of, show
from membrane_rs.errors import InputError, InputTypeError
from membrane_rs.mesh.triangulation import frozen
from membrane_rs.scene import Scene
from membrane_rs.scene.assembly import Assembly
from membrane_rs.simulation.continuation import (
    check_balance,
    check_kinds,
    check_method,
    check_same_nodes,
    has_same_creases,
    scene_digest,
    unknown_entries,
)
from membrane_rs.simulation.copies import Copies
from membrane_rs.simulation.core_input import Settings, laws_of, model_of, refusals_named, settings_of
from membrane_rs.simulation.readings import Readings

SHORTEST_STEP = 1e-100
"""A stable step below this comes of values beyond all nature [s]."""


class Motion(KnownAttributes, Copies, Readings):
    """A scene in motion: its state, and all that is read from it. Its parameters and errors are those of
    `Simulation`, which adds what makes it go on.

    Parameters
    ----------
    scene, integrator, dt, start
        As those of `Simulation`.

    Raises
    ------
    InputError, InputTypeError, MeshError
        As `Simulation`.

    Examples
    --------
    >>> from membrane_rs import scenes
    >>> from membrane_rs.simulation import Motion
    >>> Motion(scenes.load("spinning-tether")).time
    0.0
    """

    ONCE = ("scene", "assembly")
    assembly: Assembly
    _limit: tuple[tuple[int, float, int], _core.StepLimit] | None
    SETTABLE = ("is_relaxed",)
    INSTEAD = "make another simulation, which may go on from this one (start=)"

    def __init__(
        self, scene: Scene, integrator: str | None = None, dt: float | None = None, *, start: Motion | None = None
    ) -> None:
        self._build(scene, integrator, dt)
        if start is not None:
            self._start_from(start)

    def _build(self, scene: Scene, integrator: str | None, dt: float | None) -> None:
        if not isinstance(scene, Scene):
            raise InputTypeError(f"Simulation.scene = {show(scene)}: must be a Scene, such as scenes.load(NAME)")
        self.scene = scene
        self.is_relaxed = False
        self._motions_set = 0
        self._simulate(scene.staged(0) if scene.stages else scene, integrator, dt)
        self._limit = self._now(), self._core.start_limit()

    def _simulate(self, scene: Scene, integrator: str | None, dt: float | None) -> None:
        """Make the core of a scene without stages."""
        method = scene.run.integrator if integrator is None else str(integrator)
        check_text(method, "integrator")
        assembly, step = scene.assemble(), _step_of(scene.run.dt if dt is None else dt)
        with refusals_named(scene):
            core = _core.Simulation(
                model_of(scene.as_simulated, assembly),
                laws_of(scene.as_simulated),
                method,
                step,
                self._settings(scene),
            )
        self._core, self._stage_scene, self._given_dt = core, scene, step
        self.__dict__["assembly"] = assembly
        self.__dict__.pop("masses", None)
        self._motions_set += 1
        self._limit = None
        if step is None and not self._core.dt > SHORTEST_STEP:
            raise InputError(
                f"the largest stable step is {self._core.dt} s, set by {self.limiting_part}: nothing moves in so short "
                "a time; check the values of that law, of the material and of the masses"
            )

    def _settings(self, scene: Scene) -> Settings:
        """How the core runs a scene."""
        return settings_of(scene)

    @property
    def stage_scene(self) -> Scene:
        """The scene at work now, without stages: `scene` itself, or that of its present stage."""
        return self._stage_scene

    @property
    def time(self) -> float:
        """Simulated time [s]: the start plus a whole number of steps, never a running sum, unless `is_adaptive`; or
        the time that was last reached, where it lies between two steps.
        """
        return self._core.time

    @property
    def dt(self) -> float:
        """Step [s]; where `is_adaptive`, the one to be tried next."""
        return self._core.dt

    @property
    def given_dt(self) -> float | None:
        """Step that the scene or the caller gave [s]; None where it follows from the limit or from the tolerance."""
        return self._given_dt

    @property
    def is_adaptive(self) -> bool:
        """Whether the method chooses each step by its error. States between two steps are then interpolated by the
        method's continuous extension.
        """
        return self._core.is_adaptive

    @property
    def rejected_count(self) -> int:
        """Steps that were tried and rejected because of their error; their evaluations count."""
        return self._core.rejected_count

    @property
    def statistics(self) -> dict[str, int]:
        """Counts of an implicit method: "newton_iterations", "factorisations", and "fallbacks", the steps or parts
        of steps that it took in halves because Newton's method failed; zeros for explicit methods.
        """
        spent = self._core.statistics
        return {
            "newton_iterations": spent.iterations,
            "factorisations": spent.factorisations,
            "fallbacks": spent.fallbacks,
        }

    @property
    def contact_statistics(self) -> dict[str, float]:
        """What contact between layers has spent in this stage, states between steps included; zeros without it.

        Pairs, summed over all steps: "looked_at"; of these "near", which would have come too near; of these "pressed",
        with an impulse. "rigid" steps, in which nodes moved as a rigid body; "checks" for crossings. Elapsed [s]:
        "list_time", on lists of pairs; "look_time", on looking at them; "check_time", on checks; "impulse_time", on all
        the rest.
        """
        spent = self._core.contact_statistics
        keys = (
            "looked_at",
            "near",
            "pressed",
            "rigid",
            "checks",
            "list_time",
            "look_time",
            "impulse_time",
            "check_time",
        )
        return {key: getattr(spent, key) for key in keys}

    @property
    def integrator(self) -> str:
        """Name of the method."""
        return self._core.integrator

    @property
    def step_count(self) -> int:
        """Steps taken."""
        return self._core.step_count

    @property
    def evaluation_count(self) -> int:
        """Evaluations of the forces while stepping."""
        return self._core.evaluation_count

    @property
    def node_count(self) -> int:
        """N, nodes of the membrane and of the cords."""
        return self.assembly.node_count

    @property
    def positions(self) -> Floats:
        """(N, 3) a read-only copy of the positions [m]; `.copy()` gives one to change. Setting them, all at once, keeps
        the time and opens the energy ledger anew. Where any position is another one, each crease is on its own side.
        """
        return frozen(self._core.positions())

    @positions.setter
    def positions(self, values: ArrayLike) -> None:
        self._set_motion(self._vectors(values, "positions", "m"), self.velocities)

    @property
    def velocities(self) -> Floats:
        """(N, 3) a read-only copy of the velocities relative to the turning frame [m/s], set as positions are. Fixed
        nodes stay at rest.
        """
        return frozen(self._core.velocities())

    @velocities.setter
    def velocities(self, values: ArrayLike) -> None:
        self._set_motion(self.positions, self._vectors(values, "velocities", "m/s"))

    def _start_from(self, other: Motion) -> None:
        """Go on from where another simulation of the same nodes is. Raises InputError."""
        if not isinstance(other, Motion):
            raise InputTypeError(
                f"start = {show(other)}: must be a Simulation, or the path of a saved state or of a run's folder"
            )
        check_same_nodes(self.assembly, other.assembly)
        angles = other._core.crease_angles() if has_same_creases(self.scene.mesh, other.scene.mesh) else None
        past = (angles, other._core.layer_shapes())
        self._core.start_from(other.time, other._core.hub(), other.positions, other.velocities, past)
        self.is_relaxed = other.is_relaxed
        self._motions_set += 1

    def _set_motion(self, positions: Floats, velocities: Floats) -> None:
        self._core.set_motion(positions, velocities)
        self._motions_set += 1

    @cached_property
    def masses(self) -> Floats:
        """(N,) mass of each node [kg], tip masses and cords included; read only."""
        return frozen(self._core.masses())

    @cached_property
    def spring_pairs(self) -> Ints:
        """(S, 2) ends of each spring: the mesh's edges in their order, with `Rectangles` the second diagonals, then the
        segments of the cords; read only.
        """
        mesh, pairs = self.scene.mesh, [self.assembly.cords.nodes]
        if mesh is not None and any(law.has_rectangles for law in self.scene.laws):
            pairs.insert(0, mesh.find_rectangles()[:, ::2])
        return frozen(np.vstack([*([] if mesh is None else [mesh.edges]), *pairs]))

    @property
    def slow_laws(self) -> list[str]:
        """The laws that are evaluated once a step, others at each of its `substeps`; empty without those."""
        return self._core.slow_laws

    @property
    def contiguous_shares(self) -> dict[str, float]:
        """By law, the share of its elements whose nodes are contiguous in the core's numbering [-].

        Kernels are quick with those, and gather the nodes of the others one by one. For laws that have elements.
        """
        return self._core.contiguous_shares()

    def stable_dt(self) -> float:
        """The largest step that this method can take here without growing modes [s]; no margin is taken off.

        From the largest eigenvalue of the stiffness at the current positions, with every spring taut, every crease in
        contact and every contact closed; infinite where nothing is stiff.

        Returns
        -------
        float
            [s]
        """
        return self._stability().dt

    @property
    def instructions(self) -> str:
        """The vector instructions that the core computes with: "baseline", "avx2" or "avx512"."""
        return self._core.instructions

    @property
    def limiting_part(self) -> str:
        """The law and node that set `stable_dt`, and the node set it lies in."""
        limit = self._stability()
        sets = [name for name, nodes in self.assembly.node_sets.items() if limit.node in nodes]
        return f"{limit.part} (in {', '.join(sets)})" if sets else limit.part

    @property
    def limiting_node(self) -> int:
        """The node that moves most in the vibration that sets `stable_dt`."""
        return self._stability().node

    def _stability(self) -> _core.StepLimit:
        """The limit, kept for as long as nothing moves, since it costs many steps."""
        if self._limit is None or self._limit[0] != self._now():
            with refusals_named(self.scene):
                self._limit = self._now(), self._core.limit()
        return self._limit[1]

    def _now(self) -> tuple[int, float, int]:
        """What changes with all that moves."""
        return self.step_count, self.time, self._motions_set

    def state(self) -> dict[str, Any]:
        """All that changes while the scene moves, copied, by name: what `set_state` continues from with the same bits.

        Among it "positions" (N, 3) [m], "velocities" (N, 3) [m/s], and "history_vectors" (k N, 3), what the method
        keeps from step to step, if it keeps anything. They are those at the end of the last step; "output_time" [s] is
        there where the time now is another. "scene_digest" tells the scene from others; "integrator", "dt" [s] and
        "is_adaptive" say how it is stepped.

        Returns
        -------
        dict of str to object
            Copies.
        """
        method = {"integrator": self.integrator, "dt": self.dt, "is_adaptive": self.is_adaptive}
        return {**self._core.progress(), "scene_digest": self._digest, **method}

    def set_state(self, state: dict[str, Any]) -> None:
        """Continue from what `state` gave, of the same scene, method and step.

        Parameters
        ----------
        state : dict
            What `state` gave.

        Raises
        ------
        InputError
            An entry that is missing or unknown, of the wrong type or of another scene's size, a value that is not
            finite, energies that contradict each other, or a state of another scene, method or step:
            `Simulation(scene, start=other)` goes on from that. The simulation is then unchanged.
        InputTypeError
            No dict.
        """
        if not isinstance(state, dict):
            raise InputTypeError(f"state = {show(state)}: must be a dict that `state` gave")
        for name in ("hub_phase", "scene_digest"):
            if name not in state:
                raise InputError(f"saved state: {name} is missing; give one that this version saved")
        for entry, words in unknown_entries(state, self._law_names()).items():
            raise InputError(f"saved state: {entry}: {words}")
        if str(state["scene_digest"]) != self._digest:
            raise InputError(
                "saved state: scene_digest is that of another scene, with other laws, parts or values; set it in a "
                "simulation of its own scene, or go on from that one under this scene: Simulation(scene, start=other)"
            )
        check_kinds(state)
        check_method(state, self.integrator, self.dt, is_adaptive=self.is_adaptive)
        before = self._core.progress()
        self._core.resume(state)
        try:
            check_balance(state, self.ledger())
        except InputError:
            self._core.resume(before)
            raise
        self._motions_set += 1

    def _law_names(self) -> list[str]:
        """The laws whose histories a state may hold."""
        return self._core.law_names

    @cached_property
    def _digest(self) -> str:
        return scene_digest(self.scene)

    effort = Renamed("statistics")
    shares_in_runs = Renamed("contiguous_shares")
    is_settled = Renamed("is_relaxed")

    def _vectors(self, values: ArrayLike, name: str, unit: str) -> Floats:
        try:
            array = numeric(values, name, "fiu", "numbers")
        except InputTypeError as error:
            what = f"{name} = {show(values)}: must be numbers [{unit}], one row x, y, z per node"
            raise InputTypeError(f"{what}; {error}") from None
        if array.shape != (self.node_count, 3):
            raise InputTypeError(f"{name} has shape {array.shape}; it must be ({self.node_count}, 3), one row per node")
        with np.errstate(over="ignore"):
            return array.astype(np.float64, order="C")


def _step_of(dt: object) -> float | None:
    if dt is None:
        return None
    number = number_of("dt", dt)
    if number <= 0:
        raise InputError(f"dt = {number}: must be greater than 0 (s), or left out")
    return number


def check_simulation(sim: object) -> None:
    """Refuse what has no scene and no assembly, and so is no simulation. Raises InputTypeError."""
    if not isinstance(getattr(sim, "scene", None), Scene) or not hasattr(sim, "assembly"):
        raise InputTypeError(f"sim = {show(sim)}: must be a Simulation")
