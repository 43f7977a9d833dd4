"""The value of a parameter with which a scene's curves are nearest to those of another scene, the target.

The misfit is the distance of the mean curves over the spread of the target's own starts: at a misfit of one the two
scenes differ no more than two runs of the target do.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from membrane_rs._markdown import table
from membrane_rs._validation import count_of, is_list, number_of, show
from membrane_rs.errors import InputError, InputTypeError
from membrane_rs.scene import Scene
from membrane_rs.study.common.executor import Tell, teller
from membrane_rs.study.common.run import MOST_MEMBERS
from membrane_rs.study.convergence import CURVES, POINTS, Density, densities
from membrane_rs.study.length_scales import PAPER
from membrane_rs.study.mesh import jobs_of, mesh_study, sail_of

MOST_TRIES = 1000
"""Values that the method tries, at most."""


@dataclass(frozen=True)
class Tried:
    """One value that was tried, and the distance of its curves from the target's.

    Attributes
    ----------
    value : float
        In the unit of the parameter.
    density : Density
        Its runs.
    distance : dict of str to float
        Root mean square distance of the mean curves, by column, in its unit.
    misfit : float
        Root mean square over the columns of the distance over the spread of the target's starts [-].

    Examples
    --------
    >>> from membrane_rs.study import Density, Tried
    >>> tried = Tried(10.0, Density("paper", 16, 0.011, ()), {"deployment_rate": 0.01}, 2.5)
    >>> tried.value, tried.misfit
    (10.0, 2.5)
    """

    value: float
    density: Density
    distance: dict[str, float]
    misfit: float


@dataclass(frozen=True)
class SceneMatch:
    """All values tried, and the best of them.

    Attributes
    ----------
    parameter : str
        Key of the parameter.
    target : Density
        Runs of the scene whose curves are the target.
    spread : dict of str to float
        Standard deviation between the target's starts, by column, in its unit.
    tried : tuple of Tried
        In their order; each has its `value`, its `density` (the runs), its `distance` by column, and its `misfit`.

    Examples
    --------
    >>> from membrane_rs.study.convergence import Density
    >>> from membrane_rs.study.scene_match import SceneMatch, Tried
    >>> runs, none = Density("paper", 16, 0.011, ()), {"deployment_rate": 0.01, "phase_difference_deg": 2.0}
    >>> tried = (Tried(10.0, runs, none, 2.5), Tried(20.0, runs, none, 1.1))
    >>> found = SceneMatch("laws.creases.stiffness", runs, none, tried)
    >>> found.best.value, found.table().splitlines()[3]
    (20.0, '| 20 | 0.0100 | 2.0 | 1.1 |')
    """

    parameter: str
    target: Density
    spread: dict[str, float]
    tried: tuple[Tried, ...]

    @property
    def best(self) -> Tried:
        """The value with the least misfit."""
        return min(self.tried, key=lambda tried: tried.misfit)

    def table(self) -> str:
        """The values tried, sorted by value.

        Returns
        -------
        str
            A table in Markdown.
        """
        head = (self.parameter, "distance of the rates", "of the phases [deg]", "misfit")
        by_value = sorted(self.tried, key=lambda tried: tried.value)
        rows = [(f"{tried.value:.3g}", *_sizes(tried.distance), f"{tried.misfit:.1f}") for tried in by_value]
        return table(head, [*rows, ("*spread of the target's starts*", *_sizes(self.spread), "1")], words=())


def match_scene(
    scene: Scene,
    parameter: str,
    between: tuple[float, float],
    target: Scene,
    folder: str | Path,
    *,
    first: Sequence[float] = (),
    tries: int = 8,
    starts: int = 2,
    until: float | None = None,
    workers: int | None = None,
    tell: Tell | None = None,
) -> SceneMatch:
    """Find the value with which a scene's curves are nearest to those of another scene; of measured ones: `calibrate`.

    The misfit is minimised by Brent's bounded method on the logarithm of the parameter.

    Parameters
    ----------
    scene : Scene
        The scene whose parameter is found; a square sail.
    parameter : str
        Name of the parameter, such as laws.triangles.buckling_on_creases; see `Scene.with_values`.
    between : (float, float)
        Bounds, in the unit of the parameter, above 0.
    target : Scene
        The scene whose curves are the target.
    folder : path
        Folder of the runs, see `mesh_study`.
    first : sequence of float
        Values tried in addition to those of the method, in its unit.
    tries : int
        Maximum number of values that the method tries.
    starts : int
        Runs for each value, and half of those of the target; 2 or above.
    until : float, optional
        Time up to which curves are compared [s]. Default: the target's.
    workers, tell
        As in `mesh_study`.

    Returns
    -------
    SceneMatch
        The values tried, and the best of them.

    Raises
    ------
    InputError, InputTypeError
        Invalid bounds, too few starts or tries, or input that `mesh_study` and `Scene.with_values` refuse.

    Examples
    --------
    It makes `starts` runs for each value that it tries, which takes minutes for a sail:

    >>> from membrane_rs import scenes
    >>> from membrane_rs.study import match_scene
    >>> springs, triangles = scenes.load("okuizumi-model-1"), scenes.load("okuizumi-model-1-triangles")
    >>> key = "laws.triangles.buckling_on_creases"
    >>> found = match_scene(triangles, key, (1.0, 1000.0), springs, "match")  # doctest: +SKIP

    >>> match_scene(triangles, key, (1000.0, 1.0), springs, "match")
    Traceback (most recent call last):
    membrane_rs.errors.InputError: between = (1000.0, 1.0): must be two numbers above 0, the lower one first
    """
    from scipy.optimize import minimize_scalar  # slow to import

    sail_of(scene)
    sail_of(target)
    low, high = _bounds(between)
    tries = count_of("tries", tries, 1, MOST_TRIES, "values that are tried")
    starts = count_of("starts", starts, 2, MOST_MEMBERS // 2, "runs for each value")
    end = target.run.until if until is None else number_of("until", until)
    report = teller(tell, "tell")
    if not is_list(first):
        raise InputTypeError(f"first = {show(first)}: must be a list of values, tried beside those of the method")
    wanted = [number_of("first", value, "in the unit of the parameter") for value in first]

    def runs_of(one: Scene, count: int) -> Density:
        sail: Any = sail_of(one)  # a square sail
        jobs = jobs_of([sail.rows_per_strip * sail.strips], {"paper": PAPER}, count, end)
        return densities(mesh_study(one, jobs, folder, workers=workers, tell=tell))["paper"][0]

    aim = runs_of(target, 2 * starts)
    times = np.linspace(0.0, end, POINTS)
    spread = {c: aim.spread(c, end) for c in CURVES}
    tried: dict[float, Tried] = {}

    def misfit(value: float) -> float:
        value = float(f"{value:.3g}")
        if value not in tried:
            found = runs_of(scene.with_values({parameter: value}), starts)
            distance = {c: float(np.sqrt(np.mean((found.mean(c, times) - aim.mean(c, times)) ** 2))) for c in CURVES}
            size = math.sqrt(sum((distance[c] / spread[c]) ** 2 for c in CURVES) / len(CURVES))
            tried[value] = Tried(value, found, distance, size)
            report(f"{parameter} = {value}: misfit {size:.2f}")
        return tried[value].misfit

    for value in wanted:
        misfit(value)
    minimize_scalar(
        lambda power: misfit(10.0**power),
        bounds=(math.log10(low), math.log10(high)),
        method="bounded",
        options={"maxiter": tries, "xatol": 0.05},
    )
    return SceneMatch(parameter, aim, spread, tuple(tried.values()))


def _bounds(between: object) -> tuple[float, float]:
    """Bounds of a parameter. Raises InputError and InputTypeError."""
    wanted = "must be two numbers above 0, the lower one first"
    if not is_list(between) or len(between) != 2:
        raise InputTypeError(f"between = {show(between)}: {wanted}")
    low, high = (number_of("between", bound, "in the unit of the parameter") for bound in between)
    if not 0.0 < low < high:
        raise InputError(f"between = {show(between)}: {wanted}")
    return low, high


def _sizes(of: dict[str, float]) -> tuple[str, str]:
    """Of the rate and of the phase [deg]."""
    rate, phase = (of[c] for c in CURVES)
    return f"{rate:.4f}", f"{phase:.1f}"
