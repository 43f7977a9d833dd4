"""Stability map: outcomes of runs over step and one parameter of a scene, for each method.

Every cell is a run, to its end or until the monitor stops it. Steps are multiples of the limit predicted for the scene
as given; the predicted limit of each changed scene is drawn as a line.
"""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from threading import Event

from membrane_rs._files import made_folder, write_text
from membrane_rs._validation import show
from membrane_rs.errors import InputError, UnstableError
from membrane_rs.plotting.stability_map import draw_map
from membrane_rs.runs import Simulation
from membrane_rs.scene import Scene
from membrane_rs.simulation import integrators
from membrane_rs.study.common.executor import run_parallel
from membrane_rs.study.common.methods import methods_of
from membrane_rs.study.common.stages import refuse_stages

OUTCOMES = ("fine", "inaccurate", "energy injected", "blown up", "refused")
"""Refused: before the run, with a reason. Energy injected and blown up: stopped by the monitor at a known time."""
ENERGY_GAIN = "spurious gain"
"""Words of the monitor's error by which an energy gain is known."""
ACCURATE = 0.01
"""Energy error up to which a run counts as fine."""
SHARES = (0.25, 0.5, 0.75, 0.95, 1.05, 1.5)
WATCH = 10
SAMPLES = 41


@dataclass(frozen=True)
class Cell:
    """One run: parameter, step and outcome."""

    integrator: str
    value: float
    dt: float
    limit: float
    """Predicted limit of the step for this value [s]."""
    outcome: str
    time: float
    """Time at which the monitor stopped it, or the end [s]."""
    energy_error: float
    """The energy error of the largest magnitude; NaN for a run that was refused."""
    message: str
    """Message of the error; empty without one."""


class _WorstError:
    """Observer of the largest energy error of a run."""

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
    """The methods with a stability limit in this scene, those that cannot run it among them."""
    _, left_out = methods_of(scene, integrators())
    return [
        name
        for name, facts in integrators().items()
        if math.isfinite(facts.imaginary_limit if name in left_out else Simulation(scene, name).stable_dt())
    ]


def stability_map(
    scene: Scene,
    parameter: str,
    values: Sequence[float],
    *,
    methods: Sequence[str],
    shares: Sequence[float] = SHARES,
    until: float | None = None,
    accurate: float = ACCURATE,
    jobs: int | None = None,
    progress: Callable[[Cell], None] | None = None,
) -> list[Cell]:
    """Run the scene for every value of `parameter`, step and method.

    Parameters
    ----------
    scene : Scene
    parameter : str
        Name of the parameter in the scene file, such as laws.spring_damping.ratio; see `Scene.with_values`.
    values : sequence of float
        Its values.
    methods : sequence of str
        Names of the methods. One that cannot run the scene has a refused cell for each value, without a step.
    shares : sequence of float
        Steps, in multiples of the limit predicted for `scene` under each method.
    until : float, optional
        End of each run [s]. Default: the scene's.
    accurate : float
        Energy error up to which a run counts as fine.
    jobs : int, optional
        Runs at a time. Default: one for each core. Cells do not depend on it.
    progress : callable, optional
        Called with each cell, as its run ends.

    Raises
    ------
    InputError
        No values, methods or steps, a parameter or value that the scene does not accept, a method without a limit, none
        that can run the scene.
    """
    refuse_stages(scene)
    for name, given in (("values", values), ("methods", methods), ("steps", shares)):
        if not len(given):
            raise InputError(f"stability map: {name} = {show(given)}: give at least one")
    if not min(shares) > 0.0:
        raise InputError(f"stability map: steps = {show(list(shares))}: must be above 0 (of the stability limit)")
    end = scene.run.until if until is None else until
    settings = replace(scene.run, until=end, dt=None, watch=WATCH, energy_loss=1e9, snapshots=(), samples=SAMPLES)
    base = replace(scene, run=settings)
    methods, left_out = methods_of(base, methods)
    wanted: list[tuple[Scene, str, float, float]] = []
    for integrator in methods:
        limit = Simulation(base, integrator).stable_dt()
        if limit == math.inf:
            raise InputError(f"integrator {integrator}: has no stability limit; leave it out")
        for value in values:
            changed = base.with_values({parameter: value})
            wanted += [(changed, integrator, value, min(share * limit, end)) for share in shares]
    stop, nan = Event(), math.nan
    refused = [
        Cell(name, value, nan, nan, "refused", 0.0, nan, why) for name, why in left_out.items() for value in values
    ]
    if progress is not None:
        for cell in refused:
            progress(cell)
    return refused + run_parallel(
        [lambda one=one: _run(one, accurate, stop) for one in wanted],  # type: ignore[misc]
        [f"{integrator}, {parameter} = {value}" for _, integrator, value, _ in wanted],
        stop,
        workers=jobs,
        each=progress,
    )


def _run(case: tuple[Scene, str, float, float], accurate: float, stop: Event) -> Cell:
    """A cell, of a scene, a method, the parameter's value and a step [s]. Raises KeyboardInterrupt at `stop`."""
    scene, integrator, value, dt = case

    def watch(_: Simulation) -> None:
        if stop.is_set():
            raise KeyboardInterrupt

    worst = _WorstError()
    limit = float("nan")
    try:
        limit = Simulation(scene, integrator).stable_dt()
        sim = Simulation(scene, integrator, dt)
        sim.run(observers=[worst], frames=2, progress=watch)
    except InputError as error:
        return Cell(integrator, value, dt, limit, "refused", 0.0, float("nan"), str(error))
    except UnstableError as error:
        outcome = "energy injected" if ENERGY_GAIN in str(error) else "blown up"
        return Cell(integrator, value, dt, limit, outcome, error.time, worst.error, str(error))
    outcome = "fine" if abs(worst.error) <= accurate else "inaccurate"
    return Cell(integrator, value, dt, limit, outcome, sim.time, worst.error, "")


def write_map(cells: Sequence[Cell], parameter: str, folder: Path, title: str = "") -> list[Path]:
    """Write stability.csv and one picture for each method; the paths written.

    Raises OutputError where that fails.
    """
    folder = made_folder(folder)
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(["integrator", parameter, "dt", "predicted_limit", "outcome", "time", "energy_error", "message"])
    for c in cells:
        numbers = [f"{x:.9g}" for x in (c.value, c.dt, c.limit)]
        message = re.sub(r"\s+", " ", c.message)
        table.writerow([c.integrator, *numbers, c.outcome, f"{c.time:.6g}", f"{c.energy_error:.4g}", message])
    paths = [folder / "stability.csv"]
    write_text(paths[0], text.getvalue())
    for name in dict.fromkeys(cell.integrator for cell in cells if math.isfinite(cell.dt)):
        paths.append(folder / f"stability-{name}.png")
        rows = [cell for cell in cells if cell.integrator == name]
        columns = [(c.value, c.dt, c.limit, c.outcome, c.time) for c in rows]
        draw_map(columns, OUTCOMES, paths[-1], parameter, f"{title}  {name}".strip())
    return paths
