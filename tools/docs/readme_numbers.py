"""Update the numbers and pictures of README from the results of the demo and of accuracy.py in `out`.

Without --write it only compares them, and the exit code gives the result.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from marked import DOCS, README, ROOT, MarkedPart
from PIL import Image

TABLES = {name: MarkedPart(README, name) for name in ("summary.md", "accuracy.md")}
"""The marked parts, by the file of the demo or of accuracy.py."""
SOURCES = {
    "reel-out.png": "okuizumi-whole/snapshots/01-reel-out-turning.png",
    "deployment.png": "okuizumi-whole/snapshots/03-release-turning.png",
    "comparison.png": "comparison.png",
}
FILM = ("deployment.gif", "okuizumi-whole/animation.gif")
WIDTH = 1500
"""Pictures in docs/ are at most this wide [px]."""


def copy_pictures(out: Path) -> None:
    """The demo's pictures into docs/, in few colours, so that the repository stays small."""
    for name, source in SOURCES.items():
        with Image.open(out / source) as picture:
            size = (min(WIDTH, picture.width), round(picture.height * min(1.0, WIDTH / picture.width)))
            small = picture.convert("RGB").resize(size, Image.Resampling.LANCZOS)
        small.quantize(128, dither=Image.Dither.NONE).save(DOCS / name, optimize=True)
    name, source = FILM
    (DOCS / name).write_bytes((out / source).read_bytes())


def main() -> None:
    """Compare, or write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--out", type=Path, default=ROOT / "out", help="folder of the results")
    parser.add_argument("--write", action="store_true", help="write README.md and docs/*.png")
    parser.add_argument("--tables", nargs="+", choices=TABLES, help="only these tables, without the pictures")
    options = parser.parse_args()

    tables = {name: (options.out / name).read_text(encoding="utf-8") for name in options.tables or TABLES}
    if options.write:
        for name, text in tables.items():
            TABLES[name].write(text)
        if not options.tables:
            copy_pictures(options.out)
    elif any(TABLES[name].read() != text.strip() for name, text in tables.items()):
        sys.exit("README.md holds other numbers than the last demo; run `make readme`")


if __name__ == "__main__":
    main()
