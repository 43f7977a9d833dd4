"""Make what is published: a wheel for manylinux x86-64, stripped, for every Python from 3.10 on, and a source archive.

The wheel is linked by zig against an old C library, so that it runs on other Linux systems than the one that built it.
Both are made from a copy of the files that git knows. With `--links`, the address of the repository's files, the links
and pictures of README.md in that copy become absolute: a page of the package shows them, wherever it stands. The
metadata then name that address too.
"""

from __future__ import annotations

import argparse
import re
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
LINK = re.compile(r"(\]\()(?!https?://|#)([^)\s]+\))")
PLATFORM = "manylinux2014"


def absolute(text: str, links: str) -> str:
    """A page with its relative links under an address."""
    return LINK.sub(lambda found: f"{found[1]}{links.rstrip('/')}/{found[2]}", text)


def with_urls(metadata: str, links: str) -> str:
    """pyproject.toml with the addresses of documentation and changelog."""
    pages = {"Documentation": "docs/index.md", "Changelog": "CHANGELOG.md", "Citation": "CITATION.cff"}
    table = "".join(f'{name} = "{links.rstrip("/")}/{file}"\n' for name, file in pages.items())
    return metadata.replace("[project.scripts]\n", f"[project.urls]\n{table}\n[project.scripts]\n", 1)


def copy_of_tree(to: Path, links: str | None) -> None:
    """Copy all files that git knows, as they are now."""
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, check=True, capture_output=True, text=True).stdout
    for name in filter(None, listed.split("\0")):
        (to / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(ROOT / name, to / name)
    if links:
        for name, changed in (("README.md", absolute), ("pyproject.toml", with_urls)):
            text = (to / name).read_text(encoding="utf-8")
            (to / name).write_text(changed(text, links), encoding="utf-8")


def maturin(tree: Path, *words: str) -> None:
    """Call maturin of this environment in the copy, with cargo's results kept in the project's own folder."""
    command = [sys.executable, "-m", "maturin", *words]
    subprocess.run([*command, "--manifest-path", "rust/python/Cargo.toml"], cwd=tree, check=True)


def main() -> None:
    """Build both into a folder, and print their paths."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--out", type=Path, default=ROOT / "dist", help="folder of both files; emptied first")
    options.add_argument("--links", help="address under which the files of the repository are found")
    given = options.parse_args()
    out = given.out.resolve()
    shutil.rmtree(out, ignore_errors=True)
    tree = ROOT / "target" / "dist" / "tree"
    shutil.rmtree(tree, ignore_errors=True)
    copy_of_tree(tree, given.links)
    target = ("--target-dir", str(tree.parent))
    zig = ("--zig", "--compatibility", PLATFORM, "--target", "x86_64-unknown-linux-gnu")
    maturin(tree, "build", "--release", "--strip", *zig, *target, "--out", str(out))
    maturin(tree, "sdist", "--out", str(out))
    for file in sorted(out.iterdir()):
        print(f"{file}  {file.stat().st_size / 1e6:.1f} MB")


if __name__ == "__main__":
    main()
