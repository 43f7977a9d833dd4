"""One run of the whole deployment of IKAROS with all that a run writes, for contact sheets and a film."""

from __future__ import annotations

from pathlib import Path

from ikaros_runs import whole
from marked import DOCS, copy_small, in_few_colours
from membrane_rs import Simulation
from membrane_rs.errors import MissingFileError
from membrane_rs.plotting.sheets import stage_prefix
from membrane_rs.results import read_summary
from PIL import Image, ImageSequence

SHEET = 0.75
"""Width of a contact sheet over its own."""
EVERY, WIDTH, COLOURS = 2, 300, 64
"""Of the film: every how many frames, width [px], colours."""


def write_shapes(out: Path) -> None:
    """The contact sheet of each stage, the momenta of hub and sail, and the film, into docs/."""
    folder = run_folder(out)
    for index, stage in enumerate(read_summary(folder)["stages"]):
        prefix = stage_prefix(index, stage["name"])
        copy_small(folder / "snapshots" / f"{prefix}turning.png", f"ikaros-{prefix}sheet.png", share=SHEET)
    copy_small(folder / "momentum.png", "ikaros-momentum.png")
    copy_film(folder / "animation.gif", DOCS / "ikaros.gif")


def run_folder(out: Path) -> Path:
    """The folder of the finished run; made where it is missing."""
    scene = whole()
    folder = out / f"run-{scene.name}"
    try:
        is_there = read_summary(folder)["outcome"] == "finished"
    except MissingFileError:
        is_there = False
    if not is_there:
        Simulation(scene).run(out=folder, overwrite=True)
    return folder


def copy_film(source: Path, target: Path) -> None:
    """Every few frames of an animation, small and in few colours."""
    frames, shown = [], []
    with Image.open(source) as animation:
        for frame in ImageSequence.Iterator(animation):
            frames.append(frame.convert("RGB"))
            shown.append(int(frame.info["duration"]))
    frames, starts = frames[::EVERY], range(0, len(shown), EVERY)
    durations = [sum(shown[k : k + EVERY]) for k in starts]
    size = (WIDTH, round(WIDTH * frames[0].height / frames[0].width))
    small = [in_few_colours(frame.resize(size, Image.Resampling.LANCZOS), COLOURS) for frame in frames]
    small[0].save(target, save_all=True, append_images=small[1:], duration=durations, loop=0, optimize=True)
