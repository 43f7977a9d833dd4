"""The scenes that docs/softening.md compares: films softened, meshes coarser, dashpots of other kinds."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

from membrane_rs import Scene, SpringDamping, scenes
from membrane_rs.scene.softened import with_softening
from membrane_rs.study import agreeing
from membrane_rs.study.common.density import denser
from membrane_rs.study.common.perturbation import MODEL_SHIFT, SHIFT

MODELS = {"model 1": "okuizumi-model-1", "model 2": "okuizumi-model-2"}
FAST_SCENES = {model: f"{name}-fast" for model, name in MODELS.items()}
SOFTENINGS = (3, 5, 10, 30, 100)
ON_COARSE = (3, 10, 30)
SUBSTEPS, SHARE = 3, 0.8
"""Substeps of leapfrog in a step, and the step over its limit."""
FAST, SOFT = 2.0, 0.1
"""Factors of the two scenes that tell the bounds of the rule apart: of the rate of spin, and of alpha on creases."""

FULL, AGAIN, NARROW = "full model", "full model, other starts", f"full model, {SHIFT:g} m"
COARSE, REDUCED = "every other line of the mesh", "reduced mass in the dashpots"
RATIO = "softened 10, ratio of the dashpots kept"
ALIKE = "petals alike"


@dataclass(frozen=True)
class Case:
    """An ensemble of starts of one scene.

    Attributes
    ----------
    label : str
        What tables call it.
    make : callable
        The scene.
    shift : float
        Standard deviation of the displacement of each coordinate at the start [m].
    first_seed : int
        Of its starts: those of the reference are no starts of others.
    alike : bool
        Whether all petals are given their mean motion, again and again.
    """

    label: str
    make: Callable[[], Scene]
    shift: float = MODEL_SHIFT
    first_seed: int = 1000
    alike: bool = False


def fast(scene: Scene) -> Scene:
    """The scene by leapfrog with substeps, without pictures."""
    run = replace(scene.run, integrator="leapfrog", substeps=SUBSTEPS, snapshots=())
    return replace(scene, run=run)


def coarse(scene: Scene) -> Scene:
    """The scene on half as many rows and columns, with cords of half as many segments.

    Lengths of its laws are those of the fine mesh, so that it is the same film.
    """
    found = agreeing(scene).of(denser(scene, 0.5))
    parts = [part if (fewer := part.coarser(2)) is None else fewer[1] for part in found.parts]
    return replace(found, parts=parts)


def reduced(scene: Scene) -> Scene:
    """The scene with the reduced mass in its dashpots, at their ratio."""
    return _with_damping(scene, mass="reduced")


def ratio_kept(scene: Scene, factor: float) -> Scene:
    """The softened scene with the reduced mass in its dashpots and their ratio in place of their c."""
    damping = scene.law(SpringDamping)
    assert damping is not None
    return _with_damping(with_softening(scene, factor).as_simulated, ratio=damping.ratio)


def spun(scene: Scene) -> Scene:
    """The scene at `FAST` times the rate of spin, for as many turns: the film bears the square of that in strain."""
    faster = scene.with_values({"laws.spin.frequency": FAST * scene.value("laws.spin.frequency")})
    return replace(faster, run=replace(faster.run, until=scene.run.until / FAST))


def weak_creases(scene: Scene) -> Scene:
    """The scene with `SOFT` times the alpha on creases."""
    key = "laws.springs.buckling_on_creases"
    return scene.with_values({key: SOFT * scene.value(key)})


def charted(model: str) -> dict[str, Case]:
    """The full model twice, and its softened films."""
    return _softened_cases(lambda: fast(scenes.load(MODELS[model])), SOFTENINGS)


def fast_scene(model: str) -> dict[str, Case]:
    """The full model twice, and its fast scene by its own step."""
    scene = scenes.load(FAST_SCENES[model])
    scene = replace(scene, run=replace(scene.run, snapshots=()))
    factor = scene.value("material.softening")
    own = Case(f"{soft(factor)}, {scene.run.substeps} substeps", lambda: scene)
    full = charted(model)
    return {FULL: full[FULL], AGAIN: full[AGAIN], own.label: own}


def others(model: str) -> dict[str, Case]:
    """Coarser meshes, and dashpots of other kinds."""

    def plain() -> Scene:
        return fast(scenes.load(MODELS[model]))

    found = [Case(COARSE, lambda: coarse(plain()))]
    found += [
        Case(f"{COARSE}, softened {factor}", lambda factor=factor: with_softening(coarse(plain()), factor))  # type: ignore[misc]
        for factor in ON_COARSE
    ]
    found += [Case(REDUCED, lambda: reduced(plain())), Case(RATIO, lambda: ratio_kept(plain(), 10))]
    return {case.label: case for case in found}


def displaced(model: str) -> dict[str, Case]:
    """The full model from starts that are displaced as in other studies."""
    return {NARROW: Case(NARROW, lambda: fast(scenes.load(MODELS[model])), SHIFT)}


def symmetric(model: str) -> dict[str, Case]:
    """The full model twice, and with petals that all do the same."""
    full = charted(model)
    return {FULL: full[FULL], AGAIN: full[AGAIN], ALIKE: replace(full[AGAIN], label=ALIKE, alike=True)}


RULE: Mapping[str, tuple[Callable[[Scene], Scene], tuple[int, ...]]] = {
    f"model 1 at {FAST:g} times the spin": (spun, (3, 10, 30)),
    f"model 1 with {SOFT:g} times alpha on creases": (weak_creases, (10, 30, 100)),
}
"""Scenes in which one of both strains is another, and their softenings."""


def of_rule(name: str) -> dict[str, Case]:
    """The full scene twice, and its softened films."""
    change, factors = RULE[name]
    return _softened_cases(lambda: fast(change(scenes.load(MODELS["model 1"]))), factors)


def _softened_cases(plain: Callable[[], Scene], factors: tuple[int, ...]) -> dict[str, Case]:
    found = [Case(FULL, plain, first_seed=0), Case(AGAIN, plain)]
    found += [Case(soft(factor), lambda factor=factor: with_softening(plain(), factor)) for factor in factors]  # type: ignore[misc]
    return {case.label: case for case in found}


def soft(factor: float) -> str:
    """What tables call a softened film."""
    return f"softened {factor:g}"


def _with_damping(scene: Scene, **changes: object) -> Scene:
    damping = scene.law(SpringDamping)
    assert damping is not None
    other = replace(damping, **changes)  # type: ignore[arg-type]
    return replace(scene, laws=[other if law.kind == damping.kind else law for law in scene.laws])
