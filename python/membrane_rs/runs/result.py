"""A run as it is read: its history, frames and summary, from memory or from its folder."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from membrane_rs._html import Card, HasCard, in_a_line
from membrane_rs._known_attributes import KnownAttributes
from membrane_rs.mesh import Mesh
from membrane_rs.results.run_history import RunHistory
from membrane_rs.runs.frames import RunFrames
from membrane_rs.runs.tables import to_pandas, to_xarray
from membrane_rs.scene import Scene
from membrane_rs.scene.card import lines_of

if TYPE_CHECKING:
    from pandas import DataFrame
    from xarray import Dataset

    from membrane_rs.plotting.viewer import NotebookView


class Run(HasCard, KnownAttributes):
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

    Examples
    --------
    >>> import membrane_rs
    >>> made = membrane_rs.run("spinning-tether", until=0.02, samples=3, frames=2)
    >>> made
    Run('spinning-tether', finished: 3 samples, 2 frames)
    >>> made.history["time"].tolist(), made.history.units["hub_torque"]
    ([0.0, 0.01, 0.02], 'N m')
    >>> made.frames[-1].time, made.frames.near(0.001).time, made.summary["outcome"]
    (0.02, 0.0, 'finished')
    >>> made.view(where="picture")
    <view of spinning-tether at 0.000 s, coloured by film>
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
        """Look at it, in a window or in a notebook, as `membrane_rs.view` does.

        Parameters
        ----------
        color : str
            "film", or a field that the run has, such as "speed".
        camera : {"turning", "fixed"}
            Whether the camera turns with the hub.
        scale : {"run", "frame"}
            Whether the colours span the values of the whole run, or of each frame.
        time : float, optional
            Of the frame that is shown first, the nearest one [s]. Default: the first.
        where : {"window", "notebook", "browser", "picture"}, optional
            Default: a notebook where Python runs in one, else a window.

        Returns
        -------
        NotebookView or None
            What a notebook shows; None once a window is closed.

        Raises
        ------
        InputError
            A word that is none of those, a field that the run lacks, or a run without frames.
        InputTypeError
            A time that is no number.
        DisplayError
            A window where there is no display.
        MissingExtraError
            pyvista or matplotlib is not installed.
        """
        from membrane_rs.plotting.viewer import look_at

        return look_at(self, color=color, camera=camera, scale=scale, time=time, where=where)

    def to_pandas(self) -> DataFrame:
        """The history as a `pandas.DataFrame`, by the time [s]; the units are in its `attrs`.

        Returns
        -------
        pandas.DataFrame
            A row for each sample, a column for each of the history but the time.

        Raises
        ------
        MissingExtraError
            pandas is not installed.

        Examples
        --------
        >>> import membrane_rs
        >>> table = membrane_rs.run("spinning-tether", until=0.01, samples=3, frames=2).to_pandas()
        >>> table.index.tolist(), table.attrs["units"]["kinetic_energy"]
        ([0.0, 0.005, 0.01], 'J')
        """
        return to_pandas(self)

    def to_xarray(self, frames: bool = True) -> Dataset:
        """The history and the positions of the frames as an `xarray.Dataset`, with units.

        Parameters
        ----------
        frames : bool
            Take the positions of all frames, as "positions" over "frame_time", "node" and "axis" ("x", "y", "z").

        Returns
        -------
        xarray.Dataset
            Columns of the history over "time" [s], and what the frames add.

        Raises
        ------
        InputError
            Frames of more than 4 GB, or a recorded measure with the name of one of their variables.
        MissingExtraError
            xarray is not installed.

        Examples
        --------
        >>> import membrane_rs
        >>> data = membrane_rs.run("spinning-tether", until=0.01, samples=3, frames=2).to_xarray()
        >>> dict(data.sizes), data["positions"].attrs["units"]
        ({'time': 3, 'frame_time': 2, 'node': 11, 'axis': 3}, 'm')
        """
        return to_xarray(self, frames=frames)

    def _card(self) -> Card:
        """What notebooks show: the last frame."""
        summary, history = self.summary, self.history
        times, balance = history["time"], summary.get("energy_balance")
        error = balance.get("error") if isinstance(balance, dict) else None
        rows: list[tuple[str, object]] = [
            ("outcome", self.outcome),
            *([("time [s]", f"{times[0]:.6g} to {times[-1]:.6g}")] if len(times) else []),
            ("samples", history.sample_count),
            ("columns", len(history)),
            ("frames", len(self.frames)),
            ("method", summary.get("integrator", "")),
            ("steps", summary.get("steps", "")),
            *([("energy error [%]", f"{100.0 * error:.3g}")] if isinstance(error, float) else []),
            *([] if self.path is None else [("folder", self.path)]),
        ]
        lines = lines_of(self.mesh, self.scene.assemble(), self.frames[-1].positions) if len(self.frames) else None
        return Card(f"Run of {self.scene.name}", rows, lines)

    def __repr__(self) -> str:
        """Scene, outcome and sizes."""
        where = "" if self.path is None else f", in {in_a_line(self.path)}"
        size = f"{self.history.sample_count} samples, {len(self.frames)} frames"
        return f"Run({self.scene.name!r}, {in_a_line(self.outcome)}: {size}{where})"
