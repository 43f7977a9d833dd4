"""What a killed process leaves of a run: copies of its folder while it goes on."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

from child_processes import wait_until
from membrane_rs import Simulation
from membrane_rs.runs import RunFolder

RUN: dict[str, Any] = {"until": 0.02, "frames": 9, "samples": 41, "pictures": False, "checkpoint": 0.0}


class Copies:
    """An observer behind a run's folder that copies it at each frame, when what was begun before is written."""

    def __init__(self, results: RunFolder) -> None:
        self._results, self._count = results, 0

    def start(self, sim: Simulation) -> None: ...

    def sample(self, sim: Simulation) -> None: ...

    def frame(self, sim: Simulation) -> None:
        wait_until(lambda: self._results._record.background.is_idle, "what was begun is written")
        shutil.copytree(self._results.path, self._results.path.with_name(f"left-{self._count}"))
        self._count += 1

    def finish(self, sim: Simulation, error: BaseException | None) -> None: ...


def run_copied(sim: Simulation, path: Path, *, pictures: bool = False, **changes: Any) -> None:
    """Run into `path`, and leave a copy of it at each frame."""
    results = RunFolder(path, pictures=pictures)
    sim.run(**RUN | changes, observers=[results, Copies(results)])


def contents(folder: Path) -> dict[str, bytes]:
    """The bytes of all files of a run but its summary, which holds times of the clock."""
    files = (file for file in folder.rglob("*") if file.is_file() and file.name != "summary.json")
    return {str(file.relative_to(folder)): file.read_bytes() for file in files}
