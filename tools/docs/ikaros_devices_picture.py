"""Both shapes of the sail of IKAROS, with devices and without, for docs/ikaros_devices.md."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from marked import in_few_colours
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from membrane_rs import Scene
from membrane_rs._arrays import Floats
from membrane_rs.plotting.figure import save_figure
from PIL import Image


def draw(runs: Mapping[str, tuple[Scene, Mapping[str, Floats]]], picture: Path) -> None:
    """Distance along the axis from the hub [m] over the flat sail, in one range of colours."""
    figure = Figure(figsize=(9.0, 4.2), layout="constrained")
    FigureCanvasAgg(figure)
    panels = list(figure.subplots(1, len(runs)))
    depths = {name: -run["positions"][:, 2] for name, (_, run) in runs.items()}
    low, high = min(map(min, depths.values())), max(map(max, depths.values()))
    drawn = None
    for axes, (name, (scene, _)) in zip(panels, runs.items(), strict=True):
        assert scene.mesh is not None
        x, y = scene.mesh.reference[:, :2].T
        drawn = axes.tripcolor(x, y, scene.mesh.triangles, depths[name], vmin=low, vmax=high, shading="gouraud")
        axes.set(title=name, aspect="equal", xlabel="x, flat [m]")
    panels[0].set_ylabel("y, flat [m]")
    assert drawn is not None
    figure.colorbar(drawn, ax=panels, label="Away from the sun, from the hub [m]")
    save_figure(figure, picture)
    with Image.open(picture) as drawn_picture:
        small = in_few_colours(drawn_picture.convert("RGB"), 128)
    small.save(picture, optimize=True)
