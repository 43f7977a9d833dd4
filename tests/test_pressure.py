"""Uniform pressure: a disc that is blown up closes its energy balance, and comes to rest in the shape that is known."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from membrane_rs import Fixed, MassDamping, Pressure, Scene, Simulation, Springs, Triangles, scenes
from membrane_rs.check.redundancy import idle_laws
from membrane_rs.folding import Disc
from membrane_rs.scene.laws import Law
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from small_scenes import RUBBER

RADIUS = 0.1
FILMS = [Triangles(compression=1.0), Springs(buckling=0.0, buckling_on_creases=0.0)]
"""A plate, and a network without buckling force."""


def blown(film: Law, pressure: float, *others: Law, rings: int = 6) -> Scene:
    """A disc that is held at its rim."""
    return Scene(Disc(RADIUS, rings).mesh(), RUBBER, [film, Pressure(pressure), *others], [Fixed("rim")])


@pytest.mark.parametrize("film", FILMS, ids=lambda film: film.kind)
def test_the_energy_balance_of_a_disc_that_is_blown_up_closes(film: Law) -> None:
    scene = blown(film, 5.0)
    dt = 0.2 * Simulation(scene, "rk4").stable_dt()
    sim = Simulation(scene, "rk4", dt)
    errors, gains = [], []
    for _ in range(6):
        sim.step(50)
        ledger = sim.ledger()
        errors.append(abs(ledger["error"]))
        gains.append(ledger["work_by_law"]["pressure"])
    assert max(errors) < 1e-6
    assert min(gains) > 1e-5
    assert sim.ledger()["stored_by_law"].keys() == {film.kind}


@pytest.mark.parametrize("integrator", ["leapfrog", "generalized_alpha"])
def test_other_methods_do_the_same_work(integrator: str) -> None:
    scene = blown(FILMS[0], 5.0)
    dt = 0.1 * Simulation(scene, "rk4").stable_dt()
    runs = [Simulation(scene, name, dt) for name in ("rk4", integrator)]
    for sim in runs:
        sim.step(200)
    work, other = (sim.ledger()["work_by_law"]["pressure"] for sim in runs)
    assert other == pytest.approx(work, rel=1e-3)
    assert abs(runs[1].ledger()["error"]) < 1e-3


def hencky(poisson_ratio: float) -> float:
    """Height of a clamped disc over a (p a/(E h))^(1/3), by Hencky's equations of a membrane of small slope.

    With x = r/a and the radial tension n: n w' = -x/2, (x^3 n')' = -x^3/(8 n^2), and n' + (1 - nu) n = 0 at the rim.
    """

    def along_radius(centre: float) -> Any:
        def slope(x: float, y: Any) -> list[float]:
            return [y[1] / x**3, -(x**3) / (8 * y[0] ** 2), -x / (2 * y[0])]

        return solve_ivp(slope, (1e-6, 1.0), [centre, 0.0, 0.0], rtol=1e-10, atol=1e-14).y[:, -1]

    def at_rim(centre: float) -> float:
        n, moment, _ = along_radius(centre)
        return float(moment + (1 - poisson_ratio) * n)

    return float(-along_radius(brentq(at_rim, 0.3, 1.0))[2])


def test_a_blown_up_disc_comes_to_rest_as_hencky_has_it() -> None:
    assert hencky(0.3) == pytest.approx(0.6534, abs=1e-4)
    pressure, heights = 0.05, []
    load = pressure * RADIUS / (RUBBER.youngs_modulus * RUBBER.thickness)
    for rings in (4, 8):
        sim = Simulation(blown(FILMS[0], pressure, MassDamping(60.0), rings=rings))
        sim.step(round(1.0 / sim.dt))
        heights.append(sim.positions[:, 2].max() / (RADIUS * load ** (1 / 3)))
    coarse, fine = (abs(height - hencky(RUBBER.poisson_ratio)) for height in heights)
    assert fine < 1e-3
    assert coarse > 3.0 * fine  # second order in the size of the cells


def test_it_acts_towards_the_normal_and_against_it_below_zero() -> None:
    for sign in (1.0, -1.0):
        sim = Simulation(blown(FILMS[0], sign * 2.0))
        forces = sim.forces("pressure")
        assert forces[:, 2].sum() == pytest.approx(sign * 2.0 * sim.scene.mesh.areas().sum(), rel=1e-12)  # type: ignore[union-attr]
        assert np.abs(forces[:, :2]).max() < 1e-15


def test_what_it_cannot_do_is_said() -> None:
    assert any("pressure is 0" in text for text in map(str, idle_laws(blown(FILMS[0], 0.0))))
    tether = scenes.load("spinning-tether")
    bare = Scene(None, None, [*tether.laws, Pressure(1.0)], tether.parts)
    assert any("no film" in text for text in map(str, idle_laws(bare)))
