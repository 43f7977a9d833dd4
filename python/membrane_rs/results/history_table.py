"""The history of a run: a row for each sample, in memory or in history.csv.

time                   [s]
deployment_rate        mean radius of the corners over that of the flat sail
phase_difference_deg   [deg] mean angle of the corners relative to the spool
kinetic_energy         [J] in the turning frame
stored_energy          [J] potential energy of all laws
energy_error           (energy now - energy at the start - work done) / reference energy
hub_angle              [rad] turned by the hub so far
reference_energy       [J] the largest change of a single term of the energy balance so far
energy_<law>           [J] one per law with a potential: its potential energy
work_<law>             [J] one per law and body of the scene, and for moved nodes: work done on the system, negative
                       where it takes energy
hub_force              [N] magnitude of the force of the sail on the hub, see `HubLoad`; where nodes are held, or meet a
                       spool
hub_torque             [N m] torque of the sail on the hub about its axis; likewise
contact_force          [N] sum of the magnitudes of the forces between spool and nodes; where nodes meet a spool
largest_cord_tension   [N] elastic tension of the tautest segment; with cords
largest_film_stress    [Pa] largest principal stress, at least 0, see `Motion.film_stress`; with a law of the film
motor_work             [J] work of the motor that turns the hub so far, on the sail; with a hub that turns. It is no
                       term of the balance, which is that of the turning frame. Of a free hub that of its torque
hub_rate               [rad/s] of the hub; this and the next two where the hub turns freely, in any stage
hub_momentum           [kg m2/s] angular momentum of the hub about its axis, 0 while it is driven, see `AngularMomentum`
sail_momentum          [kg m2/s] of all nodes about that axis, in inertial space
nutation_deg           [deg] angle between the axis of the hub and the angular momentum of the whole; this and the next
                       three where the hub moves in six degrees of freedom, in any stage
attitude_w, _x, _y, _z quaternion that turns vectors along the axes of the hub into those in space
hub_x, hub_y, hub_z    [m] displacement of the hub's centre of mass in space
momentum_x, _y, _z     [kg m2/s] angular momentum of the whole along axes fixed in space
motor_torque           [N m] of the motor on the hub about its axis, see `HubMotor`; with a hub that turns
motor_power            [W] that torque times the rate of the hub; likewise

With stages the columns are those of all stages; an energy is 0 where its law is not at work. There are also

stage                  index of the stage; at a boundary that of the stage that begins
energy_of_changes      [J] put in by changes of stage so far: what is stored and moves after one, less what was before

motor_work and the columns below it are the last ones; runs of earlier versions lack them, or those below it. Behind
them stand the measures that a run was asked to record, each with the unit that was given with it.
"""

from __future__ import annotations

import math
from array import array
from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs.analysis.deployment import Corners
from membrane_rs.results.recorded import Measures
from membrane_rs.scene import Scene
from membrane_rs.scene.hub import has_free_body, has_free_hub
from membrane_rs.simulation.hub import HubLoad
from membrane_rs.simulation.measures import PHASE, stowed_turn
from membrane_rs.simulation.stepper import Stepper

FIRST_COLUMNS = (
    "time",
    "deployment_rate",
    "phase_difference_deg",
    "kinetic_energy",
    "stored_energy",
    "energy_error",
    "hub_angle",
    "reference_energy",
)

