"""Softened films in the work-precision diagram: lines of their own, against the film as it is."""

from __future__ import annotations

import csv
import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from membrane_rs import InputError, InputTypeError, MembraneError, Scene, Simulation, scenes
from membrane_rs.cli import app
from membrane_rs.scene.softened import with_softening
from membrane_rs.study import WorkPrecision, work_precision
from membrane_rs.study.common.differences import position_error
from membrane_rs.study.common.run import run_case, study_case
from membrane_rs.study.refinement import Point, finest_errors
from small_scenes import hanging_strip, refused
from typer.testing import CliRunner

UNTIL, FACTOR = 0.02, 4.0
LINE = "leapfrog (softened 4)"


def charted(scene: Scene | None = None, **ways: Any) -> WorkPrecision:
    """A hanging strip, by one method unless others are given."""
    given: dict[str, Any] = {
        "methods": ["leapfrog"],
        "steps": 3,
        "instants": 2,
        "repeats": 1,
        "softenings": [FACTOR],
        **ways,
    }
    return work_precision(hanging_strip() if scene is None else scene, until=UNTIL, **given)


@pytest.fixture(scope="module")
def strip() -> WorkPrecision:
    return charted(methods=["rk4", "leapfrog", "generalized_alpha"], softenings=[16, FACTOR, FACTOR])


def test_each_softening_is_a_line_by_the_explicit_method_of_the_cheapest_step(strip: WorkPrecision) -> None:
    assert list(strip.orders) == ["rk4", "leapfrog", "generalized_alpha", LINE, "leapfrog (softened 16)"]
    assert [point.softening for point in strip.points_of(LINE)] == [FACTOR] * 5
    assert {point.softening for point in strip.points_of("leapfrog")} == {None}
    dopri5 = charted(methods=["generalized_alpha", "dopri5"], steps=1)
    assert list(dopri5.orders)[2:] == ["dopri5 (softened 4)"]


def test_a_softened_film_has_steps_of_its_own_limit(strip: WorkPrecision) -> None:
    limit = Simulation(with_softening(hanging_strip(), FACTOR), "leapfrog").stable_dt()
    assert all(point.dt / point.share == pytest.approx(limit) for point in strip.points_of(LINE))
    assert limit > 1.2 * Simulation(hanging_strip(), "leapfrog").stable_dt()


def test_its_errors_are_against_the_film_as_it_is(strip: WorkPrecision) -> None:
    case = study_case(hanging_strip(), UNTIL, strip.instants)
    true = run_case(case, "rk4", strip.reference_dt, shapes=True)
    point = strip.points_of(LINE)[-1]
    soft = run_case(case.of(with_softening(case.scene, FACTOR)), "leapfrog", point.dt, shapes=True)
    assert point.errors["position"] == pytest.approx(position_error(soft, true, case.start))
    # Against itself it would seem a thousand times as good.
    own = run_case(case.of(with_softening(case.scene, FACTOR)), "rk4", strip.reference_dt, shapes=True)
    assert position_error(soft, own, case.start) < 1e-3 * point.errors["position"]


def test_its_floor_is_no_order_and_is_reported(strip: WorkPrecision, tmp_path: Path) -> None:
    errors = [point.errors["position"] for point in strip.points_of(LINE) if point.is_stable]
    assert max(errors) < 2.0 * min(errors)
    assert math.isnan(strip.orders[LINE]["position"])
    assert strip.orders["leapfrog"]["position"] == pytest.approx(2.0, abs=0.2)
    text = strip.summary()
    assert f"levels out at {errors[-1]:.1e}\n" in text
    assert text.count("levels out at") == 2
    assert text.endswith("is a floor of them, which no step lessens.")
    assert strip._line(LINE, "position").label == f"{LINE}: levels out at {errors[-1]:.1e}"
    strip.save(tmp_path)
    with (tmp_path / "chart.csv").open(newline="") as file:
        assert {row["softening"] for row in csv.DictReader(file)} == {"", "4.0", "16.0"}
    data = json.loads((tmp_path / "chart.json").read_text())
    assert (data["reference_softening"], data["points"][-1]["softening"]) == (None, 16.0)


def test_an_order_is_measured_well_above_the_floor() -> None:
    scene = hanging_strip()
    undamped = replace(scene, laws=[law for law in scene.laws if law.kind != "spring_damping"])
    found = charted(undamped, softenings=[1.0 + 1e-9], steps=6)  # the steps make nearly all of the error
    (line,) = set(found.orders) - {"leapfrog"}
    finest = found.points_of(line)[-1].errors["position"]
    assert f"ends at {finest:.1e}" in found.summary()
    assert found.orders[line]["position"] == pytest.approx(2.0, abs=0.2)


