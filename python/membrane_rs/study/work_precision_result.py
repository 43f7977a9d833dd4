"""The data of a work-precision diagram: its points, orders and best methods, as text, files and a figure."""

from __future__ import annotations

import csv
import math
from dataclasses import dataclass, field
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from membrane_rs._files import made_folder, replacing
from membrane_rs.plotting.work_precision import COSTS, Line, Row, plot_work_precision
from membrane_rs.results.run_summary import versions
from membrane_rs.results.summary import write_summary
from membrane_rs.study.common.differences import CURVES
from membrane_rs.study.common.perturbation import SHIFT
from membrane_rs.study.refinement import Best, Point, cheapest, finest_errors, line_name

REFERENCE = "rk4"
"""The method of the reference."""


@dataclass(frozen=True)
class WorkPrecision:
    """The data of a work-precision diagram.

    Attributes
    ----------
    scene : str
        Name of the scene.
    until : float
        Time at the end [s].
    instants : int
        Number of samples.
    members : int
        Runs from perturbed starts that came to their end.
    points : tuple of Point
        By method, coarsest level first.
    labels : dict of str to str
        Label of each kind of error.
    reference_dt, reference_density : float
        Step of the reference [s], and ratio of the density of its mesh to the scene's [-].
    reference_errors : dict of str to float
        Difference of the reference from itself at twice its step [-].
    floors : dict of str to float
        Largest error between perturbed starts [-]; NaN without two that came to their end.
    wanted : float
        The target error, of the first kind [-].
    orders : dict of str to dict of str to float
        Measured order [-], by line (a method, or a method on another mesh or with another film) and kind of error; NaN
        if too few errors exceed the lower bound clearly, which is at least the finest one for another film.
    best : dict of str to Best or None
        By kind of cost; None if no method reaches the target error.
    shift : float
        Standard deviation of the perturbation of each coordinate of a start [m].
    reference_softening : float or None
        Softening of the film of the reference [-]; None: as it is.
    stopped_starts : str
        A warning of perturbed starts that the monitor stopped, with the first reason; empty where it stopped none.
    left_out : dict of str to str
        Methods that cannot run the scene, and why.

    Examples
    --------
    >>> from membrane_rs import scenes
    >>> from membrane_rs.study import work_precision
    >>> scene = scenes.load("spinning-tether")
    >>> found = work_precision(scene, ["leapfrog"], until=0.005, steps=2, instants=2, repeats=1)
    >>> [point.is_stable for point in found.points_of("leapfrog")]
    [False, False, True, True]
    >>> found.summary().splitlines()[0], found.best["evaluations"].integrator, found.as_dict()["reference"]
    ('spinning-tether, 0.005 s, 2 samples', 'leapfrog', 'rk4')
    >>> found.save("chart")
    """

    scene: str
    until: float
    instants: int
    members: int
    points: tuple[Point, ...]
    labels: dict[str, str]
    reference_dt: float
    reference_density: float
    reference_errors: dict[str, float]
    floors: dict[str, float]
    wanted: float
    orders: dict[str, dict[str, float]]
    best: dict[str, Best | None]
    shift: float = SHIFT
    reference_softening: float | None = None
    stopped_starts: str = ""
    left_out: dict[str, str] = field(default_factory=dict)

    def points_of(self, line: str) -> list[Point]:
        """The points of one line.

        Parameters
        ----------
        line : str
            A method, or a method on another mesh or with another film, as `orders` has them.

        Returns
        -------
        list of Point
            Coarsest first.
        """
        return [point for point in self.points if point.line == line]

    def summary(self) -> str:
        """The result as text.

        Returns
        -------
        str
            Several lines.
        """
        lines = [f"{self.scene}, {self.until:g} s, {self.instants} samples"]
        for name, label in self.labels.items():
            lines.append(f"{label}:")
            lines.append(
                f"  reference: {self._reference} at {self.reference_dt:.3g} s, "
                f"{self.reference_errors[name]:.1e} from itself at twice that step"
            )
            if self.members:
                spread = f"  spread of {self.members} starts perturbed by {self.shift:g} m: {self.floors[name]:.1e}"
                lines.append(spread + ("; smaller errors are indistinguishable" if name in CURVES else ""))
            for line, orders in self.orders.items():
                found = [self._described(line, orders[name]), *self._levelled(line, name)]
                lines.append(f"  {line}: {', '.join(found)}")
        lines += [f"Left out: {name}. {reason}" for name, reason in self.left_out.items()]
        lines += [f"Warning: {self.stopped_starts}"] if self.stopped_starts else []
        first = next(iter(self.labels))
        for cost, best in self.best.items():
            what = f"{COSTS[cost].lower()} for an error of {self.wanted:g} ({first})"
            lines.append(
                f"Least {what}: {best.words()}, {best.cost:.3g}"
                if best
                else f"Least {what}: no method reaches it below its limit"
            )
        bound = self._bounds[first]
        if self.wanted < bound:
            lines.append(f"An error of {self.wanted:g} is below the lower bound of {bound:.1e}.")
            by_line = {line: self.points_of(line) for line in self.orders}
            for cost, words in COSTS.items():
                best = cheapest(by_line, first, bound, cost)
                lines += [f"Least {words.lower()} within the bound: {best.words()}, {best.cost:.3g}"] if best else []
        if self._has_other_films:
            lines.append(
                "Errors of softened films are against the film as it is: what softening changes is a floor of them, "
                "which no step lessens."
            )
        elif self.reference_softening is not None:
            lines.append(
                f"The reference has the film softened by {self.reference_softening:g} too: errors are of the steps, "
                "without what softening changes."
            )
        return "\n".join(lines)

    @property
    def _bounds(self) -> dict[str, float]:
        return error_bounds(self.reference_errors, self.floors, curves=next(iter(self.labels)) in CURVES)

    @property
    def _reference(self) -> str:
        """The line of the reference."""
        return line_name(REFERENCE, self.reference_density, self.reference_softening)

    @property
    def _has_other_films(self) -> bool:
        return any(point.softening != self.reference_softening for point in self.points)

    def _levelled(self, line: str, name: str) -> list[str]:
        """Where the errors of a film other than the reference's end, as text."""
        points = self.points_of(line)
        error, has_levelled = finest_errors(points, name)
        if points[0].softening == self.reference_softening or not math.isfinite(error):
            return []
        if name in CURVES and error <= self._bounds[name]:
            return [f"ends within the bounds, at {error:.1e}"]
        return [f"levels out at {error:.1e}" if has_levelled else f"ends at {error:.1e}"]

    def _described(self, line: str, order: float) -> str:
        """A line as text: its order, and the number of runs stopped or left out."""
        points = self.points_of(line)
        stopped = [p for p in points if p.failed_at is not None]
        dear = [p for p in points if p.failure is not None and p.failed_at is None]
        why = "no order, too few errors depend on the step and exceed the bounds"
        words = [f"measured order {order:.2f}" if math.isfinite(order) else why]
        words += [f"{len(stopped)} of {len(points)} runs stopped by the monitor"] if stopped else []
        words += [f"{len(dear)} of {len(points)} runs left out as too costly"] if dear else []
        return ", ".join(words)

    def save(self, folder: Path | str) -> None:
        """Write chart.csv, chart.json and chart.png into a folder.

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
        with replacing(folder / "chart.csv") as part, part.open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            names = ["integrator", "density", "softening", "dt", "share_of_limit", "tolerance", "steps", "rejected"]
            names += ["evaluations", "seconds"]
            writer.writerow([*names, *(f"{name}_error" for name in self.labels), "failed_at", "failure"])
            for p in self.points:
                row = [p.integrator, p.density, p.softening, p.dt, p.share, p.tolerance, p.steps, p.rejected]
                row += [p.evaluations, p.seconds]
                writer.writerow([*row, *p.errors.values(), p.failed_at, p.failure])
            between = [None] * (len(names) - 1 + len(self.labels) + 1)
            writer.writerows([name, *between, reason] for name, reason in self.left_out.items())
        write_summary(folder / "chart.json", self.as_dict())
        plot_work_precision(self._rows(), folder / "chart.png", f"{self.scene}, first {1e3 * self.until:g} ms")

    def as_dict(self) -> dict[str, Any]:
        """All data as plain numbers and texts, as chart.json holds them.

        Returns
        -------
        dict of str to object
            By the names of the attributes.
        """
        plain = {name: value for name, value in vars(self).items() if name not in ("points", "best")}
        best = {cost: vars(found) if found else None for cost, found in self.best.items()}
        reference = {"reference": REFERENCE, "points": [vars(point) for point in self.points]}
        return {**plain, "best": best, **reference, "versions": versions()}

    def _rows(self) -> list[Row]:
        return [
            Row(
                label,
                [self._line(line, name) for line in self.orders],
                self.reference_errors[name],
                self.floors[name],
                self.wanted if name == next(iter(self.labels)) else math.nan,
            )
            for name, label in self.labels.items()
        ]

    def _line(self, line: str, name: str) -> Line:
        """A line's points; a stopped run is drawn at its extrapolated cost."""
        points = self.points_of(line)
        done = [p for p in points if p.failure is None]
        costs = {cost: np.array([float(getattr(p, cost)) for p in points]) for cost in COSTS}
        for k, p in enumerate(points):
            for cost in COSTS:
                per_step = median(getattr(q, cost) / q.steps for q in done) if done else math.nan
                if p.failure is not None:
                    costs[cost][k] = per_step * self.until / p.dt if p.failed_at is not None else math.nan
        order = self.orders[line][name]
        label = f"{line}: order {order:.1f}" if math.isfinite(order) else ": ".join([line, *self._levelled(line, name)])
        errors = np.array([p.errors[name] for p in points])
        return Line(label, costs, errors, np.array([not p.is_stable for p in points]))


def error_bounds(reference: dict[str, float], floors: dict[str, float], *, curves: bool) -> dict[str, float]:
    """Lower bounds of meaningful errors: the reference's own error, and for curves the spread of perturbed starts.

    Pointwise all runs have the same start to the last bit, so the spread is no bound.
    """
    return {name: float(np.fmax(value, floors[name] if curves else 0.0)) for name, value in reference.items()}
