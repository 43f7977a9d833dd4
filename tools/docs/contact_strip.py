"""A strip folded on itself and pressed by its weight, with contact between its layers and without it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from contact_followed import followed
from contact_sheets import FILM
from membrane_rs import Fixed, Gravity, Mesh, RunSettings, Scene, SelfContact, Simulation, SpringDamping, Springs
from membrane_rs._arrays import Floats
from membrane_rs._markdown import table
from membrane_rs.folding import Strip

PANEL, WIDTH = 0.022, 0.044
"""Length of each of the four panels, and width [m]."""
FOLDED = 2.6
"""Fold angle of the creases [rad]."""
WEIGHT = 3.0 * 9.81
"""Acceleration by gravity [m/s2]."""
INTERVAL, UNTIL = 1e-3, 0.06
"""Between counts of crossings, and of the run [s]."""
ROWS = (0.02, 0.03, 0.04, 0.06)
"""Instants that are listed [s]."""


def strip(*, with_contact: bool) -> Scene:
    """Four panels in an accordion, the lowest one held, which fall on each other."""
    found = Strip(4 * PANEL, WIDTH, 16, 8, creases=(0.25, 0.5, 0.75), fold_angle=FOLDED).mesh()
    floor = np.flatnonzero(found.reference[:, 0] <= 1.001 * PANEL)
    mesh = Mesh(
        found.reference, found.triangles, positions=found.positions, creases=found.creases,
        fold_angles=found.fold_angles, node_sets={"floor": floor},
    )  # fmt: skip
    laws = [Springs(), SpringDamping(), Gravity((0.0, 0.0, -WEIGHT)), *([SelfContact()] if with_contact else [])]
    run = RunSettings(until=UNTIL, integrator="leapfrog")
    return Scene(mesh, FILM, laws, (Fixed("floor"),), name="folded strip", run=run)


def pressed(*, with_contact: bool) -> dict[str, Floats]:
    """Crossings, residual of the energy balance and the height of the highest node [m] at instants [s]."""
    sim = Simulation(strip(with_contact=with_contact))

    def read() -> tuple[float, ...]:
        return sim.time, sim.crossings(limit=0).count, sim.ledger()["error"], float(sim.positions[:, 2].max())

    instants = (k * INTERVAL for k in range(1, round(UNTIL / INTERVAL) + 1))
    return followed(sim, sim.scene.name, instants, read, ("time", "crossings", "residual", "height"))


def strip_table(without: Mapping[str, Floats], run: Mapping[str, Floats]) -> str:
    """Both at some instants; what is counted is the most so far."""
    body = []
    for instant in ROWS:
        cells = []
        for one in (without, run):
            k = int(np.searchsorted(one["time"], instant - 0.5 * INTERVAL))
            if k == len(one["time"]):
                cells += ["stopped", "-", "-"]
                continue
            crossings, residual = one["crossings"][: k + 1].max(), 100.0 * one["residual"][k]
            cells += [f"{crossings:,.0f}", f"{1e3 * one['height'][k]:.1f}", f"{residual:+.2f}"]
        body.append((f"{instant:g}", *cells))
    heads = (
        "up to [s]", "most crossings without", "height [mm]", "energy residual [%]", "with contact", "height [mm]",
        "energy residual [%]",
    )  # fmt: skip
    return table(heads, body, words=())
