"""The deployment of IKAROS by a hub that turns freely, for docs/ikaros.md: spin against the reported one, which sail
and hub would match, the second stage on other meshes and with other values, balances, cost.

Finished runs are kept in the folder `out` and read again; remove it to repeat them, which takes half an hour on two
cores. With `--write` the tables and pictures of docs/ikaros.md are replaced.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

from ikaros_balance import balance_table, cost_table, reeling_table, roll_table
from ikaros_momentum import match_table, needed_table, spin_table, states_of
from ikaros_pictures import draw_second_stage, draw_spin
from ikaros_runs import film_masses, finer, ikaros, in_time, of_inertia, watched, whole
from ikaros_shapes import write_shapes
from ikaros_variants import MESHES, OTHER, OWN, mesh_name, of_mesh, variant_table, variants
from marked import DOCS, MarkedPart
from membrane_rs import Scene
from membrane_rs._arrays import Floats
from page_of_runs import Runs, make_page

NAMES = ("spin", "needed", "match", "meshes", "values", "roll", "reeling", "balance", "cost")
PARTS = {name: MarkedPart(DOCS / "ikaros.md", f"ikaros-{name}") for name in NAMES}
INERTIAS = (72.0, 90.0, 108.0)
"""Of the hub: the scenes' own and 20 % to either side [kg m2]."""
OWN_INERTIA = INERTIAS[1]
DURATIONS = (30.0, 60.0, 240.0)
"""Of the reeling out, besides that of the scene [s]."""
FINER = "twice as fine"
Run = Mapping[str, Floats]


class Sails(Runs):
    """Runs of both scenes."""

    def sails(self, scenes: Mapping[str, tuple[Scene, int]]) -> dict[str, Run]:
        """The runs of scenes from the starts of these seeds."""
        jobs = {f"{scene.name} {name}": partial(watched, scene, seed) for name, (scene, seed) in scenes.items()}
        return dict(zip(scenes, self.of(jobs).values(), strict=True))

    def wholes(self) -> dict[float, Run]:
        """The whole deployment, by inertia of the hub [kg m2]."""
        found = self.sails({f"{one:g} kg m2": (of_inertia(whole(), one), 0) for one in INERTIAS})
        return dict(zip(INERTIAS, found.values(), strict=True))

    def reelings(self) -> dict[str, tuple[Scene, Run]]:
        """The whole deployment as it is, from another start, on a finer mesh and in other times, with their scenes."""
        scene = whole()
        others = {OTHER: (scene, 1), FINER: (finer(scene), 0)}
        others |= {f"in {duration:g} s": (in_time(scene, duration), 0) for duration in DURATIONS}
        made = {OWN: self.wholes()[OWN_INERTIA], **self.sails(others)}
        return {label: (others.get(label, (scene, 0))[0], run) for label, run in made.items()}

    def meshes(self) -> dict[str, Run]:
        """The second stage on each mesh."""
        return self.sails({mesh_name(*size): (of_mesh(ikaros(), *size), 0) for size in MESHES})

    def values(self) -> dict[str, Run]:
        """The second stage as it is, from another start and with other values."""
        others = {label: (scene, 0) for label, scene in variants().items()}
        return self.sails({OWN: (ikaros(), 0), OTHER: (ikaros(), 1), **others})


def spin_part(runs: Sails, picture: Path) -> str:
    """The table of spin and its picture."""
    found = runs.wholes()
    draw_spin(found, states_of(whole(), found[OWN_INERTIA]), stage_names(), picture)
    return spin_table(whole(), found)


def needed_part(runs: Sails, _: Path) -> str:
    """What the reported spins need, with the first of them taken in the roll and with the tips out."""
    states = states_of(whole(), runs.wholes()[OWN_INERTIA])
    return "\n".join(
        f"{start.label.capitalize()} at the first spin:\n\n{needed_table(states, start, OWN_INERTIA)}"
        for start in states[:2]
    )


def match_part(runs: Sails, _: Path) -> str:
    """Which film and hub would match."""
    return match_table(states_of(whole(), runs.wholes()[OWN_INERTIA]), float(film_masses(whole()).sum()))


def meshes_part(runs: Sails, picture: Path) -> str:
    """The second stage on each mesh, and its curves."""
    found = runs.meshes()
    draw_second_stage(found, picture)
    return variant_table(found, list(found)[-1])


def values_part(runs: Sails, picture: Path) -> str:
    """The second stage with other values, and its curves."""
    found = runs.values()
    draw_second_stage(found, picture)
    return variant_table(found, OWN)


def roll_part(runs: Sails, _: Path) -> str:
    """What holds the roll together."""
    return roll_table(whole(), runs.wholes()[OWN_INERTIA])


def reeling_part(runs: Sails, _: Path) -> str:
    """The reeling out on both meshes and in other times."""
    return reeling_table(runs.reelings())


def balance_part(runs: Sails, _: Path) -> str:
    """Momentum and energy of each stage of both scenes."""
    return balance_table({"`ikaros-whole`": runs.wholes()[OWN_INERTIA], "`ikaros`": runs.values()[OWN]}, stage_names())


def cost_part(runs: Sails, _: Path) -> str:
    """Steps and processor time."""
    wholes = {f"`ikaros-whole`, {name}": runs.reelings()[name][1] for name in (OWN, FINER)}
    return cost_table({**wholes, "`ikaros`": runs.values()[OWN]}, stage_names())


def stage_names() -> list[str]:
    """Those of the whole deployment."""
    return [stage.name for stage in whole().stages]


MAKERS: dict[str, Callable[[Sails, Path], str]] = {
    "spin": spin_part,
    "needed": needed_part,
    "match": match_part,
    "meshes": meshes_part,
    "values": values_part,
    "roll": roll_part,
    "reeling": reeling_part,
    "balance": balance_part,
    "cost": cost_part,
}


if __name__ == "__main__":
    make_page(
        "ikaros",
        __doc__,
        runs_in=Sails,
        parts=PARTS,
        makers=MAKERS,
        write_shapes=lambda runs: write_shapes(runs.folder),
    )
