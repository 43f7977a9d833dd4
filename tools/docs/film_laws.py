"""Springs, rectangles and triangles as the film: what each represents of it, its largest stable step and its cost.

Shares of energy are those of uniform strains of 1e-6 on a mesh of squares, by the energies of the simulator. Times are
processor times of rk4, the least of slices that take turns. With `--write` the tables of docs/choosing.md are replaced.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from marked import DOCS, MarkedPart
from membrane_rs import (
    Fixed,
    Material,
    MeshError,
    Rectangles,
    Scene,
    Simulation,
    SpringDamping,
    Springs,
    Triangles,
    scenes,
)
from membrane_rs._arrays import Floats
from membrane_rs._markdown import table
from membrane_rs.folding import Strip
from membrane_rs.scene.laws import Law
from membrane_rs.study.limits import measured_limit

PARTS = {name: MarkedPart(DOCS / "choosing.md", name) for name in ("film-shares", "film-cost")}
MODEL = "okuizumi-model-1"
RATIOS = (0.0, 0.2, 1 / 3, 0.34, 0.45)
"""Poisson's ratios of the film [-]."""
TAUT: dict[str, Law] = {
    "springs": Springs(buckling=1e12, buckling_on_creases=1e12),
    "rectangles": Rectangles(buckling=1e12, buckling_on_creases=1e12),
    "triangles": Triangles(compression=1.0),
}
"""Films that do not buckle."""
STRAINS: dict[str, tuple[float, float, float]] = {
    "along a side": (1.0, 0.0, 0.0),
    "shear along it": (0.0, 0.0, 1.0),
    "along a diagonal": (0.5, 0.5, 1.0),
    "cap": (1.0, 1.0, 0.0),
    "saddle": (1.0, -1.0, 0.0),
}
"""Uniform strains by name: along x, along y, and the shear strain."""
SLENDER = 20.0
"""Rectangles with longer sides are not tried."""
SMALL = 1e-6
"""Size of the strains [-]."""


def main() -> None:
    """Measure, print, and write if asked."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--quick", action="store_true", help="few repeats: for a check, not for measurements")
    parser.add_argument("--write", action="store_true", help="write into docs/")
    options = parser.parse_args()
    for name, text in {"film-shares": shares(), "film-cost": cost(3 if options.quick else 40)}.items():
        print(f"\n{name}\n\n{text}", flush=True)
        if options.write:
            PARTS[name].write(text)


def shares() -> str:
    """Energies of uniform strains over those of the film in plane stress, by law and Poisson's ratio."""
    body = []
    for name, law in TAUT.items():
        for nu in RATIOS:
            found = (f"{share(law, nu, strain):.3f}" for strain in STRAINS.values())
            most = longest_side(law, nu)
            body.append((name, f"{nu:.2f}", *found, f"{most:.3f}" if most < SLENDER else "any"))
    return table(("energy over the film's", "nu", *STRAINS, "longest side"), body)


def longest_side(law: Law, nu: float) -> float:
    """The longest side of rectangles with other sides of 1 with which a scene is taken; `SLENDER`: any."""

    def is_taken(side: float) -> bool:
        mesh, film = Strip(0.04 * side, 0.04, 4, 4).mesh(), Material(3.2e9, nu, 1420.0, 7.5e-6)
        try:
            Simulation(Scene(mesh, film, [law], [Fixed("start")]))
        except MeshError:
            return False
        return True

    low, high = 1.0, SLENDER
    if is_taken(high):
        return high
    while high - low > 1e-4:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if is_taken(middle) else (low, middle)
    return low


def share(law: Law, nu: float, strain: tuple[float, float, float]) -> float:
    """The energy of a uniform strain of squares over that of the film in plane stress."""
    mesh, film = Strip(0.08, 0.08, 8, 8).mesh(), Material(3.2e9, nu, 1420.0, 7.5e-6)
    sim = Simulation(Scene(mesh, film, [law], [Fixed("start")]))
    e1, e2, g = (SMALL * component for component in strain)
    gradient = np.array([[1 + e1, g / 2, 0.0], [g / 2, 1 + e2, 0.0], [0.0, 0.0, 1.0]])
    sim.positions = mesh.reference @ gradient.T
    stretch = film.youngs_modulus / (1.0 - nu * nu) * (e1 * e1 + e2 * e2 + 2.0 * nu * e1 * e2)
    shear = film.youngs_modulus / (2.0 + 2.0 * nu) * g * g
    return float(sim.energies()[law.kind] / (0.5 * (stretch + shear) * film.thickness * mesh.areas().sum()))


def cost(repeats: int) -> str:
    """Elements, largest stable step and times of steps of model 1, by law."""
    whole = {name: scene_of(law, is_whole=True) for name, law in films().items()}
    alone = {name: scene_of(law, is_whole=False) for name, law in films().items()}
    limits = {name: Simulation(scene).stable_dt() for name, scene in whole.items()}
    with_all, of_film = times(whole, repeats), times(alone, repeats)
    body = []
    for name, scene in whole.items():
        mesh = scene.mesh
        assert mesh is not None
        count = {"springs": len(mesh.edges), "triangles": len(mesh.triangles)}
        elements = count.get(name, len(mesh.edges) + len(mesh.triangles) // 2)
        step = with_all[name] / with_all["springs"]
        run = step * limits["springs"] / limits[name]
        measured = 1e6 * measured_limit(scene, "rk4")
        numbers = (1e6 * limits[name], measured, of_film[name] / of_film["springs"], step, run)
        body.append((name, f"{elements:,}", *(f"{number:.2f}" for number in numbers)))
    head = (
        "model 1, rk4",
        "elements",
        "stable step [us]",
        "measured [us]",
        "film and its damping",
        "all laws",
        "a second at that step",
    )
    return table(head, body)


def films() -> dict[str, Law]:
    """The films of model 1; buckling is that of its springs."""
    springs = scenes.load(MODEL).law("springs")
    assert isinstance(springs, Springs)
    alphas = {"buckling": springs.buckling, "buckling_on_creases": springs.buckling_on_creases}
    return {"springs": springs, "rectangles": Rectangles(**alphas), "triangles": Triangles(**alphas)}


def scene_of(law: Law, *, is_whole: bool) -> Scene:
    """Model 1 with this film, with all laws or with that of the film and its damping alone."""
    scene = scenes.load(MODEL)
    laws = [law if other.is_film else other for other in scene.laws]
    kept = laws if is_whole else [law, *(other for other in laws if isinstance(other, SpringDamping))]
    return replace(scene, laws=kept)


def times(films: Mapping[str, Scene], repeats: int, steps: int = 100) -> dict[str, float]:
    """Processor time of a step of each scene from its start [s]: the least of `repeats` slices that take turns."""
    sims = {name: Simulation(scene, "rk4", dt=1e-6) for name, scene in films.items()}
    starts: dict[str, tuple[Floats, Floats]] = {name: (sim.positions, sim.velocities) for name, sim in sims.items()}
    least = dict.fromkeys(sims, np.inf)
    for _ in range(repeats):
        for name, sim in sims.items():
            sim.positions, sim.velocities = starts[name]
            began = time.process_time()
            sim.step(steps)
            least[name] = min(least[name], (time.process_time() - began) / steps)
    return least


if __name__ == "__main__":
    main()
