"""How far a film may be softened: the rule by hand on small scenes, and what `check` says of it."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from membrane_rs import (
    Fixed,
    Material,
    Mesh,
    Scene,
    Schedule,
    Simulation,
    Spin,
    Springs,
    Tether,
    TipMasses,
    Triangles,
    scenes,
)
from membrane_rs.check import audit, facts, softening_advice
from membrane_rs.check.redundancy import limit_of_step
from membrane_rs.check.softening import (
    CHARTED_PHASE,
    CHARTED_RATE,
    MOST_CRITICAL_STRAIN,
    MOST_FACTOR,
    MOST_STRAIN,
    softening_of_film,
    step_of_softened_film,
)
from membrane_rs.folding import Disc
from membrane_rs.simulation import Motion
from small_scenes import FILM, hanging_strip

SIDE, TIP = 0.1, 0.05
"""Of a square [m], and the sum of the masses on its corners [kg]: far more than that of the film."""
WEIGHTLESS = Material(1e9, 1 / 3, 1e-3, 1e-4)
CORNERS = [[0.0, 0.0, 0.0], [SIDE, 0.0, 0.0], [SIDE, SIDE, 0.0], [0.0, SIDE, 0.0]]


def square(law: Any = None, spin: Any = None, creases: Any = None) -> Scene:
    """A square about the axis with all its mass on its corners."""
    points = np.array(CORNERS) - [SIDE / 2, SIDE / 2, 0.0]
    mesh = Mesh(points, [[0, 1, 2], [0, 2, 3]], node_sets={"corners": [0, 1, 2, 3]}, **(creases or {}))
    laws = [law or Springs(buckling=0.0, buckling_on_creases=0.0), spin or Spin(2.0)]
    return Scene(mesh, WEIGHTLESS, laws, [TipMasses(nodes="corners", mass=TIP / 4)])


def test_the_strain_of_spin_by_hand() -> None:
    # Omega^2 m r^2 over E h S: r^2 is half the side's square, and S is that square.
    by_hand = (4.0 * math.pi) ** 2 * TIP * 0.5 / (1e9 * 1e-4)
    found = softening_advice(square())
    assert found.spin_strain == pytest.approx(by_hand, rel=1e-4)
    assert found.critical_strain == 0.0
    assert found.factor == float(f"{MOST_STRAIN / by_hand:.2g}")


@pytest.mark.parametrize(
    ("spin", "most"),
    [
        (Spin(-2.0), 2.0),
        (Spin(0.0, acceleration=3.0), 3.0 * 0.5),
        (Spin(schedule=Schedule([0.0, 0.1], [4.0, 1.0])), 4.0),
    ],
)
def test_the_largest_rate_of_the_hub_counts(spin: Spin, most: float) -> None:
    scene = square(spin=spin)
    scene = replace(scene, run=replace(scene.run, until=0.5))
    assert softening_advice(scene).spin_strain == pytest.approx(softening_advice(square(spin=Spin(most))).spin_strain)


def test_the_critical_strain_of_creases_by_hand() -> None:
    creases = {"creases": [[0, 2]], "fold_angles": [0.0]}
    length = SIDE * math.sqrt(2.0)
    unit = math.pi**2 * 1e-8 / 12.0
    for law, by_hand in (
        (Springs(10.0, 50.0), 50.0 * unit / length**2),
        (Springs(10.0, 50.0, buckling_length=0.02), 50.0 * unit / 0.02**2),
        (Springs(10.0, 50.0, crease_length=0.02), (10.0 / length + 40.0 / 0.02) * unit / length),
        (Triangles(buckling=10.0, buckling_on_creases=50.0), 50.0 * unit / length**2),
    ):
        assert softening_advice(square(law, creases=creases)).critical_strain == pytest.approx(by_hand)
    edges = (4.0 / SIDE**2 + 1.0 / length**2) / 5.0
    assert softening_advice(square(Springs(10.0, 50.0))).critical_strain == pytest.approx(10.0 * unit * edges)


@pytest.mark.parametrize("lengths", [{}, {"buckling_length": 0.01}, {"crease_length": 0.02}])
def test_a_crease_of_the_core_buckles_at_that_strain(lengths: dict[str, Any]) -> None:
    scene = square(Springs(1e2, 5e3, **lengths), creases={"creases": [[0, 2]], "fold_angles": [0.0]})
    critical = softening_advice(scene).critical_strain
    sim = Motion(scene)
    crease = next(k for k, pair in enumerate(sim.spring_pairs) if set(pair) == {0, 2})
    for share, buckled in ((0.99, False), (1.01, True)):
        sim.positions = sim.assembly.reference * (1.0 - share * critical)
        assert sim.buckled()[crease] == buckled


def test_the_smaller_bound_counts_and_one_is_the_least() -> None:
    stiff = square(Springs(2e3, 2e3))
    found = softening_advice(stiff)
    assert MOST_CRITICAL_STRAIN / found.critical_strain < MOST_STRAIN / found.spin_strain
    assert found.factor == float(f"{MOST_CRITICAL_STRAIN / found.critical_strain:.2g}") > 1.0
    assert softening_advice(square(spin=Spin(100.0))).factor == 1.0


@pytest.mark.parametrize("name", ["okuizumi-model-1", "okuizumi-model-2", "okuizumi-model-1-triangles"])
def test_sails_of_the_paper_may_be_five_times_as_soft(name: str) -> None:
    scene = scenes.load(name)
    assert softening_advice(scene).factor == 5.0
    softened = scene.with_values({"material.softening": 5.0})
    assert softening_advice(softened) == softening_advice(scene)


def test_of_stages_the_least_counts() -> None:
    scene = scenes.load("okuizumi-stage-1")
    each = [softening_advice(scene.staged(k)).factor for k in range(len(scene.stages))]
    assert max(each) == 5.0
    assert softening_advice(scene).factor == min(each) == 1.0


@pytest.mark.parametrize(
    ("scene", "reason"),
    [
        (scenes.load("spinning-tether"), "no film"),
        (Scene(Disc(0.1, rings=2).mesh(), FILM, [Spin()]), "no law of the film"),
        (hanging_strip(), "does not turn"),
    ],
)
def test_scenes_without_advice_say_why(scene: Scene, reason: str) -> None:
    found = softening_advice(scene)
    assert found.factor == 1.0
    assert math.isnan(found.spin_strain)
    assert reason in found.reason


@pytest.mark.parametrize("points", [[0.05, 0.0, 0.0], [0.1, 0.0, 0.0]])
@pytest.mark.parametrize("parts", [[], [Fixed((0,))]])
def test_a_triangle_without_area_has_no_advice_and_check_lists_it(points: list[float], parts: list[Fixed]) -> None:
    mesh = Mesh([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], points, [0.0, 0.1, 0.0]], [[0, 1, 2], [0, 1, 3]])
    scene = Scene(mesh, FILM, [Springs(), Spin(2.0)], parts)
    found = softening_advice(scene)
    assert found.factor == 1.0
    assert "triangle 0" in found.reason
    assert audit(scene).find("degenerate") is not None
    assert audit(scene.with_values({"material.softening": 3.0})).find("degenerate") is not None


@pytest.mark.parametrize("frequency", [1e-170, 1e160])
def test_a_spin_whose_strain_is_no_number_has_no_advice(frequency: float) -> None:
    found = softening_advice(square(spin=Spin(frequency)))
    assert found.factor == 1.0
    assert "no number above 0" in found.reason


@pytest.mark.parametrize("frequency", [1e-3, 1e-158])
def test_no_more_is_advised_than_was_compared(frequency: float) -> None:
    assert softening_advice(square(spin=Spin(frequency))).factor == MOST_FACTOR


@pytest.mark.parametrize("factor", [5.0, 5.0001, 5.0012, 5.00225, 5.006, 5.4])
def test_no_warning_is_without_its_reason(factor: float) -> None:
    scene = scenes.load("okuizumi-model-1").with_values({"material.softening": factor})
    warnings = [one for one in softening_of_film(scene) if one.severity == "warning"]
    assert bool(warnings) == (factor > 5.005)
    assert all(
        "deploy nearly as unsoftened ones do: " in one.message and "5 is the largest softening" in one.message
        for one in warnings
    )


def test_cords_that_gain_much_mass_are_warned_of_and_bound_the_advice() -> None:
    # Cords of 0.2 m in all, at 1 g/m, beside a film of 0.1 g.
    film = Material(1e9, 1 / 3, 100.0, 1e-4)
    cords = [Tether((0.05, y, 0.0), (0.15, y, 0.0), 4, 50.0, 1e-3) for y in (-0.1, 0.1)]
    scene = replace(square(), material=film, parts=cords)
    most = softening_advice(scene).factor
    assert most == 1.0  # 1 + 0.1 * 0.1 / 0.2, of which two digits
    lighter = replace(scene, parts=[replace(cord, linear_density=2e-5) for cord in cords])
    assert softening_advice(lighter).factor == pytest.approx(1.0 + 0.1 * 1e-4 / 4e-6, abs=0.1)
    (found,) = [
        one for one in softening_of_film(lighter.with_values({"material.softening": 5.0})) if "heavier" in one.message
    ]
    assert found.severity == "warning"
    assert "by 1.6e-05 kg" in found.message
    assert "a mass of 0.0001 kg" in found.message
    assert f"take {softening_advice(lighter).factor:g} or less" in found.remedy
    advised = lighter.with_values({"material.softening": softening_advice(lighter).factor})
    assert [one.severity for one in softening_of_film(advised)] == ["info"]
    assert not list(softening_of_film(scene.with_values({"material.softening": 1.0})))


def test_facts_have_the_mass_of_the_sail_without_its_softening() -> None:
    scene = scenes.load("okuizumi-model-1")
    assert facts(scene.with_values({"material.softening": 10.0}))["mass"] == facts(scene)["mass"]


def test_check_says_what_softening_gains() -> None:
    scene = scenes.load("okuizumi-model-1")
    (found,) = step_of_softened_film(scene)
    gain = limit_of_step(scene.with_values({"material.softening": 5.0})) / limit_of_step(scene)
    assert found.severity == "info"
    assert f"the step would be {gain:.2g} times as long" in found.message
    assert f"{100.0 * (1.0 - 1.0 / gain):.0f} % fewer steps" in found.message
    assert f"{MOST_FACTOR:g} times as soft differ from the full models' by {CHARTED_RATE:g} in the" in found.message
    assert "--set material.softening=5" in found.remedy
    for other in ({"run.integrator": "generalized_alpha"}, {"material.softening": 5.0}):
        assert not list(step_of_softened_film(scene.with_values(other)))


def test_what_softening_changes_is_what_the_readme_has() -> None:
    page = (Path(__file__).parent.parent / "README.md").read_text(encoding="utf-8")
    part = page.partition("<!-- fast-scenes: begin -->")[2].partition("<!-- fast-scenes: end -->")[0]
    head, _, *rows = ([cell.strip() for cell in line.split("|")] for line in part.splitlines() if "|" in line)
    assert all(f"softened {MOST_FACTOR:g}," in row[2] for row in rows)
    for name, charted in (("rate", CHARTED_RATE), ("phase [deg]", CHARTED_PHASE)):
        assert max(float(row[head.index(name)]) for row in rows) == charted


def test_nothing_is_said_where_something_else_sets_the_step() -> None:
    scene = scenes.load("okuizumi-model-1").with_values({"laws.creases.contact_penalty": 1e8})
    assert not list(step_of_softened_film(scene))


def test_a_softened_scene_is_named() -> None:
    scene = scenes.load("okuizumi-model-1").with_values({"material.softening": 5.0})
    found = audit(scene, costly=False)
    assert not found.without_facts().findings
    fact = found.find("softening")
    assert fact is not None
    assert "strains are those of the softened film" in fact.message
    assert facts(scene)["softening"] == "5-fold in stretch"
    assert "softened 5-fold" in str(scene._card())
    assert "softening" not in facts(scenes.load("okuizumi-model-1"))


@pytest.mark.parametrize(
    ("scene", "words"),
    [
        (scenes.load("okuizumi-model-1").with_values({"material.softening": 30.0}), "30 is above 5.*spin is 0.000509"),
        (scenes.load("single-crease").with_values({"material.softening": 3.0}), "3 is without advice: .*not turn"),
    ],
)
def test_too_much_softening_is_warned_of(scene: Scene, words: str) -> None:
    from membrane_rs import AuditWarning

    with pytest.warns(AuditWarning, match=words):
        Simulation(scene)


def test_a_film_that_bears_no_softening_is_to_be_left_without() -> None:
    fast = scenes.load("okuizumi-model-1").with_values({"material.softening": 3.0, "laws.spin.frequency": 40.0})
    assert softening_advice(fast).factor == 1.0
    (found,) = (one for one in audit(fast, costly=False).without_facts().findings if one.kind == "softening")
    assert "the rule allows none, the mean strain under the spin is" in found.message
    assert found.remedy.startswith("leave it out, or compare")


def test_softening_makes_no_implicit_step_longer() -> None:
    scene = scenes.load("okuizumi-model-1").with_values({"material.softening": 5.0})
    implicit = scene.with_values({"run.integrator": "generalized_alpha"})
    (found,) = audit(implicit, costly=False).without_facts().findings
    assert found.kind == "setting_without_effect"
    assert "'generalized_alpha', which is implicit" in found.message
    # A caller's own method is no fault of the scene.
    assert not Simulation(scene, "generalized_alpha").audit().without_facts().findings
