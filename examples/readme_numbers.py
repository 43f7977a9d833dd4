"""Keep the README's numbers and pictures in step with what the demo and accuracy.py have left in `out`.

Without --write it only tells whether they are, by its exit code.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from PIL import Image

ROOT = Path(__file__).resolve().parent.parent
README = ROOT / "README.md"
TABLES = ("summary.md", "accuracy.md")
SOURCES = {
    "deployment.png": "okuizumi-model-1/snapshots/turning.png",
    "comparison.png": "comparison.png",
}
WIDTH = 1500
"""Pictures in docs/ are at most this wide [px]."""


def with_tables(text: str, out: Path, tables: Sequence[str]) -> str:
    """The README's text with each table between its two markers made anew."""
    for name in tables:
        begin, end = f"<!-- {name}: begin -->", f"<!-- {name}: end -->"
        before, found, rest = text.partition(begin)
        _, closed, tail = rest.partition(end)
        if not (found and closed):
            raise SystemExit(f"{README.name} lacks the marker {begin if not found else end}")
        text = f"{before}{begin}\n{(out / name).read_text(encoding='utf-8').strip()}\n{end}{tail}"
    return text


def copy_pictures(out: Path) -> None:
    """The demo's pictures into docs/, in few colours, so that the repository stays small."""
    for name, source in SOURCES.items():
        with Image.open(out / source) as picture:
            size = (min(WIDTH, picture.width), round(picture.height * min(1.0, WIDTH / picture.width)))
            small = picture.convert("RGB").resize(size, Image.Resampling.LANCZOS)
        small.quantize(128, dither=Image.Dither.NONE).save(ROOT / "docs" / name, optimize=True)


def main() -> None:
    """Compare, or write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--out", type=Path, default=ROOT / "out", help="what demo.py and accuracy.py left")
    parser.add_argument("--write", action="store_true", help="write README.md and docs/*.png")
    parser.add_argument("--tables", nargs="+", choices=TABLES, help="these alone, without the pictures")
    options = parser.parse_args()

    old = README.read_text(encoding="utf-8")
    new = with_tables(old, options.out, options.tables or TABLES)
    if options.write:
        README.write_text(new, encoding="utf-8")
        if not options.tables:
            copy_pictures(options.out)
    elif new != old:
        sys.exit("README.md holds other numbers than the last demo; run `make readme`")


if __name__ == "__main__":
    main()
