"""Time to build a mesh of a million nodes, and to import the package.

The mesh is the square sail with its creases: edges, the sides of triangles, hinges, audit. Its pattern, which computes
the flat and stowed positions, is timed separately. The import is timed in fresh processes with existing byte code.
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
AIMS = {"a mesh, its edges, hinges and audit": 10.0, "import of membrane_rs": 0.3}
"""[s]"""

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


def import_time() -> float:
    """Of the package, in a fresh process [s]."""
    code = "import time; began = time.perf_counter(); import membrane_rs; print(time.perf_counter() - began)"
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    return float(done.stdout)


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
    import_time()  # writes missing byte code
    times["import of membrane_rs"] = [import_time() for _ in range(3 if chosen.quick else 11)]
    show(PART, f"Processor: {cpu()}, one thread.\n\n{text(mesh, times)}", write=chosen.write)


if __name__ == "__main__":
    main()
