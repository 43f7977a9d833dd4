"""Pictures at chosen times, in the turning frame and as a fixed camera sees them, and their contact sheets.

The times are those that the scene names. Of a run that ends before most of them, frames are drawn that are spread over
the run. The sheets are laid out like Figs. 10 and 12 of Okuizumi et al. 2012: rows of five, "(a) 0.0 sec" under each.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import astuple, dataclass
from pathlib import Path

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs._files import replacing
from membrane_rs.plotting.drawing import Drawing, decimals
from membrane_rs.plotting.painter import Painter, painter
from membrane_rs.plotting.picture import Image
from membrane_rs.plotting.shape_files import SHAPES, read_shapes, write_shape
from membrane_rs.results.record import Record
from membrane_rs.results.vtk import read_frame
from membrane_rs.simulation.motion import Motion
from membrane_rs.simulation.stepper import Stepper

VIEWS = ("turning", "fixed")
SIZE = 700
COLUMNS = 5
FEWEST, SPREAD = 4, 6
"""With fewer snapshots than the first number, and others named for later, so many frames are drawn instead."""
_TILE = 360
_CAPTION = 44
_TITLE = 56


@dataclass(frozen=True)
class Snapshot:
    """Positions (N, 3) [m] in the turning frame at `time` [s], and how far the hub had turned [rad]."""

    time: float
    hub_angle: float
    positions: Floats


class Snapshots(Drawing):
    """Keeps the shapes at the times that the scene names, and draws them."""

    own_files = (*(f"snapshots/{view}{end}.png" for view in VIEWS for end in ("", "-*s")), SHAPES)

    def start(self, sim: Stepper, record: Record) -> None:
        """Wait for the times that are still to come."""
        self._begin(sim, record, sim.time)

    def resume(self, sim: Stepper, record: Record) -> None:
        """Take over the shapes up to now."""
        self._begin(sim, record, record.summary["start_time"])
        for shape in (Snapshot(*content) for content in read_shapes(record.path, sim.time)):
            record.shapes.append(self._taker.take(shape).positions)

    def sample(self, sim: Stepper) -> None:
        """Keep the state if a snapshot is due, in the folder too: a run that is resumed draws it."""
        shape = self._taker.offer(sim)
        if shape is not None:
            self.record.shapes.append(shape.positions)
            folder, number = self.record.path, len(self._taker.taken) - 1
            self.record.background.add(lambda: write_shape(folder, number, astuple(shape)))

    def count(self) -> int:
        """One for each view and time."""
        return len(self._views) * (len(self._spread_frames()) or len(self._taker.taken))

    def draw(self, sim: Stepper) -> None:
        """Draw each, and the sheets."""
        shots = [self._snapshot(*frame) for frame in self._spread_frames()] or self._taker.taken
        if shots:
            with painter(self.subject(sim), SIZE) as artist:
                folder = self.record.path / "snapshots"
                write_snapshots(folder, shots, artist, sim.scene.name, self.record.tick, views=self._views)

    def _begin(self, sim: Stepper, record: Record, since: float) -> None:
        super().start(sim, record)
        self._views = VIEWS if any(law.turns_hub for law in sim.scene.laws) else VIEWS[1:]
        self._taker = SnapshotTaker(sim.scene.run.snapshots, since)

    def _spread_frames(self) -> list[tuple[float, str]]:
        """Frames spread over a run that came to few of its snapshots; none where it came to them."""
        if not self._taker.wanted or len(self._taker.taken) >= FEWEST:
            return []
        frames = self.record.frames
        return [frames[k] for k in sorted(set(np.linspace(0, len(frames) - 1, SPREAD).round().astype(int)))]

    def _snapshot(self, time: float, file: str) -> Snapshot:
        table = self.record.table
        angle = float(np.interp(time, table["time"], table["hub_angle"]))
        return Snapshot(time, angle, read_frame(self.record.path / file))


class SnapshotTaker:
    """Keeps the first state at or after each of the wanted times.

    Times before the first state that is offered, as in a run that was restored, are dropped.
    """

    def __init__(self, times: Iterable[float], start: float) -> None:
        self.wanted = sorted(time for time in times if time >= start - 1e-9)
        self.taken: list[Snapshot] = []

    def offer(self, sim: Motion) -> Snapshot | None:
        """Keep the state of `sim` and give it if a wanted time has come."""
        if not self.wanted or sim.time < self.wanted[0] - 1e-9:
            return None
        return self.take(Snapshot(sim.time, sim.hub_angle, sim.positions.copy()))

    def take(self, shape: Snapshot) -> Snapshot:
        """Keep a shape: times up to its own are no longer wanted."""
        self.wanted = [time for time in self.wanted if time > shape.time + 1e-9]
        self.taken.append(shape)
        return shape


def write_snapshots(
    folder: Path,
    snapshots: Sequence[Snapshot],
    artist: Painter,
    title: str,
    tick: Callable[[], None],
    *,
    views: Sequence[str] = VIEWS,
) -> None:
    """Write <view>-<time>s.png for each snapshot and view, and one sheet <view>.png for each view.

    Where no hub turns both views are one, `views` is ("fixed",), and the title does not name it. `tick` is called
    after each picture. Raises OutputError.
    """
    from PIL import Image as Pillow

    digits = decimals([shot.time for shot in snapshots], 3)
    for view in views:
        images = []
        for shot in snapshots:
            image = artist.paint(shot.positions, shot.hub_angle if view == "fixed" else 0.0)
            with replacing(folder / f"{view}-{shot.time:.{digits}f}s.png") as part:
                Pillow.fromarray(image).save(part, format="PNG")
            images.append(image)
            tick()
        where = ", turning frame" if view == "turning" else ", fixed camera" if len(views) > 1 else ""
        captions = [caption(k, shot.time, digits) for k, shot in enumerate(snapshots)]
        sheet = Pillow.fromarray(contact_sheet(images, captions, f"{title}{where}"))
        with replacing(folder / f"{view}.png") as part:
            sheet.save(part, format="PNG")


def caption(index: int, time: float, decimals: int = 3) -> str:
    """The paper's caption of a picture: (a) 0.0 sec, (b) 0.05 sec ..."""
    letter = chr(ord("a") + index) if index < 26 else str(index + 1)
    digits = f"{time:.{decimals}f}".rstrip("0")
    return f"({letter}) {digits + '0' if digits.endswith('.') else digits} sec"


