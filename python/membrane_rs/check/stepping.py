"""How a scene is stepped: a step beyond the stability limit, and settings that have no effect with its method."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, fields, replace

from membrane_rs.errors import MembraneError
from membrane_rs.mesh.findings import Finding
from membrane_rs.scene import Scene
from membrane_rs.scene.laws import Law
from membrane_rs.scene.run_settings import RunSettings
from membrane_rs.scene.softened import softening_of
from membrane_rs.simulation.methods import IntegratorFacts, integrators
from membrane_rs.simulation.motion import Motion

LEFT_OUT = " (--dt auto, or --set run.dt=auto; None in Python)"
"""How to leave out the step that a scene gives."""
WITH_STEP = " and a given step"
"""Why a method that chooses its steps by their error ignores the tolerance."""
SUBSTEPPED = "leapfrog"
"""The method whose steps may have substeps."""


@dataclass(frozen=True)
class Stepping:
    """By which method and step a scene is run.

    Attributes
    ----------
    run : RunSettings
        With the method and the step that are used; dt is None where the step was not given.
    own : RunSettings
        Those of the scene, whose method and step a caller may have replaced.
    stable_dt : callable
        Gives the largest stable step [s]. Raises MembraneError where the scene cannot be simulated.
    softening : float or None
        Of the film [-].
    laws : sequence of Law
        Those of the scene.
    """

    run: RunSettings
    own: RunSettings
    stable_dt: Callable[[], float]
    softening: float | None = None
    laws: Sequence[Law] = ()

    @classmethod
    def of_scene(cls, scene: Scene) -> Stepping:
        """As its run settings say."""
        return cls(scene.run, scene.run, lambda: Motion(scene).stable_dt(), softening_of(scene), scene.laws)

    @classmethod
    def of_motion(cls, sim: Motion) -> Stepping:
        """As a simulation steps its scene."""
        own = sim.stage_scene.run
        run = replace(own, integrator=sim.integrator, dt=sim.given_dt)
        return cls(run, own, sim.stable_dt, softening_of(sim.stage_scene), sim.stage_scene.laws)


def is_explicit(integrator: str) -> bool:
    """Whether a method has a limit of its step; False for a method that is not known."""
    facts: IntegratorFacts | None = integrators().get(integrator)
    return facts is not None and math.isfinite(facts.imaginary_limit)


def laws_of_other_methods(stepping: Stepping) -> Iterator[Finding]:
    """Laws that do not go with the method."""
    method = stepping.run.integrator
    for law in stepping.laws:
        if law.methods is not None and method not in law.methods:
            yield Finding(
                "error",
                "method",
                1,
                f"run.integrator = {method!r}: laws.{law.kind} goes with {' or '.join(map(repr, law.methods))} alone",
                f"set run.integrator to {' or '.join(map(repr, law.methods))}, or leave {law.kind} out",
            )


def step_above_limit(stepping: Stepping) -> Iterator[Finding]:
    """A given step above the stability limit: some vibration grows from step to step until the monitor stops the run.

    The limit holds with every spring taut and every contact closed, so that a run may get by where they are not. A step
    that is not given lies below it.
    """
    dt = stepping.run.dt
    if dt is None:
        return
    try:
        limit = stepping.stable_dt()
    except MembraneError:  # `Simulation` says why
        return
    if dt > limit:
        yield Finding(
            "warning",
            "step",
            1,
            f"dt = {dt:.4g} s is above the stability limit of {limit:.4g} s",
            f"leave dt out{LEFT_OUT if stepping.own.dt is not None else ''}, or use a smaller one",
        )


def settings_without_effect(stepping: Stepping) -> Iterator[Finding]:
    """Run settings other than the default that the method does not use.

    Nothing where a caller's method or step replaces that of the scene, with which they have an effect.
    """
    run, own = stepping.run, stepping.own
    defaults = {item.name: item.default for item in fields(RunSettings)}
    unused, unused_by_scene = _unused(run), _unused(own)
    for name, why in unused.items():
        value = getattr(run, name)
        if name in unused_by_scene and value != defaults[name]:
            yield Finding(
                "warning",
                "setting_without_effect",
                1,
                f"run.{name} = {value:g} has no effect with {run.integrator!r}{why}",
                f"leave it out, or dt{LEFT_OUT}" if why == WITH_STEP else "leave it out, or take another method",
            )


def _unused(run: RunSettings) -> dict[str, str]:
    """Settings that the method of a run does not use, and what does, in words."""
    facts: IntegratorFacts | None = integrators().get(run.integrator)
    if facts is None:  # the core names those that there are
        return {}
    found: dict[str, str] = {}
    if not facts.is_adaptive or run.dt is not None:
        why = WITH_STEP if facts.is_adaptive else ", whose steps are not chosen by their error"
        found |= dict.fromkeys(("tolerance", "tolerance_length", "tolerance_speed"), why)
    if math.isfinite(facts.imaginary_limit):
        found["spectral_radius"] = ", which is explicit"
    if run.integrator != SUBSTEPPED:
        found["substeps"] = f"; {SUBSTEPPED!r} alone takes substeps"
    return found
