"""Ablation: the scene without each of its laws and parts in turn, and on a coarser and a finer mesh.

For each variant the study gives the saving in cost and the change in the results. A change is compared with a
tolerance and with the spread of an ensemble of perturbed starts, below which it is indistinguishable from chaos. The
smallest model leaves out everything that is dispensable. It is run as a whole; where it exceeds the tolerance, the
laws and parts of the largest change are restored one by one.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from pathlib import Path
from threading import Event
from typing import Any

import numpy as np

from membrane_rs._files import made_folder, replacing, write_text
from membrane_rs._markdown import table
from membrane_rs._validation import nearest
from membrane_rs.errors import InputError
from membrane_rs.results.run_summary import versions
from membrane_rs.results.summary import write_summary
from membrane_rs.runs import Simulation
from membrane_rs.scene import Scene
from membrane_rs.simulation import integrators
from membrane_rs.study.common.executor import Tell, run_parallel
from membrane_rs.study.common.run import StudyCase, StudyRun, ensemble, run_case, study_case
from membrane_rs.study.common.step_cost import cost_against
from membrane_rs.study.variants import Variant, variants, without

INSTANTS = 100
"""Number of samples of the curves."""
SMALLEST = "smallest model"
"""Folder of the recommended scene, and name of its row in the table."""


@dataclass(frozen=True)
class Change:
    """Difference between a run and that of the complete scene.

    Attributes
    ----------
    rate : float
        Largest difference in the deployment rate.
    phase : float
        Largest difference in the phase [deg].
    strain : float
        Difference between the largest strains of any spring at any instant.
    stress : float
        Difference between the largest stresses in the film at any instant [Pa]; NaN without film.
    """

    rate: float
    phase: float
    strain: float
    stress: float = math.nan

    def within(self, allowed: Change) -> bool:
        """Whether no component exceeds the allowed one; NaN (no corners, no film) is ignored."""
        pairs = zip(vars(self).values(), vars(allowed).values(), strict=True)
        return not any(abs(found) > most for found, most in pairs)

    def largest_share(self, allowed: Change) -> float:
        """The largest ratio of a component to the allowed one."""
        pairs = list(zip(vars(self).values(), vars(allowed).values(), strict=True))
        known = [(abs(a), b) for a, b in pairs if not math.isnan(a + b)]
        return max((a / b if b else (math.inf if a else 0.0) for a, b in known), default=0.0)


@dataclass(frozen=True)
class Item:
    """One row of the table: a scene with something left out.

    Attributes
    ----------
    name : str
        Name of the variant.
    time_per_step, step_limit, cost : float
        Ratios of this scene to the complete one; cost is the first over the second. NaN for a scene that did not run.
    change : Change or None
        None for a run that did not reach its end.
    verdict : str
        "can be omitted", "can be omitted: change within the spread", "needed", or the reason why it cannot be left
        out. For a denser mesh: whether the scene's mesh is dense enough.
    """

    name: str
    time_per_step: float
    step_limit: float
    cost: float
    change: Change | None
    verdict: str

    @property
    def may_go(self) -> bool:
        """Whether the scene keeps the tolerance without it."""
        return self.verdict.startswith("can be omitted")

    @property
    def share(self) -> float:
        """Share of the time of a step that is saved; NaN for a scene that did not run."""
        return 1.0 - self.time_per_step


@dataclass(frozen=True)
class Ablation:
    """Result of an ablation, with the smallest model.

    `spread` is that of the ensemble, `allowed` the larger of it and the tolerance, component by component. `smallest`
    is None if nothing is dispensable; `items` then has no row for it. `peak_stress` [Pa] is NaN without film.
    """

    scene: str
    until: float
    tolerance: float
    members: int
    dt: float
    peak_strain: float
    peak_stress: float
    spread: Change
    allowed: Change
    items: tuple[Item, ...]
    left_out: tuple[str, ...]
    smallest: Scene | None

    def table(self) -> str:
        """The rows as Markdown."""
        head: tuple[str, ...] = ("left out", "time per step saved", "step limit", "cost of the run")
        head += ("rate", "phase [deg]", "peak strain", "peak stress [Pa]", "verdict")
        rows = [_row(item) for item in self.items]
        for name, change in (("spread of perturbed starts", self.spread), ("allowed", self.allowed)):
            rows.append((f"*{name}*", "", "", "", *(text.lstrip("+") for text in _changes(change)), ""))
        return table(head, rows, words=(0, len(head) - 1))

    def heading(self) -> str:
        """The case, and the peaks with which the changes compare."""
        stress = "" if math.isnan(self.peak_stress) else f", peak stress {self.peak_stress:.2e} Pa"
        head = f"{self.scene}, {self.until:g} s by steps of {self.dt:.3g} s, {self.members} perturbed starts"
        return f"{head}; tolerance {self.tolerance:g}, peak strain {self.peak_strain:.2e}{stress}"

    def verdict(self) -> str:
        """The laws and parts that the smallest model leaves out."""
        if self.smallest is None:
            return "Nothing can be omitted."
        return f"The smallest model leaves out: {', '.join(self.left_out)}."

    def summary(self) -> str:
        """The result as text."""
        return f"{self.heading()}\n\n{self.table()}\n{self.verdict()}"

    def as_dict(self) -> dict[str, Any]:
        """All but the scene as plain numbers and texts, as ablation.json holds them."""
        plain: dict[str, Any] = {key: value for key, value in vars(self).items() if key not in ("smallest", "items")}
        plain |= {"spread": vars(self.spread), "allowed": vars(self.allowed)}
        items = [{**vars(i), "change": vars(i.change) if i.change else None} for i in self.items]
        return {**plain, "items": items, "versions": versions()}

    def save(self, folder: Path | str) -> None:
        """Write ablation.md, ablation.csv, ablation.json, and the smallest model's scene. Raises OutputError."""
        folder = made_folder(folder)
        write_text(folder / "ablation.md", self.table())
        with replacing(folder / "ablation.csv") as part, part.open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            names = ["left_out", "time_per_step", "step_limit", "cost", "rate", "phase_deg", "peak_strain"]
            names += ["peak_stress", "verdict"]
            writer.writerow(names)
            for i in self.items:
                changes = vars(i.change).values() if i.change else [None] * 4
                writer.writerow([i.name, i.time_per_step, i.step_limit, i.cost, *changes, i.verdict])
        write_summary(folder / "ablation.json", self.as_dict())
        if self.smallest is not None:
            self.smallest.save(folder / SMALLEST.replace(" ", "-"))


