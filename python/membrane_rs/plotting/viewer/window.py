"""The window of a viewer."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from membrane_rs._extras import need
from membrane_rs.errors import DisplayError, MembraneError
from membrane_rs.plotting.actors import silence_vtk
from membrane_rs.plotting.viewer.canvas import Canvas, canvas_of
from membrane_rs.plotting.viewer.controls import FOOT, Controls
from membrane_rs.plotting.viewer.keys import KEYS
from membrane_rs.plotting.viewer.pictures import save_new
from membrane_rs.plotting.viewer.viewer import Viewer

SIZE = (1200, 860)
TICK = 30
"""Between two looks at the clock while it plays [ms]."""
MESSAGE_SECONDS = 4.0
PICTURE_ZOOM = 2
"""Pixels of a saved picture for each of the window, along each side."""
NO_WINDOW = ("vtkEGLRenderWindow", "vtkOSOpenGLRenderWindow")
"""VTK's kinds of windows that are not seen."""


def check_display() -> None:
    """Raise DisplayError where no window can be opened."""
    import vtkmodules.vtkRenderingOpenGL2  # noqa: F401 - which kinds of windows there are
    from vtkmodules.vtkRenderingCore import vtkRenderWindow

    silence_vtk()
    if vtkRenderWindow().GetClassName() in NO_WINDOW:
        raise DisplayError(
            "no window can be opened, since there is no display; save a picture with `membrane-rs view RUN --picture "
            "FILE`, make a page with `membrane-rs report RUN`, serve one with `membrane-rs view RUN --browser`, call "
            "run.view() in a notebook, or log in with `ssh -X`"
        )


