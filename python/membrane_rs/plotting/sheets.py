"""Files of snapshots: each picture, and contact sheets."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs._files import replacing
from membrane_rs.analysis.attitude import Turn
from membrane_rs.plotting.camera import Camera
from membrane_rs.plotting.drawing import RIGHT, decimals
from membrane_rs.plotting.painter import Painter
from membrane_rs.plotting.picture import Image
from membrane_rs.plotting.scenery import Scenery
from membrane_rs.scene.solid import Solid

if TYPE_CHECKING:
    from PIL import ImageDraw

VIEWS = ("turning", "fixed")
OF_STAGE = "[0-9][0-9]-*-"
"""Pattern of what names of files begin with in a scene with stages: see `stage_prefix`."""
COLUMNS = 5
_LONGEST = 40
_TILE = 360
_CAPTION, _LINE = 44, 28
_TITLE = 56


@dataclass(frozen=True)
class Snapshot:
    """Positions (N, 3) [m] in the frame of the hub at `time` [s], and how that had turned."""

    time: float
    turn: Turn
    positions: Floats


@dataclass(frozen=True)
class Part:
    """Snapshots that share a camera and a sheet: those of a run, or of one of its stages.

    `prefix` begins the names of its files; `frames` are times [s] and files of its frames.
    """

    shots: Sequence[Snapshot]
    title: str
    prefix: str = ""
    name: str = ""
    stage: int | None = None
    frames: Sequence[tuple[float, str]] = ()


def stage_prefix(index: int, name: str) -> str:
    """What names of files of a stage begin with: its index, as in history.csv, and the letters of its name."""
    slug = re.sub("[^a-z0-9]+", "-", name.lower())[:_LONGEST].strip("-") or "stage"
    return f"{index:02d}-{slug}-"


class Sheets:
    """Writes <prefix><view>-<time>s.png for each snapshot and view, and one sheet <prefix><view>.png for each view.

    Where no hub turns both views are one, `views` is ("fixed",), and the title does not name it. `tick` is called
    after each picture.
    """

    def __init__(self, folder: Path, artist: Painter, tick: Callable[[], None], views: Sequence[str] = VIEWS) -> None:
        self._folder, self._artist, self._tick, self._views = folder, artist, tick, views
        self._all: dict[str, list[tuple[Image, float, str]]] = {view: [] for view in views}

    def write(self, part: Part, solids: Sequence[Sequence[Solid]], camera: Camera | None = None) -> None:
        """Draw the pictures of a part, with the bodies beside each, and its sheets. Raises OutputError."""
        from PIL import Image as Pillow

        digits = decimals([shot.time for shot in part.shots], 3)
        captions = captions_of([shot.time for shot in part.shots])
        for view in self._views if part.shots else ():
            images = []
            for shot, beside in zip(part.shots, solids, strict=True):
                around = Scenery(tuple(beside), camera)
                image = self._artist.paint(shot.positions, shot.turn if view == "fixed" else 0.0, around)
                with replacing(self._folder / f"{part.prefix}{view}-{shot.time:.{digits}f}s.png") as file:
                    Pillow.fromarray(image).save(file, format="PNG")
                images.append(image)
                self._all[view].append((image, shot.time, part.name))
                self._tick()
            self._write_sheet(f"{part.prefix}{view}.png", images, captions, self._title(part.title, view))

    def write_all(self, title: str) -> None:
        """One sheet for each view of all pictures so far, each with the name of its stage; of two at one time that of
        the stage which ends. Raises OutputError.
        """
        for view, drawn in self._all.items():
            pictures = [item for k, item in enumerate(drawn) if k == 0 or item[1] != drawn[k - 1][1]]
            shown = captions_of([time for _, time, _ in pictures])
            captions = [f"{text}\n{name}" for text, (_, _, name) in zip(shown, pictures, strict=True)]
            images = [image for image, _, _ in pictures]
            self._write_sheet(f"{view}.png", images, captions, self._title(title, view))

    def _title(self, title: str, view: str) -> str:
        where = ", turning frame" if view == "turning" else ", fixed camera" if len(self._views) > 1 else ""
        return f"{title}{where}"

    def _write_sheet(self, name: str, images: Sequence[Image], captions: Sequence[str], title: str) -> None:
        from PIL import Image as Pillow

        sheet = Pillow.fromarray(contact_sheet(images, captions, title))
        with replacing(self._folder / name) as file:
            sheet.save(file, format="PNG")


def captions_of(times: Sequence[float]) -> list[str]:
    """Letters and times of the pictures of a sheet, all with as many decimals as one of them needs."""
    digits = decimals(sorted(set(times)), 3, RIGHT)
    needed = max((len(f"{time:.{digits}f}".rstrip("0").partition(".")[2]) for time in times), default=1)
    return [caption(k, time, max(needed, 1)) for k, time in enumerate(times)]


def caption(index: int, time: float, decimals: int = 3) -> str:
    """Letter and time of a picture: (a) 0.00 s, (b) 0.05 s ..."""
    letter = chr(ord("a") + index) if index < 26 else str(index + 1)
    return f"({letter}) {time:.{decimals}f} s"


def contact_sheet(images: Sequence[Image], captions: Sequence[str], title: str) -> Image:
    """All pictures on one sheet, in rows of five, or six in rows of three, under a title; each with its caption of one
    or two lines below.
    """
    from PIL import Image as Pillow
    from PIL import ImageDraw

    columns = max(1, min(COLUMNS, len(images))) if len(images) != 6 else 3
    rows = -(-len(images) // columns)
    below = _CAPTION + _LINE * max((text.count("\n") for text in captions), default=0)
    sheet = Pillow.new("RGB", (columns * _TILE, _TITLE + rows * (_TILE + below)), "white")
    draw = ImageDraw.Draw(sheet)
    font = _fitting(draw, title, sheet.width, 26.0)
    draw.text((sheet.width / 2, _TITLE / 2), title, "black", font, anchor="mm")
    for k, (image, text) in enumerate(zip(images, captions, strict=True)):
        left, top = k % columns * _TILE, _TITLE + k // columns * (_TILE + below)
        sheet.paste(Pillow.fromarray(image).resize((_TILE, _TILE), Pillow.Resampling.LANCZOS), (left, top))
        for line, part in enumerate(text.split("\n")):
            middle = (left + _TILE / 2, top + _TILE + _CAPTION / 2 - 6 + line * _LINE)
            draw.text(middle, part, "black", _fitting(draw, part, _TILE, 24.0 if line == 0 else 20.0), anchor="mm")
    return np.asarray(sheet)


def _fitting(draw: ImageDraw.ImageDraw, text: str, width: float, size: float) -> Any:
    """The font in which a text is not wider than so many pixels, of a size or smaller."""
    from PIL import ImageFont

    while size > 9.0 and draw.textlength(text, ImageFont.load_default(size)) > 0.96 * width:
        size -= 1.0
    return ImageFont.load_default(size)
