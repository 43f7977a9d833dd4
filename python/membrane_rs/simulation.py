"""Runs a scene: the core steps, observers look on."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from membrane_rs import _core
from membrane_rs._validation import show
from membrane_rs.assembly import Assembly
from membrane_rs.errors import InputError, InputTypeError, UnstableError
from membrane_rs.laws import Law, Springs
from membrane_rs.run_settings import MOST_INSTANTS
from membrane_rs.saved_state import read_state, write_state
from membrane_rs.scene import Scene

if TYPE_CHECKING:
    from membrane_rs.output import RunFolder

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

MARGIN = 0.4
"""Share of the stability limit that is taken as the step where none is given."""
ENERGY_TOLERANCE = 1e-2
"""Energy from nowhere, as a share of the energy turned over, at which a run stops."""
MOST_STEPS = 10**15
"""More steps than this are a slip of the pen: they would take centuries."""


PROGRESS_LOOKS = 500
"""How often a run that is followed tells its progress, beside every sample."""


@dataclass(frozen=True)
class IntegratorFacts:
    """What is known of a method of time integration.

    order : of the error after a given time. evaluations : of the forces per step. evaluations_at_start : before the
    first step. keeps_energy : whether the energy of an undamped motion stays bounded, however long it lasts.
    is_adaptive : whether it chooses its own step where none is given. imaginary_limit : largest stable
    omega dt of an undamped oscillation. real_limit : largest stable rate times dt of a pure decay.
    """

    order: int
    evaluations: int
    evaluations_at_start: int
    keeps_energy: bool
    is_adaptive: bool
    imaginary_limit: float
    real_limit: float


def integrators() -> dict[str, IntegratorFacts]:
    """What is known of each method, by name."""
    return {facts[0]: IntegratorFacts(*facts[1:]) for facts in _core.integrators()}


class Observer(Protocol):
    """Looks on while a scene runs."""

    def start(self, sim: Simulation) -> None:
        """Called before the first step."""

    def sample(self, sim: Simulation) -> None:
        """Called at each instant of the history."""

    def frame(self, sim: Simulation) -> None:
        """Called at each instant at which a shape is kept; each is also a sample."""

    def finish(self, sim: Simulation, error: BaseException | None) -> None:
        """Called at the end, whatever ended the run."""


class Simulation:
    """A scene that moves. Arrays are in the order of the scene: the mesh's nodes, then those of the cords.

    Positions are [m] in the frame that turns with the hub, and velocities [m/s] are relative to it.

    Parameters
    ----------
    scene : Scene
        What is simulated.
    integrator : str, optional
        Name of the method. Default: the scene's own, which is "rk4" unless it says otherwise.
    dt : float, optional
        Step [s]. Default: the scene's own; without one, "dopri5" chooses each step so that its error stays below
        the scene's tolerance; "generalized_alpha", which has no limit, takes 50 times 2/omega of the highest frequency;
        other methods take 0.4 of the stability limit. All take a little less so that a whole number of steps, and
        at least one, lies between two samples of the scene's history.

    Raises
    ------
    MeshError
        A triangle without area, negative spring constants, a crease that is no hinge.
    InputError
        dt not above zero or far beyond the limit, an integrator that does not exist, a node without mass.
    """

    def __init__(self, scene: Scene, integrator: str | None = None, dt: float | None = None) -> None:
        if not isinstance(scene, Scene):
            raise InputTypeError(f"Simulation.scene = {show(scene)}: must be a Scene; load or build one first")
        self.scene = scene
        self.assembly: Assembly = scene.assemble()
        step = _step_of(scene.run.dt if dt is None else dt)
        self._core = _core.Simulation(
            **_core_arguments(scene, self.assembly),
            integrator=scene.run.integrator if integrator is None else str(integrator),
            dt=step,
            margin=MARGIN,
            watch_interval=scene.run.watch,
            energy_tolerance=ENERGY_TOLERANCE,
            loss_tolerance=scene.run.energy_loss,
            tolerance=(scene.run.tolerance, scene.run.tolerance_length, scene.run.tolerance_speed),
            spectral_radius=scene.run.spectral_radius,
            short_steps=scene.run.short_steps,
        )
        if step is None and not self.is_adaptive:
            interval = scene.run.until / (scene.run.samples - 1)
            self._core.set_dt(interval / math.ceil(interval / self._core.dt))
        self.is_settled = False

    @property
    def time(self) -> float:
        """Simulated time [s]: the start plus a whole number of steps, never a running sum, unless `is_adaptive`."""
        return self._core.time

    @property
    def dt(self) -> float:
        """Step [s]; where `is_adaptive`, the one to be tried next."""
        return self._core.dt

    @property
    def is_adaptive(self) -> bool:
        """Whether the method chooses each step by its error; instants between two steps are then shown as they are."""
        return self._core.is_adaptive

    @property
    def rejected_count(self) -> int:
        """Steps that were tried and rejected because of their error; their evaluations count."""
        return self._core.rejected_count

    @property
    def effort(self) -> dict[str, int]:
        """What an implicit method has spent: "newton_iterations", "factorisations", and "fallbacks", the steps or parts
        of steps that it took in halves because Newton's method failed; zeros for explicit methods.
        """
        return dict(zip(("newton_iterations", "factorisations", "fallbacks"), self._core.effort, strict=True))

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
        """(N, 3) a copy of the positions [m]. Setting them opens the energy ledger anew."""
        return self._core.positions()

    @positions.setter
    def positions(self, values: ArrayLike) -> None:
        self._core.set_motion(self._vectors(values, "positions", "m"), self.velocities)

    @property
    def velocities(self) -> Floats:
        """(N, 3) a copy of the velocities relative to the turning frame [m/s]. Held nodes stay at rest."""
        return self._core.velocities()

    @velocities.setter
    def velocities(self, values: ArrayLike) -> None:
        self._core.set_motion(self.positions, self._vectors(values, "velocities", "m/s"))

    @cached_property
    def masses(self) -> Floats:
        """(N,) mass of each node [kg], tip masses and cords included; read only."""
        masses = self._core.masses()
        masses.setflags(write=False)
        return masses

    @cached_property
    def spring_pairs(self) -> Ints:
        """(S, 2) ends of each spring: the mesh's edges in their order, then the segments of the cords."""
        edges = self.scene.mesh.edges if self.scene.mesh is not None else np.zeros((0, 2), np.int64)
        return np.vstack([edges, self.assembly.cord_pairs])

    def forces(self, law: str | Law | type[Law] | None = None) -> Floats:
        """(N, 3) forces now [N], of one law or of all.

        Parameters
        ----------
        law : str, law or class of a law, optional
            "springs", "creases", ... or "tethers" and "bridges", which come with those parts. Default: all.

        Raises
        ------
        InputError
            A law that the scene does not hold.
        """
        name = law if law is None or isinstance(law, str) else getattr(law, "kind", None)
        if law is not None and name is None:
            raise InputTypeError(f"law = {show(law)}: must be the name of a law, such as 'springs'")
        return self._core.forces(name)

    def energies(self) -> dict[str, float]:
        """Energies now [J]: "kinetic", and one for each law that has a potential. Their sum is the mechanical energy.

        "kinetic" is that of the motion relative to the turning frame, and "spin" the centrifugal potential.
        """
        kinetic, stored = self._core.energies()
        return {"kinetic": kinetic, **dict(stored)}

    def ledger(self) -> dict[str, Any]:
        """The energy balance since the start, or since positions or velocities were last set.

        Returns
        -------
        dict
            "kinetic", "stored", "work" (done on the system, below zero where damping takes energy out), "turned_over"
            (largest change of any one account so far), all [J]; "error", the energy that is there beyond what
            was there and what work brought, as a share of the energy turned over, negative where the method loses it;
            "work_by_law", {law: J}.
        """
        kinetic, stored, work, turned_over, _, error = self._core.ledger()
        by_law = dict(work)
        return {
            "kinetic": kinetic,
            "stored": stored,
            "work": math.fsum(by_law.values()),
            "turned_over": turned_over,
            "error": error,
            "work_by_law": by_law,
        }

    def spring_strains(self) -> Floats:
        """(S,) strain of each spring, in the order of `spring_pairs`."""
        d = self.positions[self.spring_pairs[:, 1]] - self.positions[self.spring_pairs[:, 0]]
        rest: Floats = np.zeros(0) if self.scene.mesh is None else self.scene.mesh.edge_lengths
        lengths: Floats = np.concatenate([rest, self.assembly.cord_rest_length])
        strains: Floats = np.sqrt(np.einsum("ij,ij->i", d, d)) / lengths - 1.0
        return strains

    def buckled(self) -> NDArray[np.bool_]:
        """(S,) whether each spring is shorter than its critical length; a slack cord counts as buckled.

        With `Triangles`, an edge is buckled where it is shorter than in the flat mesh, beside a triangle that is
        wrinkled or slack.
        """
        found = np.zeros(len(self.spring_pairs), dtype=np.bool_)
        edges = len(self.spring_pairs) - len(self.assembly.cord_pairs)
        for law, rows in (("springs", slice(None, edges)), ("tethers", slice(edges, None))):
            readings = self._core.spring_readings(law)
            if readings is not None:
                found[rows] = readings[1]
        films = self._core.triangle_readings()
        if films is not None and self.scene.mesh is not None:
            beside = np.zeros(edges, dtype=np.bool_)
            beside[self.scene.mesh.triangle_edges[films[1] > 0]] = True
            found[:edges] = beside & (self.spring_strains()[:edges] < 0)
        return found

    def film_states(self) -> NDArray[np.int8]:
        """(m,) what the film does in each triangle: 0 taut, 1 wrinkled, 2 slack; -1 without the law `Triangles`."""
        films = self._core.triangle_readings()
        if films is None:
            return np.full(len(self.assembly.triangles), -1, np.int8)
        return films[1].astype(np.int8)

    def crease_angles(self) -> Floats:
        """(c,) crease angles [rad]: pi flat, 0 shut, below 0 where the wings interpenetrate; NaN without the law."""
        angles = self._core.crease_angles()
        return np.full(len(self.assembly.creases), np.nan) if angles is None else angles

    @property
    def hub_angle(self) -> float:
        """The angle that the hub has turned since time 0 [rad]."""
        return self._core.hub_angle

    @property
    def slow_laws(self) -> list[str]:
        """The laws that are evaluated once a step, others at each of its `short_steps`; empty without those."""
        return self._core.slow_laws

    def stable_dt(self) -> float:
        """The largest step that this method can take here without growing modes [s]; no margin is taken off.

        From the largest eigenvalue of the stiffness at the current positions, with every spring taut, every crease in
        contact and every contact closed; infinite where nothing is stiff.
        """
        return self._stability()[0]

    @property
    def limiting_part(self) -> str:
        """The law and node that set `stable_dt`, and the node set it lies in."""
        return self._stability()[1]

    @property
    def limiting_node(self) -> int:
        """The node that moves most in the vibration that sets `stable_dt`."""
        return self._stability()[2]

    def _stability(self) -> tuple[float, str, int]:
        dt, _, _, node, words = self._core.limit()
        sets = [name for name, nodes in self.assembly.node_sets.items() if node in nodes]
        return dt, f"{words} (in {', '.join(sets)})" if sets else words, node

    def step(self, n: int = 1) -> None:
        """Take `n` steps; where `is_adaptive`, `n` accepted ones from the end of the last.

        Raises
        ------
        UnstableError
            The run went wrong; the state is then that of the last check that found nothing.
        KeyboardInterrupt
            Ctrl-C, between two steps.
        """
        try:
            count = operator.index(n)
        except TypeError:
            raise InputTypeError(f"n = {show(n)}: must be a whole number of steps") from None
        if not 0 <= count <= MOST_STEPS:
            raise InputError(f"n = {count}: must be a whole number of steps, from 0 to {MOST_STEPS:.0e}")
        self._core.step(count)

    def settle(self, duration: float | None = None, rate: float | None = None) -> float:
        """Damp the scene to rest where its guide bars hold it, and start from there with the clock at zero.

        Nodes of the set "guide_bars" (none without that set) are held, and friction F = -rate m v is added, for
        `duration` of simulated time; then the nodes are let go, at rest. Returns the largest
        speed left before that [m/s].

        Raises
        ------
        InputError
            After the first step, or with a duration or rate that is not above zero.
        """
        from membrane_rs.settling import settled

        if self.step_count:
            raise InputError(
                f"settle at t = {self.time:.6g} s: it must come before the first step; build a new Simulation"
            )
        duration = None if duration is None else _number("settle: duration", duration)
        rate = None if rate is None else _number("settle: rate", rate, "1/s")
        positions, speed = settled(self.scene, self.integrator, self.positions, duration, rate)
        self._core.set_motion(positions, np.zeros_like(positions))
        self.is_settled = True
        return speed

    def run(
        self,
        until: float | None = None,
        frames: int | Sequence[float] | None = None,
        out: str | Path | None = None,
        *,
        samples: int | None = None,
        observers: Sequence[Observer] = (),
        progress: Callable[[Simulation], None] | None = None,
        overwrite: bool = False,
        pictures: bool = True,
    ) -> RunFolder | None:
        """Step to `until`, and let observers look on at frames and samples.

        Parameters
        ----------
        until : float, optional
            Time at the end [s]. Default: the scene's.
        frames : int or sequence of float, optional
            How many shapes to keep, evenly spaced from time 0 to the end, or their times [s]. Default: the scene's.
        out : path, optional
            Folder of the results; see `membrane_rs.output.RunFolder`. Default: nothing is written.
        samples : int, optional
            Rows of the history, evenly spaced. Default: the scene's.
        observers : sequence of observers, optional
            Others that look on.
        progress : callable, optional
            Called with this simulation now and then.
        overwrite, pictures : bool
            For the folder: replace an earlier run; draw pictures at the end.

        Returns
        -------
        RunFolder or None
            The folder, where `out` was given.

        Raises
        ------
        UnstableError
            The run stopped itself. What was written stays, with the last good frame.
        KeyboardInterrupt
            Ctrl-C. What was written stays; the simulation can go on.
        OutputError
            Results cannot be written.
        """
        end = _number("until", self.scene.run.until if until is None else until)
        if end < self.time:
            raise InputError(f"until = {end} s: the simulation is at {self.time:.6g} s already; give a later time")
        folder = None
        if out is not None:
            # Output looks on from above; it is named here only because a run may ask for it.
            from membrane_rs.output import RunFolder

            folder = RunFolder(out, overwrite, pictures=pictures)
        watchers: list[Observer] = [*observers, *([folder] if folder is not None else [])]
        if self.scene.run.settle > 0 and not self.is_settled and self.step_count == 0:
            self.settle()
        frame_marks = self._marks_of(self.scene.run.frames if frames is None else frames, end, "frames")
        shots = [time for time in self.scene.run.snapshots if time <= end]
        marks = frame_marks | self._marks_of(shots, end, "snapshots")
        marks |= self._marks_of(self.scene.run.samples if samples is None else samples, end, "samples")
        looks = np.linspace(min(marks), max(marks), PROGRESS_LOOKS if progress else 0)
        whole = float if self.is_adaptive else int
        for watcher in watchers:
            watcher.start(self)
        error: BaseException | None = None
        try:
            for mark in sorted(marks.union(map(whole, looks))):
                self._reach(mark)
                if mark in marks:
                    self._core.check()
                    self._show(watchers, is_frame=mark in frame_marks)
                if progress is not None:
                    progress(self)
        except BaseException as caught:
            error = caught
            if isinstance(caught, UnstableError):
                self._show(watchers, is_frame=True)  # the last good state
            raise
        finally:
            for watcher in watchers:
                watcher.finish(self, error)
        return folder

    def _show(self, watchers: Sequence[Observer], *, is_frame: bool) -> None:
        for watcher in watchers:
            watcher.sample(self)
            if is_frame:
                watcher.frame(self)

    def _reach(self, mark: float) -> None:
        """Go to a time [s] where steps are chosen, and else to a step count."""
        if self.is_adaptive:
            self._core.reach(mark)
        else:
            self._core.step(int(mark) - self.step_count)

    def _marks_of(self, wanted: int | Sequence[float], end: float, name: str) -> set[float]:
        """Marks for `_reach`: the wanted instants that are not past, or the step counts nearest to them; now and the
        end are among them.
        """
        ahead = (end - self.time) / self.dt
        if ahead > MOST_STEPS and not self.is_adaptive:
            raise InputError(
                f"until = {end} s: that is {ahead:.1e} steps of dt = {self.dt:.3g} s; give an earlier time"
            )
        if isinstance(wanted, Sequence | np.ndarray) and not isinstance(wanted, str | bytes):
            times = np.asarray([_number(name, t) for t in wanted], dtype=np.float64)
        else:
            try:
                count = operator.index(wanted)  # type: ignore[arg-type]
            except TypeError:
                raise InputTypeError(
                    f"{name} = {show(wanted)}: must be a whole number or a list of times (s)"
                ) from None
            if not 2 <= count <= MOST_INSTANTS:
                raise InputError(f"{name} = {count}: must be from 2 to {MOST_INSTANTS}, or a list of times (s)")
            times = np.linspace(0.0, end, count)
        if self.is_adaptive:
            # Twelve digits, so that a frame and a sample of the same instant are one mark.
            later = [float(f"{time:.12g}") for time in times[(times > self.time) & (times < end)]]
            return {self.time, end, *later}
        last = round(ahead)
        steps = np.round(np.clip((times - self.time) / self.dt, -1.0, last + 1.0)).astype(np.int64)
        steps = np.array([0, last, *steps[(steps > 0) & (steps <= last)]]) + self.step_count
        return set(steps.tolist())

    def save(self, path: str | Path) -> None:
        """Write scene and state into one file (.npz), from which `restore` continues with the same bits.

        Raises
        ------
        OutputError
            It cannot be written.
        """
        state = {
            "integrator": self.integrator,
            "dt": self.dt,
            "is_adaptive": self.is_adaptive,
            "is_settled": self.is_settled,
            **self._core.progress(),
        }
        write_state(Path(path), self.scene, state)

    @classmethod
    def restore(cls, path: str | Path) -> Simulation:
        """The simulation that `save` wrote.

        Raises
        ------
        MissingFileError
            No such file.
        InputError
            Not a saved state, or damaged.
        """
        scene, state = read_state(Path(path))
        try:
            dt, is_adaptive = state.pop("dt"), state.pop("is_adaptive")
            if not isinstance(is_adaptive, bool):
                raise ValueError("is_adaptive is not true or false")
            sim = cls(scene, str(state.pop("integrator")), None if is_adaptive else dt)
            if is_adaptive:
                sim._core.set_dt(_number("dt", dt))
            sim.is_settled = bool(state.pop("is_settled"))
            sim._core.resume(state)
        except ValueError as error:
            raise InputError(
                f"{path}: is a damaged saved state ({error}); give one that Simulation.save wrote"
            ) from None
        return sim

    def _vectors(self, values: ArrayLike, name: str, unit: str) -> Floats:
        try:
            given = np.asarray(values)
            array = given.astype(np.float64) if given.dtype.kind in "fiu" else None
        except (TypeError, ValueError):
            array = None
        if array is None:
            raise InputTypeError(f"{name} = {show(values)}: must be numbers [{unit}], one row x, y, z per node")
        if array.shape != (self.node_count, 3):
            raise InputTypeError(f"{name} has shape {array.shape}; it must be ({self.node_count}, 3), one row per node")
        return array


