"""animation.gif: the frames of a run, one after the other, in the turning frame."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from membrane_rs._files import replacing
from membrane_rs.plotting.drawing import Drawing, decimals
from membrane_rs.plotting.painter import Painter, painter
from membrane_rs.plotting.picture import Image
from membrane_rs.results.vtk import read_frame
from membrane_rs.simulation.stepper import Stepper

if TYPE_CHECKING:
    from PIL import Image as Pillow

SIZE = 480
MOST_FRAMES = 160
COLORS = 128
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
            with painter(self.subject(sim), SIZE) as artist:
                write_animation(self.record.path / "animation.gif", frames, artist, self.record.tick)

    def _frames(self) -> list[tuple[float, Path]]:
        return chosen([(time, self.record.path / file) for time, file in self.record.frames])


def chosen(frames: Sequence[tuple[float, Path]]) -> list[tuple[float, Path]]:
    """The frames to show: all, or MOST_FRAMES of them evenly spread, first and last among them."""
    picks = np.unique(np.linspace(0, len(frames) - 1, min(len(frames), MOST_FRAMES)).round().astype(int))
    return [frames[k] for k in picks]


def write_animation(
    path: Path, frames: Sequence[tuple[float, Path]], artist: Painter, tick: Callable[[], None]
) -> None:
    """Draw VTU frames, given as (time [s], file), into a GIF that repeats for ever.

    `tick` is called after each picture. Raises OutputError.
    """
    from PIL import Image as Pillow

    images, digits = [], decimals([time for time, _ in frames], 2)
    for time, file in frames:
        images.append(_labelled(artist.paint(read_frame(file)), f"{time:.{digits}f} s"))
        tick()
    # One palette for all, from pictures spread over the run: no flicker, and a small file.
    some = images[:: max(1, len(images) // 6)]
    strip = Pillow.fromarray(np.concatenate([np.asarray(image) for image in some]))
    palette = strip.quantize(COLORS)
    pictures = [image.quantize(palette=palette, dither=Pillow.Dither.NONE) for image in images]
    durations = [round(1000 * SECONDS_PER_PICTURE)] * (len(pictures) - 1) + [round(1000 * SECONDS_AT_END)]
    with replacing(path) as part:
        pictures[0].save(
            part, "GIF", save_all=True, append_images=pictures[1:], duration=durations, loop=0, optimize=False
        )


def _labelled(image: Image, text: str) -> Pillow.Image:
    """The picture with a text in the upper left corner."""
    from PIL import Image as Pillow
    from PIL import ImageDraw, ImageFont

    picture = Pillow.fromarray(image)
    ImageDraw.Draw(picture).text((12, 10), text, "black", ImageFont.load_default(22))
    return picture
