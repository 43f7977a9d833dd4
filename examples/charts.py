"""What accuracy costs and what a scene can do without: a chart for each of four scenes, and two ablations.

Writes into the folder `out`; takes some minutes. With `--write` the pictures and tables of docs/studies.md are
made anew.
"""

from __future__ import annotations

import argparse
import shutil
from pathlib import Path

from membrane_rs import scenes
from membrane_rs.study import ablate, chart

DOCS = Path(__file__).parent.parent / "docs"
CHARTS = {"spinning-tether": 0.1, "spinning-disc": 0.02, "single-crease": 0.05, "okuizumi-model-1": 0.002}
"""Scenes, and the time up to which their motion is compared point by point [s]."""
ABLATIONS = {"spinning-tether": 0.3, "okuizumi-model-1": 0.05}


def main() -> None:
    """Make all charts and tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--until", type=float, default=1.0, help="end each run here at the latest [s]")
    parser.add_argument("--out", type=Path, default=Path("out"), help="folder of the results")
    parser.add_argument("--write", action="store_true", help="write into docs/studies.md and its pictures")
    options = parser.parse_args()

    tables = {}
    for name, until in CHARTS.items():
        folder = options.out / f"{name}-chart"
        found = chart(scenes.load(name), until=min(until, options.until))
        found.save(folder)
        print(found.summary(), end="\n\n", flush=True)
        if options.write:
            shutil.copy(folder / "chart.png", DOCS / f"chart-{name}.png")
            tables[f"{name}-chart"] = f"```text\n{found.summary()}\n```"
    for name, until in ABLATIONS.items():
        removed = ablate(scenes.load(name), min(until, options.until))
        removed.save(options.out / f"{name}-ablation")
        print(removed.summary(), end="\n\n", flush=True)
        tables[f"{name}-ablation"] = removed.table().rstrip()
    if options.write:
        write(tables)


def write(tables: dict[str, str]) -> None:
    """Put each table between its two marks in docs/studies.md."""
    page = DOCS / "studies.md"
    text = page.read_text(encoding="utf-8")
    for name, table in tables.items():
        begin, end = f"<!-- {name}: begin -->\n", f"\n<!-- {name}: end -->"
        before, rest = text.split(begin)
        text = before + begin + table + end + rest.split(end)[1]
    page.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
