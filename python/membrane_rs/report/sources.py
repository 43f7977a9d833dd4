"""What a page is made of: runs by their labels, and measured curves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from membrane_rs.plotting.style import COLORS
from membrane_rs.results.experiment import Experiment

if TYPE_CHECKING:
    from membrane_rs.runs import Run

*RUN_COLORS, BLACK = COLORS
"""Of runs; and of means and experiments."""


@dataclass(frozen=True)
class LabelledRun:
    """A run, by what the page calls it."""

    run: Run
    label: str
    number: int

    @property
    def key(self) -> str:
        """The name of what belongs to it in the page."""
        return f"run-{self.number}"

    @property
    def color(self) -> str:
        """Of its curves."""
        return RUN_COLORS[self.number % len(RUN_COLORS)]


@dataclass(frozen=True)
class Sources:
    """Runs and experiments of a page.

    Attributes
    ----------
    runs : sequence of LabelledRun
        One or more.
    experiments : sequence of Experiment
        In the units of the histories.
    ensemble : bool
        Whether the curves of the runs are drawn as their mean and spread.
    """

    runs: Sequence[LabelledRun]
    experiments: Sequence[Experiment]
    ensemble: bool = False

    def key_of(self, experiment: int) -> str:
        """The name of what belongs to an experiment in the page, by its number."""
        return f"data-{experiment}"

    def unknown(self, experiment: Experiment) -> list[str]:
        """Columns of an experiment that no run has."""
        return [name for name in experiment.columns if not any(name in one.run.history for one in self.runs)]


def labelled(runs: Sequence[Run]) -> list[LabelledRun]:
    """Runs by the names of their folders, or of their scenes; several of one name are numbered."""
    names = [run.scene.name if run.path is None else run.path.resolve().name for run in runs]
    found = []
    for k, (run, name) in enumerate(zip(runs, names, strict=True)):
        label = f"{name} ({names[: k + 1].count(name)})" if names.count(name) > 1 else name
        found.append(LabelledRun(run, label, k))
    return found
