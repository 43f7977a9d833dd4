"""Ablation: the scene without each of its laws and parts in turn, and on a coarser and a finer mesh.

For each variant the study gives the saving in cost and the change in the results. A change is compared with a
tolerance and with the spread of an ensemble of perturbed starts, below which it is indistinguishable from chaos. The
smallest model leaves out everything that is dispensable. It is run as a whole; where it exceeds the tolerance, the
laws and parts of the largest change are restored one by one.

All run by one step, so that they differ by the model alone; a variant whose only saving is a longer step, such as a
softened film, runs by its own step, of the same ratio to its limit.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from threading import Event

import numpy as np

from membrane_rs._validation import count_of, nearest, number_of, show
from membrane_rs.errors import InputError
from membrane_rs.runs import Simulation
from membrane_rs.scene import Scene
from membrane_rs.scene.softened import softening_of
from membrane_rs.simulation import integrators
from membrane_rs.study.ablation_result import SMALLEST, Ablation, Change, Item
from membrane_rs.study.common.executor import Tell, run_parallel, teller
from membrane_rs.study.common.perturbation import SHIFT, check_shift, shift_of
from membrane_rs.study.common.run import (
    MOST_MEMBERS,
    StudyCase,
    StudyRun,
    ensemble,
    run_case,
    stopped_starts,
    study_case,
)
from membrane_rs.study.common.step_cost import cost_against
from membrane_rs.study.variants import Variant, variants, without

INSTANTS = 100
"""Number of samples of the curves."""


def ablate(
    scene: Scene,
    until: float | None = None,
    *,
    tolerance: float = 0.01,
    members: int = 5,
    shift: float = SHIFT,
    integrator: str | None = None,
    share: float | None = None,
    dense_until: float | None = None,
    jobs: int | None = None,
    progress: Tell | None = None,
) -> Ablation:
    """Run a scene complete, without each law and part, and on coarser and finer meshes; find its smallest model.

    Parameters
    ----------
    scene : Scene
        The complete scene.
    until : float, optional
        Time at the end [s]; the result holds up to then. Default: the scene's.
    tolerance : float
        Allowed change [-]: of the deployment rate by this much, of the phase by this many turns, of the peak strain and
        stress by this share of themselves; or of each by the spread of the ensemble, if that is larger. Neither strain
        nor stress is compared for a softened film: it strains more under a load, and bears less stress at a fold.
    members : int
        Runs from perturbed starts. The spread is the largest difference between any two of them, the run from
        the unperturbed start among them; 0: none. A run that the monitor stops is not counted, but reported.
    shift : float
        Standard deviation of the perturbation of each coordinate of a start [m]. Starts that differ by rounding alone
        have their first instants in common, and show less than what any small change, of the model too, does there.
    integrator : str, optional
        The method of all runs. Default: the scene's.
    share : float, optional
        The ratio of their steps to each scene's stability limit [-]. Default: the scene's step, or 0.4.
    dense_until : float, optional
        End of the run on the denser mesh, which costs about eight times the others [s]. Default: as for all.
    jobs : int, optional
        Number of parallel runs. Default: one on each core. Results do not depend on it.
    progress : callable, optional
        Called with a line of text after each run.

    Returns
    -------
    Ablation
        What each law and part costs and changes.

    Raises
    ------
    InputError
        A number outside its range, a shift not below the shortest edge, an unknown method.
    InputTypeError
        No scene, or no number.
    UnstableError
        The run of the complete scene stopped.

    Examples
    --------
    The cost of each variant is timed, which takes some seconds:

    >>> from membrane_rs import scenes
    >>> from membrane_rs.study import ablate
    >>> found = ablate(scenes.load("okuizumi-model-1"), until=0.01, members=2)  # doctest: +SKIP
    >>> found.save("ablation")  # doctest: +SKIP

    >>> ablate(scenes.load("spinning-tether"), tolerance=0.0)
    Traceback (most recent call last):
    membrane_rs.errors.InputError: tolerance = 0.0: must be greater than 0 and finite
    """
    tolerance = number_of("tolerance", tolerance, "-")
    if not 0.0 < tolerance < math.inf:
        raise InputError(f"tolerance = {tolerance}: must be greater than 0 and finite")
    members = count_of("members", members, 0, MOST_MEMBERS, "perturbed starts, --ensemble")
    dense_until = None if dense_until is None else number_of("dense_until", dense_until)
    shift = shift_of(shift)
    share = None if share is None else number_of("share", share, "of the stability limit")
    if dense_until is not None and not dense_until > 0.0:
        raise InputError(f"dense_until = {dense_until}: must be greater than 0 (s)")
    if share is not None and not 0.0 < share < 1.0:
        raise InputError(f"share = {share}: must be greater than 0 and less than 1 (of the stability limit)")
    if integrator is not None and (not isinstance(integrator, str) or integrator not in integrators()):
        raise InputError(f"integrator: there is no {show(integrator)}; {nearest(str(integrator), integrators())}")
    tell = teller(progress)
    case = study_case(scene, until, INSTANTS)
    if members:
        check_shift(shift, case.scene)
    whole = _simulation(case.scene, integrator, step_ratio=share)
    reference, *starts = ensemble(case, whole.integrator, whole.dt, members, shift=shift, jobs=jobs, tell=tell)
    reference, others = reference.completed(), [start for start in starts if start.failure is None]
    spread = _largest([_change(one, other) for one, other in combinations((reference, *others), 2)])
    peak = float(reference.strain.max())
    stress = float(reference.stress.max())
    wanted = Change(tolerance, 360.0 * tolerance, tolerance * abs(peak), tolerance * abs(stress))
    allowed = _largest([spread, wanted])

    comparison = _Comparison(case, whole, reference, spread, allowed, share, dense_until, jobs, tell)
    found = [comparison.named(variant) for variant in variants(case.scene, whole.integrator)]
    runnable = [variant for variant in found if variant.scene is not None]
    runnable.sort(key=lambda variant: -variant.density)  # the longest run first, so that the cores end together
    runs = dict(zip([v.name for v in runnable], comparison.runs(runnable), strict=True))
    items = []
    for variant in found:
        items.append(comparison.item(variant, runs.get(variant.name)))
        tell(f"left out: {variant.name}: {items[-1].verdict}")
    smallest, row, left_out = _smallest(comparison, found, items)
    return Ablation(
        scene=scene.name,
        until=case.until,
        tolerance=tolerance,
        members=len(others),
        dt=reference.dt,
        peak_strain=peak,
        peak_stress=stress,
        spread=spread,
        allowed=allowed,
        items=(*items, *([row] if row else [])),
        left_out=tuple(variant.name for variant in left_out),
        smallest=None if smallest is None else replace(smallest, name=f"{scene.name[:80]}-smallest", run=scene.run),
        shift=shift,
        stopped_starts=stopped_starts(starts, shift),
    )


@dataclass(frozen=True)
class _Comparison:
    """The reference of each variant: the complete scene, its run, and the allowed change."""

    case: StudyCase
    whole: Simulation
    reference: StudyRun
    spread: Change
    allowed: Change
    step_ratio: float | None
    dense_until: float | None
    jobs: int | None
    tell: Tell

    def named(self, variant: Variant) -> Variant:
        """The variant, whose name contains the end of a shortened run."""
        case = self.case.shortened(self.dense_until)
        if variant.density <= 1.0 or case is self.case:
            return variant
        return replace(variant, name=f"{variant.name} (first {case.until:.3g} s)")

    def runs(self, chosen: Sequence[Variant]) -> list[StudyRun]:
        """One run of each by the method and step of the complete scene, or a smaller one where its limit is lower; by
        its own step where that is what it saves.
        """
        stop = Event()

        def job(variant: Variant) -> StudyRun:
            assert variant.scene is not None
            own = _simulation(variant.scene, self.whole.integrator, self.step_ratio).dt
            # One step that is stable for both: then the runs differ by the model alone.
            dt = own if variant.saves_by_step else min(self.whole.dt, own)
            case = self.case.shortened(self.dense_until) if variant.density > 1.0 else self.case
            return run_case(case.of(variant.scene), self.whole.integrator, dt, stop=stop)

        names = [f"left out: {variant.name}" for variant in chosen]
        jobs = [lambda v=v: job(v) for v in chosen]
        return run_parallel(jobs, names, stop, workers=self.jobs, tell=self.tell)

    def item(self, variant: Variant, run: StudyRun | None) -> Item:
        """The row of a variant."""
        if variant.scene is None or run is None:
            return Item(variant.name, math.nan, math.nan, math.nan, None, f"cannot be left out: {variant.reason}")
        time, limit = cost_against(self.whole, variant.scene)
        step = run.dt / self.reference.dt
        if run.failure is not None:
            verdict = f"needed: without it the run stops at {run.failure.time:.3g} s ({run.failure.law})"
            return Item(variant.name, time, limit, time / limit, None, verdict, step)
        change = _change(run, self.reference)
        if softening_of(variant.scene) != softening_of(self.case.scene):
            # Its strain and stress, at peaks set by the folding rather than by loads, are those of another film.
            change = replace(change, strain=math.nan, stress=math.nan)
        if variant.density > 1.0:
            enough = "within tolerance: the mesh is dense enough"
            verdict = enough if change.within(self.allowed) else "beyond tolerance: a denser mesh gives another answer"
            return Item(variant.name, time, limit, time / limit, change, verdict, step)
        verdict = "needed"
        if change.within(self.allowed):
            has_spread = not all(map(math.isnan, vars(self.spread).values()))
            hidden = has_spread and any(vars(change).values()) and change.within(self.spread)
            verdict = "can be omitted: change within the spread" if hidden else "can be omitted"
        return Item(variant.name, time, limit, time / limit, change, verdict, step)


def _simulation(scene: Scene, integrator: str | None, step_ratio: float | None) -> Simulation:
    """The scene with its own step, or with a step of this ratio to its limit."""
    sim = Simulation(scene, integrator)
    return sim if step_ratio is None else Simulation(scene, integrator, step_ratio * sim.stable_dt())


def _smallest(
    comparison: _Comparison, found: Sequence[Variant], items: Sequence[Item]
) -> tuple[Scene | None, Item | None, list[Variant]]:
    """The scene without all that is dispensable; the largest change is restored until the whole keeps the tolerance."""
    rows = zip(found, items, strict=True)
    going = [(variant, item.change) for variant, item in rows if item.may_go and item.change is not None]
    going.sort(key=lambda pair: pair[1].largest_share(comparison.allowed))
    while going:
        # A part that is left out is not replaced as well.
        bare = {variant.place for variant, _ in going if variant.other is None}
        chosen = [variant for variant, _ in going if variant.other is None or variant.place not in bare]
        try:
            scene = without(comparison.case.scene, chosen)
            by_step = any(variant.saves_by_step for variant in chosen)
            variant = Variant(SMALLEST, ("", 0), scene, saves_by_step=by_step)
            item = comparison.item(variant, comparison.runs([variant])[0])
        except InputError:  # the remainder is not a valid scene
            item = None
        if item is not None and item.may_go:
            return scene, replace(item, verdict="within tolerance"), sorted(chosen, key=found.index)
        going.pop()
    return None, None, []


def _change(run: StudyRun, reference: StudyRun) -> Change:
    """Change over the instants that the run reached."""
    count = len(run.times)
    rate, phase = (np.abs(a - b[:count]).max() for a, b in ((run.rate, reference.rate), (run.phase, reference.phase)))
    peaks = ((run.strain, reference.strain), (run.stress, reference.stress))
    return Change(float(rate), float(phase), *(float(a.max() - b[:count].max()) for a, b in peaks))


def _largest(changes: Sequence[Change]) -> Change:
    """The largest of each component; NaN without changes."""
    if not changes:
        return Change(math.nan, math.nan, math.nan, math.nan)
    rows = np.abs([list(vars(change).values()) for change in changes])
    return Change(*(float(value) for value in np.fmax.reduce(rows, axis=0)))
