"""Each law and each step, by plain scalar loops and by the kernels with every instruction set, on four meshes.

Runs `cargo bench --bench kernels` (criterion) and makes tables of its medians: one for each mesh, and one of the cost
per node against the size of the mesh. In brackets is the speed-up over the scalar loops.
"""

from __future__ import annotations

import json
import re
import subprocess
import time
from pathlib import Path

from machine import cpu
from membrane_rs._markdown import table
from page import README, MarkedPart, options, show

ROOT = Path(__file__).resolve().parent.parent
PART = MarkedPart(README, "kernels")
CRITERION = ROOT / "target" / "criterion"
COLUMNS = ("scalar", "baseline", "avx2", "avx512")
WHOLE = ("evaluation: all", "step: leapfrog", "step: rk4")
"""The rows of the table of costs per node."""

Medians = dict[int, dict[str, dict[str, float]]]
"""[us] by number of nodes, row and column."""


def run(*, quick: bool) -> None:
    """Let criterion measure."""
    command = ["cargo", "bench", "--package", "membrane-benches", "--bench", "kernels", "--"]
    subprocess.run([*command, "--quick" if quick else "--noplot"], cwd=ROOT, check=True, stdout=subprocess.DEVNULL)


def medians(folder: Path, since: float) -> Medians:
    """Results of criterion since a time; those of earlier runs are ignored."""
    found: Medians = {}
    for file in sorted(folder.glob("*-*/*/*/new/estimates.json")):
        group = re.fullmatch(r"(evaluation|step)-(\d+)", file.parts[-5])
        if group is None or file.stat().st_mtime < since:
            continue
        row = found.setdefault(int(group[2]), {}).setdefault(f"{group[1]}: {file.parts[-4]}", {})
        row[file.parts[-3]] = json.loads(file.read_text(encoding="utf-8"))["median"]["point_estimate"] / 1e3
    return dict(sorted(found.items()))


def tables(found: Medians) -> str:
    """One for each mesh, by decreasing cost; then the cost per node."""
    return "\n".join([*(_of_mesh(nodes, rows) for nodes, rows in found.items()), _growth(found)])


def _columns(rows: dict[str, dict[str, float]]) -> list[str]:
    return [name for name in COLUMNS if any(name in row for row in rows.values())]


def _of_mesh(nodes: int, rows: dict[str, dict[str, float]]) -> str:
    columns = _columns(rows)
    lines = []
    for label, row in sorted(rows.items(), key=lambda item: (item[0].split(":")[0], -max(item[1].values()))):
        cells = [_number(row[name]) + _times(row, name) if name in row else "-" for name in columns]
        lines.append((label, *cells))
    return table((f"{nodes:,} nodes [us]", *columns), lines)


def _growth(found: Medians) -> str:
    """Cost per node [ns], and its ratio to that on the first mesh."""
    columns = _columns({label: row for rows in found.values() for label, row in rows.items()})
    lines = []
    for label in WHOLE:
        first: dict[str, float] = {}
        for nodes, rows in found.items():
            share = {name: 1e3 * value / nodes for name, value in rows.get(label, {}).items()}
            first = first or share
            cells = [
                f"{share[name]:.1f} ({share[name] / first[name]:.1f}x)" if name in share else "-" for name in columns
            ]
            lines.append((f"{label}, {nodes:,} nodes", *cells))
    return table(("per node [ns] (ratio to the smallest mesh)", *columns), lines)


def _number(value: float) -> str:
    return f"{value:.1f}" if value < 1000 else f"{value:,.0f}"


def _times(row: dict[str, float], name: str) -> str:
    return f" ({row['scalar'] / row[name]:.1f}x)" if name != "scalar" and "scalar" in row else ""


def main() -> None:
    """Measure, print, and write if asked."""
    chosen = options(__doc__).parse_args()
    began = time.time()
    run(quick=chosen.quick)
    show(PART, f"Processor: {cpu()}, one thread.\n\n{tables(medians(CRITERION, began))}", write=chosen.write)


if __name__ == "__main__":
    main()
