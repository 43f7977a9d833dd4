"""Parts of pages that scripts write, between two marks.

In a page of Markdown `<!-- name: begin -->` and `<!-- name: end -->` stand on lines of their own. Each script names the
parts that it writes as constants of its module; `tests/test_marked.py` holds them against the marks of all pages.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from membrane_rs._files import write_text
from PIL import Image

ROOT = Path(__file__).resolve().parent.parent.parent
DOCS = ROOT / "docs"


WIDTH = 1500
"""Pictures in docs/ are at most this wide [px]."""


def in_few_colours(picture: Image.Image, colours: int) -> Image.Image:
    """A picture with a palette of colours chosen by their distances, not by how often they occur: thin curves keep
    theirs. Each is then the mean of those it stands for, so that grey areas stay grey.
    """
    return picture.quantize(colours, Image.Quantize.MAXCOVERAGE, kmeans=1, dither=Image.Dither.NONE)


def copy_small(source: Path, name: str, *, share: float = 1.0, colours: int | None = 128) -> None:
    """A picture into docs/, at most `WIDTH` wide and in few colours, so that the repository stays small.

    None: all colours, where few of them would make steps of a colour bar.
    """
    with Image.open(source) as picture:
        share = min(share, WIDTH / picture.width)
        size = (round(picture.width * share), round(picture.height * share))
        small = picture.convert("RGB").resize(size, Image.Resampling.LANCZOS)
    if colours is not None:
        small = in_few_colours(small, colours)
    small.save(DOCS / name, optimize=True)


@dataclass(frozen=True)
class MarkedPart:
    """The part of `page` between the marks of this name."""

    page: Path
    name: str

    @property
    def marks(self) -> tuple[str, str]:
        """The line before it and the line after it."""
        return f"<!-- {self.name}: begin -->", f"<!-- {self.name}: end -->"

    def read(self) -> str:
        """What stands there, without the blank lines around it.

        Raises SystemExit where the page lacks a mark, has it twice, or has them in the wrong order.
        """
        return self._split()[1].strip()

    def write(self, text: str) -> None:
        """Put `text` there; the page is written whole or stays as it is.

        Raises SystemExit as `read` does, OutputError where the page cannot be written.
        """
        write_text(self.page, self.replaced(text))

    def replaced(self, text: str) -> str:
        """The page with `text` there. Raises SystemExit as `read` does."""
        before, _, after = self._split()
        begin, end = self.marks
        return f"{before}{begin}\n\n{text.strip()}\n\n{end}{after}"

    def publish(self, text: str, picture: Path, *, write: bool) -> None:
        """Print `text`; where `write`, put it there, and the picture, if there is one, beside the pages.

        Raises as `write` does.
        """
        print(f"{self.name}\n\n{text}", flush=True)
        if write:
            self.write(text)
            if picture.exists():
                (DOCS / picture.name).write_bytes(picture.read_bytes())

    def _split(self) -> tuple[str, str, str]:
        """The page before the first mark, between the two, and after the second."""
        page = self.page.read_text(encoding="utf-8")
        for mark in self.marks:
            if (count := page.count(mark)) != 1:
                fault = f"has {count} times the mark" if count else "lacks the mark"
                raise SystemExit(f"{self.page} {fault} {mark}; it stands once, where the part of that name belongs")
        begin, end = self.marks
        before, _, rest = page.partition(begin)
        between, found, after = rest.partition(end)
        if not found:
            raise SystemExit(f"{self.page} has the mark {end} before {begin}; exchange them")
        return before, between, after


def make_parts(
    script: str | None,
    parts: Mapping[str, MarkedPart],
    make: Mapping[str, Callable[[], str]],
    picture: tuple[str, str, Callable[[Path], None]] | None = None,
) -> None:
    """The command line of a script whose docstring is `script`: print the parts of its page, and with --write put them
    there. A picture has the name of a part with which it is written, that of its file in docs/, and who draws it.
    """
    parser = argparse.ArgumentParser(description=script.splitlines()[0] if script else None)
    parser.add_argument("--write", action="store_true", help="write into docs/")
    parser.add_argument("--only", nargs="+", choices=tuple(parts), default=tuple(parts), help="some parts")
    options = parser.parse_args()
    for name in options.only:
        text = make[name]()
        print(f"\n{name}\n\n{text}", flush=True)
        if options.write:
            parts[name].write(text)
    if options.write and picture is not None and picture[0] in options.only:
        _, name, draw = picture
        drawn = Path("out") / name
        drawn.parent.mkdir(exist_ok=True)
        draw(drawn)
        copy_small(drawn, name)
