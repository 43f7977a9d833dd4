"""Deploy the sail of model 1, and read its measures; without --until only its first 20 ms."""

from __future__ import annotations

import argparse
from pathlib import Path

from membrane_rs import Simulation, scenes
from membrane_rs.results import deployment_rate


def main() -> None:
    """Run it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--until", type=float, default=0.02, help="simulated time [s], 0.8 in the paper")
    parser.add_argument("--out", type=Path, default=Path("out/deploy"), help="folder of the results")
    options = parser.parse_args()

    sim = Simulation(scenes.load("okuizumi-model-1"))
    print(f"{sim.node_count} nodes, step {sim.dt:.3g} s, limited by {sim.limiting_part}")
    print(f"t = {sim.time:.3f} s: deployment rate {deployment_rate(sim):.4f}")
    sim.run(until=options.until, frames=11, out=options.out, overwrite=True)
    print(f"t = {sim.time:.3f} s: deployment rate {deployment_rate(sim):.4f}")
    print({name: f"{energy:+.2e} J" for name, energy in sim.energies().items()})
    print(f"energy error: {100 * sim.ledger()['error']:+.3f} % of the reference energy")
    print(f"pictures, curves and frames: {options.out}")


if __name__ == "__main__":
    main()
