"""Pressure of sunlight: tabulated forces on plates, both sides, edge-on, the sun fixed in space, energy, refusals."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from membrane_rs import Fixed, Scene, Schedule, Simulation, SolarPressure, Spin, Springs, Triangles
from membrane_rs.check import audit
from membrane_rs.check.redundancy import idle_laws
from membrane_rs.errors import InputError
from membrane_rs.folding import Disc, Strip
from membrane_rs.scene.laws.solar_pressure import ASTRONOMICAL_UNIT
from small_scenes import RUBBER, Floats, cord, rotation, turned

DISC = Disc(0.1, rings=3).mesh()
WAVY = Strip(0.12, 0.04, 8, 2, creases=(0.25, 0.5, 0.75), fold_angle=1.0).mesh()
"""Facets at several attitudes to any sun."""
FILMS = {"mirror": (1.0, 0.0), "black": (0.0, 0.0), "aluminium": (0.84, 0.04)}
TABLE = {
    "mirror": {0: (0.0, -9.120), 30: (0.0, -6.840), 60: (0.0, -2.280)},
    "black": {0: (0.0, -4.560), 30: (-1.9745, -3.420), 60: (-1.9745, -1.140)},
    "aluminium": {0: (0.0, -8.512), 30: (-0.3159, -6.3981), 60: (-0.3159, -2.1584)},
}
"""Force per area along x and z [uPa] on films in the plane z = 0, by the angle of the sun from z towards x [deg]."""
TWO_SIDED = SolarPressure(
    0.84, 0.04, back_specular=0.2, back_diffuse=0.3, front_emissivity=0.05, front_lambert=0.8, back_emissivity=0.6,
    back_lambert=0.5,
)  # fmt: skip
CASES = [(film, angle) for film, row in TABLE.items() for angle in row]


def towards(angle: float) -> tuple[float, float, float]:
    """The direction at an angle from z towards x [deg], not of unit length."""
    return (3.0 * math.sin(math.radians(angle)), 0.0, 3.0 * math.cos(math.radians(angle)))


def per_area(law: SolarPressure, *others: Any) -> Floats:
    """Total force on a flat disc over its area [Pa]."""
    sim = Simulation(Scene(DISC, RUBBER, [Springs(), law, *others], [Fixed("rim")]))
    total: Floats = sim.forces("solar_pressure").sum(axis=0) / DISC.areas().sum()
    return total


def expected(law: SolarPressure, mesh: Any, positions: Floats, sun: Floats) -> Floats:
    """(n, 3) forces [N], triangle by triangle and side by side as the formula has them."""
    forces = np.zeros_like(positions)
    pressure = 4.56e-6 * (ASTRONOMICAL_UNIT / law.distance) ** 2
    sun = sun / np.linalg.norm(sun)
    sides = {
        side: [getattr(law, f"{side}_{name}") for name in ("specular", "diffuse", "emissivity", "lambert")]
        for side in ("front", "back")
    }
    for nodes in mesh.triangles:
        a, b, c = positions[nodes]
        twice = np.cross(b - a, c - a)
        area, normal = 0.5 * np.linalg.norm(twice), twice / np.linalg.norm(twice)
        is_front = normal @ sun > 0.0
        lit, dark = ("front", "back") if is_front else ("back", "front")
        normal = normal if is_front else -normal
        (specular, diffuse, emissivity, lambert), (_, _, other, other_lambert) = sides[lit], sides[dark]
        thermal = (1.0 - specular - diffuse) * (emissivity * lambert - other * other_lambert) / (emissivity + other)
        cosine = normal @ sun
        along_normal = 2.0 * specular * cosine + 2.0 / 3.0 * diffuse + thermal
        force = -pressure * area * cosine * ((1.0 - specular) * sun + along_normal * normal)
        forces[nodes] += force / 3.0
    return forces


@pytest.mark.parametrize(("film", "angle"), CASES)
def test_forces_on_a_plate_are_those_of_the_table(film: str, angle: int) -> None:
    x, y, z = 1e6 * per_area(SolarPressure(*FILMS[film], sun=towards(angle)))
    along, across = TABLE[film][angle]
    assert (x, z) == pytest.approx((along, across), abs=0.51e-4)
    assert y == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("angle", [0, 30, 60])
def test_light_from_behind_meets_the_back(angle: int) -> None:
    behind = (towards(angle)[0], 0.0, -towards(angle)[2])
    for film, (specular, diffuse) in FILMS.items():
        front = per_area(SolarPressure(specular, diffuse, sun=towards(angle)))
        both_alike = per_area(SolarPressure(specular, diffuse, sun=behind))
        other = per_area(SolarPressure(0.3, 0.3, sun=behind, back_specular=specular, back_diffuse=diffuse))
        assert both_alike == pytest.approx(front * [1, 1, -1], rel=1e-12, abs=1e-20), film
        assert other == pytest.approx(front * [1, 1, -1], rel=1e-12, abs=1e-20), film


def test_emission_recoils_from_the_side_that_emits_more() -> None:
    """A black film that emits on its back alone is pushed back towards the sun by 2/3 of the light's momentum."""
    behind = SolarPressure(0.0, 0.0, front_emissivity=0.0, back_emissivity=1.0)
    assert 1e6 * per_area(behind)[2] == pytest.approx(-4.56 / 3.0, rel=1e-12)
    before = SolarPressure(0.0, 0.0, front_emissivity=1.0, back_emissivity=0.0)
    assert 1e6 * per_area(before)[2] == pytest.approx(-4.56 * 5.0 / 3.0, rel=1e-12)
    assert TWO_SIDED.simpler() == ("recoil of emission", replace(TWO_SIDED, back_emissivity=None, back_lambert=None))
    assert SolarPressure(0.84, 0.04).simpler() is None


