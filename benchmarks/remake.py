"""Every figure and table of the accuracy side, made anew from nothing: `make accuracy`.

Each part is a few commands of its own, which write into docs/ and README.md as they go. One that fails loses nothing
of the others; what failed is told at the end, and by the exit code. Parts that fill all cores run alone, the others
side by side.
"""

from __future__ import annotations

import argparse
import difflib
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
MAP = (
    "stability", "hanging-strip", "--integrator", "rk4", "--values", "0,0.02,0.1,0.3,1,3",
    "--steps", "0.05,0.1,0.25,0.5,0.75,0.95,1.05,1.5,3", "--out", "out/stability",
)  # fmt: skip


@dataclass(frozen=True)
class Part:
    """What can be remade alone: commands for this interpreter, and files to copy once they are done.

    `fills_cores`: it runs on all cores by itself.
    """

    name: str
    what: str
    commands: Sequence[Sequence[str]]
    copies: dict[str, str] = field(default_factory=dict)
    fills_cores: bool = False


CHARTS = ("spinning-tether", "spinning-disc", "single-crease", "release", "deployment")
ABLATIONS = ("spinning-tether", "okuizumi-model-1", "okuizumi-model-2")
PARTS = (
    Part(
        "charts",
        "docs/studies.md: error against work",
        [("tools/docs/charts.py", "--write", "--only", *(f"{name}-chart" for name in CHARTS))],
        fills_cores=True,
    ),
    Part(
        "ablations",
        "docs/studies.md: what each law costs and changes",
        [("tools/docs/charts.py", "--write", "--only", *(f"{name}-ablation" for name in ABLATIONS))],
        fills_cores=True,
    ),
    Part(
        "meshes",
        "docs/mesh_parameters.md: convergence with the mesh",
        [("tools/docs/mesh_parameters.py", "--write")],
        fills_cores=True,
    ),
    Part("integrators", "docs/integrators.md: orders, kinks, limits", [("benchmarks/integrators.py", "--write")]),
    Part("limits", "docs/limits.md: steps predicted and measured", [("tests/limit_cases.py",)]),
    Part("poisoned", "docs/poisoned.md: how poisoned runs end", [("tests/poisoned.py",)]),
    Part(
        "map",
        "docs/stability.png: which steps are fine",
        [("-m", "membrane_rs.cli", *MAP)],
        copies={"out/stability/stability-rk4.png": "docs/stability.png"},
    ),
    Part(
        "readme",
        "README.md: the table of known answers",
        [("tools/docs/accuracy.py",), ("tools/docs/readme_numbers.py", "--write", "--tables", "accuracy.md")],
    ),
)


def remake(part: Part) -> tuple[bool, float]:
    """Run the commands of a part, its name before every line that they say; whether all went well, and the time [s]."""
    began = time.perf_counter()
    for words in part.commands:
        process = subprocess.Popen(
            [sys.executable, "-u", *words],
            cwd=ROOT,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            encoding="utf-8",
        )
        assert process.stdout is not None
        try:
            for line in process.stdout:
                print(f"{part.name:<11} | {line}", end="", flush=True)
        finally:
            if sys.exc_info()[0] is not None:
                process.terminate()
        if process.wait():
            return False, time.perf_counter() - began
    for source, target in part.copies.items():
        shutil.copy(ROOT / source, ROOT / target)
    return True, time.perf_counter() - began


def main() -> None:
    """Make all parts, or those that are named."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("parts", nargs="*", metavar="PART", help="of those that --list shows; default: all")
    parser.add_argument("--list", action="store_true", help="show the parts, and make none")
    options = parser.parse_args()
    names = [part.name for part in PARTS]
    if options.list:
        print("\n".join(f"{part.name:<11} {part.what}" for part in PARTS))
        return
    for name in options.parts:
        if name not in names:
            near = difflib.get_close_matches(name, names, 1)
            hint = f"did you mean {near[0]!r}?" if near else f"known are: {', '.join(names)}"
            parser.error(f"there is no part {name!r}; {hint}")
    chosen = [part for part in PARTS if part.name in (options.parts or names)]

    began, ended = time.perf_counter(), {}

    def done(part: Part) -> None:
        ended[part.name] = remake(part)
        fine, seconds = ended[part.name]
        print(f"{part.name:<11} | {'done' if fine else 'FAILED'} after {seconds:.0f} s", flush=True)

    for part in (part for part in chosen if part.fills_cores):
        done(part)
    with ThreadPoolExecutor(max_workers=os.cpu_count()) as pool:
        list(pool.map(done, [part for part in chosen if not part.fills_cores]))
    print(f"\nAll took {time.perf_counter() - began:.0f} s:")
    for part in chosen:
        fine, seconds = ended[part.name]
        print(f"  {part.name:<11} {seconds:>5.0f} s  {'done' if fine else 'FAILED'}  {part.what}")
    if not all(fine for fine, _ in ended.values()):
        sys.exit(
            "Some parts failed; make them alone with: make accuracy PART="
            + " ".join(n for n in ended if not ended[n][0])
        )


if __name__ == "__main__":
    main()
