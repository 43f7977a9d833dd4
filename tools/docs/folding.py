"""Folding of flat patterns by simulation, against closed forms (docs/folding.md).

python tools/docs/folding.py [--write] [--only sheets ...]
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from folding_cases import SECTORS, SQUARE_TWIST, distance, multiplier, rigid_tilt, sheet, square_twist, vertex
from marked import DOCS, MarkedPart, make_parts
from matplotlib.figure import Figure
from membrane_rs import FoldResult, Mesh, fold
from membrane_rs._markdown import table

NAMES = ("sheets", "fractions", "patterns", "file")
PARTS = {name: MarkedPart(DOCS / "folding.md", f"folding-{name}") for name in NAMES}
SHEETS = ((0.2, 6, 4), (0.8, 6, 4), (1.5, 6, 4), (1.2, 20, 20))
"""Tilt [rad], columns, rows."""
INCREMENTS = (1, 10, 30)
STIFFNESSES = (0.3, 10.0, 100.0, 1000.0)
FRACTIONS = (0.3, 0.6, 0.9, 1.0)
SHOWN = (0.15, 0.3, 0.6, 0.9)
"""Fractions of the picture."""


def main() -> None:
    """Print the tables, and write them and the picture into the docs."""
    make = {"sheets": sheets, "fractions": fractions, "patterns": patterns, "file": file}
    make_parts(__doc__, PARTS, make, ("patterns", "folding.png", draw))


def sheets() -> str:
    """Miura sheets folded to all of their angles, by the number of increments."""
    rows = []
    for tilt, columns, lines in SHEETS:
        pattern = sheet(tilt, columns, lines)
        mesh = pattern.mesh()
        for increments in INCREMENTS:
            found = fold(mesh, increments=increments)
            away = distance(found.mesh.positions, mesh.positions) / pattern.zigzag_side
            rows.append(
                [
                    f"{columns} x {lines}", f"{math.degrees(tilt):.0f}", str(increments), f"{found.steps:,}",
                    f"{worst(found):.0e}", f"{away:.0e}", f"{found.largest_strain:.0e}",
                ]
            )  # fmt: skip
    head = ["facets", "tilt [deg]", "increments", "steps", "angle [deg]", "distance", "strain"]
    return table(head, rows)


def fractions() -> str:
    """A Miura sheet folded in part, against the same sheet with rigid panels."""
    pattern = sheet(1.5)
    mesh = pattern.mesh()
    rows = []
    for fraction in FRACTIONS[:-1]:
        rigid = replace(pattern, tilt=rigid_tilt(pattern, fraction))
        for stiffness in STIFFNESSES:
            found = fold(mesh, fraction, facet_stiffness=stiffness)
            away = distance(found.mesh.positions, rigid.mesh().positions) / pattern.zigzag_side
            rows.append(
                [
                    f"{fraction:g}", f"{stiffness:g}", f"{found.steps:,}", f"{worst(found):.1f}",
                    f"{np.degrees(found.largest_bend):.2f}", f"{away:.0e}", f"{found.largest_strain:.0e}",
                ]
            )  # fmt: skip
    head = ["fraction", "facet_stiffness", "steps", "angle [deg]", "bend [deg]", "distance", "strain"]
    return table(head, rows)


def patterns() -> str:
    """A vertex of four creases, and the square twist."""
    cases: dict[str, Callable[[], Mesh]] = {
        "vertex": lambda: vertex(SECTORS, "MVMM"),
        "square twist": square_twist,
        "the same, divided by 3": lambda: square_twist().divided(3),
    }
    rows = []
    for name, make in cases.items():
        for fraction in FRACTIONS:
            found = fold(make(), fraction)
            ratio = "-"
            if name == "vertex" and fraction < 1.0:
                first, second = np.tan(0.5 * np.abs(found.angles[:2]))
                ratio = f"{first / second / multiplier(SECTORS) - 1.0:+.0e}"
            rows.append(
                [
                    name, f"{fraction:g}", f"{found.steps:,}", f"{worst(found):.1f}",
                    f"{np.degrees(found.largest_bend):.1f}", f"{found.largest_strain:.0e}",
                    str(found.crossings.count) if fraction < 1.0 else "-", ratio,
                ]
            )  # fmt: skip
    head = ["pattern", "fraction", "steps", "angle [deg]", "bend [deg]", "strain", "crossings", "ratio"]
    return table(head, rows)


def worst(found: FoldResult) -> float:
    """The largest error of a fold angle [degrees]."""
    return float(np.degrees(np.abs(found.errors).max()))


def file() -> str:
    """The pattern of the page, as it stands in examples/."""
    return f"<!-- file: {SQUARE_TWIST.name} -->\n```json\n{SQUARE_TWIST.read_text(encoding='utf-8').strip()}\n```"


def draw(path: Path) -> None:
    """The square twist on its way."""
    figure = Figure(figsize=(10.0, 3.0), layout="constrained")
    for number, fraction in enumerate(SHOWN):
        mesh = fold(square_twist().divided(3), fraction).mesh.divided(12)  # drawn by the order of small triangles
        axes = figure.add_subplot(1, len(SHOWN), number + 1, projection="3d")
        axes.plot_trisurf(
            *(1e3 * mesh.positions.T), triangles=mesh.triangles, color="tab:olive", linewidth=0, antialiased=False
        )
        axes.set(title=f"{fraction:g} of the angles", xlim=(-38, 38), ylim=(-38, 38), zlim=(-19, 19))
        axes.set_box_aspect((4, 4, 2), zoom=1.4)
        axes.view_init(elev=55, azim=-60)
        axes.set_axis_off()
    figure.savefig(path, dpi=150)


if __name__ == "__main__":
    main()