def contact_sheet(images: Sequence[Image], captions: Sequence[str], title: str) -> Image:
    """All pictures on one sheet, in rows of five, each with its caption below, under a title."""
    from PIL import Image as Pillow
    from PIL import ImageDraw, ImageFont

    columns = max(1, min(COLUMNS, len(images)))
    rows = -(-len(images) // columns)
    sheet = Pillow.new("RGB", (columns * _TILE, _TITLE + rows * (_TILE + _CAPTION)), "white")
    draw = ImageDraw.Draw(sheet)
    size = 26.0
    while size > 9.0 and draw.textlength(title, ImageFont.load_default(size)) > 0.96 * sheet.width:
        size -= 1.0
    draw.text((sheet.width / 2, _TITLE / 2), title, "black", ImageFont.load_default(size), anchor="mm")
    for k, (image, text) in enumerate(zip(images, captions, strict=True)):
        left, top = k % columns * _TILE, _TITLE + k // columns * (_TILE + _CAPTION)
        sheet.paste(Pillow.fromarray(image).resize((_TILE, _TILE), Pillow.Resampling.LANCZOS), (left, top))
        middle = (left + _TILE / 2, top + _TILE + _CAPTION / 2 - 6)
        draw.text(middle, text, "black", ImageFont.load_default(24), anchor="mm")
    return np.asarray(sheet)
