"""Two free sheets that are thrown at each other, with contact and without it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from membrane_rs import Material, Mesh, RunSettings, Scene, SelfContact, Simulation, Springs, UnstableError
from membrane_rs._arrays import Floats
from membrane_rs._markdown import table
from membrane_rs.folding import Strip
from membrane_rs.mesh.crossings import crossings

SPEEDS = (0.1, 1.0, 5.0, 10.0, 20.0, 50.0)
"""Of the upper sheet, downwards [m/s]; the lower one is at rest."""
SIDE, CELLS = 0.11, 10
"""Of a sheet: length [m], and cells in it."""
GAP = 5e-4
"""Between the sheets at the start [m]."""
TURN, SHIFT = 0.3, (3e-3, 2e-3)
"""Of the upper sheet about the axis [rad], and across it [m]: no node lies over another."""
AFTER = 1e-3
"""From the time at which the sheets would meet at the latest [s]."""
READINGS = 50
FILM = Material(3.2e9, 0.34, 1420.0, 7.5e-6)
"""That of the paper's sails."""


def two_sheets(*, with_contact: bool, aligned: bool = False) -> Scene:
    """The scene of two sheets, the upper one turned, or over the lower one node by node."""
    sheet = Strip(SIDE, SIDE, CELLS, CELLS).mesh()
    flat = sheet.reference - sheet.reference.mean(axis=0)
    c, s = (1.0, 0.0) if aligned else (np.cos(TURN), np.sin(TURN))
    upper = flat @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    upper += [0.0, 0.0, GAP] if aligned else [*SHIFT, GAP]
    count = len(flat)
    mesh = Mesh(
        np.vstack([flat, flat + np.array([2.0 * SIDE, 0.0, 0.0])]),
        np.vstack([sheet.triangles, sheet.triangles + count]),
        positions=np.vstack([flat, upper]),
        node_sets={"lower": np.arange(count), "upper": np.arange(count, 2 * count)},
    )
    laws = [Springs(), *([SelfContact(crossing_interval=50)] if with_contact else [])]
    return Scene(mesh, FILM, laws, name="two-sheets", run=RunSettings(until=1.0, integrator="leapfrog"))


def thrown(speed: float, *, with_contact: bool, aligned: bool = False) -> dict[str, Floats]:
    """What is left after the sheets have met.

    "lower" and "upper" are mean velocities along the axis over `speed`, "energy" the kinetic energy over that at the
    start, "crossings" the most pairs of triangles that cross at a reading, "below" the share of the nodes of the upper
    sheet that end below the lower one, "residual" that of the energy balance,
    "momentum" and "angular" the largest changes of a component, over that of the upper sheet and that times `SIDE`,
    "step" [s]; "stopped" is 1 where the run was stopped.
    """
    scene = two_sheets(with_contact=with_contact, aligned=aligned)
    sim = Simulation(scene)
    sets, masses = sim.assembly.node_sets, sim.masses
    velocities = np.zeros((len(masses), 3))
    velocities[sets["upper"], 2] = -speed
    sim.velocities = velocities
    before, kinetic = _momenta(sim), sim.ledger()["kinetic"]
    most, stopped = 0, 0.0
    try:
        for share in np.linspace(0.0, 1.0, READINGS + 1)[1:].tolist():
            sim.reach(share * (GAP / speed + AFTER))
            most = max(most, crossings(sim.assembly.triangles, sim.positions, 0).count)
    except UnstableError as error:
        print(f"{speed:g} m/s: {error}", flush=True)
        stopped = 1.0
    after, ledger = _momenta(sim), sim.ledger()
    own = float(masses[sets["upper"]].sum()) * speed
    means = [
        float(np.average(sim.velocities[sets[name], 2], weights=masses[sets[name]])) / speed
        for name in ("lower", "upper")
    ]
    low, high = (sim.positions[sets[name], 2] for name in ("lower", "upper"))
    values = {
        "below": float(np.mean(high < low.mean())), "lower": means[0], "upper": means[1],
        "energy": ledger["kinetic"] / kinetic, "crossings": float(most),
        "residual": ledger["error"], "momentum": float(np.abs(after[0] - before[0]).max()) / own,
        "angular": float(np.abs(after[1] - before[1]).max()) / (own * SIDE), "step": sim.dt, "stopped": stopped,
    }  # fmt: skip
    return {name: np.array([value]) for name, value in values.items()}


def _momenta(sim: Simulation) -> tuple[Floats, Floats]:
    """Momentum and angular momentum about the origin."""
    own = sim.masses[:, None] * sim.velocities
    return own.sum(axis=0), np.cross(sim.positions, own).sum(axis=0)


def sheets_table(found: Mapping[str, tuple[Mapping[str, Floats], Mapping[str, Floats]]]) -> str:
    """What is left of each throw, by its name: without contact and with it."""
    body = []
    for label, (without, run) in found.items():
        one = {name: float(values[0]) for name, values in run.items()}
        cells: tuple[str, ...] = ("stopped", *"-----") if one["stopped"] else (
            f"{one['crossings']:,.0f}", f"{one['lower']:.3f}, {one['upper']:.3f}", f"{one['energy']:.3f}",
            f"{100.0 * one['residual']:+.2f}", f"{one['momentum']:.0e}", f"{one['angular']:.0e}",
        )  # fmt: skip
        body.append((label, f"{100.0 * float(without['below'][0]):.0f}", *cells))
    heads = (
        "upper sheet", "without contact: has gone through [%]", "with contact: crossings",
        "mean velocity of lower, upper, over V", "kinetic energy, over that before", "energy residual [%]",
        "change of momentum", "of angular momentum",
    )  # fmt: skip
    return table(heads, body, words=(0,))
