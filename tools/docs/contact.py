"""Contact between layers, for docs/contact.md: crossings, energy, cost, change, sheets, strip, roll, whole deployment.

Finished runs are kept in the folder `out` and read again; remove it to repeat them. With `--write` the tables and
pictures of docs/contact.md are replaced.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

from contact_pictures import draw_arm, draw_cost, draw_crossings, draw_curves
from contact_roll import at_rest, roll_table
from contact_runs import MODELS, OWN, WITH, arm_of, both, ensembles, fast, single
from contact_sheets import SPEEDS, sheets_table, thrown
from contact_strip import pressed, strip_table
from contact_tables import (
    EDGES,
    change_table,
    cost_table,
    crossings_table,
    distance_table,
    energy_table,
    ratios,
    spent_table,
    times_of_step,
)
from contact_whole import deployed, whole_table
from marked import DOCS, MarkedPart, copy_small
from membrane_rs._arrays import Floats
from page_of_runs import Runs, make_page

NAMES = ("crossings", "cost", "change", "sheets", "strip", "roll", "whole")
PARTS = {name: MarkedPart(DOCS / "contact.md", f"contact-{name}") for name in NAMES}
ALIGNED = "1 m/s, node over node"
SCENES = (MODELS[0], fast(MODELS[0]))
"""Of the runs whose crossings are drawn."""


def crossings_part(runs: Runs, picture: Path) -> str:
    """The tables of crossings and of the balance, and their curves."""
    found = {name: single(runs, name) for name in SCENES}
    draw_crossings(found, picture)
    return f"{crossings_table(found)}\n{energy_table(found)}"


def cost_part(runs: Runs, picture: Path) -> str:
    """The tables of times, and their picture."""
    found = ensembles(runs)
    own = found[MODELS[0]]
    over = {model: ratios(kinds, EDGES) for model, kinds in found.items()}
    draw_cost(EDGES, over, times_of_step(own, EDGES), picture)
    return f"{cost_table(found)}\n{spent_table(own)}"


def change_part(runs: Runs, picture: Path) -> str:
    """The tables of features and distances, and the curves of all starts."""
    found = ensembles(runs)
    draw_curves(found, picture)
    return f"{change_table(found)}\n{distance_table(found)}"


def sheets_part(runs: Runs, _: Path) -> str:
    """The table of sheets that are thrown."""
    cases = {f"{speed:g} m/s": (speed, False) for speed in SPEEDS} | {ALIGNED: (1.0, True)}
    jobs: dict[str, Callable[[], Mapping[str, Floats]]] = {
        f"sheets {label} {kind}": partial(thrown, speed, with_contact=kind == WITH, aligned=aligned)
        for label, (speed, aligned) in cases.items()
        for kind in (OWN, WITH)
    }
    found = runs.of(jobs)
    return sheets_table({label: (found[f"sheets {label} {OWN}"], found[f"sheets {label} {WITH}"]) for label in cases})


def strip_part(runs: Runs, _: Path) -> str:
    """The table of the folded strip."""
    return strip_table(*both(runs, "strip", pressed).values())


def roll_part(runs: Runs, _: Path) -> str:
    """The table of the roll at rest."""
    return roll_table(*both(runs, "roll", at_rest).values())


def whole_part(runs: Runs, _: Path) -> str:
    """The table of the whole deployment."""
    return whole_table(*both(runs, "whole", deployed).values())


def write_arm(runs: Runs) -> None:
    """An arm with contact and without it, into docs/."""
    picture = runs.folder / "contact-arm.png"
    draw_arm(arm_of(runs), picture)
    copy_small(picture, picture.name)


MAKERS: dict[str, Callable[[Runs, Path], str]] = {
    "crossings": crossings_part,
    "cost": cost_part,
    "change": change_part,
    "sheets": sheets_part,
    "strip": strip_part,
    "roll": roll_part,
    "whole": whole_part,
}


if __name__ == "__main__":
    make_page("contact", __doc__, runs_in=Runs, parts=PARTS, makers=MAKERS, write_shapes=write_arm)
