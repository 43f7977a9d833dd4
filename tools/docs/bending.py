"""Bending of the film against closed forms, and its cost (docs/bending.md).

python tools/docs/bending.py [--write] [--only plates ...]
"""

from __future__ import annotations

import time
import warnings
from dataclasses import replace
from pathlib import Path
from statistics import median

from bending_cases import CASES, SIZE, Form, elastica, exact_curve, exact_elastica, order, turned_cantilever
from marked import DOCS, MarkedPart, make_parts
from matplotlib.figure import Figure
from membrane_rs import Bending, Scene, Simulation, scenes
from membrane_rs._markdown import table
from membrane_rs.errors import AuditWarning

NAMES = ("plates", "directions", "elastica", "cost")
PARTS = {name: MarkedPart(DOCS / "bending.md", f"bending-{name}") for name in NAMES}
FORMS: tuple[Form, ...] = ("hinges", "curvature")
POISSON_RATIO = 1 / 3
LOADS, CELLS = (1.0, 10.0), (10, 20, 40)
"""Of the elastica: P L^2/EI, and cells along the beam."""
MODEL, REPEATS, STEPS = "okuizumi-model-1", 9, 400
"""Of the times: scene, repeats, and steps in each."""


def main() -> None:
    """Print the tables, and write them and the picture into the docs."""
    warnings.simplefilter("ignore", AuditWarning)
    make = {"plates": plates, "directions": directions, "elastica": elastica_table, "cost": cost}
    make_parts(__doc__, PARTS, make, ("elastica", "bending.png", draw))


def plates() -> str:
    """Lowest frequencies over their closed forms on three meshes, and the order."""
    rows = []
    for name, (case, cells) in CASES.items():
        for form in FORMS:
            found = [case(form, count, POISSON_RATIO) for count in cells]
            errors = [value - 1.0 for value in found]
            shown = f"{order(errors):.1f}" if abs(errors[-1]) < 0.5 * abs(errors[0]) else "-"
            rows.append((name, form, ", ".join(map(str, cells)), *(f"{value:.4f}" for value in found), shown))
    return table(("plate", "form", "cells", "coarse", "middle", "fine", "order"), rows, words=(0, 1, 2))


def directions() -> str:
    """Lowest frequencies of cantilevers cut from one lattice of squares along two directions."""
    rows = []
    for form in FORMS:
        for cells in (8, 16):
            found = [turned_cantilever(form, cells, angle) for angle in (0.0, 45.0)]
            rows.append((form, str(cells), *(f"{value:.3f}" for value in found)))
    return table(("form", "cells", "along the cells", "at 45 degrees"), rows, words=(0,))


def elastica_table() -> str:
    """The deflection of the end, and the orders of its error."""
    rows: list[tuple[str, ...]] = []
    for load in LOADS:
        exact = exact_elastica(load)
        rows.append((f"{load:g}", "exact", f"{exact.across:.5f}", f"{exact.along:.5f}", "-", "-"))
        errors: list[tuple[float, float]] = []
        for cells in CELLS:
            found = elastica("hinges", cells, load)
            errors.append((found.across - exact.across, found.along - exact.along))
            orders = [f"{order(part):.1f}" if len(part) > 1 else "-" for part in zip(*errors, strict=True)]
            rows.append((f"{load:g}", f"{cells} cells", f"{found.across:.5f}", f"{found.along:.5f}", *orders))
    return table(("P L^2/EI", "beam", "w/L", "u/L", "order of w", "order of u"), rows, words=(1,))


def cost() -> str:
    """The time of a step of model 1 with bending, over that without, and that of its creases."""
    plain = scenes.load(MODEL)
    cases = {
        "without bending": plain,
        "without creases": _without(plain, "creases"),
        **{f"bending by {form}": replace(plain, laws=[*plain.laws, Bending(form=form)]) for form in FORMS},
    }
    sims = {name: Simulation(scene, "leapfrog") for name, scene in cases.items()}
    times: dict[str, list[float]] = {name: [] for name in sims}
    for _ in range(REPEATS):
        for name, sim in sims.items():
            start = time.perf_counter()
            sim.step(STEPS)
            times[name].append((time.perf_counter() - start) / STEPS)
    base = median(times["without bending"])
    elements = {name: sim.assembly for name, sim in sims.items()}
    creases = len(elements["without bending"].creases)
    one_crease = (base - median(times["without creases"])) / creases
    counts = {form: _count(plain, form) for form in FORMS}
    rows = [
        (name, f"{1e6 * median(values):.1f}", f"{median(values) / base:.2f}", "-", "-")
        for name, values in times.items()
    ]
    for k, form in enumerate(FORMS, start=2):
        each = (median(times[f"bending by {form}"]) - base) / counts[form]
        rows[k] = (*rows[k][:3], f"{counts[form]:,}", f"{each / one_crease:.2f}")
    return table(("model 1", "step [us]", "ratio", "elements", "an element over a crease"), rows)


def _without(scene: Scene, kind: str) -> Scene:
    return replace(scene, laws=[law for law in scene.laws if law.kind != kind])


def _count(scene: Scene, form: str) -> int:
    """Hinges or triangles of the film."""
    assert scene.mesh is not None
    if form == "curvature":
        return len(scene.mesh.triangles)
    return len(scene.mesh.edges) - len(scene.mesh.boundary_edges) - len(scene.mesh.creases)


def draw(path: Path) -> None:
    """Elasticas, beside the errors of the plates by hinges."""
    figure = Figure(figsize=(9.0, 3.6), layout="constrained")
    left, right = figure.subplots(1, 2)
    for k, load in enumerate(LOADS):
        curve = exact_curve(load)
        left.plot(curve[:, 0], -curve[:, 1], color=f"C{k}", label=f"exact, P L$^2$/EI = {load:g}")
        beam = elastica("hinges", 20, load)
        left.plot(beam.shape[:, 0] / SIZE, beam.shape[:, 2] / SIZE, "o", ms=3.5, color=f"C{k}", label="20 cells")
    left.set(xlabel="x/L", ylabel="z/L", aspect="equal", title="Elastica")
    left.legend(fontsize=8)
    for name, (case, cells) in CASES.items():
        errors = [abs(case("hinges", count, POISSON_RATIO) - 1.0) for count in cells]
        right.loglog([1.0 / count for count in cells], errors, "o-", label=name)
    right.set_xticks([0.03, 0.1, 0.3], ["0.03", "0.1", "0.3"])
    right.set_xticks([], minor=True)
    right.set(xlabel="cell/size", ylabel="error of the lowest frequency", title="Plates by hinges")
    right.legend(fontsize=8)
    figure.savefig(path, dpi=150)


if __name__ == "__main__":
    main()
