"""The measures by whose values a stage may end."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from copy import deepcopy
from inspect import currentframe
from typing import Any

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs._messages import in_one_line
from membrane_rs._validation import number_of
from membrane_rs.analysis.deployment import Corners, corner_nodes
from membrane_rs.errors import InputError, InputTypeError
from membrane_rs.folding.pattern import corner_turn
from membrane_rs.scene.stage import Stage
from membrane_rs.simulation.motion import Motion

PHASE = "phase_difference_deg"
"""The measure that is followed from one evaluation to the next, since it is an angle."""
STOWED = 1e-3
"""Distance of corners from their stowed places, over the size of the sail, up to which they are taken as stowed."""
OF_MOTION: dict[str, Callable[[Motion], float]] = {
    "deployment_rate": lambda sim: Corners(sim.assembly).deployment_rate(sim.positions),
    "kinetic_energy": lambda sim: sim.energies()["kinetic"],
    "stored_energy": lambda sim: math.fsum(energy for name, energy in sim.energies().items() if name != "kinetic"),
    "hub_angle": lambda sim: sim.hub_angle,
    "hub_rate": lambda sim: sim.hub_rate,
    "hub_force": lambda sim: float(np.linalg.norm(sim.hub_load().force)),
    "hub_torque": lambda sim: float(sim.hub_load().torque[2]),
    "contact_force": lambda sim: sim.hub_load().contact,
    "largest_cord_tension": lambda sim: float(sim.cord_tensions().max(initial=0.0)),
    "largest_film_stress": lambda sim: sim.largest_film_stress(),
    "largest_speed": lambda sim: float(np.linalg.norm(sim.velocities, axis=1).max()),
}
"""All of `membrane_rs.scene.stage.MEASURES` but `PHASE`."""


def stowed_turn(sim: Motion) -> float:
    """Angle by which the corners are wound up [rad], where they lie as the scene's own start has them; else 0."""
    corners = corner_nodes(sim.assembly)
    apart = sim.positions[corners] - sim.assembly.positions[corners]
    is_stowed = np.abs(apart).max() < STOWED * np.abs(sim.assembly.reference[corners]).max()
    return corner_turn(sim.scene.mesh) if is_stowed else 0.0


def _evaluated(measure: Callable[[Motion], object], sim: Motion) -> object:
    return measure(sim)


def _evaluations() -> Iterator[tuple[object, object]]:
    """The measures that callers of this function evaluate, and their simulations. The stack tells them: unlike a flag,
    it is right after an interrupt.
    """
    frame = currentframe()
    while frame is not None:
        if frame.f_code is _evaluated.__code__:
            yield frame.f_locals["measure"], frame.f_locals["sim"]
        frame = frame.f_back


def is_measured(sim: Motion) -> bool:
    """Whether a measure of this simulation is being evaluated, by which this is called."""
    return any(measured is sim for _, measured in _evaluations())


def reading(measure: Callable[[Any], object], sim: Motion, where: str, unit: str) -> float:
    """The value of a user's measure now.

    Raises InputError and InputTypeError, which begin with `where`, for one that raises an error, gives no finite
    number, or changes the simulation.
    """
    before = sim._core.step_count, sim._core.time, sim._motions_set
    at = f"{where} at t = {sim.time:.6g} s"
    try:
        value = _evaluated(measure, sim)
    except Exception as error:
        raise InputError(f"{at}: raised {in_one_line(error)}; mend the function") from error
    if before != (sim._core.step_count, sim._core.time, sim._motions_set):
        raise InputError(f"{at}: has stepped or set the simulation; a measure only reads")
    if isinstance(value, np.ndarray) and value.ndim:
        raise InputTypeError(f"{at}: gave an array of shape {value.shape}; must give one number, such as its .max()")
    return number_of(at, value, unit)


class Follower:
    """Evaluates the measure of a stage, or of what ends a run. An angle is followed from the turn nearest to the flat
    shape at the start of the stage, of a wound sail from that of the roll, by less than half a turn from one call of
    `at_check` to the next.
    """

    def __init__(self, stage: Stage, where: str, sim: Motion, purpose: str = "it ends a stage") -> None:
        self._stage, self.where, self._purpose = stage, where, purpose
        self._corners = Corners(sim.assembly, stowed_turn(sim)) if stage.measure == PHASE else None

    def excess(self, sim: Motion) -> float:
        """By how much the measure is beyond its value now.

        Raises InputError and InputTypeError for what is no finite number, InputError where it steps the simulation.
        """
        return self._value(sim, deepcopy(self._corners)) - (self._stage.level or 0.0)

    def at_check(self, sim: Motion) -> Follower:
        """The follower from now on, where nodes may have turned."""
        after = deepcopy(self)
        if after._corners is not None:
            after._value(sim, after._corners)
        return after

    @property
    def turned(self) -> Floats | None:
        """(k,) angles by which the corners have turned [rad]; None for a measure that is no angle."""
        return None if self._corners is None else self._corners.turned

    def resume(self, sim: Motion, turned: Floats | None) -> None:
        """Follow on from the positions now, where the corners have turned so far. Raises InputError."""
        if self._corners is not None:
            if turned is None or turned.shape != self._corners.turned.shape:
                raise InputError("saved state: stage_turned does not have one angle for each corner; it is damaged")
            self._corners.resume(turned)

    def _value(self, sim: Motion, corners: Corners | None) -> float:
        measure: Any = self._stage.measure
        before = sim._core.step_count, sim._core.time
        if corners is not None:
            value: object = corners.phase_difference(sim.positions)
        elif any(running is measure for running, _ in _evaluations()):
            what = "has copied the simulation, or made one that evaluates it as well; a measure only reads"
            raise InputError(f"{self.where}: {what}")
        else:
            value = _evaluated(OF_MOTION[measure] if isinstance(measure, str) else measure, sim)
        if before != (sim._core.step_count, sim._core.time):
            raise InputError(f"{self.where}: has stepped the simulation; a measure only reads")
        return number_of(f"{self.where} at t = {sim.time:.6g} s", value, self._purpose)

    def __deepcopy__(self, memo: dict[int, Any]) -> Follower:
        """A copy that follows on by itself."""
        made = Follower.__new__(Follower)
        made._stage, made.where, made._purpose = self._stage, self.where, self._purpose
        made._corners = deepcopy(self._corners, memo)
        return made
