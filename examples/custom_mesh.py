"""A mesh of one's own: a square folded along its diagonal, one half held, the other springing open."""

from __future__ import annotations

import argparse
import math

import numpy as np
from membrane_rs import Creases, Fixed, MassDamping, Material, Mesh, RunSettings, Scene, Simulation, Springs

SIDE = 0.05
"""Side of the square [m]."""


def folded_square(fold_angle: float) -> Mesh:
    """Two triangles that share the diagonal from node 0 to node 2, folded there as a valley.

    A fold angle of 0 is flat, pi is shut [rad]. Seen from above, the triangles run counter-clockwise.
    """
    flat = SIDE * np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
    folded = flat.copy()
    middle, outward = 0.5 * (flat[0] + flat[2]), np.array([-1.0, 1.0, 0.0]) / math.sqrt(2)
    up = np.array([0.0, 0.0, 1.0])  # the facets of a valley rise
    folded[3] = middle + SIDE / math.sqrt(2) * (math.cos(fold_angle) * outward + math.sin(fold_angle) * up)
    return Mesh(
        flat,
        [[0, 1, 2], [0, 2, 3]],
        positions=folded,
        creases=[[0, 2]],
        fold_angles=[fold_angle],
        node_sets={"held": [0, 1, 2], "free": [3]},
    )


def main() -> None:
    """Let it open, and print the crease's angle."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--until", type=float, default=0.5, help="simulated time [s]")
    options = parser.parse_args()

    film = Material(youngs_modulus=3.2e9, poisson_ratio=0.34, density=1420.0, thickness=7.5e-6)
    mesh = folded_square(math.radians(150))
    print(mesh.audit(film))
    scene = Scene(
        mesh,
        film,
        laws=[Springs(), Creases(natural_angle=math.pi), MassDamping(rate=20.0)],
        parts=[Fixed(nodes="held")],
        name="folded-square",
        run=RunSettings(until=options.until),
    )
    sim = Simulation(scene)
    for tenth in range(11):
        sim.run(until=options.until * tenth / 10)
        angle = math.degrees(sim.crease_angles()[0])
        print(f"t = {sim.time:.3f} s: crease angle {angle:6.1f} deg (180 is flat)")


if __name__ == "__main__":
    main()
