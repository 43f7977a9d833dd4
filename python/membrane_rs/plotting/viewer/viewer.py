"""What is shown of a run, without a window: which frame, coloured by what, seen in which frame of reference."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from difflib import get_close_matches

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs._validation import number_of, show
from membrane_rs.analysis.attitude import Turn, turned
from membrane_rs.errors import InputError, OutputError
from membrane_rs.plotting.actors import film_colors
from membrane_rs.plotting.camera import Camera
from membrane_rs.plotting.drawing import decimals
from membrane_rs.plotting.fields import BARE, FIELDS, SHARE, Field, fields_of, value_ranges
from membrane_rs.plotting.picture import FARTHEST, Subject, is_drawable
from membrane_rs.plotting.scenery import BodiesInTime, reach_of, stage_at
from membrane_rs.plotting.viewer.coloring import Scale
from membrane_rs.plotting.viewer.frames import KeptFrames
from membrane_rs.plotting.viewer.shown import Shown
from membrane_rs.plotting.viewer.source import ViewedRun, stages_of

FILM = "film"
"""Instead of a field: the film in the colours of its petals, as in snapshots."""
TURNING, FIXED = "turning", "fixed"
RUN, FRAME = "run", "frame"
FOR_CAMERA, FOR_RANGE = 5, 24
"""Frames that are read for the camera, at once, and for the ranges of colours, once a field is chosen."""
BETWEEN = 1.05
"""Frames between those that are read for the camera may be larger by this factor."""
PLAY_SECONDS, FRAMES_A_SECOND = (4.0, 20.0), 20.0
"""A run is played in this time at the speed of 1: by so many frames a second, within these bounds."""
SPEEDS = (0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0)


class Viewer:
    """What is shown of a run, and what a user can change of it.

    Parameters
    ----------
    run : ViewedRun
        With one frame or more.
    color : str
        "film", or the name of one of the fields of the run.
    camera : {"turning", "fixed"}
        Whether the camera turns with the hub.
    scale : {"run", "frame"}
        Whether the colours span the values of the whole run, or of each frame.

    Raises
    ------
    InputError
        The run has no frames, or no such field.
    OutputError
        No frame of it can be drawn.

    Examples
    --------
    >>> import membrane_rs
    >>> from membrane_rs.plotting.viewer import Viewer
    >>> viewer = Viewer(membrane_rs.run("hanging-strip", until=0.02, frames=3), color="speed")
    >>> viewer.go_to(0.011)
    >>> viewer.step(-1)
    >>> viewer.time, viewer.words(), viewer.shown().positions.shape
    (0.0, '0.000 s', (66, 3))
    >>> viewer.show_frame(2)
    >>> viewer.toggle_play()
    >>> viewer.faster(1)
    >>> viewer.advance(0.5), viewer.is_playing, viewer.speed
    (False, True, 2.0)
    >>> viewer.choose("film")
    >>> viewer.next_color()
    >>> viewer.toggle_scale()
    >>> viewer.toggle_frame()
    >>> viewer.scale() is None, viewer.camera().reach >= viewer.closer().reach
    (False, True)
    """

    def __init__(self, run: ViewedRun, color: str = FILM, camera: str = TURNING, scale: str = RUN) -> None:
        if not len(run.frames):
            raise InputError(
                f"the run of {run.scene.name!r} has no frames to show; run it again with frames=41, or more"
            )
        self.name, self.times = run.scene.name, np.asarray(run.frames.times, dtype=np.float64)
        scene, self._frames, self._stages = run.scene, KeptFrames(run.frames), stages_of(run)
        some = [self._frames[k] for k in self._frames.spread(FOR_CAMERA)]
        some = [frame for frame in some if is_drawable(frame.positions)]
        if not some:
            raise OutputError(
                f"no frame of the run of {self.name!r} can be drawn: their positions are not finite, or beyond "
                f"{FARTHEST:g} m; run the scene again"
            )
        shapes = [frame.positions for frame in some]
        assembly = (scene.staged(0) if scene.stages else scene).assemble()
        self.subject = Subject.of_scene(scene, assembly, shapes)
        self._bodies = BodiesInTime.of_scene(scene, self._stages, shapes[0])
        if self.subject.has_hub:  # not the flat shape that a run may never come to
            solids = [self._bodies.at(frame.time) for frame in some]
            reach = max(reach_of(*pair) for pair in zip(shapes, solids, strict=True)) or 1.0
            self.subject = replace(self.subject, camera=replace(self.subject.camera, reach=BETWEEN * reach))
        found = {field.name: field for frame in some for field in fields_of(frame)}
        self.fields: list[Field | None] = [None, *found.values()]
        self._ranges: dict[str, tuple[float, float]] = {}
        self._digits = decimals(list(self.times), 3)
        self.index, self._clock, self.is_playing, self._speed = 0, float(self.times[0]), False, SPEEDS.index(1.0)
        self.field: Field | None = None
        self.choose(color)
        self.in_turning_frame = one_of("camera", camera, (TURNING, FIXED)) == TURNING
        self.spans_run = one_of("scale", scale, (RUN, FRAME)) == RUN

    # Time

    @property
    def time(self) -> float:
        """Of the frame that is shown [s]."""
        return float(self.times[self.index])

    @property
    def stage(self) -> str:
        """Name of the stage at this time; empty without stages."""
        return self._stages[stage_at(self._stages, self.time)].name if self._stages else ""

    @property
    def stage_starts(self) -> list[tuple[str, float]]:
        """Name and start [s] of each stage."""
        return [(stage.name, stage.start) for stage in self._stages]

    @property
    def speed(self) -> float:
        """How fast it is played [-]; 1: the whole run in `play_seconds`."""
        return SPEEDS[self._speed]

    @property
    def play_seconds(self) -> float:
        """In which the whole run is played at a speed of 1 [s]."""
        return float(np.clip(len(self.times) / FRAMES_A_SECOND, *PLAY_SECONDS))

    def go_to(self, time: float) -> None:
        """Show the frame nearest to a time.

        Parameters
        ----------
        time : float
            [s]

        Raises
        ------
        InputError, InputTypeError
            No finite number.
        """
        time = number_of("time", time)
        self.show_frame(int(np.abs(self.times - time).argmin()))

    def show_frame(self, index: int) -> None:
        """Show a frame by its number.

        Parameters
        ----------
        index : int
            From 0; the first or the last is shown where there is none.
        """
        self.index = min(max(index, 0), len(self.times) - 1)
        self._clock = self.time

    def step(self, frames: int) -> None:
        """Go on or back, and stop.

        Parameters
        ----------
        frames : int
            How many; below 0 back.
        """
        self.is_playing = False
        self.show_frame(self.index + frames)

    def toggle_play(self) -> None:
        """Play or pause; from the start where the end is shown."""
        self.is_playing = not self.is_playing and len(self.times) > 1
        if self.is_playing and self.index == len(self.times) - 1:
            self.show_frame(0)

    def faster(self, steps: int) -> None:
        """Play faster, or slower.

        Parameters
        ----------
        steps : int
            Each doubles the speed; below 0 halves it.
        """
        self._speed = min(max(self._speed + steps, 0), len(SPEEDS) - 1)

    def advance(self, seconds: float) -> bool:
        """Play on; it pauses at the end.

        Parameters
        ----------
        seconds : float
            Of wall time [s].

        Returns
        -------
        bool
            Whether another frame is shown.
        """
        if not self.is_playing:
            return False
        first, last = float(self.times[0]), float(self.times[-1])
        self._clock = min(last, self._clock + seconds * self.speed * (last - first) / self.play_seconds)
        before, self.index = self.index, int(np.searchsorted(self.times, self._clock, side="right")) - 1
        self.is_playing = self._clock < last
        return self.index != before

    # Colours

    @property
    def colors(self) -> list[str]:
        """Names of what the membrane can be coloured by: "film", then its fields."""
        return [field.name if field else FILM for field in self.fields]

    @property
    def labels(self) -> dict[str, str]:
        """What a menu calls them, by name."""
        return {name: field.label if field else "Film" for name, field in zip(self.colors, self.fields, strict=True)}

    @property
    def color(self) -> str:
        """What the membrane is coloured by."""
        return self.field.name if self.field else FILM

    def choose(self, color: str) -> None:
        """Colour by "film", or by a field.

        Parameters
        ----------
        color : str
            One of `colors`; or what frames call the array of a field, such as "stress_1".

        Raises
        ------
        InputError
            It is none.
        """
        color = next((name for name, field in FIELDS.items() if field.array and field.array == color), color)
        if color in FIELDS and color not in self.colors:
            raise InputError(
                f"color = {color!r}: this run has no values of it; must be one of {', '.join(self.colors)}"
            )
        self.field = self.fields[self.colors.index(one_of("color", color, self.colors))]

    def next_color(self, steps: int = 1) -> None:
        """Colour by the next one, or by one before.

        Parameters
        ----------
        steps : int
            By how many; below 0 back.
        """
        self.field = self.fields[(self.fields.index(self.field) + steps) % len(self.fields)]

    def toggle_scale(self) -> None:
        """Span the values of the whole run, or of each frame."""
        self.spans_run = not self.spans_run

    def scale(self) -> Scale | None:
        """The colours of the field at this time; None for the bare film.

        Those of the run hold the range of `FOR_RANGE` frames, 99 % of their values each; what lies beyond has the
        colour of the end.

        Returns
        -------
        Scale or None
            With `low` and `high`, in the unit of the field.
        """
        if self.field is None:
            return None
        name = self.field.name
        if not self.spans_run:
            return Scale(self.field, *self._range([self.index], self.field))
        if name not in self._ranges:
            self._ranges[name] = self._range(self._frames.spread(FOR_RANGE), self.field)
        return Scale(self.field, *self._ranges[name])

    def _range(self, indices: Sequence[int], field: Field) -> tuple[float, float]:
        """Lowest and highest value over some frames, 0 where they have none."""
        found = value_ranges((self._frames[k] for k in indices), SHARE, [field])
        return found.get(field.name, (0.0, 0.0))

    # Space

    def toggle_frame(self) -> None:
        """Let the camera turn with the hub, or stand still."""
        self.in_turning_frame = not self.in_turning_frame

    def camera(self) -> Camera:
        """That sees the whole run.

        Returns
        -------
        Camera
            In the frame of the camera.
        """
        return self.subject.camera

    def closer(self) -> Camera:
        """From the same side, that sees the shape of this time alone.

        Returns
        -------
        Camera
            As `camera`.
        """
        shown, camera = self.shown(), self.subject.camera
        points = turned(shown.positions, shown.hub_angle)
        if self.subject.has_hub:
            return replace(camera, reach=reach_of(points, shown.solids) or 1.0)
        found = Camera.of([points], self.subject.triangles, about_axis=False)
        return replace(found, view=camera.view, up=camera.up)

    # All

    def words(self) -> str:
        """Time and stage, such as "0.250 s  deploy".

        Returns
        -------
        str
            In one line.
        """
        return f"{self.time:.{self._digits}f} s" + (f"   {self.stage}" if self.stage else "")

    def shown(self) -> Shown:
        """What is to be drawn now.

        Returns
        -------
        Shown
            `positions` (N, 3) [m], colours, bodies and the scale.

        Raises
        ------
        OutputError
            The frame cannot be read, or drawn.
        """
        frame, scale = self._frames[self.index], self.scale()
        if not is_drawable(frame.positions):
            raise OutputError(
                f"frame {self.index} at {self.time:g} s cannot be drawn: its positions are not finite, or beyond "
                f"{FARTHEST:g} m; look at another time"
            )
        upper, lower = film_colors(self.subject, back=False), film_colors(self.subject, back=True)
        lines, line_colors = np.empty((0, 2), np.int64), np.empty((0, 3), np.uint8)
        node_values: Floats | None = None
        values = None if scale is None else scale.field.values(frame)
        if scale is not None:
            upper = lower = np.tile(np.array(BARE, np.uint8), (len(upper), 1))
        if scale is not None and values is not None:
            match scale.field.place:
                case "triangles":
                    upper = lower = scale.color(values)
                case "nodes":
                    node_values = values
                case "lines":
                    has = np.isfinite(values)
                    lines, line_colors = np.asarray(frame.lines)[has], scale.color(values[has])
        return Shown(
            positions=np.asarray(frame.positions, dtype=np.float64),
            hub_angle=0.0 if self.in_turning_frame else _turn(frame.turn),
            solids=self._bodies.at(frame.time),
            upper=upper,
            lower=lower,
            node_values=node_values,
            lines=lines,
            line_colors=line_colors,
            scale=scale,
        )


def one_of(name: str, value: str, choices: Sequence[str]) -> str:
    """A choice. Raises InputError, which lists them, and names those that hold the word."""
    if value not in choices:
        alike = [choice for choice in choices if isinstance(value, str) and len(value) > 2 and value in choice]
        alike = alike or get_close_matches(str(value), choices, n=1)
        hint = f"; did you mean {' or '.join(alike)}?" if alike else ""
        raise InputError(f"{name} = {show(value)}: must be one of {', '.join(choices)}{hint}")
    return value


def _turn(turn: Turn) -> Turn:
    """A turn of a frame; 0 for an angle that is not known."""
    return turn if isinstance(turn, np.ndarray) else float(np.nan_to_num(turn))
