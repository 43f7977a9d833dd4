"""The balance of momentum by which docs/ikaros.md judges the spin of IKAROS, and its runs."""

from __future__ import annotations

import math

import ikaros_momentum as momentum
import ikaros_runs as runs
import pytest
from membrane_rs import Schedule


def test_bars_of_a_finer_roll_stand_beside_it_and_end_on_the_diagonals() -> None:
    own, fine = runs.whole(), runs.finer(runs.whole())
    radii = [runs.sail_of(scene).wound_radius for scene in (own, fine)]
    assert None not in radii
    assert radii[1] == pytest.approx(radii[0], rel=0.01)
    for scene in (own, fine):
        azimuth, turn, reach = runs.roll_of(scene)
        bars, schedule = runs.bars_of(scene), scene.stages[runs.REEL].set["bodies.bars.turn"]
        assert isinstance(schedule, Schedule)
        assert math.hypot(*bars.centre[:2]) == pytest.approx(reach, abs=1e-8)
        apart = math.remainder(math.atan2(bars.centre[1], bars.centre[0]) - azimuth, math.pi / 2)
        assert apart == pytest.approx(0.0, abs=1e-6)
        assert schedule.last == pytest.approx(turn, abs=1e-6)


def state(film: float, rest: float, reported: float) -> momentum.State:
    """A state of these moments of inertia [kg m2] and spin [rpm]."""
    return momentum.State("", slice(0, 1), film, rest, reported)


def test_two_unknowns_match_two_spins_and_one_matches_one() -> None:
    """Of a known film and hub, the spins by their balance give film and hub back."""
    factor, inertia = 1.3, 61.0
    moments = [(7.0, 2.0), (120.0, 60.0), (500.0, 200.0)]
    spins = [
        momentum.BEFORE * (inertia + factor * 7.0 + 2.0) / (inertia + factor * film + rest) for film, rest in moments
    ]
    found = momentum.matching(*(state(*pair, spin) for pair, spin in zip(moments, spins, strict=True)))
    assert found == pytest.approx((factor, inertia))
    first, last = (
        state(factor * film, rest, spin) for (film, rest), spin in zip(moments[::2], spins[::2], strict=True)
    )
    assert momentum.matching_hub(first, last) == pytest.approx(inertia)


def test_flat_moments_are_those_of_a_square_with_a_hole_and_of_its_tips() -> None:
    film, rest = runs.flat_moments(runs.ikaros())
    assert film == pytest.approx(runs.film_masses(runs.ikaros()).sum() * (14.0**2 + 3.8**2) / 6.0, rel=0.01)
    assert rest == pytest.approx(4 * 0.5 * 98.0, rel=0.01)


def test_the_samples_of_a_run_keep_the_momentum_of_sail_and_hub() -> None:
    run = runs.watched(runs.of_inertia(runs.ikaros(), 72.0).with_values({"run.until": 0.4, "run.snapshots": []}))
    assert run["momentum"] == pytest.approx(run["momentum"][0], rel=1e-12)
    assert run["momentum"][0] == pytest.approx((72.0 + run["moment"][0]) * run["rpm"][0] / runs.RPM, rel=1e-12)
    assert len(run["time"]) == 5
