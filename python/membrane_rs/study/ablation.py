"""No more than a scene needs: each law and part left out in turn, the mesh coarser and finer; what that saves and
what it changes.

Changes are held against a wanted tolerance, and against the spread of an ensemble of perturbed starts: what is
smaller than that cannot be told from chaos. The smallest model is what is left when everything that may go
has gone; it is run too, and grows again until it keeps the tolerance as a whole.
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

from membrane_rs._files import output_errors, replacing, write_text
from membrane_rs._markdown import table
from membrane_rs._validation import nearest
from membrane_rs.errors import InputError
from membrane_rs.results.summary import versions, write_summary
from membrane_rs.runs import Simulation
from membrane_rs.scene import Scene
from membrane_rs.simulation import integrators
from membrane_rs.study.common.executor import Tell, together
from membrane_rs.study.common.run import Course, Trial, course, ensemble, run
from membrane_rs.study.common.step_cost import cost_against
from membrane_rs.study.variants import Variant, variants, without

INSTANTS = 100
"""How often the curves are read."""
SMALLEST = "smallest model"
"""The folder of the recommended scene, and its row in the table."""


@dataclass(frozen=True)
class Change:
    """How far a run is from that of the whole scene.

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
        """Whether nothing is larger than allowed; what is not a number counts as nothing (no corners, no film)."""
        pairs = zip(vars(self).values(), vars(allowed).values(), strict=True)
        return not any(abs(found) > most for found, most in pairs)

    def largest_share(self, allowed: Change) -> float:
        """The largest change as a multiple of what is allowed."""
        pairs = list(zip(vars(self).values(), vars(allowed).values(), strict=True))
        known = [(abs(a), b) for a, b in pairs if not math.isnan(a + b)]
        return max((a / b if b else (math.inf if a else 0.0) for a, b in known), default=0.0)


@dataclass(frozen=True)
class Item:
    """One row: a scene with something left out.

    Attributes
    ----------
    name : str
        What was left out.
    time_per_step, step_limit, cost : float
        Of this scene over the whole one; cost is the first over the second. NaN where it did not run.
    change : Change or None
        None where it did not run to its end.
    verdict : str
        "may go", "may go: chaos hides what it does", "needed", or why it cannot be left out. Of a denser mesh: whether
        this one is dense enough.
    """

    name: str
    time_per_step: float
    step_limit: float
    cost: float
    change: Change | None
    verdict: str

    @property
    def may_go(self) -> bool:
        """Whether the tolerance is kept without it."""
        return self.verdict.startswith("may go")

    @property
    def share(self) -> float:
        """What is left out, as a share of the time of a step; NaN where it did not run."""
        return 1.0 - self.time_per_step


