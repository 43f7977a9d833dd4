"""Which bodies were touched in a run, and whether its steps resolved their friction."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from membrane_rs._warning import warn
from membrane_rs.errors import AuditWarning
from membrane_rs.mesh.findings import Finding
from membrane_rs.scene.bodies import Body
from membrane_rs.simulation.methods import integrators
from membrane_rs.simulation.stepper import Stepper

NAMES = ("first_contact", "largest_force", "friction_step", "friction_dt", "friction_time", "friction_node")
"""Of each body: time of the first sample at which it touches something [s], the largest force on a node [N]; the step
below which its friction is stable near rest [s], the step of the run, time [s] and node where that is worst."""


CLOSER = 0.99
"""Share of the step noted so far below which another one is noted: rounding is no reason."""


class BodyContacts:
    """An observer that notes at each sample what touches the bodies at work.

    Near rest Coulomb friction that is regularised by the speed e is a dashpot of mu N/e: on a node of mass m its rate
    is mu N/(m e), and a step is stable below the method's limit on the real axis over that rate. Beyond it friction,
    which is bounded, makes what is held tremble; no energy grows, so that the monitor does not see it.
    """

    def __init__(self, before: object = None) -> None:
        self.bodies: dict[str, dict[str, float | None]] = {}
        entries = before.items() if isinstance(before, Mapping) else ()
        for name, entry in entries:
            if _is_entry(entry):
                self.bodies[str(name)] = dict(entry)

    def start(self, sim: Stepper) -> None:
        """Nothing is needed before the first sample."""

    def frame(self, sim: Stepper) -> None:
        """Each frame is a sample."""

    def sample(self, sim: Stepper) -> None:
        """Note the contacts now."""
        for body in sim.stage_scene.bodies:
            entry = self.bodies.setdefault(body.name, dict.fromkeys(NAMES))
            sizes = np.linalg.norm(sim.forces(body.name), axis=1)
            if not sizes.any():
                continue
            if entry["first_contact"] is None:
                entry["first_contact"] = sim.time
            entry["largest_force"] = max(entry["largest_force"] or 0.0, float(sizes.max()))
            self._note_friction(sim, body, sizes, entry)

    def _note_friction(self, sim: Stepper, body: Body, sizes: Any, entry: dict[str, float | None]) -> None:
        limit = integrators()[sim.integrator].real_limit
        if body.friction == 0.0 or sim.is_adaptive or not math.isfinite(limit):
            return
        rates = body.friction / body.friction_speed * sizes / sim.masses
        rates[sim.assembly.fixed] = 0.0
        node = int(rates.argmax())
        if rates[node] > 0.0:
            step, known, dt = limit / float(rates[node]), entry["friction_step"], entry["friction_dt"]
            if known is None or dt is None or step / sim.dt < CLOSER * known / dt:
                now = {"friction_dt": sim.dt, "friction_time": sim.time, "friction_node": node}
                entry.update({"friction_step": step, **now})

    def finish(self, sim: Stepper, error: BaseException | None) -> None:
        """Warn of what was found, where the run came to the end of its scene."""
        if error is None:
            for finding in self.findings(sim):
                warn(f"{finding.severity}: {finding.message}; {finding.remedy}", AuditWarning)

    def findings(self, sim: Stepper) -> Iterator[Finding]:
        """Bodies that touched nothing up to the end of the scene, and friction that the steps did not resolve."""
        for body in sim.scene.bodies:
            entry = self.bodies.get(body.name)
            if entry is None:
                continue
            if entry["first_contact"] is None and _is_whole(sim):
                place = ", ".join(f"{x:.4g}" for x in body.solids(sim.time)[0].centre)
                yield Finding(
                    "warning",
                    "body_without_contact",
                    1,
                    f"the body {body.name} touches nothing at any sample of the run, up to {sim.time:.6g} s, when its "
                    f"centre is at ({place}) m",
                    "check its place and its schedules, in metres and radians in the frame of the hub, and what feels "
                    "it; or leave it out. What it touches between two samples alone is not seen",
                )
            step, dt = entry["friction_step"], entry["friction_dt"]
            if step is not None and dt is not None and dt > step:
                yield Finding(
                    "warning",
                    "friction_step",
                    1,
                    f"the friction of the body {body.name} needs steps below {step:.3g} s near rest, at node "
                    f"{entry['friction_node']} at {entry['friction_time']:.6g} s, and they have {dt:.3g} s: what it "
                    "holds trembles",
                    f"take a friction_speed of {body.friction_speed * dt / step:.3g} m/s or more, a shorter step, or "
                    "an implicit method",
                )


def _is_whole(sim: Stepper) -> bool:
    """Whether a run has come to the end of its scene."""
    return sim.is_over or (not sim.scene.stages and sim.time >= sim.scene.run.until)


def _is_entry(entry: object) -> bool:
    """Whether it is what an earlier run has noted of a body."""
    if not isinstance(entry, Mapping) or set(entry) != set(NAMES):
        return False
    numbers = [value for value in entry.values() if value is not None]
    of_friction = {entry[name] is None for name in NAMES if name.startswith("friction")}
    are_numbers = all(isinstance(value, int | float) and math.isfinite(value) for value in numbers)
    return are_numbers and len(of_friction) == 1 and entry["friction_step"] != 0
