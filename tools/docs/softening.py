"""The softened film charted, for docs/softening.md: error and cost, work-precision, wound sails, the rule.

Finished runs are kept in the folder `out` and read again; remove it to repeat them, which takes an hour on two cores.
With `--write` the tables and pictures of docs/softening.md, and the table of fast scenes in README.md, are replaced.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from marked import DOCS, ROOT, MarkedPart, copy_small
from softening_cases import (
    FAST_SCENES,
    FULL,
    MODELS,
    RULE,
    SOFTENINGS,
    Case,
    charted,
    displaced,
    fast_scene,
    of_rule,
    others,
    symmetric,
)
from softening_pictures import draw_curves, draw_distances, draw_front
from softening_rule import rule_table
from softening_runs import Ensemble, Extent, Runs, ensembles
from softening_substeps import substeps_table
from softening_tables import (
    cost_table,
    displacement_table,
    distance_table,
    fast_table,
    front_table,
    petals_table,
    starts_table,
)
from softening_wound import wound_ensembles, wound_table

STARTS, FEW = 12, 8
"""Starts of each ensemble of the paper's models, and of those that tell the bounds of the rule apart."""
QUICK = Extent(2, 0.02)
Found = Mapping[str, Mapping[str, Ensemble]]
Cases = dict[str, dict[str, Case]]


@dataclass(frozen=True)
class Part:
    """A table, and how it is made from the ensembles of `cases`. `pictures`: functions that draw into a file."""

    cases: Cases
    text: Callable[[Found], str]
    pictures: Mapping[str, Callable[[Found, Path], None]] = field(default_factory=dict)
    starts: int = STARTS


def all_cases(*kinds: Callable[[str], dict[str, Case]]) -> Cases:
    """The cases of some kinds, by model."""
    return {model: {label: case for kind in kinds for label, case in kind(model).items()} for model in MODELS}


def variants_table(found: Found) -> str:
    """Distances of coarser meshes and other dashpots alone."""
    kept = {
        model: {label: own for label, own in cases.items() if label not in CHART[model] or label == FULL}
        for model, cases in found.items()
    }
    return distance_table(kept)


def draw_rule(found: Found, picture: Path) -> None:
    """Distances of the scenes of the rule."""
    draw_distances(found, {name: RULE[name][1] for name in found}, picture)


CHART, FRONT = all_cases(charted), all_cases(charted, others)
ENSEMBLES = {
    "distances": Part(
        CHART,
        distance_table,
        {
            "softening-curves.png": lambda found, picture: draw_curves(found, SOFTENINGS, picture),
            "softening-distances.png": lambda found, picture: draw_distances(
                found, dict.fromkeys(found, SOFTENINGS), picture
            ),
        },
    ),
    "starts": Part(CHART, starts_table),
    "fast-scenes": Part(all_cases(fast_scene), lambda found: fast_table(found, FAST_SCENES)),
    "cost": Part(CHART, cost_table),
    "front": Part(FRONT, front_table, {"softening-front.png": draw_front}),
    "variants": Part(FRONT, variants_table),
    "displacement": Part(all_cases(charted, displaced), displacement_table),
    "petals": Part(all_cases(symmetric), petals_table),
    "apart": Part(
        {name: of_rule(name) for name in RULE}, distance_table, {"softening-rule.png": draw_rule}, starts=FEW
    ),
}
OTHER: dict[str, Callable[[Runs], str]] = {
    "rule": lambda _: rule_table(),
    "substeps": substeps_table,
    "wound": lambda runs: wound_table(wound_ensembles(runs)),
}
ELSEWHERE = {"fast-scenes": ROOT / "README.md"}
"""Pages of parts that are not in docs/softening.md."""
PARTS = {name: MarkedPart(ELSEWHERE.get(name, DOCS / "softening.md"), name) for name in (*ENSEMBLES, *OTHER)}


def made(name: str, runs: Runs, *, write: bool) -> str:
    """The text of a part; its pictures are drawn into the folder of the runs, and where `write` into docs/."""
    if name in OTHER:
        return OTHER[name](runs)
    part = ENSEMBLES[name]
    extent = Extent(min(part.starts, runs.extent.starts), runs.extent.share)
    found = ensembles(Runs(runs.folder, extent, runs.workers), part.cases)
    for picture, draw in part.pictures.items():
        draw(found, runs.folder / picture)
        if write:
            copy_small(runs.folder / picture, picture)
    return part.text(found)


def prepare(names: list[str], runs: Runs) -> None:
    """Make the runs of all parts that have as many starts together, so that their processor times can be compared."""
    together: Cases = {}
    for name in names:
        if name in ENSEMBLES and ENSEMBLES[name].starts == STARTS:
            for group, cases in ENSEMBLES[name].cases.items():
                together[group] = together.get(group, {}) | cases
    if together:
        ensembles(runs, together)


def main() -> None:
    """Make the tables and pictures, or some of them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--only", nargs="+", choices=list(PARTS), default=list(PARTS), help="the tables to make")
    parser.add_argument("--starts", type=int, default=STARTS, help="starts of each ensemble, at most")
    parser.add_argument("--quick", action="store_true", help="two starts, the first part of each run")
    parser.add_argument("--jobs", type=int, help="number of parallel runs; default: one on each core")
    parser.add_argument("--out", type=Path, default=Path("out/softening"), help="folder of the results")
    parser.add_argument("--write", action="store_true", help="write into docs/")
    options = parser.parse_args()
    began = time.perf_counter()
    options.out.mkdir(parents=True, exist_ok=True)
    runs = Runs(options.out, QUICK if options.quick else Extent(options.starts), options.jobs)
    prepare(options.only, runs)
    for name in options.only:
        text = made(name, runs, write=options.write)
        PARTS[name].publish(text, options.out / f"{name}.png", write=options.write)
    print(f"{time.perf_counter() - began:.0f} s")


if __name__ == "__main__":
    main()