@dataclass(frozen=True)
class Ablation:
    """What leaving out does to a scene, and the smallest model of it.

    `spread` is that of the ensemble, `allowed` the larger of it and the tolerance, kind by kind. `smallest`
    is None where nothing may go; its own row is then missing in `items`. `peak_stress` [Pa] is NaN without film.
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
        head: tuple[str, ...] = ("left out", "its share of a step", "step limit", "cost of the run")
        head += ("rate", "phase [deg]", "peak strain", "peak stress [Pa]", "verdict")
        rows = [_row(item) for item in self.items]
        for name, change in (("spread of perturbed starts", self.spread), ("allowed", self.allowed)):
            rows.append((f"*{name}*", "", "", "", *(text.lstrip("+") for text in _changes(change)), ""))
        return table(head, rows, words=(0, len(head) - 1))

    def heading(self) -> str:
        """What was run, and to what the changes of its peaks compare."""
        stress = "" if math.isnan(self.peak_stress) else f", peak stress {self.peak_stress:.2e} Pa"
        head = f"{self.scene}, {self.until:g} s by steps of {self.dt:.3g} s, {self.members} perturbed starts"
        return f"{head}; tolerance {self.tolerance:g}, peak strain {self.peak_strain:.2e}{stress}"

    def verdict(self) -> str:
        """What the smallest model leaves out."""
        if self.smallest is None:
            return "Nothing may go: the scene is the smallest model of itself."
        return f"The smallest model leaves out: {', '.join(self.left_out)}."

    def summary(self) -> str:
        """The result in words."""
        return f"{self.heading()}\n\n{self.table()}\n{self.verdict()}"

    def save(self, folder: Path | str) -> None:
        """Write ablation.md, ablation.csv, ablation.json, and the smallest model's scene. Raises OutputError."""
        folder = Path(folder)
        with output_errors(folder):
            folder.mkdir(parents=True, exist_ok=True)
        write_text(folder / "ablation.md", self.table())
        with replacing(folder / "ablation.csv") as part, part.open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            names = ["left_out", "time_per_step", "step_limit", "cost", "rate", "phase_deg", "peak_strain"]
            names += ["peak_stress", "verdict"]
            writer.writerow(names)
            for i in self.items:
                changes = vars(i.change).values() if i.change else [None] * 4
                writer.writerow([i.name, i.time_per_step, i.step_limit, i.cost, *changes, i.verdict])
        plain: dict[str, Any] = {key: value for key, value in vars(self).items() if key not in ("smallest", "items")}
        plain |= {"spread": vars(self.spread), "allowed": vars(self.allowed)}
        items = [{**vars(i), "change": vars(i.change) if i.change else None} for i in self.items]
        write_summary(folder / "ablation.json", {**plain, "items": items, "versions": versions()})
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
    """Run a scene whole, with each law and part left out and on coarser and finer meshes, and find its smallest model.

    Parameters
    ----------
    scene : Scene
        What is run.
    until : float, optional
        Time at the end [s]; nothing is said about what comes later. Default: the scene's.
    tolerance : float
        What may change: the deployment rate by this much, the phase by this many turns, the peak strain and stress by
        this share of themselves; or each by the spread of the ensemble, if that is larger.
    members : int
        Runs from perturbed starts. The spread is the largest difference between any two of them, the run from
        the true start among them; 0: none. One that the watch stops is not counted.
    integrator : str, optional
        The method of all runs. Default: the scene's.
    share : float, optional
        Their steps, as shares of each scene's stability limit. Default: the scene's step, or 0.4.
    dense_until : float, optional
        Where the run on the denser mesh, which costs about eight times the others, ends [s]. Default: like all.
    jobs : int, optional
        Runs at once. Default: one on each core. Results do not depend on it.
    progress : callable, optional
        Told in words what was just done.

    Raises
    ------
    InputError
        A number out of its range, an unknown method.
    UnstableError
        The whole scene itself stopped.
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
    where = course(scene, until, INSTANTS)
    whole = _simulation(where.scene, integrator, share)
    peer, *others = ensemble(where, whole.integrator, whole.dt, members, jobs=jobs, tell=tell)
    peer, others = peer.whole(), [trial for trial in others if trial.failure is None]
    spread = _largest([_change(one, other) for one, other in combinations((peer, *others), 2)])
    peak = float(peer.strain.max())
    stress = float(peer.stress.max())
    wanted = Change(tolerance, 360.0 * tolerance, tolerance * abs(peak), tolerance * abs(stress))
    allowed = _largest([spread, wanted])

    against = _Against(where, whole, peer, spread, allowed, share, dense_until, jobs, tell)
    found = [against.named(variant) for variant in variants(where.scene)]
    runnable = [variant for variant in found if variant.scene is not None]
    runnable.sort(key=lambda variant: -variant.density)  # the longest run first, so that none is left to run alone
    trials = dict(zip([v.name for v in runnable], against.trials(runnable), strict=True))
    items = []
    for variant in found:
        items.append(against.item(variant, trials.get(variant.name)))
        tell(f"left out: {variant.name}: {items[-1].verdict}")
    smallest, row, left_out = _smallest(against, found, items)
    return Ablation(
        scene=scene.name,
        until=where.until,
        tolerance=tolerance,
        members=len(others),
        dt=peer.dt,
        peak_strain=peak,
        peak_stress=stress,
        spread=spread,
        allowed=allowed,
        items=(*items, *([row] if row else [])),
        left_out=tuple(variant.name for variant in left_out),
        smallest=None if smallest is None else replace(smallest, name=f"{scene.name[:80]}-smallest", run=scene.run),
    )


@dataclass(frozen=True)
class _Against:
    """What each variant is held against: the whole scene, its run, and what may change."""

    where: Course
    whole: Simulation
    peer: Trial
    spread: Change
    allowed: Change
    share: float | None
    dense_until: float | None
    jobs: int | None
    tell: Tell

    def named(self, variant: Variant) -> Variant:
        """The variant; where its run ends early, its name says so."""
        where = self.where.shortened(self.dense_until)
        if variant.density <= 1.0 or where is self.where:
            return variant
        return replace(variant, name=f"{variant.name} (first {where.until:.3g} s)")

    def trials(self, chosen: Sequence[Variant]) -> list[Trial]:
        """One run of each, by the whole scene's method and step; or at a smaller one, where its own limit is lower."""
        stop = Event()

        def job(variant: Variant) -> Trial:
            assert variant.scene is not None
            # A step that suits both: the same one leaves nothing but the model to differ.
            dt = min(self.whole.dt, _simulation(variant.scene, self.whole.integrator, self.share).dt)
            where = self.where.shortened(self.dense_until) if variant.density > 1.0 else self.where
            return run(where.of(variant.scene), self.whole.integrator, dt, stop=stop)

        names = [f"left out: {variant.name}" for variant in chosen]
        jobs = [lambda v=v: job(v) for v in chosen]
        return together(jobs, names, stop, workers=self.jobs, tell=self.tell)

    def item(self, variant: Variant, trial: Trial | None) -> Item:
        """The row of a variant."""
        if variant.scene is None or trial is None:
            return Item(variant.name, math.nan, math.nan, math.nan, None, f"cannot be left out: {variant.reason}")
        time, limit = cost_against(self.whole, variant.scene)
        if trial.failure is not None:
            verdict = f"needed: without it the run stops at {trial.failure.time:.3g} s ({trial.failure.law})"
            return Item(variant.name, time, limit, time / limit, None, verdict)
        change = _change(trial, self.peer)
        if variant.density > 1.0:
            enough = "within tolerance: the mesh is dense enough"
            verdict = enough if change.within(self.allowed) else "beyond tolerance: a denser mesh gives another answer"
            return Item(variant.name, time, limit, time / limit, change, verdict)
        verdict = "needed"
        if change.within(self.allowed):
            hidden = any(vars(change).values()) and change.within(self.spread)
            verdict = "may go: chaos hides what it does" if hidden else "may go"
        return Item(variant.name, time, limit, time / limit, change, verdict)