OF_STAGES = ("stage", "energy_of_changes")
"""The last columns of a scene with stages."""
MOTOR = "motor_work"
"""A column of a scene whose hub turns."""
OF_FREE_HUB = ("hub_rate", "hub_momentum", "sail_momentum")
"""Columns of a scene whose hub turns freely."""
OF_BODY = (
    "nutation_deg",
    *(f"attitude_{name}" for name in "wxyz"),
    *(f"hub_{name}" for name in "xyz"),
    *(f"momentum_{name}" for name in "xyz"),
)
"""Further columns of a scene whose hub moves in six degrees of freedom."""
OF_MOTOR = ("motor_torque", "motor_power")
"""Further columns of a scene whose hub turns."""
LATER = ((MOTOR, *OF_MOTOR), OF_MOTOR)
"""Columns that runs of earlier versions lack."""
RENAMED = {"energy_turned_over": "reference_energy"}
"""New names of columns by those of version 0.1; files and tables have both."""
_UNITS = {
    "time": "s",
    "deployment_rate": "",
    "phase_difference_deg": "deg",
    "kinetic_energy": "J",
    "stored_energy": "J",
    "energy_error": "",
    "hub_angle": "rad",
    "reference_energy": "J",
    "hub_force": "N",
    "hub_torque": "N m",
    "contact_force": "N",
    "largest_cord_tension": "N",
    "largest_film_stress": "Pa",
    "stage": "",
    "energy_of_changes": "J",
    MOTOR: "J",
    "hub_rate": "rad/s",
    "hub_momentum": "kg m2/s",
    "sail_momentum": "kg m2/s",
    "motor_torque": "N m",
    "motor_power": "W",
    **dict.fromkeys(OF_BODY, ""),
    "nutation_deg": "deg",
    **dict.fromkeys(("hub_x", "hub_y", "hub_z"), "m"),
    **dict.fromkeys(("momentum_x", "momentum_y", "momentum_z"), "kg m2/s"),
}


def column_units(columns: Iterable[str], recorded: Mapping[str, str]) -> dict[str, str]:
    """Units of columns, empty for a number alone; of a run's own measures those that were `recorded`."""
    of_laws = dict.fromkeys((name for name in columns if name.startswith(("energy_", "work_"))), "J")
    known = {**of_laws, **_UNITS, **recorded}
    return {name: known.get(name, "") for name in columns}


class HistoryTable:
    """The rows of a history, of one simulation, with the measures that it is asked to record."""

    columns: list[str]
    last: list[float]
    """The last row; empty before the first one."""
    measures: Measures
    """Those that are recorded beside the columns that each history has."""

    def __init__(self, sim: Stepper, measures: Measures | None = None) -> None:
        self._corners = Corners(sim.assembly, stowed_turn(sim))
        self._energies = list(sim.potential_names)
        bodies = [name for body in sim.scene.bodies for name in (body.name, f"{body.name}_friction")]
        of_parts = dict.fromkeys(part.working_law for part in sim.scene.parts)
        others = [name for name in (*of_parts, *bodies) if name in sim.law_names]
        self._works = [*(law.kind for law in sim.scene.laws), *others]
        self._readings = _readings_of(sim)
        self._of_stages = OF_STAGES if sim.scene.stages else ()
        self._of_hub = _of_hub(sim.scene)
        self.columns = [
            *FIRST_COLUMNS,
            *(f"energy_{name}" for name in self._energies),
            *(f"work_{name}" for name in self._works),
            *self._readings,
            *self._of_stages,
            *self._of_hub,
        ]
        self.measures = (measures or Measures()).beside((*self.columns, *RENAMED))
        self.columns += self.measures.units
        self.last = []
        self._values = array("d")

    def add(self, sim: Stepper) -> bool:
        """Add a row for now; whether that is done.

        A state that is not later than the last one is skipped: an unstable run is set back to its last good state,
        which may be there already.
        """
        if self.last and sim.time <= self.last[0]:
            return False
        positions, ledger = sim.positions, sim.ledger()
        load = sim.hub_load() if "hub_force" in self._readings else None
        row = [
            sim.time,
            self._corners.deployment_rate(positions),
            self._corners.phase_difference(positions),
            ledger["kinetic"],
            ledger["stored"],
            ledger["error"],
            sim.hub_angle,
            ledger["reference_energy"],
            *(ledger["stored_by_law"].get(name, 0.0) for name in self._energies),
            *(ledger["work_by_law"].get(name, 0.0) for name in self._works),
            *_readings(sim, self._readings, load),
        ]
        if self._of_stages:
            row += [sim.stage, math.fsum(ledger["changes"].values())]
        row += _hub_readings(sim, self._of_hub, ledger[MOTOR], load)
        row += self.measures.values(sim)
        # Adding 0 makes 0 of -0, which a reader would take for a sign.
        self.last = [float(value) + 0.0 for value in row]
        self._values.extend(self.last)
        return True

    def take(self, columns: Sequence[str]) -> bool:
        """Take these columns, where they are those at hand, or those without some that runs of earlier versions lack;
        whether they are.
        """
        for lacking in ((), *LATER):
            if list(columns) == [name for name in self.columns if name not in lacking]:
                self.columns = list(columns)
                self._of_hub = tuple(name for name in self._of_hub if name not in lacking)
                return True
        return False

    def resume(self, sim: Stepper, rows: Floats) -> None:
        """Go on behind rows (samples, columns) of before."""
        self._values = array("d", rows.tobytes())
        self.last = rows[-1].tolist() if len(rows) else []
        last = self.last[FIRST_COLUMNS.index(PHASE)] if self.last else math.nan
        if math.isfinite(last):
            self._corners = Corners(sim.assembly, math.radians(last))

    def table(self) -> dict[str, Floats]:
        """The samples so far, one (samples,) array per column."""
        values = np.array(self._values, dtype=np.float64).reshape(-1, len(self.columns))
        return {name: values[:, k] for k, name in enumerate(self.columns)}


