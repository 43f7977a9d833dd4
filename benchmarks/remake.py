"""All figures and tables on accuracy, remade from scratch: `make accuracy`.

Each part is a sequence of commands that write into docs/. A part that fails does not affect the others;
failures are reported at the end and by the exit code. Parts that use all cores run alone, the others in parallel.
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
    """A unit of work: commands for this interpreter, and files to copy afterwards.

    `fills_cores`: it runs on all cores by itself.
    """

    name: str
    what: str
    commands: Sequence[Sequence[str]]
    copies: dict[str, str] = field(default_factory=dict)
    fills_cores: bool = False


DIAGRAMS = ("spinning-tether", "spinning-disc", "single-crease", "release", "deployment")
ABLATIONS = ("spinning-tether", "okuizumi-model-1", "okuizumi-model-2")
PARTS = (
    Part(
        "work-precision",
        "docs/studies.md: work-precision diagrams",
        [("tools/docs/studies.py", "--write", "--only", *(f"{name}-work-precision" for name in DIAGRAMS))],
        fills_cores=True,
    ),
    Part(
        "ablations",
        "docs/studies.md: cost and effect of each law",
        [("tools/docs/studies.py", "--write", "--only", *(f"{name}-ablation" for name in ABLATIONS))],
        fills_cores=True,
    ),
    Part(
        "meshes",
        "docs/mesh_parameters.md: convergence with the mesh",
        [("tools/docs/mesh_parameters.py", "--write")],
        fills_cores=True,
    ),
    Part(
        "net",
        "docs/net_of_springs.md: moduli of nets of springs, and what they change",
        [("tools/docs/net_of_springs.py", "--write")],
        fills_cores=True,
    ),
    Part(
        "films",
        "docs/choosing.md: springs, rectangles and triangles: shares of energy, stable steps, cost",
        [("tools/docs/film_laws.py", "--write")],
        fills_cores=True,
    ),
    Part(
        "free-hub",
        "docs/free_hub.md: free hubs against closed forms, and their cost",
        [("tools/docs/free_hub.py", "--write"), ("tools/docs/flight.py", "--write")],
    ),
    Part(
        "hexagon",
        "docs/hexagon.md: strain and crossings of polygons, and how one spins out",
        [("tools/docs/hexagon.py", "--write")],
    ),
    Part(
        "bending",
        "docs/bending.md: beams and plates with closed forms, and the cost of bending",
        [("tools/docs/bending.py", "--write")],
    ),
    Part(
        "folding",
        "docs/folding.md: patterns folded by simulation, against closed forms",
        [("tools/docs/folding.py", "--write")],
    ),
    Part(
        "devices",
        "docs/ikaros_devices.md: the sail of IKAROS in sunlight, with devices that curl it and without",
        [("tools/docs/ikaros_devices.py", "--write")],
        fills_cores=True,
    ),
    Part(
        "contact",
        "docs/contact.md: contact between layers, its cost, and what it changes",
        [("tools/docs/contact.py", "--write")],
        fills_cores=True,
    ),
    Part(
        "dashpots",
        "docs/dashpots.md: forms of the dashpots compared",
        [("tools/docs/dashpots.py", "--write")],
        fills_cores=True,
    ),
    Part(
        "softening",
        "docs/softening.md: error and cost of softened films",
        [("tools/docs/softening.py", "--write"), ("tools/docs/mass_scaling.py", "--write")],
        fills_cores=True,
    ),
    Part("integrators", "docs/integrators.md: orders, kinks, limits", [("benchmarks/integrators.py", "--write")]),
    Part("limits", "docs/limits.md: limits predicted and measured", [("tests/limit_cases.py",)]),
    Part("steps", "docs/step_accuracy.md: errors of default steps", [("tests/step_accuracy_cases.py",)]),
    Part("faults", "docs/fault_injection.md: outcomes of faulty runs", [("tests/fault_injection.py",)]),
    Part("motions", "docs/rigid_motions.md: verdicts on scenes that fly and turn", [("tests/rigid_motions.py",)]),
    Part(
        "map",
        "docs/stability.png: outcomes over step and damping",
        [("-m", "membrane_rs.cli", *MAP)],
        copies={"out/stability/stability-rk4.png": "docs/stability.png"},
    ),
    Part(
        "readme",
        "docs/accuracy.md: the table of exact solutions",
        [("tools/docs/accuracy.py",), ("tools/docs/readme_numbers.py", "--write", "--tables", "accuracy.md")],
    ),
)


def remake(part: Part) -> tuple[bool, float]:
    """Run the commands of a part, its name before every line of their output; (success, time [s])."""
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
                print(f"{part.name:<14} | {line}", end="", flush=True)
        finally:
            if sys.exc_info()[0] is not None:
                process.terminate()
        if process.wait():
            return False, time.perf_counter() - began
    for source, target in part.copies.items():
        shutil.copy(ROOT / source, ROOT / target)
    return True, time.perf_counter() - began


def main() -> None:
    """Make all parts, or the named ones."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("parts", nargs="*", metavar="PART", help="of those that --list shows; default: all")
    parser.add_argument("--list", action="store_true", help="list the parts, and make none")
    options = parser.parse_args()
    names = [part.name for part in PARTS]
    if options.list:
        print("\n".join(f"{part.name:<14} {part.what}" for part in PARTS))
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
        print(f"{part.name:<14} | {'done' if fine else 'FAILED'} after {seconds:.0f} s", flush=True)

    for part in (part for part in chosen if part.fills_cores):
        done(part)
    with ThreadPoolExecutor(max_workers=os.cpu_count()) as pool:
        list(pool.map(done, [part for part in chosen if not part.fills_cores]))
    print(f"\nAll took {time.perf_counter() - began:.0f} s:")
    for part in chosen:
        fine, seconds = ended[part.name]
        print(f"  {part.name:<14} {seconds:>5.0f} s  {'done' if fine else 'FAILED'}  {part.what}")
    if not all(fine for fine, _ in ended.values()):
        sys.exit(
            "Some parts failed; repeat them with: make accuracy PART=" + " ".join(n for n in ended if not ended[n][0])
        )


if __name__ == "__main__":
    main()