@pytest.mark.parametrize("law", [TWO_SIDED, *(SolarPressure(*shares) for shares in FILMS.values())])
def test_force_falls_to_nothing_edge_on_and_is_steady_there(law: SolarPressure) -> None:
    for tilt in (1e-3, 1e-6, 1e-9):
        for sign in (1.0, -1.0):
            size = np.linalg.norm(per_area(replace(law, sun=(1.0, 0.0, sign * tilt))))
            assert size <= 3.0 * 4.56e-6 * tilt
    assert np.abs(per_area(replace(law, sun=(1.0, 0.0, 0.0)))).max() == 0.0


def test_a_mirror_is_smooth_edge_on() -> None:
    """Its force is quadratic in the angle there, of either sign with the side that is lit."""
    for tilt in (1e-3, -1e-3):
        z = per_area(SolarPressure(1.0, 0.0, sun=(1.0, 0.0, tilt)))[2]
        assert z == pytest.approx(-math.copysign(2.0 * 4.56e-6 * tilt**2, tilt), rel=1e-5)


def test_pressure_falls_with_the_square_of_the_distance_and_follows_its_factor() -> None:
    near = per_area(SolarPressure(0.84, 0.04))
    far = per_area(SolarPressure(0.84, 0.04, distance=2.0 * ASTRONOMICAL_UNIT))
    assert near == pytest.approx(4.0 * far, rel=1e-14)
    shade = Schedule((0.0, 1.0), (0.25, 0.0))
    assert per_area(SolarPressure(0.84, 0.04, factor=shade)) == pytest.approx(0.25 * near, rel=1e-14)


def test_forces_on_a_folded_film_are_those_of_its_facets() -> None:
    for sun in ((0.3, -0.5, 1.2), (1.0, 0.2, -0.1), (-2.0, 1.0, 0.5)):
        law = replace(TWO_SIDED, sun=sun)
        sim = Simulation(Scene(WAVY, RUBBER, [Springs(), law], [Fixed("start")]))
        wanted = expected(law, WAVY, sim.positions, np.array(sun))
        assert sim.forces("solar_pressure") == pytest.approx(wanted, rel=1e-12, abs=1e-12 * np.abs(wanted).max())


@pytest.mark.parametrize("axis", [[0, 0, 1], [1, 0, 0], [2, -1, 0.3]])
def test_forces_on_a_scene_turned_in_space_are_turned(axis: list[float]) -> None:
    turn, sun = rotation(axis, 1.234), np.array([0.3, -0.5, 1.2])
    found = []
    for mesh, to in ((WAVY, sun), (turned(WAVY, turn), turn @ sun)):
        law = replace(TWO_SIDED, sun=(float(to[0]), float(to[1]), float(to[2])))
        found.append(Simulation(Scene(mesh, RUBBER, [Springs(), law], [Fixed("start")])).forces("solar_pressure"))
    assert found[1] == pytest.approx(found[0] @ turn.T, abs=1e-13 * np.abs(found[0]).max())