def _readings_of(sim: Stepper) -> list[str]:
    """The largest stress and tension, and the load on the hub, as far as the scene has them in any stage."""
    scenes = [sim.scene.staged(k) for k in range(len(sim.scene.stages))] or [sim.scene]
    assemblies, found = [scene.assemble() for scene in scenes], []
    has_contacts = any(len(assembly.contacts) for assembly in assemblies)
    if has_contacts or any(len(assembly.fixed) for assembly in assemblies):
        found = ["hub_force", "hub_torque", *(["contact_force"] if has_contacts else [])]
    if len(sim.assembly.cords):
        found.append("largest_cord_tension")
    if len(sim.assembly.triangles) and any(law.is_film for law in sim.scene.laws):
        found.append("largest_film_stress")
    return found


def _of_hub(scene: Scene) -> tuple[str, ...]:
    """The columns of a hub that turns."""
    if not any(law.turns_hub for law in scene.laws):
        return ()
    of_free = (*(OF_FREE_HUB if has_free_hub(scene) else ()), *(OF_BODY if has_free_body(scene) else ()))
    return (MOTOR, *of_free, *OF_MOTOR)


def _hub_readings(sim: Stepper, names: Sequence[str], work: float | None, load: HubLoad | None) -> list[float]:
    """The readings of the hub of these names now, with the work of its motor [J], and its load where it is at hand."""
    found: dict[str, float] = {MOTOR: math.nan if work is None else work}
    if "hub_rate" in names:
        momentum = sim.angular_momentum()
        found |= {"hub_rate": sim.hub_rate, "hub_momentum": momentum.hub, "sail_momentum": momentum.sail}
        if OF_BODY[0] in names:
            values = (math.degrees(sim.nutation_angle), *sim.hub_attitude, *sim.hub_displacement, *momentum.in_space)
            found |= dict(zip(OF_BODY, values, strict=True))
    if "motor_torque" in names:
        motor = sim.hub_motor(load)
        found |= {"motor_torque": motor.torque, "motor_power": motor.power}
    return [found[name] for name in names]


def _readings(sim: Stepper, names: Sequence[str], load: HubLoad | None) -> list[float]:
    """The readings of these names now, with the load on the hub where they have it."""
    found = {}
    if load is not None:
        found = {"hub_force": float(np.linalg.norm(load.force)), "hub_torque": float(load.torque[2])}
        found["contact_force"] = load.contact
    if "largest_cord_tension" in names:
        found["largest_cord_tension"] = float(sim.cord_tensions().max())
    if "largest_film_stress" in names:
        found["largest_film_stress"] = sim.largest_film_stress()
    return [found[name] for name in names]
