"""The result of an ablation: a table of what each law and part costs and changes, its files, the smallest model."""

from __future__ import annotations

import csv
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from membrane_rs._files import made_folder, replacing, write_text
from membrane_rs._markdown import table
from membrane_rs.results.run_summary import versions
from membrane_rs.results.summary import write_summary
from membrane_rs.scene import Scene
from membrane_rs.study.common.perturbation import SHIFT

SMALLEST = "smallest model"
"""Folder of the recommended scene, and name of its row in the table."""
LONGER = 1.05
"""Ratio of steps above which a row names it; below it is the rounding to the interval between samples."""


@dataclass(frozen=True)
class Change:
    """Difference between a run and that of the complete scene.

    Attributes
    ----------
    rate : float
        Largest difference in the deployment rate [-].
    phase : float
        Largest difference in the phase [deg].
    strain : float
        Difference between the largest strains of any spring at any instant [-]; NaN for another softening.
    stress : float
        Difference between the largest stresses in the film at any instant [Pa]; NaN without film, and for another
        softening.

    Examples
    --------
    >>> from membrane_rs.study import Change
    >>> found, allowed = Change(0.001, 0.2, 0.0), Change(0.01, 1.0, 1e-5)
    >>> found.within(allowed), found.largest_share(allowed)
    (True, 0.2)
    """

    rate: float
    phase: float
    strain: float
    stress: float = math.nan

    def within(self, allowed: Change) -> bool:
        """Whether no component exceeds the allowed one.

        Parameters
        ----------
        allowed : Change
            NaN (no corners, no film) is ignored.

        Returns
        -------
        bool
            Whether all are within.
        """
        pairs = zip(vars(self).values(), vars(allowed).values(), strict=True)
        return not any(abs(found) > most for found, most in pairs)

    def largest_share(self, allowed: Change) -> float:
        """The largest ratio of a component to the allowed one.

        Parameters
        ----------
        allowed : Change
            NaN is ignored.

        Returns
        -------
        float
            [-]; infinite where nothing is allowed and something changed.
        """
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
        Ratios of this scene to the complete one [-]; cost is the first over the second. NaN for a scene that did not
        run.
    change : Change or None
        None for a run that did not reach its end.
    verdict : str
        "can be omitted", "can be omitted: change within the spread", "needed", or the reason why it cannot be left
        out. For a denser mesh: whether the scene's mesh is dense enough.
    step : float
        Ratio of the step of its run to that of the complete scene [-]; above 1 where a longer step is what it saves.

    Examples
    --------
    >>> from membrane_rs.study import Change, Item
    >>> row = Item("law air_drag", 0.75, 1.0, 0.75, Change(0.001, 0.2, 0.0), "can be omitted")
    >>> row.may_go, row.share
    (True, 0.25)
    """

    name: str
    time_per_step: float
    step_limit: float
    cost: float
    change: Change | None
    verdict: str
    step: float = 1.0

    @property
    def may_go(self) -> bool:
        """Whether the scene keeps the tolerance without it."""
        return self.verdict.startswith("can be omitted")

    @property
    def share(self) -> float:
        """Share of the time of a step that is saved [-]; NaN for a scene that did not run."""
        return 1.0 - self.time_per_step


@dataclass(frozen=True)
class Ablation:
    """Result of an ablation, with the smallest model.

    Attributes
    ----------
    scene : str
        Name of the complete scene.
    until : float
        Time at the end [s].
    tolerance : float
        Allowed change, as a share of what it is of [-].
    members : int
        Runs from perturbed starts that came to their end.
    dt : float
        Step of the complete scene [s].
    peak_strain : float
        Largest strain of any spring of the complete scene [-].
    peak_stress : float
        Largest stress in its film [Pa]; NaN without film.
    spread : Change
        Largest differences between perturbed starts; NaN without any that came to their end.
    allowed : Change
        The larger of spread and tolerance, component by component.
    items : tuple of Item
        A row for each variant, that of the smallest model last; none for it where nothing is dispensable.
    left_out : tuple of str
        What the smallest model leaves out.
    smallest : Scene or None
        None where nothing is dispensable.
    shift : float
        Standard deviation of the perturbation of each coordinate of the starts [m].
    stopped_starts : str
        A warning of perturbed starts that the monitor stopped, with the first reason; empty where it stopped none.

    Examples
    --------
    >>> from math import nan
    >>> from membrane_rs.study.ablation_result import Ablation, Change, Item
    >>> none, allowed = Change(nan, nan, nan), Change(0.01, 3.6, 1e-5)
    >>> row = Item("law air_drag", 0.8, 1.0, 0.8, Change(0.001, 0.2, 0.0), "can be omitted")
    >>> found = Ablation("sail", 0.1, 0.01, 0, 1e-5, 1e-3, nan, none, allowed, (row,), (), None)
    >>> found.heading()
    'sail, 0.1 s by steps of 1e-05 s, 0 perturbed starts; tolerance 0.01, peak strain 1.00e-03'
    >>> found.table().splitlines()[2][:28], found.verdict()
    ('| law air_drag | 20 % | 100 ', 'Nothing can be omitted.')
    >>> len(found.summary().splitlines()), found.as_dict()["items"][0]["cost"]
    (9, 0.8)
    >>> found.save("ablation")
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
    shift: float = SHIFT
    stopped_starts: str = ""

    def table(self) -> str:
        """The rows as a table.

        Returns
        -------
        str
            In Markdown.
        """
        head: tuple[str, ...] = ("left out", "time per step saved", "step limit", "cost of the run")
        head += ("rate", "phase [deg]", "peak strain", "peak stress [Pa]", "verdict")
        rows = [_row(item) for item in self.items]
        for name, change in (("spread of perturbed starts", self.spread), ("allowed", self.allowed)):
            rows.append((f"*{name}*", "", "", "", *(text.lstrip("+") for text in _changes(change)), ""))
        return table(head, rows, words=(0, len(head) - 1))

    def heading(self) -> str:
        """The case, and the peaks with which the changes compare.

        Returns
        -------
        str
            One line.
        """
        stress = "" if math.isnan(self.peak_stress) else f", peak stress {self.peak_stress:.2e} Pa"
        head = f"{self.scene}, {self.until:g} s by steps of {self.dt:.3g} s, {self.members} perturbed starts"
        head += "" if self.shift == SHIFT else f" (by {self.shift:g} m)"
        return f"{head}; tolerance {self.tolerance:g}, peak strain {self.peak_strain:.2e}{stress}"

    def verdict(self) -> str:
        """The laws and parts that the smallest model leaves out.

        Returns
        -------
        str
            A sentence.
        """
        if self.smallest is None:
            return "Nothing can be omitted."
        return f"The smallest model leaves out: {', '.join(self.left_out)}."

    def summary(self) -> str:
        """Heading, table and verdict as text.

        Returns
        -------
        str
            Several lines.
        """
        warning = f"\nWarning: {self.stopped_starts}" if self.stopped_starts else ""
        return f"{self.heading()}{warning}\n\n{self.table()}\n{self.verdict()}"

    def as_dict(self) -> dict[str, Any]:
        """All but the scene as plain numbers and texts, as ablation.json holds them.

        Returns
        -------
        dict of str to object
            By the names of the attributes.
        """
        plain: dict[str, Any] = {key: value for key, value in vars(self).items() if key not in ("smallest", "items")}
        plain |= {"spread": vars(self.spread), "allowed": vars(self.allowed)}
        items = [{**vars(i), "change": vars(i.change) if i.change else None} for i in self.items]
        return {**plain, "items": items, "versions": versions()}

    def save(self, folder: Path | str) -> None:
        """Write ablation.md, ablation.csv, ablation.json, and the smallest model's scene.

        Parameters
        ----------
        folder : path
            Made where it is missing.

        Raises
        ------
        OutputError
            It cannot be written.
        InputError, InputTypeError
            No path.
        """
        folder = made_folder(folder)
        write_text(folder / "ablation.md", self.table())
        with replacing(folder / "ablation.csv") as part, part.open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            names = ["left_out", "time_per_step", "step_limit", "cost", "rate", "phase_deg", "peak_strain"]
            names += ["peak_stress", "verdict", "step"]
            writer.writerow(names)
            for i in self.items:
                changes = vars(i.change).values() if i.change else [None] * 4
                writer.writerow([i.name, i.time_per_step, i.step_limit, i.cost, *changes, i.verdict, i.step])
        write_summary(folder / "ablation.json", self.as_dict())
        if self.smallest is not None:
            self.smallest.save(folder / SMALLEST.replace(" ", "-"))


def _changes(change: Change) -> tuple[str, ...]:
    known = (f"{change.rate:.1e}", f"{change.phase:.1e}", f"{change.strain:+.1e}", f"{change.stress:+.1e}")
    return tuple("-" if "nan" in text else text for text in known)


def _row(item: Item) -> tuple[str, ...]:
    def share(value: float) -> str:
        return "-" if math.isnan(value) else f"{100 * value:.0f} %"

    own_step = f"; by steps {item.step:.2g} times as long" if item.step > LONGER else ""
    changes = _changes(item.change) if item.change else ("-",) * 4
    return (item.name, share(item.share), share(item.step_limit), share(item.cost), *changes, item.verdict + own_step)