def ablate(
    scene: Scene,
    until: float | None = None,
    *,
    tolerance: float = 0.01,
    members: int = 5,
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
        Allowed change: of the deployment rate by this much, of the phase by this many turns, of the peak strain and
        stress by this share of themselves; or of each by the spread of the ensemble, if that is larger.
    members : int
        Runs from perturbed starts. The spread is the largest difference between any two of them, the run from
        the unperturbed start among them; 0: none. A run that the monitor stops is not counted.
    integrator : str, optional
        The method of all runs. Default: the scene's.
    share : float, optional
        The ratio of their steps to each scene's stability limit. Default: the scene's step, or 0.4.
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
        A number outside its range, an unknown method.
    UnstableError
        The run of the complete scene stopped.
    """
    if not 0.0 < tolerance < math.inf:
        raise InputError(f"tolerance = {tolerance}: must be greater than 0 and finite")
    if members < 0:
        raise InputError(f"ensemble = {members}: must be 0 or above")
    if dense_until is not None and not dense_until > 0.0:
        raise InputError(f"dense_until = {dense_until}: must be greater than 0 (s)")
    if share is not None and not 0.0 < share < 1.0:
        raise InputError(f"share = {share}: must be greater than 0 and less than 1 (of the stability limit)")
    if integrator is not None and integrator not in integrators():
        raise InputError(f"integrator: there is no {integrator!r}; {nearest(integrator, list(integrators()))}")
    tell = progress or (lambda _: None)
    case = study_case(scene, until, INSTANTS)
    whole = _simulation(case.scene, integrator, step_ratio=share)
    reference, *others = ensemble(case, whole.integrator, whole.dt, members, jobs=jobs, tell=tell)
    reference, others = reference.completed(), [member for member in others if member.failure is None]
    spread = _largest([_change(one, other) for one, other in combinations((reference, *others), 2)])
    peak = float(reference.strain.max())
    stress = float(reference.stress.max())
    wanted = Change(tolerance, 360.0 * tolerance, tolerance * abs(peak), tolerance * abs(stress))
    allowed = _largest([spread, wanted])

    comparison = _Comparison(case, whole, reference, spread, allowed, share, dense_until, jobs, tell)
    found = [comparison.named(variant) for variant in variants(case.scene)]
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
        """One run of each by the method and step of the complete scene, or a smaller one where its limit is lower."""
        stop = Event()

        def job(variant: Variant) -> StudyRun:
            assert variant.scene is not None
            # One step that is stable for both: then the runs differ by the model alone.
            dt = min(self.whole.dt, _simulation(variant.scene, self.whole.integrator, self.step_ratio).dt)
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
        if run.failure is not None:
            verdict = f"needed: without it the run stops at {run.failure.time:.3g} s ({run.failure.law})"
            return Item(variant.name, time, limit, time / limit, None, verdict)
        change = _change(run, self.reference)
        if variant.density > 1.0:
            enough = "within tolerance: the mesh is dense enough"
            verdict = enough if change.within(self.allowed) else "beyond tolerance: a denser mesh gives another answer"
            return Item(variant.name, time, limit, time / limit, change, verdict)
        verdict = "needed"
        if change.within(self.allowed):
            hidden = any(vars(change).values()) and change.within(self.spread)
            verdict = "can be omitted: change within the spread" if hidden else "can be omitted"
        return Item(variant.name, time, limit, time / limit, change, verdict)


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
            variant = Variant(SMALLEST, ("", 0), scene)
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
    """The largest of each component; 0 without changes."""
    if not changes:
        return Change(0.0, 0.0, 0.0, 0.0)
    rows = np.abs([list(vars(change).values()) for change in changes])
    return Change(*(float(value) for value in np.fmax.reduce(rows, axis=0)))


def _changes(change: Change) -> tuple[str, ...]:
    known = (f"{change.rate:.1e}", f"{change.phase:.1e}", f"{change.strain:+.1e}", f"{change.stress:+.1e}")
    return tuple("-" if "nan" in text else text for text in known)


def _row(item: Item) -> tuple[str, ...]:
    def share(value: float) -> str:
        return "-" if math.isnan(value) else f"{100 * value:.0f} %"

    changes = _changes(item.change) if item.change else ("-",) * 4
    return (item.name, share(item.share), share(item.step_limit), share(item.cost), *changes, item.verdict)
