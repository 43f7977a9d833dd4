"""The built-in scenes with a free hub, against their closed forms."""

from __future__ import annotations

import math

import membrane_rs
import numpy as np
import pytest
from membrane_rs import scenes
from membrane_rs.scene.hub import has_free_hub
from membrane_rs.scene.scales import moment_of_inertia, node_masses
from scipy.optimize import brentq
from scipy.special import jv, yv
from small_scenes import Floats

RADIUS, RATE, RATIO = 0.025, 6.0 * math.pi, 41.0
"""Of the yo-yo: radius of the spool [m], rate at the start [rad/s], C = 1 + I/(m R^2)."""


def test_free_hubs_are_left_to_the_methods_that_move_them() -> None:
    free = {name for name in scenes.names() if has_free_hub(scenes.load(name))}
    assert {"free-hub-disc", "yo-yo"} <= free
    assert not free & {*scenes.for_any_method()}


def test_the_yo_yo_takes_the_spin_of_its_hub_by_the_length_that_has_unwound() -> None:
    scene = scenes.load("yo-yo")
    inertia, both = scene.value("laws.spin.inertia"), 2.0 * scene.value("parts.0.tip_mass")
    assert 1.0 + inertia / (both * RADIUS**2) == pytest.approx(RATIO)
    cord = scene.value("parts.one.linear_density") * scene.value("parts.one.length")
    assert cord == pytest.approx(0.005 * both, rel=1e-4)
    run = membrane_rs.run(scene)
    tips = [int(run.scene.assemble().node_sets[f"tether-{k}-end"][0]) for k in range(2)]
    rates = dict(zip(run.history["time"].tolist(), run.history["hub_rate"].tolist(), strict=True))
    free = np.array(
        [
            np.sqrt(np.maximum(0.0, np.square(frame.positions[tips, :2] / RADIUS).sum(axis=1) - 1.0))
            for frame in run.frames
        ]
    )
    assert free[:, 0] == pytest.approx(free[:, 1], abs=1e-6)  # both unwind alike
    square = np.square(free[:, 0])
    expected = (RATIO - square) / (RATIO + square)
    found = np.array([rates[min(rates, key=lambda time: abs(time - frame.time))] for frame in run.frames]) / RATE
    assert free[-1, 0] > 6.0
    assert np.abs(found - expected).max() < 2e-3
    assert run.summary["momentum_error"] < 1e-12
    assert np.abs(run.history["energy_error"]).max() < 1e-6
    assert run.history["motor_torque"].tolist() == [0.0] * len(run.history["time"])


def twists(inertia: float) -> float:
    """Frequency of the slowest twist of the ring on a hub of an inertia [kg m2], in shear: u = A J1(kr) + B Y1(kr)
    [Hz].
    """
    scene = scenes.load("free-hub-disc")
    inner, outer = scene.value("mesh.hub_radius"), scene.value("mesh.radius")
    density, thickness = scene.value("material.density"), scene.value("material.thickness")
    shear = scene.value("material.youngs_modulus") / (2.0 * (1.0 + scene.value("material.poisson_ratio")))

    def moment(rate: float) -> float:
        """Of film and inertia on the hub, for a rim without stress [N m]."""
        k = rate / math.sqrt(shear / density)
        of_y = -jv(2, k * outer) / yv(2, k * outer)
        stress = -shear * k * (jv(2, k * inner) + of_y * yv(2, k * inner))
        turned = (jv(1, k * inner) + of_y * yv(1, k * inner)) / inner
        return float(2.0 * math.pi * inner**2 * thickness * stress / inertia + rate**2 * turned)

    return float(brentq(moment, 2.0 * math.pi * 15.0, 2.0 * math.pi * 60.0)) / (2.0 * math.pi)


def main_frequency(time: Floats, values: Floats) -> float:
    """Of the largest line of a spectrum [Hz]."""
    tried = np.arange(10.0, 60.0, 0.05)
    weighted = (values - values.mean()) * np.hanning(len(values))
    return float(tried[np.argmax(np.abs(np.exp(-2j * np.pi * np.outer(tried, time)) @ weighted))])


def test_hub_and_ring_exchange_spin_at_the_frequency_of_their_twist() -> None:
    scene = scenes.load("free-hub-disc")
    inertia = scene.value("laws.spin.inertia")
    assert [twists(inertia), twists(1e3)] == pytest.approx([33.6, 23.6], abs=0.05)  # as the file says
    run = membrane_rs.run(scene, until=0.4, samples=2401, frames=2)
    table = run.history
    after = table["time"] > 0.02
    assert main_frequency(table["time"][after], table["hub_rate"][after]) == pytest.approx(twists(inertia), rel=0.01)
    total = table["hub_momentum"] + table["sail_momentum"]
    impulse = 2e-3 * np.minimum(table["time"], 0.02)
    assert total - total[0] == pytest.approx(impulse, abs=1e-12 * total[0])
    assert run.summary["momentum_error"] < 1e-12
    common = total[-1] / (inertia + moment_of_inertia(run.scene))
    assert table["hub_rate"][after].mean() == pytest.approx(common, rel=5e-3)
    swing = np.ptp(table["hub_momentum"][after])
    assert swing > 0.3 * (total[-1] - total[0])
    assert np.ptp(table["sail_momentum"][after]) == pytest.approx(swing, rel=1e-9)
    assert np.abs(table["energy_error"]).max() < 1e-6
    assert max(np.nanmax(frame.on_lines["buckled"]) for frame in run.frames) == 0


def test_the_ring_is_stretched_by_its_spin_at_the_start() -> None:
    run = membrane_rs.run("free-hub-disc", until=1e-4, frames=2, samples=2)
    masses, start = node_masses(run.scene), run.frames[0]
    stretched = float(masses @ np.square(start.positions[:, :2]).sum(axis=1))
    assert stretched > 1.001 * moment_of_inertia(run.scene)
    assert np.abs(start.velocities).max() < 1e-3
    assert run.history["hub_rate"][0] == pytest.approx(10.0 * math.pi, rel=1e-12)
