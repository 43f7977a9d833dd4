"""How far a film may be softened: a rule from the strains that it bears, and what `check` says of it.

A film that is softened f-fold in stretch (`Material.softening`) has f times its strain, and buckles at f times its
critical strain. The paper's sails deploy nearly as unsoftened ones do for as long as both stay small:

    f = min(A / eps, B / eps_c, 1 + C M / M_c, F), to two digits, at least 1

    eps   = Omega^2 sum m r^2 / (E h S)                 mean strain of the flat sail under its spin
    eps_c = mean of alpha_c pi^2 h^2 / (12 L^2)         critical strain of its creases, eq. (2)

with Omega the largest rate of the hub, m and r the masses of the film with its tips and their distances from the axis
in the flat shape, S the area. By the virial theorem the mean over the film of the trace of the stress times h S is the
sum of F.r over the loads, here those of the rotation; over E h S it is a strain. Where there are no creases, eps_c is
that of all edges. Cords are simulated f times as heavy: M is the mass of the film, M_c that of its cords;
their bound is rounded down, the others to the nearest.

A and B are the strains that a softened film may have, C the share of the film's mass that its cords may gain, F the
largest softening whose error was within chance in both of them. docs/softening.md argues A, B and F by the error in
the paper's models.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from membrane_rs._validation import check_kind
from membrane_rs.check.redundancy import limit_of_step
from membrane_rs.check.stepping import Stepping, is_explicit
from membrane_rs.errors import MembraneError, MeshError
from membrane_rs.material import Material
from membrane_rs.mesh import Mesh
from membrane_rs.mesh.findings import Finding
from membrane_rs.scene import Scene
from membrane_rs.scene.scales import film_mass, node_masses
from membrane_rs.scene.softened import softening_of, with_softening

MOST_STRAIN = 8.5e-5
"""A, the mean strain of a softened sail under its spin [-]."""
MOST_CRITICAL_STRAIN = 2.25e-3
"""B, the critical strain of the creases of a softened film [-]."""
MOST_ADDED_MASS = 0.1
"""C, the mass that cords gain by softening, over that of the film [-]."""
MOST_FACTOR = 5.0
"""F, the largest softening whose error was within chance in both sails of the paper, docs/softening.md [-]."""
CHARTED_RATE, CHARTED_PHASE = 0.0025, 1.62
"""Of the fast scenes of the paper's sails, softened by `MOST_FACTOR`: the larger root mean square of the difference of
their mean curves from those of the full models, of the deployment rate [-] and of the phase [deg], as in README.md."""
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
        The largest softening [-], from 1 to 5; 1 where there is no advice.
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

    By the strain of its spin, the critical strain of its creases and the mass of its cords, and no further than 5, the
    largest softening at which the paper's sails deploy nearly as unsoftened ones do.

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
    5.0
    """
    check_kind(scene, Scene, "scene", "a Scene")
    if scene.stages:
        return min((softening_advice(scene.staged(k)) for k in range(len(scene.stages))), key=lambda one: one.factor)
    if scene.mesh is None or scene.material is None:
        return SofteningAdvice(1.0, reason="the scene has no film")
    bare = with_softening(scene, None)
    with np.errstate(all="ignore"):  # an edge without length, or values that no strain follows from
        found = _strains(bare, scene.mesh, scene.material)
    if isinstance(found, str):
        return SofteningAdvice(1.0, reason=found)
    strain, critical = found
    most = min(MOST_STRAIN / strain, MOST_CRITICAL_STRAIN / critical if critical > 0.0 else math.inf, MOST_FACTOR)
    return SofteningAdvice(max(1.0, min(float(f"{most:.2g}"), _most_by_cords(bare))), strain, critical)


def _strains(bare: Scene, mesh: Mesh, film: Material) -> tuple[float, float] | str:
    """The strain under the spin and the critical strain of a scene without softening, or why there are none."""
    buckling = [law.critical_strains(mesh, film) for law in bare.laws if law.is_film]
    if not buckling:
        return "the scene has no law of the film"
    omega = 2.0 * math.pi * max((law.fastest_turning(bare.run.until) for law in bare.laws), default=0.0)
    if omega == 0.0:
        return "the scene does not turn, and the rule is that of a sail under spin"
    try:
        mesh.masses(film)
    except MeshError as error:
        return f"the film has no masses: {error}"
    moment = float(node_masses(bare)[: mesh.node_count] @ (mesh.reference[:, :2] ** 2).sum(axis=1))
    stiffness = film.youngs_modulus * film.thickness * float(mesh.areas().sum())
    strain = omega * omega * moment / stiffness if stiffness > 0.0 else math.inf
    if not 0.0 < strain < math.inf:
        return "the strain of its spin is no number above 0"
    return strain, float(np.mean(buckling[0])) if len(buckling[0]) else 0.0


