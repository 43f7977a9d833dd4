"""How far a film may be softened: a rule from the strains that it bears, and what `check` says of it.

A film that is softened f-fold in stretch (`Material.softening`) has f times its strain, and buckles at f times its
critical strain. It moves as the film does for as long as both stay small:

    f = min(A / eps, B / eps_c), rounded to two digits, at least 1

    eps   = Omega^2 sum m r^2 / (E h S)                 mean strain of the flat sail under its spin
    eps_c = mean of alpha_c pi^2 h^2 / (12 L^2)         critical strain of its creases, eq. (2)

with Omega the largest rate of the hub, m and r the masses of the film with its tips and their distances from the axis
in the flat shape, S the area. By the virial theorem the mean over the film of the trace of the stress times h S is the
sum of F.r over the loads, here those of the rotation; over E h S it is a strain. Where there are no creases, eps_c is
that of all edges.

A and B are the strains that a softened film may have. docs/softening.md argues them by the error in the paper's models.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from membrane_rs._validation import check_kind
from membrane_rs.check.redundancy import limit_of_step
from membrane_rs.check.stepping import Stepping, is_explicit
from membrane_rs.mesh.findings import Finding
from membrane_rs.scene import Scene
from membrane_rs.scene.scales import node_masses

MOST_STRAIN = 1.7e-4
"""A, the mean strain of a softened sail under its spin [-]."""
MOST_CRITICAL_STRAIN = 4.5e-3
"""B, the critical strain of the creases of a softened film [-]."""
LEAST_FACTOR = 1.5
"""Softening from which it is worth a word."""
LEAST_GAIN = 1.2
"""Gain of step from which in-plane stiffness counts as what sets it."""


@dataclass(frozen=True)
class SofteningAdvice:
    """How far the film of a scene may be softened.

    Attributes
    ----------
    factor : float
        The largest softening [-], 1 or above; 1 where there is no advice.
    spin_strain : float
        Mean strain of the flat sail under its spin [-]; NaN without advice.
    critical_strain : float
        Mean critical strain of its creases [-]; NaN without advice.
    reason : str
        Why there is no advice; empty where there is.

    Examples
    --------
    >>> from membrane_rs import scenes
    >>> from membrane_rs.check import softening_advice
    >>> softening_advice(scenes.load("spinning-tether")).reason
    'the scene has no film'
    """

    factor: float
    spin_strain: float = math.nan
    critical_strain: float = math.nan
    reason: str = ""


def softening_advice(scene: Scene) -> SofteningAdvice:
    """How far the film of a scene may be softened in stretch with little effect on its deployment.

    Parameters
    ----------
    scene : Scene
        The scene; its own softening does not count. Of a scene with stages, the least of them all.

    Returns
    -------
    SofteningAdvice
        The factor and the strains that it follows from.

    Raises
    ------
    InputTypeError
        No scene.

    Examples
    --------
    >>> from membrane_rs import scenes
    >>> from membrane_rs.check import softening_advice
    >>> softening_advice(scenes.load("okuizumi-model-1")).factor
    10.0
    """
    check_kind(scene, Scene, "scene", "a Scene")
    if scene.stages:
        return min((softening_advice(scene.staged(k)) for k in range(len(scene.stages))), key=lambda one: one.factor)
    if scene.mesh is None or scene.material is None:
        return SofteningAdvice(1.0, reason="the scene has no film")
    film = replace(scene.material, softening=None)
    bare = replace(scene, material=film)
    buckling = [law.critical_strains(scene.mesh, film) for law in scene.laws if law.is_film]
    if not buckling:
        return SofteningAdvice(1.0, reason="the scene has no law of the film")
    omega = 2.0 * math.pi * max((law.fastest_turning(scene.run.until) for law in scene.laws), default=0.0)
    if omega == 0.0:
        return SofteningAdvice(1.0, reason="the scene does not turn, and the rule is that of a sail under spin")
    radii = (scene.mesh.reference[:, :2] ** 2).sum(axis=1)
    moment = float(node_masses(bare)[: scene.mesh.node_count] @ radii)
    stiffness = film.youngs_modulus * film.thickness * float(scene.mesh.areas().sum())
    strain, critical = omega**2 * moment / stiffness, float(np.mean(buckling[0]))
    most = min(MOST_STRAIN / strain, MOST_CRITICAL_STRAIN / critical if critical > 0.0 else math.inf)
    return SofteningAdvice(max(1.0, float(f"{most:.2g}")), strain, critical)


def softening_of_film(scene: Scene) -> Iterator[Finding]:
    """A softened film is named, and a softening above the rule's is warned of."""
    if scene.material is None or scene.material.softening is None or scene.mesh is None:
        return
    factor, advice = scene.material.softening, softening_advice(scene)
    yield Finding(
        "info",
        "softening",
        1,
        f"the film is simulated {factor:g} times as soft in stretch: strains are those of the softened film",
        "",
    )
    if advice.reason:
        message = f"material.softening = {factor:g} is without advice: {advice.reason}"
        yield Finding("warning", "softening", 1, message, "compare it with a run without softening")
    elif factor > advice.factor:
        bounds = {"mean strain under the spin": (advice.spin_strain, MOST_STRAIN)}
        bounds["critical strain of the creases"] = (advice.critical_strain, MOST_CRITICAL_STRAIN)
        what = " and ".join(
            f"the {name} is {factor * strain:.2g}, above {most:g}"
            for name, (strain, most) in bounds.items()
            if factor * strain > most
        )
        yield Finding(
            "warning",
            "softening",
            1,
            f"material.softening = {factor:g} is above {advice.factor:g}, up to which a film moves as one that is not "
            f"softened: {what}",
            f"take {advice.factor:g}, or compare it with a run without softening",
        )


def step_of_softened_film(scene: Scene) -> Iterator[Finding]:
    """How much longer the step of an explicit method would be, where in-plane stiffness and cords set it."""
    if scene.material is None or scene.material.softening is not None or not is_explicit(scene.run.integrator):
        return
    factor = softening_advice(scene).factor
    if factor < LEAST_FACTOR:
        return
    soft = replace(scene, material=replace(scene.material, softening=factor))
    gain = limit_of_step(soft) / limit_of_step(scene)
    if gain > LEAST_GAIN:  # not where a limit is unknown
        yield Finding(
            "info",
            "softening",
            1,
            f"the step would be {gain:.2g} times as long with a film {factor:g} times as soft in stretch; "
            "docs/softening.md charts what that changes in the paper's models",
            f"for many runs, --set material.softening={factor:g}",
        )


def softening_without_effect(stepping: Stepping) -> Iterator[Finding]:
    """Softening with an implicit method, whose step no stiffness limits; nothing where it is a caller's method."""
    run, own = stepping.run, stepping.own
    if stepping.softening is not None and not is_explicit(run.integrator) and not is_explicit(own.integrator):
        yield Finding(
            "warning",
            "setting_without_effect",
            1,
            f"material.softening = {stepping.softening:g} makes no step longer with {run.integrator!r}, which is "
            "implicit",
            "leave it out, or take an explicit method",
        )
