"""The balance of momentum by which docs/ikaros.md judges the spin of IKAROS, and its runs."""

from __future__ import annotations

from pathlib import Path

import ikaros_momentum as momentum
import ikaros_runs as runs
import numpy as np
import pytest
from ikaros_balance import balance_table
from ikaros_shapes import WIDTH, copy_film
from ikaros_variants import tether_length
from membrane_rs import Schedule, Simulation
from PIL import Image, ImageSequence


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


def test_the_samples_of_a_run_keep_the_momentum_of_sail_and_hub() -> None:
    run = runs.watched(runs.of_inertia(runs.ikaros(), 72.0).with_values({"run.until": 0.4, "run.snapshots": []}))
    assert run["momentum"] == pytest.approx(run["momentum"][0], rel=1e-12)
    assert run["momentum"][0] == pytest.approx((72.0 + run["moment"][0]) * run["rpm"][0] / runs.RPM, rel=1e-12)
    assert len(run["time"]) == 5


def test_a_reeling_out_of_another_duration_turns_its_bars_as_far() -> None:
    own, slow = runs.whole(), runs.in_time(runs.whole(), 240.0)
    turns = [scene.stages[runs.REEL].set["bodies.bars.turn"] for scene in (own, slow)]
    assert all(isinstance(turn, Schedule) for turn in turns)
    assert turns[1].last == turns[0].last
    assert slow.stages[runs.REEL].duration == turns[1].times[-1] == 240.0


def test_the_length_of_tethers_is_that_with_which_the_flat_sail_is_taut() -> None:
    scene = runs.ikaros()
    longer = scene.with_values({"parts.tethers.length": tether_length(scene)})
    assert Simulation(longer).spring_strains() == pytest.approx(Simulation(scene).spring_strains(), abs=1e-12)


def test_balances_are_those_of_each_stage() -> None:
    made = {
        "momentum": np.array([2.0, 2.0, 2.2, 2.2]), "kinetic": np.array([0.0, 1.0, 3.0, 1.0]),
        "stored": np.array([5.0, 4.0, 1.0, 2.0]), "work": np.array([0.0, 0.0, -0.5, -2.0]),
        "error": np.array([0.0, 0.0, -0.01, -0.02]), "rpm": np.array([9.0, 8.0, 7.0, 6.0]),
        "time": np.arange(4.0), "end": np.array([2.0, 3.0]),
    }  # fmt: skip
    rows = [row.split(" | ") for row in balance_table({"own": made}, ["first", "second"]).splitlines()[2:]]
    assert [row[1] for row in rows] == ["first", "second"]
    assert [row[2:8] for row in rows] == [
        ["9.00", "7.00", "2.20", "1.0e-01", "-1.000", "-0.500"],
        ["7.00", "6.00", "2.20", "1.0e-01", "-1.000", "-1.500"],
    ]


def test_a_film_of_every_other_picture_lasts_as_long(tmp_path: Path) -> None:
    pictures = [Image.new("RGB", (600, 300), (k, 0, 255 - k)) for k in range(0, 250, 50)]
    shown = [40, 60, 80, 100, 3000]
    pictures[0].save(tmp_path / "all.gif", save_all=True, append_images=pictures[1:], duration=shown, loop=0)
    copy_film(tmp_path / "all.gif", tmp_path / "few.gif")
    with Image.open(tmp_path / "few.gif") as film:
        lasts = [frame.info["duration"] for frame in ImageSequence.Iterator(film)]
        assert film.size == (WIDTH, WIDTH // 2)
    assert lasts == [100, 180, 3000]
