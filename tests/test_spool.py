"""Contact with the spool: a node that cannot pass it, and what `check` says of segments and starts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from membrane_rs import (
    Cylinder,
    Mesh,
    Scene,
    Schedule,
    Simulation,
    SpoolContact,
    Springs,
    Tether,
    Tethers,
    UnstableError,
    integrators,
    scenes,
)
from membrane_rs.check.contact import SAG_SHARE, chord_sag, start_inside
from membrane_rs.check.spool import sail_round_spool, spool
from small_scenes import FILM


def tip() -> Scene:
    """A tip mass of 10 g on a long slack cord from beside the spool."""
    cord = Tether((0.2, 0.0, 0.0), (0.19, 0.02, 0.3), 2, 50.0, 1e-4, length=1.0, tip_mass=0.01)
    return Scene(None, None, [SpoolContact(0.05)], [cord])


@pytest.mark.parametrize("speed", [10.0, 100.0, 1000.0])
@pytest.mark.parametrize("dt", [1e-5, None])
def test_a_fast_tip_does_not_pass_the_spool_without_a_word(speed: float, dt: float | None) -> None:
    sim = Simulation(tip(), dt=dt)
    end = sim.assembly.node_count - 1
    positions, velocities = sim.positions.copy(), sim.velocities.copy()
    positions[end], velocities[end] = [0.2, 0.002, 0.0], [-speed, 0.0, 0.0]
    sim.positions, sim.velocities = positions, velocities
    with pytest.raises(UnstableError) as stopped:
        sim.step(int(np.ceil(0.5 / speed / sim.dt)) + 100)
    assert sim.positions[end, 0] > 0.0
    if "deep into the spool" in str(stopped.value):
        assert f"node {end}" in str(stopped.value)
        assert "spool_contact" in str(stopped.value)
        assert "stiffer spool" in str(stopped.value)


def test_a_start_deep_inside_stops_the_run_and_one_less_deep_is_warned_of() -> None:
    def scene(x: float) -> Scene:
        return Scene(None, None, [SpoolContact(0.05)], [Tether((0.06, 0, 0), (x, 0, 0), 1, 50.0, 1e-3)])

    with pytest.raises(UnstableError, match=r"deep into the spool.*node 1"):
        Simulation(scene(0.01)).step(200)
    assert Simulation(scene(0.04)).contact_forces()[1, 0] == pytest.approx(2.0)
    assert "node 1 deepest by 0.01 m" in str(*start_inside(scene(0.04)))
    assert not list(start_inside(scene(0.05)))
    assert not list(start_inside(scenes.load("spinning-disc")))
    # Above the end of a short spool there is no contact, and just below it little depth.
    for z, count in ((0.021, 0), (0.019, 1)):
        short = [SpoolContact(0.05, half_height=0.02)]
        above = Scene(None, None, short, [Tether((0.06, 0, z), (0.01, 0, z), 1, 50.0, 1e-3)])
        assert len(list(start_inside(above))) == count


def test_coarse_segments_are_warned_of() -> None:
    def scene(segments: int) -> Scene:
        return Scene(None, None, [SpoolContact(0.05)], [Tether((0.05, 0, 0), (0.25, 0, 0), segments, 50.0, 1e-3)])

    sag = 0.05 - np.sqrt(0.05**2 - (0.2 / 3) ** 2 / 4)
    assert f"may sink {sag:.3g} m" in str(*chord_sag(scene(3)))
    assert not list(chord_sag(scene(16)))
    assert 0.05 - np.sqrt(0.05**2 - (0.2 / 16) ** 2 / 4) < SAG_SHARE * 0.05
    assert "may sink 0.05 m" in str(*chord_sag(scene(1)))
    assert not list(chord_sag(scenes.load("okuizumi-model-1")))


def test_a_spool_that_is_a_body_is_looked_at_too() -> None:
    def tethered(spool: Cylinder, anchor: float = 0.05, segments: int = 3) -> Scene:
        cord = Tether((anchor, 0, 0), (0.25, 0, 0), segments, 50.0, 1e-3)
        return Scene(None, None, [], [cord], bodies=[spool])

    body = Cylinder("hub", 0.05, felt_by="nodes")
    assert str(*chord_sag(tethered(body))) == str(
        *chord_sag(replace(tethered(body), bodies=[], laws=[SpoolContact(0.05)]))
    )
    assert not list(chord_sag(tethered(replace(body, felt_by="edges"))))
    assert not list(chord_sag(tethered(replace(body, centre=(0.01, 0.0, 0.0)))))
    assert not list(chord_sag(tethered(replace(body, travel_z=Schedule((0.0, 1.0), (0.0, 1.0))))))
    assert not list(chord_sag(tethered(body, segments=16)))
    (film,) = chord_sag(scenes.load("okuizumi-whole").staged(0))
    assert film.severity == "info"
    sail = scenes.load("okuizumi-whole").staged(0)
    thicker = replace(sail, bodies=[Cylinder("spool", 0.0275), *sail.bodies[1:]])
    assert not list(spool(sail))
    (found,) = spool(thicker)
    assert "0.025 m from the axis, and the spool of bodies.spool has a radius of 0.0275 m" in str(found)


@pytest.mark.parametrize("method", integrators())
def test_single_steps_notice_a_node_that_crosses(method: str) -> None:
    tether = Tether((0.06, 0, 0), (0.2, 0, 0), 1, 50.0, 0.0, tip_mass=0.01)
    sim = Simulation(Scene(None, None, [SpoolContact(0.05)], [tether]), method)
    positions, velocities = sim.positions.copy(), sim.velocities.copy()
    positions[1], velocities[1] = (0.2, 0.002, 0.0), (-10.0, 0.0, 0.0)
    sim.positions, sim.velocities = positions, velocities

    def step_by_step() -> None:
        while sim.time < 0.04:
            sim.step(1)

    with pytest.raises(UnstableError, match="deep into the spool"):
        step_by_step()
    assert sim.positions[1, 0] > 0.0


@pytest.mark.filterwarnings("error")
def test_an_edge_without_length_in_the_flat_shape_is_no_fault_of_the_check() -> None:
    flat = [[0.1, 0.0, 0.0], [0.2, 0.0, 0.0], [0.2, 0.0, 0.0], [0.1, 0.1, 0.0]]
    stowed = [[0.1, 0.0, 0.0], [0.2, 0.0, 0.0], [0.2, 0.01, 0.0], [0.1, 0.1, 0.0]]
    mesh = Mesh(flat, [[0, 1, 2], [0, 2, 3]], positions=stowed)
    cords = Tethers(nodes=(0,), anchor_radius=0.15, segments=1, axial_stiffness=50.0, linear_density=1e-3)
    found = list(sail_round_spool(Scene(mesh, FILM, [Springs()], [cords])))
    assert "the flat sail comes as near to the axis as 0.1 m" in found[0].message
