"""Where a scene runs well: a map of step against one of its parameters, for each method.

Every cell is a run of its own, to its end or to where the watch stops it. Steps are shares of the limit that is
predicted for the scene as given; the limit of each changed scene is drawn across them as a line.
"""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from membrane_rs._files import output_errors, write_text
from membrane_rs.errors import InputError, UnstableError
from membrane_rs.plotting.stability_map import draw_map
from membrane_rs.runs import Simulation
from membrane_rs.scene import Scene
from membrane_rs.simulation import integrators
from membrane_rs.study.common.variation import varied

OUTCOMES = ("fine", "inaccurate", "energy injected", "blown up", "refused")
"""Refused: before the run, with words. Energy injected and blown up: stopped by the watch, at a known time."""
ACCURATE = 0.01
"""Energy error up to which a run counts as fine."""
SHARES = (0.25, 0.5, 0.75, 0.95, 1.05, 1.5)
WATCH = 10
SAMPLES = 41


@dataclass(frozen=True)
class Cell:
    """One run: what was asked, and how it ended."""

    integrator: str
    value: float
    dt: float
    limit: float
    """Predicted limit of the step for this value [s]."""
    outcome: str
    time: float
    """When it was caught, or the end [s]."""
    energy_error: float
    """The largest in size, of the energy turned over; NaN where it was not reached."""
    words: str
    """Of the error; empty where there was none."""


class _Worst:
    """Watches the energy error of a run."""

    def __init__(self) -> None:
        self.error = 0.0

    def start(self, sim: Simulation) -> None:
        pass

    frame = start

    def sample(self, sim: Simulation) -> None:
        self.error = max(self.error, sim.ledger()["error"], key=abs)

    def finish(self, sim: Simulation, error: BaseException | None) -> None:
        pass


def explicit_integrators(scene: Scene) -> list[str]:
    """The methods whose step the scene limits."""
    return [name for name in integrators() if math.isfinite(Simulation(scene, name).stable_dt())]


def stability_map(
    scene: Scene,
    parameter: str,
    values: Sequence[float],
    *,
    methods: Sequence[str],
    shares: Sequence[float] = SHARES,
    until: float | None = None,
    accurate: float = ACCURATE,
    progress: Callable[[Cell], None] | None = None,
) -> list[Cell]:
    """Run the scene for every value of `parameter`, step and method.

    Parameters
    ----------
    scene : Scene
    parameter : str
        Its name in the scene file, such as laws.spring_damping.ratio; see `varied`.
    values : sequence of float
        What it takes.
    methods : sequence of str
        Names of the methods.
    shares : sequence of float
        Steps, as shares of the limit predicted for `scene` under each method.
    until : float, optional
        End of each run [s]. Default: the scene's.
    accurate : float
        Energy error up to which a run counts as fine.
    progress : callable, optional
        Called with each cell.

    Raises
    ------
    InputError
        Nothing to run, a parameter or value that the scene does not take, a method without a limit.
    """
    if not values or not shares or not methods or min(shares) <= 0:
        raise InputError("stability map: give at least one value, one method and one step above 0")
    end = scene.run.until if until is None else until
    settings = replace(scene.run, until=end, dt=None, watch=WATCH, energy_loss=1e9, snapshots=(), samples=SAMPLES)
    base = replace(scene, run=settings)
    cells: list[Cell] = []
    for integrator in methods:
        limit = Simulation(base, integrator).stable_dt()
        if limit == math.inf:
            raise InputError(f"integrator {integrator}: has no stability limit to take shares of; leave it out")
        for value in values:
            changed = varied(base, parameter, value)
            for share in shares:
                cells.append(_run(changed, integrator, value, min(share * limit, end), accurate))
                if progress is not None:
                    progress(cells[-1])
    return cells


def _run(scene: Scene, integrator: str, value: float, dt: float, accurate: float) -> Cell:
    worst = _Worst()
    limit = float("nan")
    try:
        limit = Simulation(scene, integrator).stable_dt()
        sim = Simulation(scene, integrator, dt)
        sim.run(observers=[worst], frames=2)
    except InputError as error:
        return Cell(integrator, value, dt, limit, "refused", 0.0, float("nan"), str(error))
    except UnstableError as error:
        outcome = "energy injected" if "from nowhere" in str(error) else "blown up"
        return Cell(integrator, value, dt, limit, outcome, error.time, worst.error, str(error))
    outcome = "fine" if abs(worst.error) <= accurate else "inaccurate"
    return Cell(integrator, value, dt, limit, outcome, sim.time, worst.error, "")


def write_map(cells: Sequence[Cell], parameter: str, folder: Path, title: str = "") -> list[Path]:
    """Write stability.csv and one picture for each method; the paths written.

    Raises OutputError where that fails.
    """
    with output_errors(folder):
        folder.mkdir(parents=True, exist_ok=True)
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(["integrator", parameter, "dt", "predicted_limit", "outcome", "time", "energy_error", "words"])
    for c in cells:
        numbers = [f"{x:.9g}" for x in (c.value, c.dt, c.limit)]
        words = re.sub(r"\s+", " ", c.words)
        table.writerow([c.integrator, *numbers, c.outcome, f"{c.time:.6g}", f"{c.energy_error:.4g}", words])
    paths = [folder / "stability.csv"]
    write_text(paths[0], text.getvalue())
    for name in dict.fromkeys(cell.integrator for cell in cells):
        paths.append(folder / f"stability-{name}.png")
        rows = [cell for cell in cells if cell.integrator == name]
        columns = [(c.value, c.dt, c.limit, c.outcome, c.time) for c in rows]
        draw_map(columns, OUTCOMES, paths[-1], parameter, f"{title}  {name}".strip())
    return paths