def softening_of_film(scene: Scene) -> Iterator[Finding]:
    """A softened film is named; a softening above the rule's is warned of, and what it adds to the mass of cords."""
    factor = softening_of(scene)
    if factor is None or scene.mesh is None:
        return
    advice = softening_advice(scene)
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
    elif factor > advice.factor and (what := _beyond(factor, advice)):
        is_any = advice.factor > 1.0
        yield Finding(
            "warning",
            "softening",
            1,
            f"material.softening = {factor:g} is above {advice.factor:g}, up to which the paper's sails deploy nearly "
            f"as unsoftened ones do: {what}"
            if is_any
            else f"material.softening = {factor:g}: the rule allows none, {what}",
            f"{f'take {advice.factor:g}' if is_any else 'leave it out'}, or compare it with a run without softening",
        )
    yield from _heavier_cords(scene, factor)


def _beyond(factor: float, advice: SofteningAdvice) -> str:
    """The bounds that a softening exceeds by what three digits show, in words."""
    strains = (
        ("mean strain under the spin", advice.spin_strain, MOST_STRAIN),
        ("critical strain of the creases", advice.critical_strain, MOST_CRITICAL_STRAIN),
    )
    found = [
        f"the {name} is {factor * strain:.3g}, above {most:g}"
        for name, strain, most in strains
        if float(f"{factor * strain:.3g}") > most
    ]
    if float(f"{factor:.3g}") > MOST_FACTOR:
        found.append(f"{MOST_FACTOR:g} is the largest softening that was found so")
    return "; ".join(found)


def _heavier_cords(scene: Scene, factor: float) -> Iterator[Finding]:
    """Cords whose mass in the simulation is no small one beside that of the film."""
    cords, film = _mass_of_cords(with_softening(scene, None)), film_mass(scene)
    added = (factor - 1.0) * cords
    if added > MOST_ADDED_MASS * film:
        most = _most_by_cords(with_softening(scene, None))
        yield Finding(
            "warning",
            "softening",
            1,
            f"material.softening = {factor:g} makes the cords heavier by {added:.3g} kg, and the film has a mass of "
            f"{film:.3g} kg",
            f"take {most:g} or less, which adds at most {100.0 * MOST_ADDED_MASS:g} % of that"
            if most > 1.0
            else "leave it out",
        )


def _most_by_cords(bare: Scene) -> float:
    """The softening by which the cords of a scene without one gain no more than they may, two digits of it [-]."""
    cords = _mass_of_cords(bare)
    most = 1.0 + MOST_ADDED_MASS * film_mass(bare) / cords if cords > 0.0 else math.inf
    if not most < math.inf:
        return math.inf
    unit = 10.0 ** (math.floor(math.log10(most)) - 1)
    return float(f"{math.floor(most / unit) * unit:.2g}")


def _mass_of_cords(bare: Scene) -> float:
    """Of a scene without softening [kg]: what twice the softening adds."""
    try:
        heavier = with_softening(bare, 2.0).assemble().extra_masses
    except MembraneError:  # twice their mass is no number
        return math.inf
    return float((heavier - bare.assemble().extra_masses).sum())


def step_of_softened_film(scene: Scene) -> Iterator[Finding]:
    """How much longer the step of an explicit method would be, where in-plane stiffness and cords set it."""
    if scene.material is None or softening_of(scene) is not None or not is_explicit(scene.run.integrator):
        return
    factor = softening_advice(scene).factor
    if factor < LEAST_FACTOR:
        return
    gain = limit_of_step(with_softening(scene, factor)) / limit_of_step(scene)
    if gain > LEAST_GAIN:  # not where a limit is unknown
        yield Finding(
            "info",
            "softening",
            1,
            f"the step would be {gain:.2g} times as long with a film {factor:g} times as soft in stretch: "
            f"{100.0 * (1.0 - 1.0 / gain):.0f} % fewer steps. Mean curves of the paper's models with a film "
            f"{MOST_FACTOR:g} times as soft differ from the full models' by {CHARTED_RATE:g} in the deployment rate "
            f"and {CHARTED_PHASE:g} degrees in phase, root mean square, which is within chance (README.md, Accuracy)",
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
