"""What a user does in a window of the viewer, for a process that has a display: events as a screen sends them.

Prints what came of it as JSON. The argument is a folder for pictures.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import membrane_rs
import numpy as np
from membrane_rs.plotting.viewer.viewer import Viewer
from membrane_rs.plotting.viewer.window import Window
from small_scenes import hanging_strip


class Session:
    """A window, and what its screen and its user do."""

    def __init__(self, viewer: Viewer, folder: Path) -> None:
        self.viewer, self.window, self.folder = viewer, Window(viewer, folder), folder
        self.window.show(waits=False)
        self.interactor: Any = self.window.plotter.iren.interactor
        self.found: dict[str, Any] = {}

    def key(self, symbol: str) -> None:
        """A key is pressed."""
        character = symbol if len(symbol) == 1 else "\0"
        self.interactor.SetKeyEventInformation(0, 0, character, 0, symbol)
        self.interactor.InvokeEvent("KeyPressEvent")
        self.interactor.InvokeEvent("CharEvent")

    def mouse(self, *events: tuple[str, float, float]) -> None:
        """The left button is pressed, moved or released at a place [pixels]."""
        for event, x, y in events:
            self.interactor.SetEventInformation(round(x), round(y))
            self.interactor.InvokeEvent(event)

    def click(self, x: float, y: float) -> None:
        """A place is pressed."""
        self.mouse(("LeftButtonPressEvent", x, y), ("LeftButtonReleaseEvent", x, y))

    def wait(self, until: Any, seconds: float = 120.0) -> None:
        """The screen goes on."""
        end = time.monotonic() + seconds
        while not until() and time.monotonic() < end:
            self.window.plotter.iren.process_events()
            time.sleep(0.01)

    def pixels(self) -> Any:
        """What is seen."""
        return self.window.plotter.screenshot(return_img=True).astype(int)

    def changed(self, before: Any) -> float:
        """Share of the pixels of the picture, without the controls, that differ."""
        return float((np.abs(self.pixels() - before).max(axis=2) > 8)[120:-100, 260:-200].mean())


def slide_and_turn(session: Session) -> None:
    """The slider and the camera, by the mouse."""
    viewer, window, found = session.viewer, session.window, session.found
    first = session.pixels()
    found["colours_of_the_picture"] = len(np.unique(first[120:-100, 260:-200].reshape(-1, 3), axis=0))
    along = [window.controls.place_of(time) for time in (0.05, 0.12)]
    session.mouse(("LeftButtonPressEvent", along[0], 58), ("MouseMoveEvent", along[1], 300))
    found["slid_to"] = [viewer.time]
    session.mouse(("LeftButtonReleaseEvent", along[1], 300), ("MouseMoveEvent", along[0], 58))
    found["slid_to"].append(viewer.time)
    found["slider_moved_the_shape"] = session.changed(first)

    at = window.plotter.camera.position
    places = ((600, 400), (700, 450), (700, 450))
    events = ("LeftButtonPressEvent", "MouseMoveEvent", "LeftButtonReleaseEvent")
    session.mouse(*[(event, *place) for event, place in zip(events, places, strict=True)])
    found["mouse_turned"] = float(np.linalg.norm(np.subtract(window.plotter.camera.position, at)))
    session.key("v")
    found["v_turned_back"] = float(np.linalg.norm(np.subtract(window.plotter.camera.position, at)))


def colour_and_press_keys(session: Session) -> None:
    """The list of colours, and the keys that switch."""
    viewer, window, found = session.viewer, session.window, session.found
    film = session.pixels()
    session.key("c")
    found["c"], found["c_changed"] = viewer.color, session.changed(film)
    session.key("C")
    found["C"], found["C_left"] = viewer.color, session.changed(film)
    place = next(area for area in window.controls.areas if getattr(area.action, "args", ()) == ("speed",))
    session.click(place.left + 20, place.low + 5)
    found["pressed_colour"] = viewer.color
    reads: tuple[tuple[str, Callable[[], object]], ...] = (
        ("r", lambda: viewer.spans_run),
        ("t", lambda: viewer.in_turning_frame),
        ("h", lambda: window.controls.shows_help),
        ("Home", lambda: viewer.index),
        ("Right", lambda: viewer.index),
        ("End", lambda: viewer.index),
        ("Left", lambda: viewer.index),
        ("plus", lambda: viewer.speed),
        ("minus", lambda: viewer.speed),
    )
    for symbol, read in reads:
        session.key(symbol)
        found[symbol] = read()
    window.plotter.screenshot(str(session.folder / "keys.png"))
    session.key("h")
    before = session.pixels()
    for symbol in "wse3j":  # keys of VTK, which are not ours
        session.key(symbol)
    found["keys_of_vtk_changed"] = session.changed(before)


def play(session: Session) -> None:
    """Play by a key and by the button."""
    viewer, found = session.viewer, session.found
    session.key("Home")
    session.key("space")
    session.wait(lambda: not viewer.is_playing)
    found["played_to"] = viewer.index
    session.click(36, 58)
    found["button_plays"] = viewer.is_playing
    session.key("Right")
    found["stopped"] = not viewer.is_playing


def save_pictures(session: Session) -> None:
    """Two of the same, and those of the window."""
    session.key("p")
    session.key("p")
    session.found["message"] = session.window.controls.message
    session.window.plotter.screenshot(str(session.folder / "window.png"))
    session.window.plotter.render_window.SetSize(640, 480)
    session.wait(lambda: False, 0.3)
    session.window.refresh()
    session.window.plotter.screenshot(str(session.folder / "small.png"))


def main(folder: Path) -> None:
    """Go through all, and close two windows."""
    scene = replace(hanging_strip(), name="strip")
    run = membrane_rs.run(scene, until=0.12, frames=25)
    session = Session(Viewer(run), folder)
    session.found["window"] = session.window.plotter.render_window.GetClassName()
    for part in (slide_and_turn, colour_and_press_keys, play, save_pictures):
        part(session)
    session.key("q")
    session.window.plotter.close()

    last = Window(Viewer(run), folder)
    last.plotter.iren.interactor.AddObserver("TimerEvent", lambda *_: last.close())
    last.show()
    sys.stdout.write(json.dumps({**session.found, "closed": True}))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
