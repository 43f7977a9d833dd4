"""What a window has for the mouse: a slider of time with its stages, play and pause, colours, and words to press."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from membrane_rs.plotting.viewer.flat import ACCENT, FAINT, INK, MUTED, PAPER, Polygons, Text, rectangle
from membrane_rs.plotting.viewer.keys import key_table
from membrane_rs.plotting.viewer.viewer import Viewer

FOOT = 92
"""Height of the controls below the picture [pixels]."""
LEFT, RIGHT, LINE, TRACK = 78, 34, 58, 5
"""Ends and height of the slider, and its thickness [pixels]."""
MARGIN_BUTTON = 28
"""Left end of the button and of the words below it [pixels]."""
ROW = 25
GAP = 34


class Area(NamedTuple):
    """A rectangle that does something where it is pressed."""

    left: float
    low: float
    width: float
    height: float
    action: Callable[[], None]

    def holds(self, x: float, y: float) -> bool:
        """Whether a point lies in it."""
        return 0.0 <= x - self.left <= self.width and 0.0 <= y - self.low <= self.height


class Controls:
    """Draws the controls of a viewer, and finds what is pressed."""

    def __init__(self, plotter: Any, viewer: Viewer, toolbar: dict[str, Callable[[], None]]) -> None:
        """`toolbar` has the actions of the words below the slider: "frame", "scale", "picture" and "help"."""
        self._plotter, self._viewer, self._toolbar = plotter, viewer, toolbar
        self.areas: list[Area] = []
        self._back, self._track = Polygons(plotter, PAPER), Polygons(plotter, FAINT)
        self._done, self._marks = Polygons(plotter, ACCENT), Polygons(plotter, MUTED)
        self._knob, self._button = Polygons(plotter, ACCENT), Polygons(plotter, INK)
        self._swatch = Polygons(plotter, ACCENT)
        self._stages = [Text(plotter, 12, MUTED) for _ in viewer.stage_starts]
        self._end, self._speed = Text(plotter, 12, MUTED), Text(plotter, 14, MUTED)
        self._colors = [Text(plotter, 15, MUTED) for _ in viewer.fields]
        self._words = {name: Text(plotter, 14, MUTED) for name in toolbar}
        self._message_back, self._message = Polygons(plotter, INK, 0.85), Text(plotter, 15, PAPER)
        self._help_back, self._help = Polygons(plotter, INK, 0.95), Text(plotter, 16, PAPER)
        self._help.actor.GetTextProperty().SetFontFamilyToCourier()
        self._help.actor.GetTextProperty().SetLineSpacing(1.25)
        self._help.say(key_table())
        self.shows_help = False
        self.message = ""

    def pressed(self, x: float, y: float) -> Callable[[], None] | None:
        """What is to be done where a point is pressed; None: the point belongs to the picture."""
        return next((area.action for area in self.areas if area.holds(x, y)), None)

    def is_on_slider(self, x: float, y: float) -> bool:
        """Whether a point is near the slider."""
        width, _ = self._plotter.window_size
        return len(self._viewer.times) > 1 and abs(y - LINE) <= 14 and LEFT - 10 <= x <= width - RIGHT + 10

    def time_at(self, x: float) -> float:
        """Time at a place of the slider [s]."""
        width, _ = self._plotter.window_size
        times = self._viewer.times
        share = np.clip((x - LEFT) / max(1.0, width - RIGHT - LEFT), 0.0, 1.0)
        return float(times[0] + share * (times[-1] - times[0]))

    def place_of(self, time: float) -> float:
        """Place on the slider of a time [s]."""
        width, _ = self._plotter.window_size
        first, last = float(self._viewer.times[0]), float(self._viewer.times[-1])
        share = (time - first) / (last - first) if last > first else 0.0
        return LEFT + min(max(share, 0.0), 1.0) * max(1.0, float(width - RIGHT - LEFT))

    def draw(self) -> None:
        """Show the state of the viewer; the caller renders."""
        width, height = self._plotter.window_size
        self.areas = []
        self._back.draw([rectangle(0, 0, width, FOOT - 4)])
        self._draw_time(width)
        self._draw_colors(height)
        self._draw_toolbar()
        self._draw_message(width)
        self._draw_help(width, height)

    def _draw_time(self, width: int) -> None:
        viewer, end = self._viewer, width - RIGHT
        several = len(viewer.times) > 1
        shapes: list[Any] = [self._track, self._done, self._knob, self._button]
        for part in (*shapes, self._marks, self._end, self._speed, *self._stages):
            part.actor.SetVisibility(several)
        if not several:
            return
        low, now = LINE - 0.5 * TRACK, self.place_of(viewer.time)
        self._track.draw([rectangle(LEFT, low, end - LEFT, TRACK)])
        self._done.draw([rectangle(LEFT, low, max(1.0, now - LEFT), TRACK)])
        angles = np.linspace(0.0, 2.0 * np.pi, 40, endpoint=False)
        self._knob.draw([np.column_stack([now + 9.0 * np.cos(angles), LINE + 9.0 * np.sin(angles)])])
        if viewer.is_playing:
            self._button.draw(
                [rectangle(MARGIN_BUTTON, LINE - 10, 6, 20), rectangle(MARGIN_BUTTON + 11, LINE - 10, 6, 20)]
            )
        else:
            self._button.draw([[(MARGIN_BUTTON, LINE - 11), (MARGIN_BUTTON + 19, LINE), (MARGIN_BUTTON, LINE + 11)]])
        self.areas.append(Area(MARGIN_BUTTON - 8, LINE - 16, 36, 32, viewer.toggle_play))
        starts = viewer.stage_starts
        self._marks.actor.SetVisibility(len(starts) > 1)
        if len(starts) > 1:
            self._marks.draw([rectangle(self.place_of(start) - 0.5, LINE - 7, 1.5, 14) for _, start in starts[1:]])
        free = 0.0
        for text, (name, start) in zip(self._stages, starts, strict=True):
            at = max(self.place_of(start), LEFT)
            text.say(name if at >= free else "")
            text.place(at + 3, LINE + 11)
            if text.words:
                free = at + text.size()[0] + 12
        self._end.say(f"{viewer.times[-1]:.4g} s")
        self._end.place(end, LINE - 13, across=2, up=2)
        self._speed.say("" if viewer.speed == 1.0 else f"{viewer.speed:g} x speed")
        self._speed.place(end - 70, LINE - 13, across=2, up=2)

    def _draw_colors(self, height: int) -> None:
        viewer = self._viewer
        top = height - 112
        for row, (text, (name, label)) in enumerate(zip(self._colors, viewer.labels.items(), strict=True)):
            chosen, low = name == viewer.color, top - ROW * row
            text.say(label)
            text.look(INK if chosen else MUTED, bold=chosen)
            text.place(40, low)
            self.areas.append(Area(20, low - 5, max(text.size()[0] + 26, 60), ROW, partial(viewer.choose, name)))
            if chosen:
                self._swatch.draw([rectangle(27, low - 2, 4, 17)])

    def _draw_toolbar(self) -> None:
        viewer, x = self._viewer, float(MARGIN_BUTTON)
        said = {
            "frame": "camera turns with the hub" if viewer.in_turning_frame else "camera stands still",
            "scale": "colours span the run" if viewer.spans_run else "colours span this frame",
            "picture": "save picture",
            "help": "keys",
        }
        has = {"frame": viewer.subject.has_hub, "scale": viewer.field is not None and not viewer.field.categories}
        for name, text in self._words.items():
            text.say(said[name] if has.get(name, True) else "")
            text.place(x, 14)
            if text.words:
                wide = text.size()[0]
                self.areas.append(Area(x - 6, 6, wide + 12, 28, self._toolbar[name]))
                x += wide + GAP

    def _draw_message(self, width: int) -> None:
        for part in (self._message, self._message_back):
            part.actor.SetVisibility(bool(self.message))
        if self.message:
            self._message.say(self.message)
            wide, _ = self._message.size()
            self._message.place(0.5 * width, FOOT + 22, across=1)
            self._message_back.draw([rectangle(0.5 * (width - wide) - 16, FOOT + 11, wide + 32, 36)])

    def _draw_help(self, width: int, height: int) -> None:
        for part in (self._help, self._help_back):
            part.actor.SetVisibility(self.shows_help)
        if self.shows_help:
            wide, tall = self._help.size()
            left, low = 0.5 * (width - wide), 0.5 * (height - tall)
            self._help_back.draw([rectangle(left - 28, low - 24, wide + 56, tall + 48)])
            self._help.place(left, low)
