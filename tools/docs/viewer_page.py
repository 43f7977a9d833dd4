"""Make the lists of docs/viewer.md and its pictures: python tools/docs/viewer_page.py. Needs a display."""

from __future__ import annotations

import tempfile
from pathlib import Path

import membrane_rs
from marked import DOCS, MarkedPart, copy_small
from membrane_rs._markdown import table
from membrane_rs.plotting.fields import FIELDS
from membrane_rs.plotting.viewer.keys import KEYS
from membrane_rs.plotting.viewer.viewer import Viewer
from membrane_rs.plotting.viewer.window import Window

KEYS_PART = MarkedPart(DOCS / "viewer.md", "viewer-keys")
FIELDS_PART = MarkedPart(DOCS / "viewer.md", "viewer-fields")
UNTIL, SHOWN, COLOR = 0.12, 0.06, "state"
"""End of the run, and time and field of the picture [s]."""


def keys() -> str:
    """The table of keys."""
    return table(["key", "what it does"], [[f"`{key.shown}`", key.words] for key in KEYS], words=(0, 1))


def fields() -> str:
    """The table of fields."""
    rows = [[f"`{name}`", field.title, f"`{field.array or name}`"] for name, field in FIELDS.items()]
    return table(["colour", "what it is", "array of frames"], rows, words=(0, 1, 2))


def window(path: Path) -> None:
    """A picture of the window, with a sail in deployment."""
    run = membrane_rs.run("okuizumi-model-1", until=UNTIL, frames=41)
    viewer = Viewer(run, color=COLOR)
    viewer.go_to(SHOWN)
    shown = Window(viewer, path.parent)
    shown.show(waits=False)
    shown.view_shape()
    shown.plotter.screenshot(str(path))
    shown.plotter.close()


def main() -> None:
    """Write all."""
    KEYS_PART.write(keys())
    FIELDS_PART.write(fields())
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "window.png"
        window(path)
        copy_small(path, "viewer-window.png", colours=256)


if __name__ == "__main__":
    main()
