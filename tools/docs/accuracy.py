"""Verification: exact solutions, the energy balance, and the growth of a small perturbation.

Writes accuracy.md into the folder `out`; takes a minute or two.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from membrane_rs import Simulation, Spin, Tether, scenes
from membrane_rs._markdown import table

Row = tuple[str, str, str]


def sampled(
    sim: Simulation, until: float, samples: int, read: Callable[[Simulation], float]
) -> tuple[list[float], list[float]]:
    """Times and samples of a run."""
    times: list[float] = []
    values: list[float] = []
    for time in np.linspace(0.0, until, samples):
        sim.run(until=float(time), frames=2, samples=2)
        times.append(sim.time)
        values.append(read(sim))
    return times, values


def rises(times: Sequence[float], values: Sequence[float]) -> list[float]:
    """Interpolated times of upward zero crossings."""
    pairs = zip(zip(times, values, strict=True), zip(times[1:], values[1:], strict=True), strict=False)
    return [t - v * (s - t) / (w - v) for (t, v), (s, w) in pairs if v < 0.0 <= w]


def tether_period() -> Row:
    """Period of a tip mass on a tether in the plane of a turning hub: a pendulum in the centrifugal field.

    The period is 1/f sqrt(L/R) for small oscillations of a stiff tether. An amplitude a multiplies it by
    1 + a^2/16. A tether that stretches under the Coriolis force, an additional tension of 2 m Omega L a', adds
    4 Omega^2 m L / EA of inertia.
    """
    scene = scenes.load("spinning-tether")
    cord, spin = scene.parts[0], scene.law("spin")
    assert isinstance(cord, Tether)
    assert isinstance(spin, Spin)
    sim = Simulation(scene)
    end = int(sim.assembly.node_sets["tether-0-end"][0])

    def azimuth(sim: Simulation) -> float:
        x, y, _ = sim.positions[end] - cord.start
        return math.atan2(y, x)

    crossings = rises(*sampled(sim, scene.run.until, 1001, azimuth))
    period = (crossings[-1] - crossings[0]) / (len(crossings) - 1)
    assert cord.end is not None
    hub, length = math.hypot(*cord.start), math.dist(cord.start, cord.end)
    amplitude = math.asin((cord.end[1] - cord.start[1]) / length)
    soft = 4 * (2 * math.pi * spin.hub_frequency) ** 2 * cord.tip_mass * length / cord.axial_stiffness
    exact = math.sqrt(length / hub * (1 + soft)) / spin.hub_frequency * (1 + amplitude**2 / 16)
    return compare("oscillation of a tip mass on a turning hub, period [s]", period, exact, ".4f")


def disc_growth() -> Row:
    """Radial growth of a free spinning disc at rest, by the theory of plane stress.

    At the rate Omega the rim grows by e = (1 - nu)/4 rho Omega^2 a^2 / E, and the moment of inertia by the share
    (7 + nu)/3 e, from u(r) = (1 - nu)/(8 E) rho Omega^2 r ((3 + nu) a^2 - (1 + nu) r^2). The disc keeps its angular
    momentum, so it turns slower by that share (0.40 %), and e falls with the square of the rate.
    """
    scene = scenes.load("spinning-disc")
    film, mesh, spin = scene.material, scene.mesh, scene.law("spin")
    assert film is not None
    assert mesh is not None
    assert isinstance(spin, Spin)
    sim = Simulation(scene)
    sim.run(samples=2, frames=2)
    rim = mesh.node_sets["rim"]
    before, after = (
        float(np.linalg.norm(points[rim, :2], axis=1).mean()) for points in (mesh.reference, sim.positions)
    )
    load = film.density * (2 * math.pi * spin.hub_frequency * before) ** 2
    growth = (1.0 - film.poisson_ratio) / 4.0 * load / film.youngs_modulus
    slower = 1.0 + (7.0 + film.poisson_ratio) / 3.0 * growth
    exact = growth / slower**2
    return compare("radial growth of a spinning disc [%]", 100 * (after / before - 1.0), 100 * exact, ".4f")


def compare(label: str, found: float, exact: float, form: str) -> Row:
    """A row of the table."""
    return label, f"{found:{form}}", f"exact: {exact:{form}}; error {100 * (found / exact - 1):+.2f} %"


def energy(until: float = 0.02) -> list[Row]:
    """Energy error of model 1 after its first 20 ms, the most demanding, at the default step and below."""
    default = Simulation(scenes.load("okuizumi-model-1")).dt
    rows: list[Row] = []
    for parts in (1, 2, 4):
        sim = Simulation(scenes.load("okuizumi-model-1"), dt=default / parts)
        worst = sampled(sim, until, 21, lambda sim: sim.ledger()["reference_energy"] * sim.ledger()["error"])[1]
        at_end = sim.ledger()
        share = max(worst) / at_end["reference_energy"]
        label = f"model 1, energy error after {1e3 * until:g} ms at a step of {1e6 * sim.dt:.2f} us [%]"
        note = f"reference energy {at_end['reference_energy']:.2e} J; largest gain {100 * share:.0e} %"
        rows.append((label, f"{100 * at_end['error']:+.4f}", note))
    return rows


def growth(shift: float = 1e-12) -> list[Row]:
    """Growth of a displacement of one corner of model 1: the largest distance of any node between two runs."""
    runs = [Simulation(scenes.load("okuizumi-model-1")) for _ in range(2)]
    moved = runs[1].positions.copy()
    moved[runs[1].assembly.node_sets["corners"][0], 2] += shift
    runs[1].positions = moved
    rows: list[Row] = []
    for time in (0.005, 0.02, 0.05):
        for run in runs:
            run.run(until=time, frames=2, samples=2)
        apart = float(np.linalg.norm(runs[0].positions - runs[1].positions, axis=1).max())
        label = f"model 1, a displacement of {shift:g} m after {1e3 * time:g} ms [m]"
        rows.append((label, f"{apart:.1e}", "none: the motion is chaotic"))
    return rows


def main() -> None:
    """Compute the table, print it, write it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--until", type=float, default=0.02, help="simulated time of the energy balance [s]")
    parser.add_argument("--out", type=Path, default=Path("out"), help="folder of the result")
    options = parser.parse_args()

    rows = [tether_period(), disc_growth(), *energy(options.until), *growth()]
    text = table(("", "result", "reference"), rows, words=(0, 2))
    print(text)
    options.out.mkdir(parents=True, exist_ok=True)
    (options.out / "accuracy.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
