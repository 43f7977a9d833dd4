"""Work-precision diagrams of five motions and ablations of three scenes, for docs/studies.md.

Writes into the folder `out`. With `--write` the pictures, tables and smallest models in docs/ are replaced, each as
soon as it is done; `--only` makes some of them.
"""

from __future__ import annotations

import argparse
import difflib
import math
import shutil
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from marked import DOCS, MarkedPart, copy_small
from membrane_rs import MembraneError, Scene, Springs, scenes
from membrane_rs.scene.laws import Law
from membrane_rs.study import Ablation, WorkPrecision, ablate, work_precision

BRIEF_STEPS = 2
"""Number of levels below the limit in a brief run."""
NEVER = 1e12
"""A value of alpha at which no spring buckles."""


@dataclass(frozen=True)
class Motion:
    """The motion of a diagram: scene, end [s], and kind of comparison.

    `softenings` of films that are compared with that of the scene. `kinks`: end [s] of two more series by rk4, with and
    without buckling, which show the effect of kinks on the order. `budget` is that of a run [s].
    """

    scene: str
    until: float
    steps: int = 6
    curves: bool = False
    members: int = 0
    wanted: float = 1e-3
    repeats: int = 3
    budget: float | None = None
    softenings: tuple[float, ...] = ()
    kinks: float | None = None


DIAGRAMS = {
    "spinning-tether": Motion("spinning-tether", 0.1),
    "spinning-disc": Motion("spinning-disc", 0.02),
    "single-crease": Motion("single-crease", 0.05, kinks=0.05),
    "release": Motion("okuizumi-model-1", 0.01, members=2, repeats=1, budget=20.0, kinks=0.002),
    "deployment": Motion(
        "okuizumi-model-1", 0.8, 3, curves=True, members=4, wanted=0.01, repeats=1, budget=80.0, softenings=(3, 10, 30)
    ),
}
ABLATIONS = {
    "spinning-tether": (0.3, None),
    "okuizumi-model-1": (0.8, 0.2),
    "okuizumi-model-2": (0.8, 0.2),
}
"""Scenes, with the end of their runs and of the run on the denser mesh [s]."""
SHARE = 0.3
"""Steps of the ablations over the limit: at larger ones the energy error of leapfrog over 0.8 s is too large."""
Make = Callable[[str, float, Path], tuple[str, dict[str, Path]]]
NAMES = [*(f"{name}-work-precision" for name in DIAGRAMS), *(f"{name}-ablation" for name in ABLATIONS)]
"""All parts."""
PARTS = {name: MarkedPart(DOCS / "studies.md", name) for name in NAMES}
BRIEF = (
    "spinning-disc-work-precision",
    "single-crease-work-precision",
    "deployment-work-precision",
    "spinning-tether-ablation",
)
"""The parts of a brief run."""


def main() -> None:
    """Make all diagrams and tables, or some."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--only", nargs="+", metavar="NAME", help=f"of {', '.join(NAMES)}")
    parser.add_argument(
        "--until", type=float, default=math.inf, help="a brief run: end here [s]; some parts, with few levels"
    )
    parser.add_argument("--out", type=Path, default=Path("out"), help="folder of the results")
    parser.add_argument("--write", action="store_true", help="write into docs/")
    options = parser.parse_args()
    wanted: Sequence[str] = options.only or (NAMES if math.isinf(options.until) else BRIEF)
    for name in wanted:
        if name not in NAMES:
            near = difflib.get_close_matches(name, NAMES, 1) or [", ".join(NAMES)]
            parser.error(f"--only: there is no {name!r}; did you mean {near[0]}?")

    failed = []
    for name in wanted:
        began = time.perf_counter()
        make: Make = ablated if name.endswith("-ablation") else diagrammed
        what = name.removesuffix("-ablation").removesuffix("-work-precision")
        try:
            text, files = make(what, options.until, options.out / name)
        except MembraneError as error:
            print(f"{name}: failed after {time.perf_counter() - began:.0f} s: {error}\n", flush=True)
            failed.append(name)
            continue
        print(f"{text}\n\n{name}: {time.perf_counter() - began:.0f} s\n", flush=True)
        if options.write:
            PARTS[name].write(text)
            for target, source in files.items():
                if source.suffix == ".png":
                    copy_small(source, target)
                else:
                    shutil.copy(source, DOCS / target)
    if failed:
        sys.exit(f"failed: {', '.join(failed)}; the others are done")


def diagrammed(name: str, until: float, folder: Path) -> tuple[str, dict[str, Path]]:
    """One diagram: its text in docs/studies.md, and its picture."""
    motion, is_brief = DIAGRAMS[name], until < DIAGRAMS[name].until
    if is_brief:
        motion = replace(motion, until=until, steps=BRIEF_STEPS, repeats=1, members=min(motion.members, 1))
    scene = scenes.load(motion.scene)
    found = _diagram(scene, motion)
    found.save(folder)
    text = f"```text\n{found.summary()}\n```"
    if motion.kinks is not None:
        alone = replace(motion, until=min(motion.kinks, motion.until), members=0, repeats=1)
        smooth = replace(scene, laws=[_unbuckled(law) for law in scene.laws])
        orders = [_order(_diagram(each, alone, ["rk4"]).orders["rk4"]["position"]) for each in (scene, smooth)]
        text += f"\n\nMeasured order of rk4 over {1e3 * alone.until:g} ms: {orders[0]}; where no spring may buckle"
        text += f" (alpha {NEVER:g}): {orders[1]}."
    return text, {f"work-precision-{name}.png": folder / "chart.png"}


def ablated(name: str, until: float, folder: Path) -> tuple[str, dict[str, Path]]:
    """One ablation: its table, and the smallest model."""
    end, dense_until = ABLATIONS[name]
    members = 3 if until >= end else 1
    found: Ablation = ablate(
        scenes.load(name),
        min(end, until),
        members=members,
        integrator="leapfrog",
        share=SHARE,
        dense_until=dense_until,
        progress=_tell,
    )
    found.save(folder)
    scene = folder / "smallest-model" / "scene.toml"
    files = {f"smallest-{name}.toml": scene} if found.smallest is not None else {}
    link = f" As a scene: [smallest-{name}.toml](smallest-{name}.toml)." if files else ""
    return f"{found.heading()}.\n\n{found.table()}\n{found.verdict()}{link}", files


def _diagram(scene: Scene, motion: Motion, methods: list[str] | None = None) -> WorkPrecision:
    return work_precision(
        scene,
        methods,
        motion.until,
        steps=motion.steps,
        curves=motion.curves,
        members=motion.members,
        softenings=motion.softenings,
        wanted=motion.wanted,
        repeats=motion.repeats,
        budget=motion.budget,
        progress=_tell,
    )


def _unbuckled(law: Law) -> Law:
    return replace(law, buckling=NEVER, buckling_on_creases=NEVER) if isinstance(law, Springs) else law


def _order(value: float) -> str:
    return f"{value:.2f}" if math.isfinite(value) else "none, errors too close to the bounds"


def _tell(words: str) -> None:
    print(words, flush=True)


if __name__ == "__main__":
    main()