def _number(name: str, value: object, unit: str = "s") -> float:
    try:
        if isinstance(value, str | bytes | bool | np.bool_):
            raise TypeError
        number = float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        raise InputTypeError(f"{name} = {show(value)}: must be a number ({unit})") from None
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise InputError(f"{name} = {number}: must be finite ({unit})")
    return number


def _step_of(dt: object) -> float | None:
    if dt is None:
        return None
    number = _number("dt", dt)
    if number <= 0:
        raise InputError(f"dt = {number}: must be greater than 0 (s), or left out")
    return number


def _core_arguments(scene: Scene, assembly: Assembly) -> dict[str, Any]:
    """What the core is given, by name."""
    mesh, material = scene.mesh, scene.material
    springs = scene.law("springs")
    rule = "keep" if scene.law("triangles") is None else "unused"
    return {
        "positions": assembly.positions,
        "velocities": np.zeros_like(assembly.positions),
        "reference": np.zeros((0, 3)) if mesh is None else mesh.reference,
        "triangles": assembly.triangles,
        "film": None
        if material is None
        else (material.youngs_modulus, material.poisson_ratio, material.density, material.thickness),
        # Without the law of the springs nothing uses their constants, so nothing need be refused.
        "negative_springs": springs.negative if isinstance(springs, Springs) else rule,
        "creases": assembly.creases,
        "fold_signs": assembly.fold_signs,
        "extra_masses": assembly.extra_masses,
        "fixed": assembly.fixed,
        "cord_pairs": assembly.cord_pairs,
        "cord_stiffness": assembly.cord_stiffness,
        "cord_rest_length": assembly.cord_rest_length,
        "cord_strain_limit": assembly.cord_strain_limit,
        "bridges": assembly.bridges,
        "bridge_stiffness": assembly.bridge_stiffness,
        "contact_nodes": assembly.contact_nodes,
        "laws": [(law.kind, asdict(law)) for law in scene.laws],
    }
