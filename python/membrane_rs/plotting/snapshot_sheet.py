"""Snapshots of a run as one figure: lettered panels with their times and a scale bar."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs._validation import check_kind, nearest, number_of, show
from membrane_rs.errors import InputError, InputTypeError
from membrane_rs.plotting.camera import Camera, bar_length, length_text
from membrane_rs.plotting.drawing import spread
from membrane_rs.plotting.figure import finished, new_figure, plain_text
from membrane_rs.plotting.painter import painter
from membrane_rs.plotting.picture import Image, Subject
from membrane_rs.plotting.scenery import BodiesInTime, Scenery
from membrane_rs.plotting.sheets import VIEWS, captions_of
from membrane_rs.plotting.stage_records import stage_records
from membrane_rs.plotting.style import INCH, Style, style_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COUNT, MOST = 6, 60
PIXELS = 1000
"""Width and height of each picture, before its white margins are cut off."""
LEAST_WIDTH = 26.0
"""Of a panel [mm]."""
BAR_SHARE = 0.35
"""Largest length of the scale bar, as a share of a panel's width."""
_GAP, _MARGIN = 2.0, 1.0
"""Between panels, and around all [mm]."""
_WHITE = 250


def plot_snapshots(
    run: Any,
    times: int | Sequence[float] = COUNT,
    path: Path | str | None = None,
    title: str = "",
    dpi: float | None = None,
    *,
    view: str = "fixed",
    columns: int | None = None,
    style: Style | str | Path | Mapping[str, Any] | None = None,
) -> Figure:
    """Shapes of a run side by side, seen by one camera, with letters, times in s and a scale bar.

    Parameters
    ----------
    run : Run
        What `membrane_rs.run` and `membrane_rs.open_run` give.
    times : int or sequence of float
        So many frames, spread evenly over the time that the run has come to; or the times [s], of which the nearest
        frames are shown.
    path : path, optional
        A PNG, PDF or SVG file, by its ending. Default: none is written.
    title : str
        Where the style has one.
    dpi : float, optional
        Resolution of a PNG file [1/inch]. Default: the style's.
    view : {"fixed", "turning"}
        The frame of the camera: fixed, or turning with the hub. Without a hub that turns both are one.
    columns : int, optional
        Panels in a row. Default: as many as are 26 mm wide, in rows of equal length where that is possible.
    style : Style, str, path or mapping, optional
        "screen" (the default), "paper", a `Style`, a style sheet of matplotlib, or its parameters.

    Returns
    -------
    matplotlib.figure.Figure
        Without pyplot: nothing has to be closed.

    Raises
    ------
    InputTypeError
        What is no run.
    InputError
        A run without frames, fewer than 1 or more than 60 snapshots, a time outside of the run, a view that does not
        exist.
    MissingFileError
        No style sheet of that name.
    OutputError
        A frame is damaged, or `path` cannot be written.

    Examples
    --------
    >>> import membrane_rs
    >>> from membrane_rs.plotting import plot_snapshots
    >>> made = membrane_rs.run("spinning-tether", 0.02, frames=5)
    >>> figure = plot_snapshots(made, 3, style="paper")
    >>> [text.get_text() for text in figure.texts]
    ['(a) 0.00 s', '(b) 0.01 s', '(c) 0.02 s']
    """
    look = style_of(style)
    check_kind(title, str, "title", "a text")
    for name in ("frames", "scene"):
        if not hasattr(run, name):
            raise InputTypeError(f"run = {show(run)}: must be a Run, as membrane_rs.run and open_run give it")
    if view not in VIEWS or not isinstance(view, str):
        raise InputError(f"view = {show(view)}: {nearest(str(view), VIEWS)}")
    picks = _picks(np.asarray(run.frames.times, dtype=np.float64), times)
    if columns is not None and not (isinstance(columns, int) and 1 <= columns <= MOST):
        raise InputError(f"columns = {show(columns)}: must be a whole number from 1 to {MOST}")
    frames = [run.frames[k] for k in picks]
    images, camera = _paint(run, frames, view)
    captions = captions_of([frame.time for frame in frames])
    with look.context():
        figure = _sheet(images, captions, camera, columns, look)
        if look.title and title:
            height = figure.get_size_inches()[1]
            figure.suptitle(plain_text(title), y=1.0 - 0.3 * look.font_size / 72.0 / height, va="top")
    return finished(figure, path, dpi)


def _picks(known: Floats, wanted: int | Sequence[float]) -> list[int]:
    """Indices of frames, each once. Raises InputTypeError and InputError."""
    if not len(known):
        raise InputError("run: has no frames; a run writes the first one at its start")
    if isinstance(wanted, int | np.integer) and not isinstance(wanted, bool):
        if not 1 <= wanted <= MOST:
            raise InputError(f"times = {show(wanted)}: must be from 1 to {MOST} snapshots, or a list of times (s)")
        return spread(known, int(wanted))
    if isinstance(wanted, str | bytes) or not isinstance(wanted, Sequence | np.ndarray):
        raise InputTypeError(f"times = {show(wanted)}: must be a whole number, or a list of times (s)")
    if not 1 <= len(wanted) <= MOST:
        raise InputError(f"times: {len(wanted)} of them; must be from 1 to {MOST}")
    slack = 1e-9 + 0.5 * float(np.diff(known).max(initial=0.0))
    picks = []
    for time in (number_of("times", time) for time in wanted):
        if not known[0] - slack <= time <= known[-1] + slack:
            raise InputError(f"times: {time:g} s is outside of the run, from {known[0]:g} to {known[-1]:g} s")
        picks.append(int(np.abs(known - time).argmin()))
    return list(dict.fromkeys(picks))


