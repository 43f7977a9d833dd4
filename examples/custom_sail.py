"""A sail of one's own: other dimensions, folds, film and spin than the paper's, from Python."""

from __future__ import annotations

import argparse
import math

from membrane_rs import (
    AirDrag,
    Creases,
    Material,
    RunSettings,
    Scene,
    Simulation,
    Spin,
    SpoolContact,
    SpringDamping,
    Springs,
    Tethers,
    TipMasses,
    folding,
)
from membrane_rs.results import deployment_rate


def scene() -> Scene:
    """A sail of 0.3 m with five fold lines in each petal, of 12.5 um film, at 4 turns per second."""
    sail = folding.SquareSail(outer_width=0.30, inner_width=0.09, fold_lines=5, rows=12, spool_radius=0.02)
    film = Material(youngs_modulus=3.2e9, poisson_ratio=0.34, density=1420.0, thickness=12.5e-6)
    return Scene(
        sail.mesh(),
        film,
        laws=[
            Springs(buckling=50.0),
            SpringDamping(ratio=0.02),
            Creases(stiffness=5.0, natural_angle=math.radians(20)),
            AirDrag(pressure=1.0),
            Spin(frequency=4.0),
            SpoolContact(radius=0.02),
        ],
        parts=[TipMasses(mass=0.3e-3), Tethers(anchor_radius=0.02, segments=8)],
        name="my-sail",
        run=RunSettings(until=0.6),
    )


def main() -> None:
    """Check it, save it as a scene file, run its beginning."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--until", type=float, default=0.02, help="simulated time [s]")
    options = parser.parse_args()

    mine = scene()
    assert mine.mesh is not None
    print(mine.counts())
    print(mine.mesh.audit(mine.material))
    print(mine.to_toml().splitlines()[0], "... is what Scene.save(folder) writes as scene.toml")
    sim = Simulation(mine)
    print(f"step {sim.dt:.3g} s, limited by {sim.limiting_part}")
    for fifth in range(1, 6):
        sim.run(until=options.until * fifth / 5)
        print(f"t = {sim.time:.4f} s: deployment rate {deployment_rate(sim):.4f}")


if __name__ == "__main__":
    main()
