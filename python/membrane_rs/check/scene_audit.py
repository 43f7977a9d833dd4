"""The audit of a scene: the one list of checks, and what they find."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import TypeAlias
from weakref import WeakKeyDictionary

from membrane_rs._validation import check_kind, flag_of
from membrane_rs._warning import warn
from membrane_rs.check.bending import form_of_bending, wrinkles_twice
from membrane_rs.check.bodies import fast_bodies, inside_bodies
from membrane_rs.check.contact import chord_sag, start_inside
from membrane_rs.check.film_law import film_law, two_moduli
from membrane_rs.check.material_values import material_values
from membrane_rs.check.mesh_faults import (
    crossings,
    crossings_of_large_meshes,
    fold_angles,
    growing_modes,
    growing_modes_of_large_meshes,
    mesh_faults,
    start_strain,
)
from membrane_rs.check.net_of_springs import net_of_springs
from membrane_rs.check.rectangles import rectangles_of_film
from membrane_rs.check.redundancy import laws_without_effect, values_without_effect
from membrane_rs.check.scene_values import law_and_part_values
from membrane_rs.check.self_contact import crossing_layers, laws_beside_free_hub, touching_layers
from membrane_rs.check.softening import softening_of_film, softening_without_effect, step_of_softened_film
from membrane_rs.check.spool import sail_round_spool, spool
from membrane_rs.check.stages import stages_together
from membrane_rs.check.step_accuracy import accuracy_of_step
from membrane_rs.check.stepping import Stepping, laws_of_other_methods, settings_without_effect, step_above_limit
from membrane_rs.check.stowed_energy import stowed_energy
from membrane_rs.check.supports import supports
from membrane_rs.errors import AuditWarning
from membrane_rs.mesh.findings import Audit, Finding
from membrane_rs.scene import Scene
from membrane_rs.simulation.motion import Motion, check_simulation

Check: TypeAlias = Callable[[Scene], Iterator[Finding]]
"""Yields what it finds in a scene, run settings included; nothing where all is well. It never raises."""
SteppingCheck: TypeAlias = Callable[[Stepping], Iterator[Finding]]
"""The same for the method and the step, which a simulation may have from its caller."""

CHECKS: list[Check] = [
    mesh_faults,
    start_strain,
    fold_angles,
    growing_modes,
    crossings,
    crossing_layers,
    touching_layers,
    laws_beside_free_hub,
    film_law,
    two_moduli,
    rectangles_of_film,
    form_of_bending,
    wrinkles_twice,
    supports,
    spool,
    sail_round_spool,
    chord_sag,
    start_inside,
    inside_bodies,
    fast_bodies,
    material_values,
    law_and_part_values,
    laws_without_effect,
    values_without_effect,
    softening_of_film,
]
"""Checks that cost little beside the first step of a run: made by `Simulation`, `run` and `check` alike."""

STEPPING_CHECKS: list[SteppingCheck] = [
    laws_of_other_methods,
    step_above_limit,
    settings_without_effect,
    softening_without_effect,
]
"""Checks of the method and the step, made wherever `CHECKS` are."""

COSTLY_CHECKS: list[Check] = [
    growing_modes_of_large_meshes,
    crossings_of_large_meshes,
    net_of_springs,
    stowed_energy,
    accuracy_of_step,
    step_of_softened_film,
]
"""Checks that take longer: made by `check` alone."""

OF_START: frozenset[Check] = frozenset(
    {
        start_strain,
        fold_angles,
        crossings,
        crossings_of_large_meshes,
        crossing_layers,
        touching_layers,
        sail_round_spool,
        start_inside,
        inside_bodies,
        stowed_energy,
        accuracy_of_step,
    }
)
"""Checks of the shape at the start. Of a scene with stages they judge the first stage alone: where a later one begins
is known only when it begins.
"""

_FOUND: WeakKeyDictionary[Scene, dict[Check, tuple[Finding, ...]]] = WeakKeyDictionary()
"""What was found in scenes that are still there, which never change."""


def audit(scene: Scene, *, costly: bool = True) -> Audit:
    """Faults, risks and facts of a scene before it runs, errors first.

    Parameters
    ----------
    scene : Scene
        The scene, with the run settings by which it is to run.
    costly : bool
        Whether checks that may take seconds are made as well, as `membrane-rs check` does.

    Returns
    -------
    Audit
        The findings of all `CHECKS` and `STEPPING_CHECKS`, and of `COSTLY_CHECKS` or a note that those were left out.
        Of a scene with stages those of each stage, which a message names unless they all have it; those `OF_START` of
        the first stage alone.

    Raises
    ------
    InputTypeError
        No scene.

    Examples
    --------
    >>> from membrane_rs import scenes
    >>> from membrane_rs.check import audit
    >>> audit(scenes.load("spinning-tether"), costly=False).ok
    True
    """
    check_kind(scene, Scene, "scene", "a Scene")
    is_costly = flag_of("costly", costly)
    return _audit(scene, Stepping.of_scene, COSTLY_CHECKS if is_costly else [_left_out])


def audit_of_motion(sim: Motion) -> Audit:
    """The same of the scene of a simulation, with the method and the step that it has; costly checks left out.

    Parameters
    ----------
    sim : Motion
        The simulation.

    Returns
    -------
    Audit
        The findings.

    Raises
    ------
    InputTypeError
        No motion.

    Examples
    --------
    >>> from membrane_rs import Simulation, scenes
    >>> from membrane_rs.check import audit_of_motion
    >>> audit_of_motion(Simulation(scenes.load("spinning-tether"))).ok
    True
    """
    check_simulation(sim)

    def stepping_of(scene: Scene) -> Stepping:
        is_present = scene is (sim.stage_scene if sim.scene.stages else sim.scene)
        return Stepping.of_motion(sim) if is_present else Stepping.of_scene(scene)

    return _audit(sim.scene, stepping_of, [_left_out])


def _audit(scene: Scene, stepping_of: Callable[[Scene], Stepping], more: Sequence[Check]) -> Audit:
    """The findings of all stages, each of them once; those that not all stages have name their stages."""
    checks = [*CHECKS, *more]
    if not scene.stages:
        return Audit.of(_findings(scene, stepping_of(scene), checks))
    first, found = scene.staged(0), dict[Finding, list[str]]()
    for k, stage in enumerate(scene.stages):
        staged = scene.staged(k)
        for finding in _findings(staged, stepping_of(staged), _of_stage(checks, k)):
            found.setdefault(finding, []).append(stage.name)
    at_start = {finding for check in checks if check in OF_START for finding in _found(first, check)}
    count = len(scene.stages)
    of_stages = (
        finding if len(names) == count or finding in at_start else _in_stages(finding, names)
        for finding, names in found.items()
    )
    return Audit.of([*stages_together(scene), *of_stages])


def _of_stage(checks: Sequence[Check], index: int) -> Sequence[Check]:
    """Those that judge a stage."""
    return checks if index == 0 else [check for check in checks if check not in OF_START]


def _in_stages(finding: Finding, names: Sequence[str]) -> Finding:
    stages = "stage" if len(names) == 1 else "stages"
    return replace(finding, message=f"{stages} {', '.join(map(repr, names))}: {finding.message}")


def _findings(scene: Scene, stepping: Stepping, checks: Sequence[Check]) -> list[Finding]:
    """Those of a scene without stages."""
    of_scene = [finding for check in checks for finding in _found(scene, check)]
    return [*of_scene, *(finding for check in STEPPING_CHECKS for finding in check(stepping))]


def _found(scene: Scene, check: Check) -> tuple[Finding, ...]:
    """What a check finds in a scene, looked for once."""
    known = _FOUND.setdefault(scene, {})
    if check not in known:
        known[check] = tuple(check(scene))
    return known[check]


def unaccepted_errors(scene: Scene) -> tuple[Finding, ...]:
    """Errors for which a run is not to begin: those that no setting of the scene accepts. Costly checks are left out.

    `Springs.negative` "clip" or "keep" accepts negative springs, and "keep" the modes that grow by them; a strain limit
    above the strain at the start accepts that.

    Parameters
    ----------
    scene : Scene
        The scene.

    Returns
    -------
    tuple of Finding
        Each once.

    Raises
    ------
    InputTypeError
        No scene.

    Examples
    --------
    >>> from membrane_rs import scenes
    >>> from membrane_rs.check import unaccepted_errors
    >>> unaccepted_errors(scenes.load("spinning-tether"))
    ()
    """
    check_kind(scene, Scene, "scene", "a Scene")
    stages = [scene.staged(k) for k in range(len(scene.stages))] or [scene]
    found = [error for k, staged in enumerate(stages) for error in _unaccepted(staged, _of_stage(CHECKS, k))]
    return tuple(dict.fromkeys(found))


def _unaccepted(scene: Scene, checks: Sequence[Check]) -> list[Finding]:
    """Those of a scene without stages."""
    accepted = set()
    if scene.negative_springs in ("clip", "keep"):
        accepted |= {"negative_springs", "growing_mode"}
    limits = [law.edge_strain_limit for law in scene.laws if law.is_film]
    if scene.mesh is not None and all(limit is None or scene.mesh.strain().max() < limit for limit in limits):
        accepted.add("strain")
    found = _findings(scene, Stepping.of_scene(scene), checks)
    return [one for one in found if one.severity == "error" and one.kind not in accepted]


def warn_of(found: Audit) -> None:
    """Warn of each error and each warning of an audit, by the category `AuditWarning`."""
    for finding in found.without_facts().findings:
        warn(f"{finding.severity}: {finding.message}; {finding.remedy}", AuditWarning)


def _left_out(scene: Scene) -> Iterator[Finding]:
    names = [check.__name__.replace("_", " ") for check in COSTLY_CHECKS]
    yield Finding(
        "info",
        "left_out",
        len(names),
        f"checks that may take seconds were left out: {', '.join(names)}",
        "`membrane-rs check` makes them, and membrane_rs.check.audit",
    )
