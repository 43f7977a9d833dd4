"""Update README's pictures and the tables of docs/accuracy.md from results of the demo and of accuracy.py in `out`.

Without --write it only compares them, and the exit code gives the result.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from marked import DOCS, ROOT, MarkedPart, copy_small

TABLES = {name: MarkedPart(DOCS / "accuracy.md", name) for name in ("summary.md", "accuracy.md")}
"""The marked parts, by the file of the demo or of accuracy.py."""
SOURCES = {
    "reel-out.png": "okuizumi-whole/snapshots/01-reel-out-turning.png",
    "deployment.png": "okuizumi-whole/snapshots/03-release-turning.png",
    "comparison.png": "comparison.png",
}
FILM = ("deployment.gif", "okuizumi-whole/animation.gif")


def copy_pictures(out: Path) -> None:
    """The demo's pictures into docs/."""
    for name, source in SOURCES.items():
        copy_small(out / source, name)
    name, source = FILM
    (DOCS / name).write_bytes((out / source).read_bytes())


def main() -> None:
    """Compare, or write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--out", type=Path, default=ROOT / "out", help="folder of the results")
    parser.add_argument("--write", action="store_true", help="write docs/accuracy.md and docs/*.png")
    parser.add_argument("--tables", nargs="+", choices=TABLES, help="only these tables, without the pictures")
    options = parser.parse_args()

    tables = {name: (options.out / name).read_text(encoding="utf-8") for name in options.tables or TABLES}
    if options.write:
        for name, text in tables.items():
            TABLES[name].write(text)
        if not options.tables:
            copy_pictures(options.out)
    elif any(TABLES[name].read() != text.strip() for name, text in tables.items()):
        sys.exit("docs/accuracy.md holds other numbers than the last demo; run `make readme`")


if __name__ == "__main__":
    main()