class Window:
    """A window that shows a viewer; `folder` is where pictures are saved.

    Raises
    ------
    DisplayError
        There is no display.
    MissingExtraError
        pyvista is not installed.
    """

    def __init__(self, viewer: Viewer, folder: Path) -> None:
        need("pyvista", "matplotlib", use="a window")
        check_display()
        import pyvista

        self.viewer, self._folder = viewer, folder
        self.plotter: Any = pyvista.Plotter(
            window_size=list(SIZE),
            lighting="none",
            title=f"membrane_rs: {viewer.name}",
            off_screen=False,
            notebook=False,
        )
        self.canvas = Canvas(self.plotter, viewer, FOOT)
        toolbar = {
            "frame": self.toggle_frame,
            "scale": self.toggle_scale,
            "picture": self.save_picture,
            "help": self.toggle_help,
        }
        self.controls = Controls(self.plotter, viewer, toolbar)
        self._drags, self._clock, self._silent_at = False, time.monotonic(), 0.0
        self._size: tuple[int, int] = SIZE
        self._observe()
        self.canvas.draw()
        self.controls.draw()

    def show(self, *, waits: bool = True) -> None:
        """Open it. Until it is closed, or, where it does not wait, until `close`."""
        # pyvista closes what it has shown; a window that is asked to close then is closed once.
        self.plotter.show(auto_close=False, interactive=waits, interactive_update=not waits)
        if waits:
            self.plotter.close()

    def refresh(self) -> None:
        """Draw what the viewer shows. A frame that cannot be read is reported in the window."""
        try:
            self.canvas.draw()
        except MembraneError as error:
            self.viewer.is_playing = False
            self._say(str(error))
        self.controls.draw()
        self.plotter.render()

    # What keys do

    def toggle_play(self) -> None:
        """Play or pause."""
        self._clock = time.monotonic()
        self._do(self.viewer.toggle_play)

    def step_on(self) -> None:
        """The next frame."""
        self._do(lambda: self.viewer.step(1))

    def step_back(self) -> None:
        """The frame before."""
        self._do(lambda: self.viewer.step(-1))

    def go_to_start(self) -> None:
        """The first frame."""
        self._do(lambda: self.viewer.step(-len(self.viewer.times)))

    def go_to_end(self) -> None:
        """The last frame."""
        self._do(lambda: self.viewer.step(len(self.viewer.times)))

    def play_faster(self) -> None:
        """Twice as fast."""
        self._do(lambda: self.viewer.faster(1))

    def play_slower(self) -> None:
        """Half as fast."""
        self._do(lambda: self.viewer.faster(-1))

    def next_color(self) -> None:
        """Colour by the next field."""
        self._do(self.viewer.next_color)

    def color_before(self) -> None:
        """Colour by the field before."""
        self._do(lambda: self.viewer.next_color(-1))

    def toggle_scale(self) -> None:
        """Colours of the run or of each frame."""
        self._do(self.viewer.toggle_scale)

    def toggle_frame(self) -> None:
        """Let the camera turn with the hub, or stand still."""
        self._do(self.viewer.toggle_frame)

    def view_all(self) -> None:
        """See the whole run."""
        self._do(lambda: self.canvas.aim(self.viewer.camera()))

    def view_shape(self) -> None:
        """See the shape of now."""
        self._do(lambda: self.canvas.aim(self.viewer.closer()))

    def toggle_help(self) -> None:
        """Show the keys, or hide them."""
        self.controls.shows_help = not self.controls.shows_help
        self.refresh()

    def save_picture(self) -> None:
        """Save what is seen, without the controls, into a new file; the window says which."""
        width, height = self.plotter.window_size
        larger = canvas_of(self.viewer, (PICTURE_ZOOM * width, PICTURE_ZOOM * height), PICTURE_ZOOM)
        larger.look_as(self.canvas)
        larger.plotter.set_background("white")
        image = larger.image()
        larger.plotter.close()
        try:
            path = save_new(image, self._folder, f"{self.viewer.name}-{self.viewer.words()}")
            self._say(f"saved {path}")
        except MembraneError as error:
            self._say(str(error))
        self.refresh()

    def close(self) -> None:
        """Close the window."""
        self.plotter.iren.terminate_app()

    # Events

    def _observe(self) -> None:
        """Keys, mouse and clock."""
        interactor = self.plotter.iren.interactor
        self.plotter.iren.clear_key_event_callbacks()
        for key in KEYS:
            for symbol in key.symbols:
                self.plotter.add_key_event(symbol, getattr(self, key.action))
        # VTK's own keys would end the program, or show a wire frame.
        self.plotter.iren.interactor.GetInteractorStyle().AddObserver("CharEvent", lambda *_: None)
        for event, handle in (
            ("LeftButtonPressEvent", self._press),
            ("MouseMoveEvent", self._drag),
            ("LeftButtonReleaseEvent", self._release),
        ):
            self._observe_first(interactor, event, handle)
        interactor.AddObserver("TimerEvent", self._tick)
        interactor.AddObserver("ConfigureEvent", self._resize)
        self.plotter.renderer.AddObserver("StartEvent", self._resize)
        interactor.Initialize()
        interactor.CreateRepeatingTimer(TICK)

    @staticmethod
    def _observe_first(interactor: Any, event: str, handle: Callable[[int, int], bool]) -> None:
        """Handle an event before the camera does, which does not see it where it was handled."""
        tags: list[int] = []

        def call(*_: Any) -> None:
            interactor.GetCommand(tags[0]).SetAbortFlag(handle(*interactor.GetEventPosition()))

        tags.append(interactor.AddObserver(event, call, 10.0))

    def _press(self, x: int, y: int) -> bool:
        action = self.controls.pressed(x, y)
        if action is not None:
            self._clock = time.monotonic()
            self._do(action)
            return True
        self._drags = self.controls.is_on_slider(x, y)
        return self._drag(x, y)

    def _drag(self, x: int, y: int) -> bool:
        if self._drags:
            self.viewer.is_playing = False
            self._do(lambda: self.viewer.go_to(self.controls.time_at(x)))
        return self._drags

    def _release(self, x: int, y: int) -> bool:
        drags, self._drags = self._drags, False
        return drags

    def _tick(self, *_: Any) -> None:
        now = time.monotonic()
        elapsed, self._clock = now - self._clock, now
        plays = self.viewer.is_playing
        if self.controls.message and now > self._silent_at:
            self.controls.message = ""
            self.refresh()
        elif self.viewer.advance(elapsed) or plays != self.viewer.is_playing:
            self.refresh()

    def _resize(self, *_: Any) -> None:
        size = tuple(self.plotter.window_size)
        if size != self._size:
            self._size = size
            self.controls.draw()

    def _do(self, action: Callable[[], object]) -> None:
        action()
        self.refresh()

    def _say(self, words: str) -> None:
        """Show a message for a while."""
        self.controls.message = words if len(words) < 140 else f"{words[:137]}..."
        self._silent_at = time.monotonic() + MESSAGE_SECONDS