@pytest.mark.parametrize("spin", [Spin(4.0, -20.0), Spin(4.0, inertia=1e-5)])
def test_the_sun_stays_where_it_is_while_the_hub_turns(spin: Spin) -> None:
    sun = np.array([1.0, 0.4, 0.2])
    law = replace(TWO_SIDED, sun=(1.0, 0.4, 0.2), distance=1e-3 * ASTRONOMICAL_UNIT)
    sim = Simulation(Scene(WAVY, RUBBER, [Springs(), spin, law], [Fixed("start")]), "leapfrog")
    for time in (0.0, 0.01, 0.025):
        sim.reach(time)
        seen = rotation([0, 0, 1], -sim.hub_angle) @ sun
        wanted = expected(law, WAVY, sim.positions, seen)
        assert sim.forces("solar_pressure") == pytest.approx(wanted, abs=1e-11 * np.abs(wanted).max())
    assert abs(sim.hub_angle) > 0.5


@pytest.mark.parametrize("integrator", ["rk4", "leapfrog", "dopri5", "generalized_alpha"])
def test_the_energy_balance_of_a_film_that_light_pushes_closes(integrator: str) -> None:
    """At the sun's surface, so that the push stands out; the frame turns, and the sun in it."""
    law = replace(TWO_SIDED, sun=(0.5, 0.0, 1.0), distance=1e-3 * ASTRONOMICAL_UNIT)
    film = Triangles(compression=1.0)
    scene = Scene(DISC, RUBBER, [film, Spin(2.0), law], [Fixed("rim")])
    dt = 0.1 * Simulation(scene, "rk4").stable_dt()
    sim = Simulation(scene, integrator, dt)
    sim.reach(4000 * dt)
    ledger = sim.ledger()
    assert ledger["work_by_law"]["solar_pressure"] > 1e-5
    assert "solar_pressure" not in ledger["stored_by_law"]
    assert abs(ledger["error"]) < (1e-6 if integrator in ("rk4", "dopri5") else 1e-3)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"sun": (0.0, 0.0, 0.0)}, r"SolarPressure.sun = .*must not be 0; \(0, 0, 1\) is the hub's axis"),
        ({"distance": 0.0}, r"distance = 0.0: must be greater than 0 \(m\)"),
        ({"front_specular": 1.1}, "front_specular = 1.1: must be at least 0 and at most 1"),
        ({"front_diffuse": 0.2}, "front_diffuse = 0.2: reflects more .* front_specular = 0.9; must be at most 0.1"),
        ({"back_specular": 1.0, "back_diffuse": 0.1}, "back_diffuse = 0.1: reflects .*; must be at most 0"),
        ({"back_specular": 0.95}, "back_diffuse = 0.1: reflects more .* back_specular = 0.95; must be at most 0.05"),
        ({"front_emissivity": 0.0}, "front_emissivity = 0.0: .*nothing emits what the film absorbs"),
        ({"back_lambert": -0.1}, "back_lambert = -0.1: must be at least 0 and at most 1"),
    ],
)
def test_wrong_values_are_refused_by_name(values: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        SolarPressure(**({"front_specular": 0.9, "front_diffuse": 0.1} | values))


def test_it_comes_back_from_a_file_and_a_distance_may_be_in_au(tmp_path: Path) -> None:
    shade = Schedule((0.0, 1.0), (0.25, 0.0))
    for law in (SolarPressure(0.84, 0.04), replace(TWO_SIDED, sun=(1.0, 2.0, 3.0), factor=shade)):
        scene = Scene(WAVY, RUBBER, [Springs(), law], [Fixed("start")])
        scene.save(tmp_path / "scene")
        assert Scene.from_toml(tmp_path / "scene" / "scene.toml").law(SolarPressure) == law
    found = scene.with_values({"laws.solar_pressure.distance": "0.5 au"}).law(SolarPressure)
    assert found is not None
    assert found.distance == 0.5 * ASTRONOMICAL_UNIT


def test_what_it_cannot_do_and_what_is_hardly_meant_is_said() -> None:
    bare = Scene(None, None, [SolarPressure(0.84, 0.04)], [cord()])
    dark = Scene(DISC, RUBBER, [Springs(), SolarPressure(0.84, 0.04, factor=Schedule((0.0,), (0.0,)))])
    assert any("no film" in text for text in map(str, idle_laws(bare)))
    assert any("factor is 0" in text for text in map(str, idle_laws(dark)))
    near = Scene(DISC, RUBBER, [Springs(), SolarPressure(0.84, 0.04, distance=1.0)], [Fixed("rim")])
    doubts = [finding for finding in audit(near, costly=False).warnings if "solar_pressure.distance" in finding.message]
    assert ["was 1 au meant?" in doubt.remedy for doubt in doubts] == [True]
