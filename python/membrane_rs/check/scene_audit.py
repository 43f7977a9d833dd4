"""The audit of a scene: the one list of checks, and what they find."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import TypeAlias
from weakref import WeakKeyDictionary

from membrane_rs.check.bodies import fast_bodies, inside_bodies
from membrane_rs.check.contact import chord_sag, start_inside
from membrane_rs.check.film_law import film_law
from membrane_rs.check.material_values import material_values
from membrane_rs.check.mesh_faults import (
    crossings,
    crossings_of_large_meshes,
    fold_angles,
    growing_modes,
    growing_modes_of_large_meshes,
    mesh_faults,
)
from membrane_rs.check.net_of_springs import net_of_springs
from membrane_rs.check.redundancy import laws_without_effect
from membrane_rs.check.scene_values import law_and_part_values
from membrane_rs.check.spool import spool
from membrane_rs.check.step_accuracy import accuracy_of_step
from membrane_rs.check.stepping import Stepping, settings_without_effect, step_above_limit
from membrane_rs.check.stowed_energy import stowed_energy
from membrane_rs.check.supports import supports
from membrane_rs.errors import AuditWarning
from membrane_rs.mesh.findings import Audit, Finding
from membrane_rs.scene import Scene
from membrane_rs.simulation.motion import Motion

Check: TypeAlias = Callable[[Scene], Iterator[Finding]]
"""Yields what it finds in a scene, run settings included; nothing where all is well. It never raises."""
SteppingCheck: TypeAlias = Callable[[Stepping], Iterator[Finding]]
"""The same for the method and the step, which a simulation may have from its caller."""

CHECKS: list[Check] = [
    mesh_faults,
    fold_angles,
    growing_modes,
    crossings,
    film_law,
    supports,
    spool,
    chord_sag,
    start_inside,
    inside_bodies,
    fast_bodies,
    material_values,
    law_and_part_values,
    laws_without_effect,
]
"""Checks that cost little beside the first step of a run: made by `Simulation`, `run` and `check` alike."""

AT_START = (start_inside, inside_bodies)
"""Those of them that judge the shape at the start, which later stages do not start from."""

STEPPING_CHECKS: list[SteppingCheck] = [
    step_above_limit,
    settings_without_effect,
]
"""Checks of the method and the step, made wherever `CHECKS` are."""

COSTLY_CHECKS: list[Check] = [
    growing_modes_of_large_meshes,
    crossings_of_large_meshes,
    net_of_springs,
    stowed_energy,
    accuracy_of_step,
]
"""Checks that take longer: made by `check` alone."""


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
        Of a scene with stages those of each stage, which a message names unless they all have it; what starts inside a
        body, or a spool, of the first stage alone.
    """
    more = COSTLY_CHECKS if costly else [_left_out]
    if not scene.stages:
        return _audit(scene, Stepping.of_scene(scene), more)
    return _of_stages(scene, lambda staged, checks: _audit(staged, Stepping.of_scene(staged), more, checks))


def audit_of_motion(sim: Motion) -> Audit:
    """The same of the scene of a simulation, with the method and the step that it has; costly checks left out."""
    if not sim.scene.stages:
        return _audit(sim.scene, Stepping.of_motion(sim), [_left_out])

    def of_stage(staged: Scene, checks: Sequence[Check]) -> Audit:
        stepping = Stepping.of_motion(sim) if staged is sim.stage_scene else Stepping.of_scene(staged)
        return _audit(staged, stepping, [_left_out], checks)

    return _of_stages(sim.scene, of_stage)


def _of_stages(scene: Scene, audit_of: Callable[[Scene, Sequence[Check]], Audit]) -> Audit:
    """The findings of all stages, each of them once; those that not all stages have name their stages."""
    found: dict[Finding, list[str]] = {}
    for k, stage in enumerate(scene.stages):
        for finding in audit_of(scene.staged(k), _checks_of_stage(k)).findings:
            found.setdefault(finding, []).append(stage.name)
    count = len(scene.stages)
    return Audit.of(finding if len(names) == count else _in_stages(finding, names) for finding, names in found.items())


def _in_stages(finding: Finding, names: Sequence[str]) -> Finding:
    stages = "stage" if len(names) == 1 else "stages"
    return replace(finding, message=f"{stages} {', '.join(map(repr, names))}: {finding.message}")


def _checks_of_stage(index: int) -> Sequence[Check]:
    """Later stages start from a shape that is not known."""
    return CHECKS if index == 0 else [check for check in CHECKS if check not in AT_START]


def _audit(scene: Scene, stepping: Stepping, more: Sequence[Check], checks: Sequence[Check] | None = None) -> Audit:
    known = _FOUND.setdefault(scene, {})
    made = (*(CHECKS if checks is None else checks), *more)
    for check in made:
        if check not in known:
            known[check] = tuple(check(scene))
    of_scene = [finding for check in made for finding in known[check]]
    return Audit.of([*of_scene, *(finding for check in STEPPING_CHECKS for finding in check(stepping))])


def unaccepted_errors(scene: Scene) -> tuple[Finding, ...]:
    """Errors for which a run is not to begin: those that no setting of the scene accepts. Costly checks are left out.

    `Springs.negative` "clip" or "keep" accepts negative springs, and "keep" the modes that grow by them; a strain limit
    above the strain at the start accepts that.
    """
    if scene.stages:
        of_stages = [_unaccepted_errors(scene.staged(k), _checks_of_stage(k)) for k in range(len(scene.stages))]
        return tuple(dict.fromkeys(error for errors in of_stages for error in errors))
    return _unaccepted_errors(scene, CHECKS)


def _unaccepted_errors(scene: Scene, checks: Sequence[Check]) -> tuple[Finding, ...]:
    """Those of a scene without stages, by these checks."""
    accepted = set()
    if scene.negative_springs in ("clip", "keep"):
        accepted |= {"negative_springs", "growing_mode"}
    limits = [law.edge_strain_limit for law in scene.laws if law.is_film]
    if scene.mesh is not None and all(limit is None or scene.mesh.strain().max() < limit for limit in limits):
        accepted.add("strain")
    found = _audit(scene, Stepping.of_scene(scene), [_left_out], checks)
    return tuple(error for error in found.errors if error.kind not in accepted)


def warn_of(found: Audit, stacklevel: int = 2) -> None:
    """Warn of each error and each warning of an audit, by the category `AuditWarning`."""
    for finding in found.without_facts().findings:
        text = f"{finding.severity}: {finding.message}; {finding.remedy}"
        warnings.warn(text, AuditWarning, stacklevel=stacklevel + 1)


def _left_out(scene: Scene) -> Iterator[Finding]:
    names = [check.__name__.replace("_", " ") for check in COSTLY_CHECKS]
    yield Finding(
        "info",
        "left_out",
        len(names),
        f"checks that may take seconds were left out: {', '.join(names)}",
        "`membrane-rs check` makes them, and membrane_rs.check.audit",
    )
