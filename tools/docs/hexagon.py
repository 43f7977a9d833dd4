"""The spiral hexagon: strain and crossings of stowed polygons, of random ones, and the scene that spins out.

With `--write` the tables and pictures of docs/hexagon.md are replaced. It takes a minute.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from marked import DOCS, MarkedPart, copy_small
from membrane_rs import MeshError, Simulation, scenes
from membrane_rs._markdown import table
from membrane_rs.folding import SpiralHexagon
from membrane_rs.results import read_history
from membrane_rs.results.features import curve_features

PARTS = {name: MarkedPart(DOCS / "hexagon.md", name) for name in ("hexagon-shapes", "hexagon-random", "hexagon-run")}
PATTERN, SHEET = "hexagon-pattern.png", "hexagon-sheet.png"
SIDES = (3, 4, 5, 6, 8, 12)
THICK = 7.5e-6
"""Distance of layers that touch, in the film of the built-in scene [m]."""
OPEN = 0.99
"""Share of its last radius at which the sail is called open [-]."""


def main() -> None:
    """Make tables and pictures; print and write them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--random", type=int, default=2000, help="number of random polygons")
    parser.add_argument("--until", type=float, help="a brief run: end here [s]")
    parser.add_argument("--out", type=Path, default=Path("out/hexagon"), help="folder of the run")
    parser.add_argument("--write", action="store_true", help="write into docs/")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    draw(options.out / PATTERN)
    texts = {
        "hexagon-shapes": shapes(),
        "hexagon-random": random_shapes(options.random),
        "hexagon-run": deployed(options.out / "run", options.until),
    }
    for name, text in texts.items():
        print(f"\n{name}\n\n{text}", flush=True)
        if options.write:
            PARTS[name].write(text)
    if options.write:
        copy_small(options.out / PATTERN, PATTERN)
        copy_small(options.out / "run" / "snapshots" / "turning.png", SHEET)


def polygon(sides: int) -> SpiralHexagon:
    """Five strips on a hub of a fifth of the apothem."""
    apothem = SpiralHexagon().radius * math.cos(math.pi / sides)
    return SpiralHexagon(sides=sides, strip_height=0.16 * apothem)


def shapes() -> str:
    """Polygons of several sides, and layers as far apart as the film is thick."""
    rows = []
    for sides in SIDES:
        for sail in (polygon(sides), replace(polygon(sides), rows=40, layer_gap=THICK)):
            mesh, path = sail.mesh(), sail._path()
            met, strain = mesh.crossings(limit=0), 100.0 * mesh.strain()
            gap = float(path.offset[sail.rows_per_strip] - path.offset[0])
            rows.append(
                (
                    f"{sides}",
                    f"{sail.strips * sail.rows_per_strip}",
                    f"{1e6 * gap:.2f}",
                    f"{1e3 * sail.wound_radius:.1f} to {1e3 * sail.wound_outer_radius:.1f}",
                    f"{sail.turns:.3f}",
                    f"{strain.min():.3f} to {strain.max():.3f}",
                    f"{met.count} of {met.candidates}",
                )
            )
    names = ("sides", "rows", "gap [um]", "radius [mm]", "turns", "strain [%]", "crossings of candidates")
    return table(names, rows)


def polygons(count: int) -> Iterator[SpiralHexagon | None]:
    """Random ones; None for dimensions that are refused."""
    dice = np.random.default_rng(0)
    for _ in range(count):
        sides, strips = int(dice.integers(3, 21)), int(dice.integers(1, 9))
        apothem = 0.325 * math.cos(math.pi / sides)
        try:
            yield SpiralHexagon(
                sides=sides,
                strips=strips,
                strip_height=apothem * float(dice.uniform(0.1, 0.97)) / strips,
                rows=strips * int(dice.integers(1, max(2, 24 // strips))),
                columns=int(dice.integers(1, 21)) if dice.random() < 0.5 else None,
                spool_radius=float(dice.uniform(0.02, 0.26)) if dice.random() < 0.5 else None,
                layer_gap=float(10.0 ** dice.uniform(-7.0, -3.5)) if dice.random() < 0.5 else None,
            )
        except MeshError:
            yield None


def random_shapes(count: int) -> str:
    """Crossings of random polygons, in a sentence."""
    sails = [sail for sail in polygons(count) if sail is not None]
    met = [sail.mesh().crossings(limit=0) for sail in sails]
    pairs = [sum(getattr(one, name) for one in met) for name in ("candidates", "count", "overlapping", "touching")]
    return (
        f"Of {count} random polygons of 3 to 20 sides, {count - len(sails)} are refused, with a remedy. Of the "
        f"{pairs[0]} pairs of triangles of the others whose bounding boxes meet, {pairs[1]} cross, {pairs[2]} overlap "
        f"in one plane and {pairs[3]} touch."
    )


def deployed(folder: Path, until: float | None) -> str:
    """The built-in scene, run with its outputs."""
    scene = scenes.load("hexagon")
    simulation = Simulation(scene)
    simulation.run(until=until or scene.run.until, out=folder, overwrite=True)
    history = read_history(folder)
    rate, time = history["deployment_rate"], history["time"]
    lag = curve_features(history)["phase_trough_deg"]
    opened = time[np.argmax(rate >= OPEN * rate[-1])]
    error = 100.0 * float(np.abs(history["energy_error"][-1]))
    rows = [
        ("nodes, triangles", f"{len(scene.mesh.reference)}, {len(scene.mesh.triangles)}" if scene.mesh else ""),
        ("step", f"{1e6 * simulation.dt:.3g} us"),
        (f"corners at {100 * OPEN:g} % of their last radius", f"{opened:.3f} s"),
        ("largest lag of the corners", "" if lag is None else f"{lag:.1f} degrees"),
        ("last deployment rate, phase", f"{rate[-1]:.4f}, {history['phase_difference_deg'][-1]:.2f} degrees"),
        ("residual of the energy balance", f"{error:.2f} % of the largest exchange"),
    ]
    return table(("quantity", "value"), rows)


def draw(file: Path) -> None:
    """The crease pattern, and the stowed sail along the axis."""
    mesh = SpiralHexagon(rows=10).mesh()
    figure, (flat, stowed) = plt.subplots(1, 2, figsize=(10, 5), layout="constrained")
    for sign, colour, name in ((-1, "tab:red", "mountain"), (1, "tab:blue", "valley")):
        ends = mesh.creases[sign * mesh.fold_angles > 0]
        x, y = (1e3 * np.insert(mesh.reference[ends, k], 2, np.nan, axis=1).ravel() for k in range(2))
        flat.plot(x, y, color=colour, linewidth=1.2, label=name)
    outline = np.insert(1e3 * mesh.reference[mesh.boundary_edges, :2], 2, np.nan, axis=1).reshape(-1, 2)
    flat.plot(*outline.T, color="0.3", linewidth=0.8)
    flat.set(title="creases", xlabel="x [mm]", ylabel="y [mm]", aspect="equal")
    flat.legend(loc="upper right")
    stowed.triplot(*(1e3 * mesh.positions[:, :2].T), mesh.triangles, color="tab:gray", linewidth=0.4)
    stowed.set(title="stowed, along the axis", xlabel="x [mm]", ylabel="y [mm]", aspect="equal")
    figure.savefig(file, dpi=120)
    plt.close(figure)


if __name__ == "__main__":
    main()
