"""A run as it is read: its history, frames and summary, from memory or from its folder."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from membrane_rs._known_attributes import KnownAttributes
from membrane_rs.mesh import Mesh
from membrane_rs.results.run_history import RunHistory
from membrane_rs.runs.frames import RunFrames
from membrane_rs.scene import Scene

if TYPE_CHECKING:
    from membrane_rs.plotting.viewer import NotebookView


class Run(KnownAttributes):
    """What a run has shown. `membrane_rs.run` gives it, and `membrane_rs.open_run` that of a folder.

    Attributes
    ----------
    scene : Scene
        What was run, all values resolved.
    history : RunHistory
        A mapping from the names of columns to (samples,) arrays, with their `units`; the columns are those of
        history.csv, and the measures that were recorded.
    frames : RunFrames
        A sequence of `RunFrame`, with their `times` [s]; those of a folder are read one at a time.
    summary : dict
        What summary.json says: see `membrane_rs.results.summary`.
    path : Path or None
        The folder; None for a run in memory alone.
    """

    ONCE = ("scene", "history", "frames", "summary", "path")
    INSTEAD = "run the scene again"

    def __init__(
        self, scene: Scene, history: RunHistory, frames: RunFrames, summary: dict[str, Any], path: Path | None = None
    ) -> None:
        self.scene = scene
        self.history = history
        self.frames = frames
        self.summary = summary
        self.path = path

    @property
    def mesh(self) -> Mesh | None:
        """The membrane; None for a scene of cords alone."""
        return self.scene.mesh

    @property
    def outcome(self) -> str:
        """What ended the run: "finished", "interrupted", "unstable: ..." or "failed: ..."; of a folder also "running",
        or "killed" where no process goes on with it.
        """
        return str(self.summary["outcome"])

    @property
    def stages(self) -> list[Mapping[str, Any]]:
        """What the summary says of each stage that was reached, `StageRecord` and curves; empty without stages, and for
        a run that has not come to its end.
        """
        return list(self.summary.get("stages") or [])

    def view(
        self,
        *,
        color: str = "film",
        camera: str = "turning",
        scale: str = "run",
        time: float | None = None,
        where: str | None = None,
    ) -> NotebookView | None:
        """Look at it, in a window or in a notebook: see `membrane_rs.view`."""
        from membrane_rs.plotting.viewer import look_at

        return look_at(self, color=color, camera=camera, scale=scale, time=time, where=where)

    def __repr__(self) -> str:
        """Scene, outcome and sizes."""
        where = "" if self.path is None else f", in {self.path}"
        size = f"{self.history.sample_count} samples, {len(self.frames)} frames"
        return f"Run({self.scene.name!r}, {self.outcome}: {size}{where})"
