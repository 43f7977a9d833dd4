"""The built-in scene of a bridle: its statics, and what its winch does."""

from __future__ import annotations

import numpy as np
import pytest
from membrane_rs import Simulation, scenes


def test_the_bridle_hangs_by_statics_before_and_after_it_is_hauled_in() -> None:
    scene = scenes.load("bridle")
    sim, sets = Simulation(scene), scene.assemble().node_sets
    riser, left, right = (sets[name] for name in ("riser", "left", "right"))
    below = 9.81 * float(sim.masses[np.setdiff1d(np.arange(len(sim.masses)), riser[:-1])].sum())
    lowest = []
    for until in (0.5, 3.0):
        sim.run(until=until)
        found, legs = sim.cord_tensions(), sim.positions[[left[1], right[1]]] - sim.positions[riser[-1]]
        cosines = legs[:, 0] / np.linalg.norm(legs, axis=1)
        assert found[4] == pytest.approx(below, rel=1e-3)
        joint = 9.81 * float(sim.masses[riser[-1]])
        assert found[[5, 9]] == pytest.approx(0.5 * (below - joint) / cosines, rel=1e-3)
        lowest.append(float(sim.positions[:, 0].max()))
    ledger = sim.ledger()
    # The riser of 0.25 m, EA = 20 N, is hauled in by half, and lifts all that hangs on it, and its own nodes by shares.
    assert lowest[0] - lowest[1] == pytest.approx(0.125 * (1.0 + below / 20.0), rel=2e-3)
    own = 9.81 * float(sim.masses[riser[1:-1]] @ np.linspace(0.0, 1.0, 6)[1:-1])
    work = (below + own) * 0.125 * (1.0 + 0.5 * below / 20.0)
    assert ledger["work_by_law"]["winches"] == pytest.approx(work, rel=2e-3)
    assert abs(float(ledger["error"])) < 1e-6
