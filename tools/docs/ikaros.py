"""The deployment of IKAROS by a hub that turns freely, for docs/ikaros.md: spin against the reported one, which sail
and hub would match, the second stage on other meshes and with other values, balances, cost.

Finished runs are kept in the folder `out` and read again; remove it to repeat them, which takes half an hour on two
cores. With `--write` the tables and pictures of docs/ikaros.md are replaced.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from threading import Event

from ikaros_balance import balance_table, cost_table, reeling_table
from ikaros_momentum import match_table, needed_table, spin_table, states_of
from ikaros_pictures import draw_second_stage, draw_spin
from ikaros_runs import film_masses, finer, ikaros, of_inertia, watched, whole
from ikaros_variants import MESHES, OTHER, OWN, mesh_name, of_mesh, variant_table, variants
from kept import kept, slug
from marked import DOCS, MarkedPart
from membrane_rs import Scene
from membrane_rs._arrays import Floats
from membrane_rs.study.common.executor import run_parallel

NAMES = ("spin", "needed", "match", "meshes", "values", "reeling", "balance", "cost")
PARTS = {name: MarkedPart(DOCS / "ikaros.md", f"ikaros-{name}") for name in NAMES}
INERTIAS = (72.0, 90.0, 108.0)
"""Of the hub: the scenes' own and 20 % to either side [kg m2]."""
OWN_INERTIA = INERTIAS[1]
Run = Mapping[str, Floats]


class Runs:
    """Runs by their names, each made once and kept in a folder."""

    def __init__(self, folder: Path, workers: int | None) -> None:
        self.folder, self.workers = folder, workers

    def of(self, scenes: Mapping[str, tuple[Scene, int]]) -> dict[str, Run]:
        """The runs of scenes from the starts of these seeds, in parallel."""
        calls = [
            partial(kept, self.folder / f"{slug(scene.name, name)}.npz", partial(watched, scene, seed))
            for name, (scene, seed) in scenes.items()
        ]
        found = run_parallel(calls, list(scenes), Event(), workers=self.workers, tell=partial(print, flush=True))
        return dict(zip(scenes, found, strict=True))

    def wholes(self) -> dict[float, Run]:
        """The whole deployment, by inertia of the hub [kg m2]."""
        found = self.of({f"{one:g} kg m2": (of_inertia(whole(), one), 0) for one in INERTIAS})
        return dict(zip(INERTIAS, found.values(), strict=True))

    def reelings(self) -> dict[str, Run]:
        """The whole deployment on its own mesh and on a finer one."""
        fine = self.of({"twice as fine": (finer(whole()), 0)})
        return {"as it is": self.wholes()[OWN_INERTIA], **fine}

    def meshes(self) -> dict[str, Run]:
        """The second stage on each mesh."""
        return self.of({mesh_name(*size): (of_mesh(ikaros(), *size), 0) for size in MESHES})

    def values(self) -> dict[str, Run]:
        """The second stage as it is, from another start and with other values."""
        others = {label: (scene, 0) for label, scene in variants().items()}
        return self.of({OWN: (ikaros(), 0), OTHER: (ikaros(), 1), **others})


def spin_part(runs: Runs, picture: Path) -> str:
    """The table of spin and its picture."""
    found = runs.wholes()
    draw_spin(found, states_of(whole(), found[OWN_INERTIA]), [stage.name for stage in whole().stages], picture)
    return spin_table(whole(), found)


def needed_part(runs: Runs, _: Path) -> str:
    """What the reported spins need, with the first of them taken in the roll and with the tips out."""
    states = states_of(whole(), runs.wholes()[OWN_INERTIA])
    return "\n".join(
        f"{start.label.capitalize()} at the first spin:\n\n{needed_table(states, start, OWN_INERTIA)}"
        for start in states[:2]
    )


def match_part(runs: Runs, _: Path) -> str:
    """Which film and hub would match."""
    return match_table(states_of(whole(), runs.wholes()[OWN_INERTIA]), float(film_masses(whole()).sum()))


def meshes_part(runs: Runs, picture: Path) -> str:
    """The second stage on each mesh, and its curves."""
    found = runs.meshes()
    draw_second_stage(found, picture)
    return variant_table(found, list(found)[-1])


def values_part(runs: Runs, picture: Path) -> str:
    """The second stage with other values, and its curves."""
    found = runs.values()
    draw_second_stage(found, picture)
    return variant_table(found, OWN)


def reeling_part(runs: Runs, _: Path) -> str:
    """The reeling out on both meshes."""
    return reeling_table(whole(), runs.reelings())


def balance_part(runs: Runs, _: Path) -> str:
    """Momentum and energy of each run."""
    wholes = {f"`ikaros-whole`, {one:g} kg m2": run for one, run in runs.wholes().items()}
    return balance_table({**wholes, "`ikaros`": runs.values()[OWN]})


def cost_part(runs: Runs, _: Path) -> str:
    """Steps and processor time."""
    wholes = {f"`ikaros-whole`, {name}": run for name, run in runs.reelings().items()}
    return cost_table(whole(), {**wholes, "`ikaros`": runs.values()[OWN]})


MAKERS: dict[str, Callable[[Runs, Path], str]] = {
    "spin": spin_part,
    "needed": needed_part,
    "match": match_part,
    "meshes": meshes_part,
    "values": values_part,
    "reeling": reeling_part,
    "balance": balance_part,
    "cost": cost_part,
}


def main() -> None:
    """Make the tables and pictures, or some of them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--only", nargs="+", choices=MAKERS, default=list(MAKERS), help="the tables to make")
    parser.add_argument("--jobs", type=int, help="number of parallel runs; default: one on each core")
    parser.add_argument("--out", type=Path, default=Path("out/ikaros"), help="folder of the results")
    parser.add_argument("--write", action="store_true", help="write into docs/")
    options = parser.parse_args()
    began = time.perf_counter()
    options.out.mkdir(parents=True, exist_ok=True)
    runs = Runs(options.out, options.jobs)
    for name in options.only:
        picture = options.out / f"ikaros-{name}.png"
        PARTS[name].publish(MAKERS[name](runs, picture), picture, write=options.write)
    print(f"{time.perf_counter() - began:.0f} s")


if __name__ == "__main__":
    main()