def _simulation(scene: Scene, integrator: str | None, share: float | None) -> Simulation:
    """The scene with its own step, or with a share of its limit."""
    sim = Simulation(scene, integrator)
    return sim if share is None else Simulation(scene, integrator, share * sim.stable_dt())


def _smallest(
    against: _Against, found: Sequence[Variant], items: Sequence[Item]
) -> tuple[Scene | None, Item | None, list[Variant]]:
    """The scene without all that may go; what changes most comes back until the whole keeps the tolerance."""
    rows = zip(found, items, strict=True)
    going = [(variant, item.change) for variant, item in rows if item.may_go and item.change is not None]
    going.sort(key=lambda pair: pair[1].largest_share(against.allowed))
    while going:
        # A part that may go is not also replaced.
        bare = {variant.place for variant, _ in going if variant.other is None}
        chosen = [variant for variant, _ in going if variant.other is None or variant.place not in bare]
        try:
            scene = without(against.where.scene, chosen)
            variant = Variant(SMALLEST, ("", 0), scene)
            item = against.item(variant, against.trials([variant])[0])
        except InputError:  # what is left is no scene
            item = None
        if item is not None and item.may_go:
            return scene, replace(item, verdict="within tolerance"), sorted(chosen, key=found.index)
        going.pop()
    return None, None, []


def _change(trial: Trial, peer: Trial) -> Change:
    """Over the instants that the trial came to."""
    count = len(trial.times)
    rate, phase = (np.abs(a - b[:count]).max() for a, b in ((trial.rate, peer.rate), (trial.phase, peer.phase)))
    peaks = ((trial.strain, peer.strain), (trial.stress, peer.stress))
    return Change(float(rate), float(phase), *(float(a.max() - b[:count].max()) for a, b in peaks))


def _largest(changes: Sequence[Change]) -> Change:
    """The largest of each; 0 without any."""
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
