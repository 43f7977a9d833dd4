"""Install what `build.py` made in fresh environments outside the tree, and use it as a new user would.

    wheel           the version, a run without pictures, the error that names the extra of pictures
    wheel[plot]     a run with pictures, and the time from nothing to the first of them
    source archive  all that README.md links to is in it; built, installed, some of its own tests pass

Each step prints its seconds; the first that fails ends the program with exit code 1.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import tarfile
import tempfile
import time
import venv
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

ROOT = Path(__file__).parents[2]
SCENE = ("spinning-tether", "--until", "0.02", "--out")
TESTS = ("test_mesh.py", "test_tethers.py", "test_cli.py")
LINK = re.compile(r"\]\((?!https?://|#)([^)#\s]+)")


class Failure(Exception):
    """What was tried gave another result than it should."""


@contextmanager
def timed(what: str) -> Iterator[None]:
    """Print how long a step took."""
    began = time.perf_counter()
    yield
    print(f"{what}: {time.perf_counter() - began:.1f} s", flush=True)


class Environment:
    """A fresh environment in a folder, which knows nothing of the tree."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        venv.create(folder / "venv", with_pip=True)
        self.bin = folder / "venv" / "bin"

    def call(self, *command: str | Path, cwd: Path | None = None, code: int = 0) -> str:
        """What a command prints, on both streams. Raises Failure where it ends with another exit code."""
        own = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "VIRTUAL_ENV"))}
        own["PATH"] = f"{self.bin}{os.pathsep}{own['PATH']}"
        words = [str(word) for word in command]
        done = subprocess.run(
            words, cwd=cwd or self.folder, env=own, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
        )
        if done.returncode != code:
            raise Failure(f"{' '.join(words)} ended with {done.returncode}, not {code}:\n{done.stdout}")
        return done.stdout

    def install(self, *what: str) -> None:
        """Install by pip."""
        self.call(self.bin / "python", "-m", "pip", "install", "--quiet", "--disable-pip-version-check", *what)

    def program(self, *words: str, code: int = 0) -> str:
        """Call the command line."""
        return self.call(self.bin / "membrane-rs", *words, code=code)


def expect(text: str, part: str) -> None:
    """See that a text has a part. Raises Failure."""
    if part not in text:
        raise Failure(f"{part!r} is not in:\n{text}")


def try_wheel(wheel: Path) -> None:
    """The package alone, then with its pictures."""
    began = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        with timed("environment and wheel"):
            fresh = Environment(Path(folder))
            fresh.install(str(wheel))
        with timed("version, scenes"):
            expect(fresh.program("--version"), wheel.name.split("-")[1])
            expect(fresh.program("scenes"), SCENE[0])
        with timed("a run without pictures"):
            fresh.program("run", *SCENE, "bare", "--no-pictures")
            expect((fresh.folder / "bare" / "summary.json").read_text(encoding="utf-8"), '"outcome": "finished"')
        expect(fresh.program("run", *SCENE, "refused", code=1), "membrane_rs[plot]")
        with timed("extra plot"):
            fresh.install(f"{wheel}[plot]")
        with timed("a run with pictures"):
            fresh.program("run", *SCENE, "drawn")
        if not (fresh.folder / "drawn" / "deployment.png").stat().st_size:
            raise Failure("deployment.png is empty")
    print(f"nothing to first picture: {time.perf_counter() - began:.1f} s", flush=True)


def try_source(archive: Path) -> None:
    """The source archive: whole, and it builds."""
    with tempfile.TemporaryDirectory() as folder:
        with tarfile.open(archive) as packed:
            packed.extractall(folder, filter="data")
        (tree,) = Path(folder).iterdir()
        missing = [name for name in LINK.findall((tree / "README.md").read_text(encoding="utf-8"))]
        missing = [name for name in missing if not (tree / name).exists()]
        if missing:
            raise Failure(f"README.md links to what the source archive lacks: {', '.join(missing)}")
        with tempfile.TemporaryDirectory() as other:
            fresh = Environment(Path(other))
            with timed("source archive, built"):
                fresh.install(f"{archive}[plot]", "pytest", "pytest-timeout", "hypothesis")
            with timed(f"tests of the source archive: {', '.join(TESTS)}"):
                paths = [str(tree / "tests" / name) for name in TESTS]
                fresh.call(fresh.bin / "python", "-m", "pytest", "-q", *paths, cwd=tree)


def only(files: Sequence[Path], what: str) -> Path:
    """The one file. Raises Failure."""
    if len(files) != 1:
        raise Failure(f"{len(files)} files of kind {what}, not one; run build.py first")
    return files[0]


def main() -> int:
    """Try both; the exit code."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--dist", type=Path, default=ROOT / "dist", help="folder of both files")
    options.add_argument("--only", choices=("wheel", "source"), help="try one of them")
    given = options.parse_args()
    folder = given.dist.resolve()
    try:
        if given.only != "source":
            try_wheel(only(list(folder.glob("*.whl")), "*.whl"))
        if given.only != "wheel":
            try_source(only(list(folder.glob("*.tar.gz")), "*.tar.gz"))
    except Failure as failure:
        print(f"failed: {failure}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
