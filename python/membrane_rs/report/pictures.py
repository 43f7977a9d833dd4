"""The contact sheets of a run: those of its folder, or drawn from its frames."""

from __future__ import annotations

import base64
from typing import TYPE_CHECKING
from xml.etree.ElementTree import Element

import numpy as np

from membrane_rs.plotting.painter import painter
from membrane_rs.plotting.picture import is_drawable
from membrane_rs.plotting.scenery import Scenery
from membrane_rs.plotting.sheets import VIEWS, captions_of, contact_sheet, stage_prefix
from membrane_rs.plotting.web import WebPicture, web_picture, web_picture_of
from membrane_rs.report.deployment import Staged
from membrane_rs.report.markup import element
from membrane_rs.report.sources import LabelledRun

if TYPE_CHECKING:
    from membrane_rs.runs import Run

WIDE = 1.6
"""Width over height of sheets that take the whole row."""
SPREAD, SIZE = 10, 480
"""Frames on a sheet that is drawn for the page, and their size [pixels]."""
TURNING = ", in the frame that turns with the hub"


def sheet_section(labelled: LabelledRun) -> Element | None:
    """The sheets of a run; None without a shape."""
    sheets = _of_folder(labelled.run) or _drawn(labelled.run)
    if not sheets:
        return None
    grid = element("div", class_="grid" if len(sheets) > 1 else None)
    for words, sheet in sheets:
        source = "data:image/webp;base64," + base64.b64encode(sheet.content).decode("ascii")
        width, height = sheet.size
        picture = element("img", src=source, alt=f"Contact sheet: {words}", width=str(width), height=str(height))
        style = "wide" if width > WIDE * height else None
        grid.append(element("figure", picture, element("figcaption", words), class_=style))
    return element("section", element("h2", "Contact sheet"), grid, class_="sheets")


def _of_folder(run: Run) -> list[tuple[str, WebPicture]]:
    """Those that the run has drawn: of each stage, or one; in the turning frame where there is such a view."""
    if run.path is None:
        return []
    folder, name, found = run.path / "snapshots", run.scene.name, []
    parts = [(stage_prefix(k, stage.name), f"{name}: {stage.name}") for k, stage in enumerate(run.scene.stages)]
    for prefix, words in parts or [("", name)]:
        for view in VIEWS:
            sheet = web_picture_of(folder / f"{prefix}{view}.png")
            if sheet is not None:
                found.append((f"{words}{TURNING if view == VIEWS[0] else ''}", sheet))
                break
    return found


def _drawn(run: Run) -> list[tuple[str, WebPicture]]:
    """One that is drawn from frames spread over the run; none without a frame that can be drawn."""
    count = len(run.frames)
    picks = np.unique(np.linspace(0, count - 1, min(count, SPREAD)).round().astype(int))
    frames = [frame for frame in (run.frames[int(k)] for k in picks) if is_drawable(frame.positions)]
    if not frames:
        return []
    staged, times = Staged.of(run), [frame.time for frame in frames]
    subject = staged.subject([frame.positions for frame in frames])
    bodies = staged.bodies(frames[0].positions)
    with painter(subject, SIZE) as artist:
        images = [artist.paint(frame.positions, 0.0, Scenery(bodies.at(frame.time))) for frame in frames]
    words = f"{run.scene.name}{TURNING if subject.has_hub else ''}"
    return [(words, web_picture(contact_sheet(images, captions_of(times), run.scene.name)))]
