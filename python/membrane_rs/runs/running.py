"""A scene is run, and what it has shown is given back."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path

from membrane_rs import scenes
from membrane_rs.errors import Interrupted, MembraneError
from membrane_rs.results.recorded import Recorded
from membrane_rs.runs.memory import RunMemory
from membrane_rs.runs.opening import open_run
from membrane_rs.runs.request import CHECKPOINT
from membrane_rs.runs.result import Run
from membrane_rs.runs.simulation import Simulation
from membrane_rs.scene import Scene
from membrane_rs.simulation.motion import Motion
from membrane_rs.simulation.observer import Observer
from membrane_rs.simulation.stopping import StopWhen


def run(
    scene: Scene | str | Path,
    until: float | None = None,
    *,
    integrator: str | None = None,
    dt: float | None = None,
    start: Motion | str | Path | None = None,
    record: Recorded | None = None,
    every: float | None = None,
    samples: int | Sequence[float] | None = None,
    frames: int | Sequence[float] | None = None,
    stop_when: StopWhen | None = None,
    out: str | Path | None = None,
    overwrite: bool = False,
    pictures: bool = True,
    crossings: bool = False,
    checkpoint: float = CHECKPOINT,
    observers: Sequence[Observer[Simulation]] = (),
    progress: Callable[[Simulation], None] | None = None,
) -> Run:
    """Run a scene, and give back its history, frames and summary."""
    sim = Simulation(scenes.scene_of(scene), integrator, dt, start=start)
    memory = RunMemory() if out is None else None
    try:
        sim.run(
            until,
            frames,
            out,
            samples=samples,
            record=record,
            every=every,
            stop_when=stop_when,
            observers=[*observers, *([] if memory is None else [memory])],
            progress=progress,
            overwrite=overwrite,
            pictures=pictures,
            crossings=crossings,
            checkpoint=checkpoint,
        )
    except BaseException as error:
        _keep(error, memory, out)
        raise
    result = memory.result() if memory is not None else open_run(str(out))
    assert result is not None, "a run that has ended without an error has a result"
    return result


def _keep(error: BaseException, memory: RunMemory | None, out: str | Path | None) -> None:
    """Give an error what the run had recorded by then."""
    with suppress(MembraneError):  # the run's own error is the one to tell
        found = memory.result() if memory is not None else out and open_run(out)
        if found is not None and isinstance(error, MembraneError | Interrupted):
            error.run = found
