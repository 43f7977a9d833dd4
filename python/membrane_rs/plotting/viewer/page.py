"""A page that shows a viewer, served by trame: the picture, drawn here, with a slider for the time and a menu for the
colours.
"""

from __future__ import annotations

import asyncio
import logging
import os
import sys
import threading
import time
import webbrowser
from itertools import count
from typing import Any

from membrane_rs._extras import need
from membrane_rs.errors import MembraneError
from membrane_rs.plotting.viewer.canvas import canvas_of
from membrane_rs.plotting.viewer.launcher import answer_at
from membrane_rs.plotting.viewer.viewer import Viewer

SIZE = (960, 600)
TICK = 0.05
"""Between two pictures while it plays [s]."""
HEIGHT = "640px"
DISPLAYS = ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER")
"""Variables of the environment that say that a browser can be seen; without one a browser would take the terminal."""
LOGGERS = ("asyncio", "aiohttp.server", "wslink.protocol")
"""Of those that send pictures."""
_NUMBERS = count(1)


class Page:
    """A page of its own server.

    Raises
    ------
    MissingExtraError
        trame is not installed.
    """

    def __init__(self, viewer: Viewer) -> None:
        need("trame", "trame_vtk", "trame_vuetify", use="a view in a notebook")
        from trame.app import get_server

        self.viewer, self.canvas = viewer, canvas_of(viewer, SIZE)
        self.server: Any = get_server(f"membrane_rs-view-{next(_NUMBERS)}", client_type="vue3")
        parser = self.server.cli
        read = parser.parse_known_args
        parser.parse_known_args = lambda *_, **__: read([])  # not what a user's script was called with
        state = self.server.state
        state.frame, state.words, state.playing = viewer.index, viewer.words(), False
        state.color, state.turning, state.spans_run = viewer.color, viewer.in_turning_frame, viewer.spans_run
        self.layout = self._lay_out()
        if os.environ.get("TRAME_IFRAME_BUILDER") == "jupyter-extension":
            # JupyterLab answers the messages of that extension in a thread of its own, in which OpenGL draws nothing.
            from trame_client.ui.core import iframe_url_builder_default, iframe_url_builder_jupyter_hub

            is_hub = "JUPYTERHUB_SERVICE_PREFIX" in os.environ
            self.layout.iframe_builder = iframe_url_builder_jupyter_hub if is_hub else iframe_url_builder_default
        for name, take in (
            ("frame", viewer.show_frame),
            ("color", viewer.choose),
            ("turning", lambda on: setattr(viewer, "in_turning_frame", bool(on))),
            ("spans_run", lambda on: setattr(viewer, "spans_run", bool(on))),
        ):
            state.change(name)(lambda name=name, take=take, **values: self._take(take, values[name]))
        state.change("playing")(lambda playing, **_: self._play(bool(playing)))
        self.server.controller.on_server_bind.add(answer_at)
        self._task: Any = None

    def refresh(self) -> None:
        """Draw what the viewer shows, and send it. A frame that cannot be read or drawn is reported in its words."""
        words = self.viewer.words()
        try:
            self.canvas.draw()
        except MembraneError as error:
            self.viewer.is_playing = False
            words = str(error)
        self.canvas.plotter.render()
        self.server.state.words = words
        self._view.update()

    async def start(self) -> None:
        """Start its server in the loop that runs, and wait until it answers."""
        self.server.start(
            exec_mode="task",
            port=0,
            open_browser=False,
            show_connection_info=False,
            disable_logging=True,
            timeout=0,
            backend="aiohttp",  # with the extension of JupyterLab it would be that one's messages
        )
        await self.server.ready

    def html(self) -> str:
        """The frame of HTML that holds the page, once its server has started."""
        return f"<div>{self.layout._jupyter_content()}</div>"

    def _take(self, take: Any, value: Any) -> None:
        take(value)
        self.refresh()

    def _play(self, wanted: bool) -> None:
        if wanted != self.viewer.is_playing:
            self.viewer.toggle_play()
            self.server.state.frame = self.viewer.index
            self.refresh()
        if self.viewer.is_playing and (self._task is None or self._task.done()):
            self._task = asyncio.ensure_future(self._advance())

    async def _advance(self) -> None:
        """Play until the end, or until it is paused."""
        before = time.monotonic()
        state = self.server.state
        while self.viewer.is_playing:
            await asyncio.sleep(TICK)
            now = time.monotonic()
            if self.viewer.advance(now - before):
                with state:
                    state.frame = self.viewer.index
                self.refresh()
            before = now
        with state:
            state.playing = False

    def _lay_out(self) -> Any:
        from trame.ui.vuetify3 import VAppLayout
        from trame.widgets import client, html, vuetify3
        from trame.widgets.vtk import VtkRemoteView

        viewer = self.viewer
        several, last = len(viewer.times) > 1, len(viewer.times) - 1
        items = [{"title": label, "value": name} for name, label in viewer.labels.items()]
        bar = "display: flex; align-items: center; gap: 16px; padding: 0 16px; height: 64px; background: white;"
        with VAppLayout(self.server, height=HEIGHT) as layout:
            client.Style("html { overflow: hidden !important; }")
            with html.Div(style="position: absolute; inset: 0 0 64px 0;"):
                self._view = VtkRemoteView(self.canvas.plotter.render_window, interactive_ratio=1, still_quality=95)
            with html.Div(style=f"position: absolute; left: 0; right: 0; bottom: 0; {bar}"):
                if several:
                    icon = "playing ? 'mdi-pause' : 'mdi-play'"
                    vuetify3.VBtn(icon=(icon,), click="playing = !playing", variant="text", classes="play")
                    vuetify3.VSlider(
                        v_model=("frame",),
                        min=0,
                        max=last,
                        step=1,
                        hide_details=True,
                        density="compact",
                        classes="time",
                    )
                    html.Span("{{ words }}", classes="words", style="min-width: 80px; white-space: nowrap;")
                vuetify3.VSelect(
                    v_model=("color",), items=("colors", items), label="Colour", density="compact", hide_details=True,
                    variant="outlined", style="max-width: 230px;", classes="colour",
                )  # fmt: skip
                vuetify3.VSwitch(
                    v_model=("spans_run",),
                    label="range of the run",
                    density="compact",
                    hide_details=True,
                    v_if="color != 'film'",
                )
                if viewer.subject.has_hub:
                    vuetify3.VSwitch(v_model=("turning",), label="turning", density="compact", hide_details=True)
        return layout


def _is_of_note(record: logging.LogRecord) -> bool:
    """Whether a message is more than that a browser was closed while a picture was on its way to it."""
    error = (record.exc_info or sys.exc_info())[1]  # wslink reports what it handles without it
    return not isinstance(error, ConnectionError)


def serve(viewer: Viewer) -> None:
    """Serve the page to this machine, and open it in a browser where there is a display, until Ctrl-C."""
    page = Page(viewer)
    for name in LOGGERS:
        logging.getLogger(name).addFilter(_is_of_note)

    def tell(**_: Any) -> None:
        address = f"http://localhost:{page.server.port}/"
        sys.stdout.write(f"{address}\nOpen it in a browser on this machine. Ctrl-C ends it.\n")
        sys.stdout.flush()
        if os.name == "nt" or sys.platform == "darwin" or any(map(os.environ.get, DISPLAYS)):
            threading.Thread(target=webbrowser.open, args=[address], daemon=True).start()

    page.server.controller.on_server_ready.add(tell)
    page.server.start(port=0, timeout=0, host="localhost", show_connection_info=False, open_browser=False)
