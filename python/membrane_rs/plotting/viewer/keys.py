"""The keys of the window: the one list, which the window, the help of the command and the page of the viewer show."""

from __future__ import annotations

from typing import NamedTuple


class Key(NamedTuple):
    """Keys that do one thing."""

    symbols: tuple[str, ...]
    """X's names of the keys."""
    shown: str
    """How the help calls them."""
    words: str
    """What they do."""
    action: str
    """The method of `Window`."""


KEYS = (
    Key(("space",), "space", "play, pause", "toggle_play"),
    Key(("Right",), "right", "next frame", "step_on"),
    Key(("Left",), "left", "frame before", "step_back"),
    Key(("Home",), "home", "first frame", "go_to_start"),
    Key(("End",), "end", "last frame", "go_to_end"),
    Key(("plus", "equal", "KP_Add"), "+", "play faster", "play_faster"),
    Key(("minus", "KP_Subtract"), "-", "play slower", "play_slower"),
    Key(("c",), "c", "colour by the next field", "next_color"),
    Key(("C",), "C", "colour by the field before", "color_before"),
    Key(("r",), "r", "range of colours: of the run, of each frame", "toggle_scale"),
    Key(("t",), "t", "camera turns with the hub, stands still", "toggle_frame"),
    Key(("v",), "v", "view the whole run", "view_all"),
    Key(("z",), "z", "zoom to the shape of now", "view_shape"),
    Key(("p",), "p", "save a picture", "save_picture"),
    Key(("h", "question"), "h", "show these keys, hide them", "toggle_help"),
    Key(("q", "Escape"), "q", "close", "close"),
)
"""In the order in which they are shown."""


def key_table() -> str:
    """The keys, one a line."""
    width = max(len(key.shown) for key in KEYS)
    return "\n".join(f"{key.shown:<{width}}  {key.words}" for key in KEYS)
