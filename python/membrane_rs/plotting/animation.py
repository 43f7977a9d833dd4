"""animation.gif: the frames of a run, one after the other, in the turning frame.

Of a scene with stages each picture names its stage, and where a hub turns the camera follows the size of the shape.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from membrane_rs._files import replacing
from membrane_rs.plotting.camera import Camera
from membrane_rs.plotting.drawing import Drawing, decimals
from membrane_rs.plotting.painter import Painter, painter
from membrane_rs.plotting.picture import Image
from membrane_rs.plotting.scenery import NONE, BodiesInTime, Scenery, reach_of, stage_at
from membrane_rs.results.vtk import read_frame
from membrane_rs.simulation.stepper import Stepper

if TYPE_CHECKING:
    from PIL import Image as Pillow

SIZE = 480
MOST_FRAMES = 160
NEARBY = 20
"""The camera follows the size over this share of all pictures, before and after."""
COLORS = (128, 64, 32)
"""Of the palette: the first number with which the file is not larger than `MOST_BYTES`, or the last one."""
MOST_BYTES = 4_000_000
SECONDS_PER_PICTURE = 0.06
SECONDS_AT_END = 1.5


class Animation(Drawing):
    """Draws the frames that were written, where there are two or more."""

    own_files = ("animation.gif",)

    def count(self) -> int:
        """One for each frame that is shown."""
        return len(self._frames())

    def draw(self, sim: Stepper) -> None:
        """Draw them."""
        frames = self._frames()
        if len(frames) > 1:
            subject, bodies = self.subject(sim), BodiesInTime(sim, self.first_shape(sim))
            solids = [bodies.at(time) for time, _ in frames]
            cameras: list[Camera | None] = [None] * len(frames)
            if sim.stages and subject.has_hub:
                pairs = zip(frames, solids, strict=True)
                reaches = smoothed([reach_of(read_frame(file), beside) for (_, file), beside in pairs])
                cameras = [replace(subject.camera, reach=reach) for reach in reaches]
            around = [Scenery(*pair) for pair in zip(solids, cameras, strict=True)]
            names = [sim.stages[stage_at(sim.stages, time)].name if sim.stages else "" for time, _ in frames]
            pictures = [Picture(*items) for items in zip(frames, around, names, strict=True)]
            with painter(subject, SIZE) as artist:
                write_animation(self.record.path / "animation.gif", pictures, artist, self.record.tick)

    def _frames(self) -> list[tuple[float, Path]]:
        return chosen([(time, self.record.path / file) for time, file in self.record.frames])


def chosen(frames: Sequence[tuple[float, Path]]) -> list[tuple[float, Path]]:
    """The frames to show: all, or MOST_FRAMES of them evenly spread, first and last among them."""
    picks = np.unique(np.linspace(0, len(frames) - 1, min(len(frames), MOST_FRAMES)).round().astype(int))
    return [frames[k] for k in picks]


class Picture(NamedTuple):
    """A picture of an animation."""

    frame: tuple[float, Path]
    """Time [s] and VTU file."""
    around: Scenery = NONE
    label: str = ""
    """What is said beside the time."""


def smoothed(reaches: Sequence[float]) -> list[float]:
    """Reaches [m] that change slowly from picture to picture, none below the one given: means of the logarithms of the
    largest ones nearby, over as many pictures.
    """
    width = max(1, len(reaches) // NEARBY)
    ends = np.pad(np.log(np.maximum(reaches, 1e-300)), 2 * width, mode="edge")
    largest = np.lib.stride_tricks.sliding_window_view(ends, 2 * width + 1).max(axis=1)
    means = np.lib.stride_tricks.sliding_window_view(largest, 2 * width + 1).mean(axis=1)
    return [float(reach) for reach in np.exp(means)]


def write_animation(path: Path, shown: Sequence[Picture], artist: Painter, tick: Callable[[], None]) -> None:
    """Draw pictures into a GIF that repeats for ever. `tick` is called after each. Raises OutputError."""
    from PIL import Image as Pillow

    images, digits = [], decimals([picture.frame[0] for picture in shown], 2)
    for (time, file), around, label in shown:
        text = f"{time:.{digits}f} s" + (f"  {label}" if label else "")
        images.append(_labelled(artist.paint(read_frame(file), 0.0, around), text))
        tick()
    # One palette for all, from pictures spread over the run: no flicker, and a small file.
    some = images[:: max(1, len(images) // 6)]
    strip = Pillow.fromarray(np.concatenate([np.asarray(image) for image in some]))
    durations = [round(1000 * SECONDS_PER_PICTURE)] * (len(images) - 1) + [round(1000 * SECONDS_AT_END)]
    with replacing(path) as part:
        for colors in COLORS:
            palette = strip.quantize(colors)
            first, *others = [image.quantize(palette=palette, dither=Pillow.Dither.NONE) for image in images]
            first.save(part, "GIF", save_all=True, append_images=others, duration=durations, loop=0, optimize=False)
            if part.stat().st_size <= MOST_BYTES:
                break


def _labelled(image: Image, text: str) -> Pillow.Image:
    """The picture with a text in the upper left corner."""
    from PIL import Image as Pillow
    from PIL import ImageDraw, ImageFont

    picture = Pillow.fromarray(image)
    ImageDraw.Draw(picture).text((12, 10), text, "black", ImageFont.load_default(22))
    return picture
