"""The spin of the hub in stages: the last of a frequency and a schedule that was set is the one that holds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from membrane_rs import InputError, Plane, Scene, SceneError, Schedule, Simulation, Spin, Stage
from small_scenes import cord, refused
from staged_scenes import oscillator

UP = Schedule((0.0, 0.1), (0.0, 2.0), 0.2)
KEY = "laws.spin."


def turned(spin: Spin, *of_stages: dict[str, Any]) -> Scene:
    """A mass on a cord in stages of 0.1 s."""
    stages = [
        Stage(str(k), 0.1, set={KEY + name: value for name, value in values.items()})
        for k, values in enumerate(of_stages)
    ]
    return Scene(None, None, [spin], [cord()], stages=stages)


def spins(scene: Scene) -> list[Any]:
    return [scene.staged(k).law("spin") for k in range(len(scene.stages))]


@pytest.mark.parametrize("first", [Spin(), Spin(1.0), Spin(3.0), Spin(2.0, 0.5)])
@pytest.mark.parametrize(
    ("of_stages", "expected"),
    [
        ([{"schedule": UP}], [Spin(schedule=UP)]),
        ([{"schedule": UP}, {"frequency": 2.0}, {}], [Spin(schedule=UP), 2.0, 2.0]),
        ([{"schedule": UP}, {"frequency": 3.0}], [Spin(schedule=UP), 3.0]),
        ([{"schedule": UP}, {}, {"schedule": UP}], [Spin(schedule=UP), Spin(schedule=UP), UP.delayed(0.2)]),
        ([{"frequency": 2.0}, {"schedule": UP}, {}], [2.0, UP.delayed(0.1), UP.delayed(0.1)]),
        ([{"acceleration": 20.0}, {"schedule": UP}], [20.0, UP.delayed(0.1)]),
    ],
)
def test_the_last_that_was_set_holds(first: Spin, of_stages: Sequence[dict[str, Any]], expected: list[Any]) -> None:
    found = spins(turned(first, *of_stages))
    for values, spin, wanted in zip(of_stages, found, expected, strict=True):
        if isinstance(wanted, Spin):
            assert spin == wanted
        elif isinstance(wanted, Schedule):
            assert spin == Spin(schedule=wanted)
        elif "acceleration" in values:
            begin = first.frequency or 0.0
            assert spin == Spin(schedule=Schedule((0.0, 0.1), (begin, begin + 0.1 * wanted)))
        elif spin.schedule is not None:
            assert (first.acceleration, spin.schedule.at(0.0)) == (0.5, wanted)
        else:
            assert spin == Spin(wanted)


def test_a_frequency_in_place_of_the_schedule_of_a_scene_holds_later_too() -> None:
    found = spins(turned(Spin(schedule=UP), {}, {"frequency": 2.0}, {}, {"acceleration": 1.0}, {}))
    assert [*found[:3], found[4]] == [Spin(schedule=UP), Spin(2.0), Spin(2.0), Spin(2.0)]
    assert found[3].schedule.values == pytest.approx((2.0, 2.1))
    # An acceleration alone has no frequency to begin with.
    words = r"spin\.acceleration = 2.0: is not used with a schedule; leave it out, or set a frequency"
    refused(lambda: turned(Spin(1.0), {"schedule": UP}, {"acceleration": 2.0}), SceneError, words)
    again = spins(turned(Spin(1.0), {"schedule": UP}, {"acceleration": 2.0, "frequency": 1.0}, {}))
    assert again[1].schedule.values == pytest.approx((1.0, 1.2))
    assert again[2] == Spin(1.0)
    # Of a scene without a schedule it holds in its own stage alone.
    assert spins(turned(Spin(1.0), {"frequency": 2.0}, {})) == [Spin(2.0), Spin(1.0)]


def test_a_body_that_a_stage_holds_still_in_place_of_its_schedule_stays_so_in_later_ones() -> None:
    wall = Plane("wall", centre=(2.2, 0.0, 0.0), direction=(-1.0, 0.0, 0.0), travel_x=UP)
    stages = [Stage("a", 0.1), Stage("b", 0.1, set={"bodies.wall.travel_x": None}), Stage("c", 0.1)]
    scene = replace(oscillator(), bodies=[wall], stages=stages)
    assert [scene.staged(k).bodies[0].travel_x for k in range(3)] == [UP, None, None]


def test_a_hub_spun_up_and_held_turns_as_it_is_told() -> None:
    sim = Simulation(turned(Spin(0.0), {"schedule": UP}, {"frequency": 2.0}, {}), "rk4", dt=1e-3)
    for time, turns in ((0.1, 0.1), (0.2, 0.3), (0.3, 0.5)):
        sim.reach(time)
        assert sim.hub_angle == pytest.approx(2.0 * 3.141592653589793 * turns, rel=1e-9)


def test_both_at_once_are_refused() -> None:
    for value in (2.0, 3.0, 0.0):
        words = rf"spin\.frequency = {value}: is not used with a schedule; leave it out"
        refused(lambda value=value: turned(Spin(1.0), {"frequency": value, "schedule": UP}), SceneError, words)  # type: ignore[misc]
        refused(lambda value=value: Spin(value, schedule=UP), InputError, words.replace("spin", "Spin"))  # type: ignore[misc]
    scaled = Stage("a", 0.1, scale={KEY + "frequency": 2.0})
    words = "'laws.spin.frequency': is None, no number, so it is not scaled"
    refused(lambda: replace(turned(Spin(schedule=UP), {}), stages=[scaled]), SceneError, words)
    later = [Stage("up", 0.1, set={KEY + "schedule": UP}), replace(scaled, name="b")]
    refused(lambda: replace(turned(Spin(1.0), {}), stages=later), SceneError, words)


def test_the_default_is_3_hz_and_none_beside_a_schedule(tmp_path: Path) -> None:
    assert Spin().frequency == Spin(None).frequency == 3.0
    assert Spin(schedule=UP).frequency is None
    assert replace(Spin(schedule=UP), schedule=UP.delayed(1.0)).schedule == UP.delayed(1.0)
    scene = turned(Spin(schedule=UP), {}, {"frequency": 2.0})
    scene.save(tmp_path)
    again = Scene.from_toml(tmp_path / "scene.toml")
    assert (again.laws, again.stages, again.to_toml()) == (scene.laws, scene.stages, scene.to_toml())
    assert "# frequency: not set  # Hz" in scene.to_toml()