def _paint(run: Any, frames: Sequence[Any], view: str) -> tuple[list[Image], Camera]:
    """A picture of each frame, without scale bar, and the camera of all."""
    shapes = [frame.positions for frame in frames]
    subject = Subject.of_scene(run.scene, run.scene.assemble(), shapes)
    bodies = BodiesInTime.of_scene(run.scene, stage_records(getattr(run, "stages", ())), shapes[0])
    images = []
    with painter(subject, PIXELS) as artist:
        for frame in frames:
            around = Scenery(bodies.at(frame.time), scale_bar=False)
            images.append(artist.paint(frame.positions, frame.turn if view == "fixed" else 0.0, around))
    return images, subject.camera


def _sheet(images: Sequence[Image], captions: Sequence[str], camera: Camera, columns: int | None, style: Style) -> Any:
    """The figure: panels of the part that any picture has content in, all at one scale."""
    box = _content(images)
    most = max(1, int((style.millimetres - 2.0 * _MARGIN + _GAP) / (LEAST_WIDTH + _GAP)))
    rows = -(-len(images) // min(columns or most, len(images)))
    across = columns or -(-len(images) // rows)
    line = 1.5 * style.font_size / 72.0 * INCH
    width = (style.millimetres - 2.0 * _MARGIN - (across - 1) * _GAP) / across
    per_pixel = width / (box[1] - box[0])  # [mm]
    height = (box[3] - box[2]) * per_pixel
    bar = bar_length(BAR_SHARE * (box[1] - box[0]) / PIXELS * 2.0 * camera.half_width)
    # Room for the scale bar below the first row, where it would stand on what is shown.
    below = line if _is_covered(images[0], box, per_pixel, 1.3 * line) else 0.0
    step = height + line + _GAP
    head = line if style.title else 0.0
    whole = 2.0 * _MARGIN + rows * step - _GAP + head + below
    figure = new_figure(style, (style.millimetres / INCH, whole / INCH))
    figure.set_layout_engine("none")
    for k, (image, text) in enumerate(zip(images, captions, strict=True)):
        left = _MARGIN + k % across * (width + _GAP)
        row = k // across
        bottom = whole - _MARGIN - head - row * step - height - (below if row else 0.0)
        place = (left / style.millimetres, bottom / whole, width / style.millimetres, height / whole)
        axes = figure.add_axes(place)
        axes.imshow(image[box[2] : box[3], box[0] : box[1]], aspect="auto")
        axes.set_axis_off()
        middle = (left + 0.5 * width) / style.millimetres, (bottom - (0.0 if row else below) - 0.25 * line) / whole
        figure.text(*middle, plain_text(text), ha="center", va="top", fontsize=style.font_size)
        if k == 0:
            pixels = bar / (2.0 * camera.half_width) * PIXELS
            base = box[3] - box[2] - 1 + (below - 0.2 * line) / per_pixel
            axes.plot([0, pixels], [base, base], color="black", linewidth=1.2, solid_capstyle="butt", clip_on=False)
            axes.annotate(
                length_text(bar), (0.0, base), (0, 1.5), textcoords="offset points", fontsize="small",
                annotation_clip=False,
            )  # fmt: skip
            axes.set(xlim=(-0.5, box[1] - box[0] - 0.5), ylim=(box[3] - box[2] - 0.5, -0.5))
    return figure


def _content(images: Sequence[Image]) -> tuple[int, int, int, int]:
    """Left, right, top and bottom of what any picture shows [pixel], with a margin."""
    shown = np.any([image.min(axis=2) < _WHITE for image in images], axis=0)
    if not shown.any():
        return 0, PIXELS, 0, PIXELS
    margin = PIXELS // 60
    bounds = []
    for axis in (0, 1):
        places = np.flatnonzero(shown.any(axis=axis))
        bounds += [max(int(places[0]) - margin, 0), min(int(places[-1]) + margin + 1, PIXELS)]
    # A strip seen from the side is not drawn as wide as a column.
    least = int(0.6 * (bounds[3] - bounds[2]))
    lacking = max(least - (bounds[1] - bounds[0]), 0)
    left = max(bounds[0] - lacking // 2, 0)
    right = min(left + max(bounds[1] - bounds[0], least), PIXELS)
    return left, right, bounds[2], bounds[3]


def _is_covered(image: Image, box: tuple[int, int, int, int], per_pixel: float, height: float) -> bool:
    """Whether the lower left of a picture, where the scale bar would stand, shows something."""
    rows = max(1, round(height / per_pixel))
    across = round((BAR_SHARE + 0.05) * (box[1] - box[0]))
    corner = image[max(box[3] - rows, box[2]) : box[3], box[0] : box[0] + across]
    return bool((corner.min(axis=2) < _WHITE).any())