def test_curves_within_the_spread_are_not_distinguished_from_the_film_as_it_is() -> None:
    found = charted(curves=True, members=1, steps=1, instants=5)
    assert found._line(LINE, "rate").label.startswith(f"{LINE}: ends at ")
    wide = replace(found, floors={"rate": 1e3, "phase": 1e3})
    assert wide._line(LINE, "rate").label.startswith(f"{LINE}: ends within the bounds, at ")
    assert wide.summary().count("ends within the bounds, at ") == 2


def test_the_softening_of_the_scene_is_left_out_where_others_are_compared(strip: WorkPrecision) -> None:
    found = charted(with_softening(hanging_strip(), 16.0))
    assert found.reference_softening is None
    assert [replace(p, seconds=0.0) for p in found.points_of(LINE)] == [
        replace(p, seconds=0.0) for p in strip.points_of(LINE)
    ]
    alone = charted(with_softening(hanging_strip(), 16.0), softenings=(), steps=1)
    assert list(alone.orders) == ["leapfrog (softened 16)"]
    assert alone.reference_softening == 16.0
    assert "reference: rk4 (softened 16) at" in alone.summary()
    assert alone.summary().endswith("errors are of the steps, without what softening changes.")
    assert "softening" not in charted(softenings=(), steps=1).summary()


def test_starts_are_further_apart_where_films_are_compared() -> None:
    found = {shift: charted(members=1, steps=1, shift=shift) for shift in (None, 1e-6, 1e-7)}
    assert [each.shift for each in found.values()] == [1e-6, 1e-6, 1e-7]
    assert found[None].floors == found[1e-6].floors
    assert found[1e-6].floors["position"] == pytest.approx(10.0 * found[1e-7].floors["position"], rel=1e-3)
    assert "1 starts perturbed by 1e-06 m" in found[None].summary()
    assert charted(softenings=(), steps=1).shift == 1e-12


@pytest.mark.parametrize(
    ("errors", "finest", "has_levelled"),
    [
        ([4.0, 2.1, 1.1], 1.1, True),
        ([4.0, 2.1, 1.0], 1.0, False),
        ([4.0, 3.9, math.nan], 3.9, True),
        ([math.nan, 1.0], 1.0, False),
    ],
)
def test_a_line_has_levelled_out_where_half_the_step_leaves_more_than_half(
    errors: list[float], finest: float, has_levelled: bool
) -> None:
    points = [Point("rk4", 1.0, 0.5, 1, 4, 0.0, {"position": error}, None, None) for error in errors]
    assert finest_errors(points, "position") == (finest, has_levelled)
    beyond = replace(points[0], share=1.05)
    assert finest_errors([beyond, *points], "position") == (finest, has_levelled)
    assert math.isnan(finest_errors([beyond], "position")[0])


@pytest.mark.parametrize(
    ("given", "kind", "words"),
    [
        ({"softenings": [0.5]}, InputError, "material.softening = 0.5: must be at least 1 and at most 1e"),
        ({"softenings": [1e7]}, InputError, "material.softening = 10000000.0: must be at least 1 and at most 1e"),
        ({"softenings": [math.nan]}, InputError, "softenings = nan: must be finite"),
        ({"softenings": ["soft"]}, InputTypeError, "softenings = 'soft': must be a number"),
        ({"softenings": 3.0}, InputTypeError, "softenings = 3.0: must be a list of numbers"),
        ({"shift": 0.0}, InputError, "shift = 0.0: must be above 0"),
        ({"methods": ["generalized_alpha"]}, InputError, "which is implicit; add an explicit method"),
        ({"scene": scenes.load("spinning-tether")}, InputError, "material.softening = 4.0: .* it has no material"),
    ],
)
def test_wrong_softenings_are_refused(given: dict[str, Any], kind: type[MembraneError], words: str) -> None:
    refused(lambda: charted(**given), kind, words)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("--softening 3,x", "--softening = '3,x': must be numbers separated by commas"),
        ("--softening 0.5", "material.softening = 0.5: must be at least 1"),
        ("--softening 3 --shift 0", "shift = 0.0: must be above 0"),
    ],
)
def test_wrong_options_are_refused_in_one_line(words: str, message: str) -> None:
    result = CliRunner().invoke(app, ["work-precision", "spinning-disc", "--until", "0.001", *words.split()])
    assert result.exit_code == 2
    assert message in " ".join(result.output.split())


def test_the_command_charts_softened_films(tmp_path: Path) -> None:
    words = "--until 0.005 --steps 1 --integrators leapfrog --repeats 1 --softening 3,10 --json --out"
    result = CliRunner().invoke(app, ["work-precision", "spinning-disc", *words.split(), str(tmp_path)])
    assert result.exit_code == 0
    data = json.loads(result.stdout)
    assert list(data["orders"]) == ["leapfrog", "leapfrog (softened 3)", "leapfrog (softened 10)"]
    assert data["shift"] == 1e-6
