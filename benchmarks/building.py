"""Time to build a mesh of a million nodes, to import the package, and to make a simulation of a scene.

The mesh is the square sail with its creases: edges, the sides of triangles, hinges, audit. Its pattern, which computes
the flat and stowed positions, is timed separately. The import is timed in fresh processes with existing byte code, and
so is `Simulation(scene, "leapfrog")` of model 1, as it is and denser: its audit, the core's model and the stable step;
and once more of the same scene, which has kept the audit of its mesh.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Callable
from statistics import median
from typing import TypeVar

from machine import cpu
from membrane_rs import Mesh, _core
from membrane_rs._markdown import table
from membrane_rs.folding import SquareSail
from page import README, MarkedPart, options, show

T = TypeVar("T")
PART = MarkedPart(README, "building")
ROWS, FEW_ROWS = 392, 48
"""Of a petal: a million nodes, and some thousands."""
IMPORTS = {
    "import of membrane_rs": "import membrane_rs",
    "from membrane_rs import Simulation, scenes": "from membrane_rs import Simulation, scenes",
}
"""The package alone reads its modules on demand; the second line is that of a first script."""
AIMS = {"a mesh, its edges, hinges and audit": 10.0, "import of membrane_rs": 0.3}
"""[s]"""

DENSITIES, FEW_DENSITIES = (1.0, 9.5), (1.0,)
"""Of the mesh of model 1, of which simulations are made."""

Times = dict[str, list[float]]


def build(rows: int, times: Times) -> Mesh:
    """Build the sail once, and add how long each part took [s]."""

    def timed(what: str, make: Callable[[], T]) -> T:
        began = time.perf_counter()
        made = make()
        times.setdefault(what, []).append(time.perf_counter() - began)
        return made

    found = timed("the pattern of the sail, flat and stowed", SquareSail(rows=rows).mesh)
    began = time.perf_counter()
    mesh = timed(
        "a mesh from arrays: edges, sides of triangles, creases checked",
        lambda: Mesh(
            found.reference,
            found.triangles,
            positions=found.positions,
            creases=found.creases,
            fold_angles=found.fold_angles,
            node_sets=found.node_sets,
        ),
    )
    hinges = timed("its hinges", lambda: _core.hinge_count(mesh.reference, mesh.triangles, mesh.creases))
    audit = timed("its audit", mesh.audit)
    times.setdefault("a mesh, its edges, hinges and audit", []).append(time.perf_counter() - began)
    if hinges != len(mesh.creases) or not audit.ok:
        raise RuntimeError(f"the sail is not sound: {hinges} hinges of {len(mesh.creases)} creases, {audit}")
    return mesh


def fresh(code: str) -> list[float]:
    """What code prints in a fresh process: numbers."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    return [float(word) for word in done.stdout.split()]


def import_time(line: str) -> float:
    """Of a line of imports, in a fresh process [s]."""
    return fresh(f"import time; began = time.perf_counter(); {line}; print(time.perf_counter() - began)")[0]


def import_times(repeats: int) -> Times:
    """Of each of `IMPORTS`, by turns."""
    for line in IMPORTS.values():
        import_time(line)  # writes missing byte code
    times: Times = {what: [] for what in IMPORTS}
    for _ in range(repeats):
        for what, line in IMPORTS.items():
            times[what].append(import_time(line))
    return times


def making_time(density: float) -> list[float]:
    """Nodes of model 1 with a mesh so many times as dense, and the times to make its simulation, to make another of the
    same scene, and to step it [s].
    """
    return fresh(f"""
import time
from membrane_rs import Simulation, scenes
from membrane_rs.study.common.density import denser
scene = denser(scenes.load("okuizumi-model-1"), {density})
began = time.perf_counter()
sim = Simulation(scene, "leapfrog")
made = time.perf_counter() - began
began = time.perf_counter()
sim = Simulation(scene, "leapfrog")
again = time.perf_counter() - began
count = 1 + 2_000_000 // len(sim.positions)
sim.step(count)
began = time.perf_counter()
sim.step(count)
print(len(sim.positions), made, again, (time.perf_counter() - began) / count)
""")


def making(repeats: int, densities: tuple[float, ...]) -> str:
    """The table of the time to make a simulation: medians, those of all sizes by turns."""
    found: dict[float, list[list[float]]] = {density: [] for density in densities}
    for _ in range(repeats):
        for density in densities:
            found[density].append(making_time(density))
    rows = []
    for times in found.values():
        nodes, made, again, step = (median(column) for column in zip(*times, strict=True))
        seconds = (f"{made:.3f}", f"{again:.3f}", f"{1e3 * step:.3g}")
        rows.append((f"{nodes:,.0f}", *seconds, f"{made / step:,.0f}", f"{again / step:,.0f}"))
    heads = (
        "a simulation of it [s]",
        "another one [s]",
        "a step of leapfrog [ms]",
        "the first in steps",
        "another in steps",
    )
    return table(("nodes of the scene", *heads), rows)


def text(mesh: Mesh, times: Times) -> str:
    """The table, with the aim of each row that has one."""
    rows = [(what, f"{median(found):.2f}", f"{AIMS[what]:g}" if what in AIMS else "") for what, found in times.items()]
    counts = f"{mesh.node_count:,} nodes, {len(mesh.edges):,} edges, {len(mesh.triangles):,} triangles"
    return f"{counts}, {len(mesh.creases):,} creases.\n\n{table(('wall time', '[s]', 'aim [s]'), rows)}"


def main() -> None:
    """Measure, print, and write if asked."""
    chosen = options(__doc__).parse_args()
    times: Times = {}
    for _ in range(1 if chosen.quick else 3):
        mesh = build(FEW_ROWS if chosen.quick else ROWS, times)
    times |= import_times(3 if chosen.quick else 11)
    made = making(*(1, FEW_DENSITIES) if chosen.quick else (7, DENSITIES))
    show(PART, f"Processor: {cpu()}, one thread.\n\n{text(mesh, times)}\n{made}", write=chosen.write)


if __name__ == "__main__":
    main()
