"""The paper's two sails, from release to full deployment: rate, phase and the balance of energy.

The motion is chaotic at the scale of wrinkles: halving the step, or moving the start by 1e-12 m, changes
the rate by up to 0.008 and the phase by up to 2.6 degrees. The bounds below are wider than that spread.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field

import numpy as np
import pytest
from membrane_rs import Simulation, scenes
from membrane_rs.analysis.deployment import Corners

MODELS = ("okuizumi-model-1", "okuizumi-model-2")


@dataclass
class Curves:
    """An observer that keeps what the paper plots, and the energy error."""

    time: list[float] = field(default_factory=list)
    rate: list[float] = field(default_factory=list)
    phase: list[float] = field(default_factory=list)
    error: list[float] = field(default_factory=list)
    corners: Corners | None = None

    def start(self, sim: Simulation) -> None:
        self.corners = Corners(sim.assembly)

    def sample(self, sim: Simulation) -> None:
        assert self.corners is not None
        positions = sim.positions
        self.time.append(sim.time)
        self.rate.append(self.corners.deployment_rate(positions))
        self.phase.append(self.corners.phase_difference(positions))
        self.error.append(sim.ledger()["error"])

    def frame(self, sim: Simulation) -> None:
        assert np.isfinite(sim.positions).all()

    def finish(self, sim: Simulation, error: BaseException | None) -> None:
        assert error is None

    def after_zero(self) -> tuple[float, float]:
        """When the phase comes back through zero [s], and the rate then."""
        phase = np.array(self.phase)
        back = int(np.argmin(phase))
        at = back + int(np.argmax(phase[back:] >= 0))
        assert phase[at] >= 0, "the phase does not come back to zero"
        share = -phase[at - 1] / (phase[at] - phase[at - 1])
        times, rates = self.time[at - 1 : at + 1], self.rate[at - 1 : at + 1]
        return times[0] + share * (times[1] - times[0]), rates[0] + share * (rates[1] - rates[0])


def deployed(name: str) -> tuple[Simulation, Curves]:
    """A built-in scene run to its end, at its default step."""
    sim, curves = Simulation(scenes.load(name)), Curves()
    sim.run(observers=[curves])
    return sim, curves


@pytest.fixture(scope="module")
def runs() -> dict[str, tuple[Simulation, Curves]]:
    """Both models for all of 0.8 s, side by side: the core leaves the interpreter to the other while it
    steps.
    """
    with ThreadPoolExecutor(len(MODELS)) as pool:
        return dict(zip(MODELS, pool.map(deployed, MODELS), strict=True))


@pytest.mark.parametrize("name", MODELS)
def test_the_release(name: str) -> None:
    sim, curves = Simulation(scenes.load(name)), Curves()
    assert sim.scene.mesh is not None
    assert np.abs(sim.scene.mesh.strain()).max() < 5e-3
    sim.run(until=0.01, samples=11, observers=[curves])
    # The corners of the ideal stowed shape lie on the diagonals at 0.734 of their flat radius.
    assert curves.rate[0] == pytest.approx(0.734, abs=0.001)
    assert curves.phase[0] == pytest.approx(0.0, abs=0.5)
    # They turn back against the spool, slowly at first, on their way out.
    assert curves.phase[-1] < curves.phase[0]
    assert max(curves.error) <= 1e-5
    assert min(curves.error) > -0.01
    # The four petals stay alike for as long as wrinkles have not grown from rounding.
    x, y, _ = sim.positions[sim.assembly.node_sets["corners"]].T
    assert np.ptp(np.hypot(x, y)) < 1e-3


@pytest.mark.parametrize("name", MODELS)
def test_the_counts_of_table_2(name: str) -> None:
    counts = Simulation(scenes.load(name)).scene.counts()
    assert (counts["masses"], counts["springs"], counts["elements"]) == (1980, 5432, 3456)


@pytest.mark.parametrize("name", MODELS)
def test_full_deployment_as_the_phase_passes_zero(name: str, runs: dict[str, tuple[Simulation, Curves]]) -> None:
    sim, curves = runs[name]
    assert sim.time == pytest.approx(0.8, rel=1e-12)
    time, rate = curves.after_zero()
    # Measured at the default step: model 1 at 0.750 s with 0.9985, model 2 at 0.763 to 0.769 s with 0.998.
    assert 0.70 < time < 0.80
    assert rate >= 0.99
    assert max(curves.rate) < 1.01
    assert -120 < min(runs[MODELS[0]][1].phase) < -95
    assert -125 < min(curves.phase) < -95


def test_model_2_swings_deeper_and_later(runs: dict[str, tuple[Simulation, Curves]]) -> None:
    # Measured: troughs of -107 and -114 to -117 degrees, zeros at 0.750 and 0.763 to 0.769 s.
    (_, one), (_, two) = (runs[name] for name in MODELS)
    assert min(two.phase) < min(one.phase)
    assert two.after_zero()[0] > one.after_zero()[0]


@pytest.mark.parametrize("name", MODELS)
def test_the_balance_of_energy(name: str, runs: dict[str, tuple[Simulation, Curves]]) -> None:
    sim, curves = runs[name]
    # What RK4 loses: up to 0.78 and 0.57 % early on, 0.13 and 0.16 % in the end. Nothing is created.
    assert min(curves.error) > -0.01
    assert max(curves.error) <= 1e-5
    ledger = sim.ledger()
    assert ledger["reference_energy"] > 0
    assert set(ledger["work_by_law"]) == {"spring_damping", "air_drag"}
    assert all(work < 0 for work in ledger["work_by_law"].values())


@pytest.mark.parametrize("name", MODELS)
def test_the_sail_is_whole_and_flat_in_the_end(name: str, runs: dict[str, tuple[Simulation, Curves]]) -> None:
    sim, curves = runs[name]
    assert sim.spring_strains().max() < 0.1
    assert curves.rate[-1] > 0.9
    assert np.abs(np.median(sim.crease_angles())) > np.radians(30)  # no longer folded shut
