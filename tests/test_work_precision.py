"""The work-precision diagram: known orders, stopped runs, lower bounds, the cheapest method."""

from __future__ import annotations

import csv
import json
import math
import re
from dataclasses import replace
from pathlib import Path
from threading import Event
from typing import Any

import numpy as np
import pytest
from membrane_rs import InputError, RunSettings, Simulation, UnstableError, scenes
from membrane_rs.cli import app
from membrane_rs.simulation import integrators
from membrane_rs.study import WorkPrecision, ablation, accuracy, work_precision
from membrane_rs.study.common.density import denser
from membrane_rs.study.common.differences import position_error
from membrane_rs.study.common.executor import run_parallel
from membrane_rs.study.common.perturbation import SHIFT
from membrane_rs.study.common.run import StudyRun, ensemble, run_case, study_case
from membrane_rs.study.refinement import Point, cheapest, measured_order, refinement_levels
from PIL import Image
from small_scenes import hanging_strip, refused
from typer.testing import CliRunner


@pytest.fixture(scope="module")
def disc() -> WorkPrecision:
    """A disc that rings in its plane: smooth, so that every method shows its order."""
    return work_precision(scenes.load("spinning-disc"), until=0.02, steps=5, repeats=1)


def test_every_method_runs_at_every_level(disc: WorkPrecision) -> None:
    assert list(disc.orders) == list(integrators())
    limited = [
        name for name in integrators() if math.isfinite(Simulation(scenes.load("spinning-disc"), name).stable_dt())
    ]
    for name in limited:
        points = disc.points_of(name)
        if integrators()[name].is_adaptive:
            continue
        assert len(points) == 7
        shares = [point.share for point in points]
        assert shares == sorted(shares, reverse=True)
        assert shares[0] > 1.0 > shares[2]
        assert points[-1].evaluations > points[2].evaluations


def test_order_of_rk4_on_a_smooth_motion_is_four(disc: WorkPrecision) -> None:
    assert disc.orders["rk4"]["position"] == pytest.approx(4.0, abs=0.1)
    errors = [p.errors["position"] for p in disc.points_of("rk4") if p.share < 1.0]
    assert errors == sorted(errors, reverse=True)
    assert disc.reference_errors["position"] < 0.1 * errors[-1]
    assert math.isnan(disc.floors["position"])


def test_an_adaptive_method_takes_tolerances(disc: WorkPrecision) -> None:
    points = disc.points_of("dopri5")
    tolerances = [point.tolerance for point in points]
    assert tolerances == pytest.approx([1e-3 / 10 ** (1.5 * k) for k in range(5)])
    assert points[-1].errors["position"] < 1e-3 * points[0].errors["position"]
    assert points[0].rejected > 0
    # Rejected steps cost their evaluations too: six a step, and one at the start.
    assert all(point.evaluations == 6 * (point.steps + point.rejected) + 1 for point in points)
    assert points[-1].dt == pytest.approx(disc.until / points[-1].steps, rel=0.2)


def test_steps_beyond_the_limit_are_marked_where_the_monitor_stops_them(disc: WorkPrecision) -> None:
    worst = disc.points_of("rk4")[0]
    assert worst.failure is not None
    assert worst.failed_at is not None
    assert 0.0 < worst.failed_at <= disc.until
    assert math.isnan(worst.errors["position"])
    assert all(point.failure is None for point in disc.points if point.share < 1.0)
    assert all(point.is_stable for point in disc.points if point.tolerance is not None)


def test_the_cheapest_method_is_named(disc: WorkPrecision) -> None:
    best = disc.best["evaluations"]
    assert best is not None
    assert best.integrator in integrators()
    assert disc.best["seconds"] is not None
    assert f"{best.integrator} with {'dt' if best.tolerance is None else 'tolerance'} = " in disc.summary()


def test_a_diagram_is_written(disc: WorkPrecision, tmp_path: Path) -> None:
    disc.save(tmp_path / "new" / "folder")
    folder = tmp_path / "new" / "folder"
    with (folder / "chart.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["dt"]) for row in rows] == [point.dt for point in disc.points]
    assert float(rows[-1]["position_error"]) == disc.points[-1].errors["position"]
    data = json.loads((folder / "chart.json").read_text())
    assert data["reference"] == "rk4"
    assert len(data["points"]) == len(disc.points)
    assert data["points"][0]["errors"]["position"] is None
    assert "membrane_rs" in data["versions"]
    with Image.open(folder / "chart.png") as picture:
        assert picture.width > 1000
        assert len(picture.convert("L").getcolors() or []) > 10
    assert sorted(path.name for path in folder.iterdir()) == ["chart.csv", "chart.json", "chart.png"]


def test_curves_have_a_floor_from_perturbed_starts(tmp_path: Path) -> None:
    found = work_precision(
        hanging_strip(), ["rk4"], 0.02, steps=2, curves=True, members=2, repeats=1, instants=20, wanted=1e-30
    )
    assert list(found.labels) == ["rate", "phase"]
    assert all(0.0 < found.floors[name] < 1e-6 for name in found.labels)
    assert found.best == {"evaluations": None, "seconds": None}
    text = found.summary()
    assert "no method reaches it" in text
    assert "is below the lower bound" in text
    reach = replace(found, floors={"rate": 1.0, "phase": 1.0}).summary()
    assert "Least force evaluations within the bound: rk4 with dt = " in reach
    found.save(tmp_path)
    with Image.open(tmp_path / "chart.png") as picture:
        assert picture.height > 800  # two rows of panels


def test_other_meshes_are_lines_of_their_own_against_the_finest(tmp_path: Path) -> None:
    scene = hanging_strip(4, 2)
    ways: dict[str, Any] = {"steps": 2, "curves": True, "members": 0, "instants": 5, "densities": [0.5, 2.0, 0.5, 1.0]}
    found = work_precision(scene, ["rk4", "leapfrog"], 0.02, **ways)
    assert list(found.orders) == ["rk4", "leapfrog", "leapfrog on 0.5 x the mesh", "leapfrog on 2 x the mesh"]
    assert found.reference_density == 2.0
    finest = {line: found.points_of(line)[-1].errors["rate"] for line in found.orders}
    # The scene's own mesh is off by what its mesh leaves, whatever the method; the finest by its step alone.
    assert finest["rk4"] == pytest.approx(finest["leapfrog"], rel=0.05)
    assert finest["leapfrog on 2 x the mesh"] < 0.1 * finest["leapfrog"] < finest["leapfrog on 0.5 x the mesh"]
    assert "rk4 on 2 x the mesh at" in found.summary()
    found.save(tmp_path)
    with (tmp_path / "chart.csv").open(newline="") as file:
        assert {float(row["density"]) for row in csv.DictReader(file)} == {0.5, 1.0, 2.0}


def test_runs_beyond_the_budget_are_left_out_and_reported(tmp_path: Path) -> None:
    found = work_precision(hanging_strip(), ["rk4"], 0.02, steps=2, budget=1e-9, repeats=1)
    points = [point for point in found.points if point.share < 1.0]
    assert all("left out: it would have taken about" in (point.failure or "") for point in points)
    assert all(point.failed_at is None and math.isnan(point.errors["position"]) for point in points)
    assert found.best["evaluations"] is None
    assert "left out as too costly" in found.summary()
    found.save(tmp_path)


def test_levels_for_every_kind_of_method() -> None:
    limited = refinement_levels("a", 1.0, 3, limit=2.0, unit=1.0, is_adaptive=False)
    assert [level.dt for level in limited] == pytest.approx([2.6, 2.1, 1.8, 0.9, 0.45])
    free = refinement_levels("a", 1.0, 3, limit=math.inf, unit=1.0, is_adaptive=False)
    assert [level.dt for level in free] == pytest.approx([64.0, 32.0, 16.0])
    chosen = refinement_levels("a", 0.5, 2, limit=2.0, unit=1.0, is_adaptive=True)
    assert [level.dt for level in chosen] == [None, None]
    assert [level.tolerance for level in chosen] == pytest.approx([1e-3, 1e-3 / 10**1.5])
    assert str(chosen[0]) == "a on 0.5 x the mesh, tolerance 0.001"
    assert "of its limit" not in str(free[0])


def test_progress_is_reported_run_by_run() -> None:
    lines: list[str] = []
    work_precision(hanging_strip(), ["rk4"], 0.2, steps=1, repeats=1, progress=lines.append)
    parts = [line.split("]")[0] for line in lines if line[0] == "["]
    assert parts == ["[1/2", "[2/2", "[1/3", "[2/3", "[3/3"]
    assert re.fullmatch(r"reference: rk4, dt = .* s: [\d,]+ steps, the longest run of all", lines[0])
    shares = [line.split(": ")[2].split(",")[0] for line in lines[1:] if line[0] != "["]
    assert shares == [f"{share} %" for share in range(10, 100, 10)]
    assert "evaluations" in lines[-1]


def test_results_do_not_depend_on_the_number_of_workers() -> None:
    ways: dict[str, Any] = {"steps": 2, "curves": True, "members": 2, "instants": 5}
    one, two = (work_precision(hanging_strip(), ["rk4", "leapfrog"], 0.01, jobs=jobs, **ways) for jobs in (1, 3))
    assert [replace(p, seconds=0.0) for p in one.points] == [replace(p, seconds=0.0) for p in two.points]
    assert one.floors == two.floors


def test_an_interrupt_ends_all_runs_soon() -> None:
    stop, ended = Event(), []

    def work() -> int:
        ended.append(stop.wait(60.0))
        return 0

    def interrupted() -> int:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_parallel([work, interrupted, work], ["", "", ""], stop, workers=2)
    assert ended == [True]  # the third was never begun


def test_one_ensemble_is_like_the_next() -> None:
    case = study_case(hanging_strip(), 0.01, 2)
    dt = Simulation(case.scene).dt
    first, second = (ensemble(case, "rk4", dt, 2, shapes=True, jobs=jobs) for jobs in (1, 2))
    for one, other in zip(first, second, strict=True):
        assert (one.shapes == other.shapes).all()
    apart = [float(np.abs(member.shapes[-1] - first[0].shapes[-1]).max()) for member in first[1:]]
    assert 0.1 * SHIFT < min(apart) < max(apart) < 1e-6
    assert apart[0] != apart[1]


def test_a_case_perturbs_free_nodes_and_keeps_fixed_ones() -> None:
    case = study_case(hanging_strip(), 0.01, 3)
    held = case.scene.assemble().fixed
    shift = case.perturbed(0).start - case.start
    assert (shift[held] == 0.0).all()
    assert 0.1 * SHIFT < np.abs(shift).max() < 10 * SHIFT
    assert case.interval / case.step_near(1e-4) == pytest.approx(round(case.interval / 1e-4))
    assert case.step_near(1.0) == case.interval
    short = case.shortened(0.007)
    assert short.instants == 2
    assert short.until == pytest.approx(2 / 3 * 0.01)
    assert case.shortened(1.0) is case.shortened(None) is case
    assert case.shortened(1e-9).instants == 1


def test_a_case_relaxes_the_scene_once_for_all() -> None:
    scene = hanging_strip()
    relaxing = replace(scene, run=RunSettings(until=0.1, relax=0.02))
    case = study_case(relaxing, 0.01, 2)
    assert not np.allclose(case.start, scene.assemble().positions)
    assert case.scene.run.relax == 0.0
    found = run_case(case, "rk4", 1e-4)
    assert found.failure is None
    assert found.times[-1] == pytest.approx(0.01)
    # Another scene of the same mesh starts there too; one of another mesh is relaxed itself.
    assert (case.of(replace(scene, laws=scene.laws[:1])).start == case.start).all()
    finer = denser(relaxing, 2.0)
    other = case.of(replace(finer, run=replace(finer.run, relax=0.0)))
    assert other.start.shape == finer.assemble().positions.shape
    assert not np.allclose(other.start, finer.assemble().positions)


def test_a_run_that_stops_is_a_result() -> None:
    case = study_case(scenes.load("spinning-tether"), 0.1, 10)
    found = run_case(case, "rk4", 1.3 * Simulation(case.scene, "rk4").stable_dt(), shapes=True)
    assert isinstance(found.failure, UnstableError)
    assert len(found.times) == len(found.shapes) < 10


def point(name: str, dt: float, error: float, evaluations: int, share: float = 0.2) -> Point:
    """A level with an error, or stopped (NaN)."""
    failed = math.isnan(error)
    return Point(
        name, dt, share, 1, evaluations, 1e-6 * evaluations, {"position": error}, "stopped" if failed else None, None
    )


def test_measured_order_is_the_slope_clear_of_the_bounds() -> None:
    points = [point("a", dt, 3.0 * dt**2, 1) for dt in (0.4, 0.2, 0.1)]
    assert measured_order(points, "position", 0.0) == pytest.approx(2.0)
    assert math.isnan(measured_order(points, "position", 0.2))
    assert math.isnan(measured_order([replace(p, share=0.9) for p in points], "position", 0.0))
    assert math.isnan(measured_order([point("a", 0.1, math.nan, 1)] * 3, "position", 0.0))


def test_the_cheapest_lies_between_two_levels() -> None:
    low = [point("low", 0.1 / 2**k, 1e-2 / 4**k, 100 * 2**k) for k in range(6)]
    high = [point("high", 0.1 / 2**k, 1e-1 / 16**k, 400 * 2**k) for k in range(6)]
    lines = {"low": low, "high": high}
    rough, fine = (cheapest(lines, "position", wanted, "evaluations") for wanted in (5e-3, 1e-6))
    assert rough is not None
    assert fine is not None
    assert (rough.integrator, fine.integrator) == ("low", "high")
    assert rough.cost == pytest.approx(100 * math.sqrt(2.0))
    assert rough.dt == pytest.approx(0.1 / math.sqrt(2.0))
    assert cheapest(lines, "position", 1e-12, "seconds") is None


def test_a_level_counts_only_with_all_finer_ones_and_below_the_limit() -> None:
    lucky = [point("a", 0.4, 1e-9, 10, share=1.2), point("a", 0.2, 1e-9, 20), point("a", 0.1, 1e-2, 40)]
    assert cheapest({"a": lucky}, "position", 1e-3, "evaluations") is None
    stopped = [point("a", 0.4, math.nan, 10), point("a", 0.2, 1e-9, 20)]
    best = cheapest({"a": stopped}, "position", 1e-3, "evaluations")
    assert best is not None
    assert (best.dt, best.cost) == (0.2, 20)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"methods": ["rk5"]}, "did you mean 'rk4'"),
        ({"until": 0.0}, "until = 0.0: must be from 1e-15 to 1e.12"),
        ({"until": 1e-16}, "until = 1e-16: must be from 1e-15"),
        ({"until": 1e13}, "must be from 1e-15 to 1e.12"),
        ({"until": math.nan}, "until = nan"),
        ({"steps": 0}, "steps = 0: must be from 1 to 24"),
        ({"members": -1}, "members = -1: must be from 0 to 1,000"),
        ({"members": 1, "shift": 0.06}, "shift = 0.06: must be below 0.01667, the shortest edge or cord"),
        ({"repeats": 0}, "repeats = 0: must be from 1 to 1,000"),
        ({"wanted": 0.0}, "wanted = 0.0: must be greater than 0"),
        ({"instants": -1}, "instants = -1: must be from 1 to"),
        ({"budget": 0.0}, "budget = 0.0: must be greater than 0"),
        ({"jobs": 0}, "jobs = 0: must be from 1 to"),
        ({"densities": [2.0]}, "only curves can be compared; add --curves"),
        ({"densities": [0.3], "curves": True}, "columns = 6 would become 1.8, which is no whole number; take 0.333"),
    ],
)
def test_wrong_numbers_are_refused(given: dict[str, Any], words: str) -> None:
    refused(lambda: work_precision(hanging_strip(), **({"until": 0.01} | given)), InputError, words)


def test_a_scene_at_rest_has_no_relative_error() -> None:
    case = study_case(hanging_strip(), 0.01, 1)
    found = run_case(case, "rk4", 1e-4, shapes=True)
    rest = replace(found, shapes=case.start[None])
    refused(lambda: position_error(found, rest, case.start), InputError, "nothing moves")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("--density 2,x --curves", "--density = '2,x': must be numbers separated by commas"),
        ("--density 2", "add --curves"),
        ("--density 0.3 --curves", "Disc.rings = 8 would become 2.4, which is no whole number; take 0.25"),
        ("--integrators rk5", "did you mean 'rk4'"),
        ("--integrators rk4,", "must be names separated by commas"),
        ("--jobs 0", "jobs = 0: must be from 1 to"),
        ("--budget -1", "budget = -1.0: must be greater than 0"),
    ],
)
def test_wrong_options_are_refused_in_one_line(words: str, message: str) -> None:
    result = CliRunner().invoke(app, ["work-precision", "spinning-disc", "--until", "0.001", *words.split()])
    assert result.exit_code == 2
    assert message in " ".join(result.output.split())


def test_the_command_reports_its_folder(tmp_path: Path) -> None:
    words = "--until 0.005 --curves --density 0.5 --steps 1 --ensemble 0 --integrators leapfrog --jobs 2 --out"
    result = CliRunner().invoke(app, ["work-precision", "spinning-disc", *words.split(), str(tmp_path / "here")])
    assert result.exit_code == 0
    assert "leapfrog on 0.5 x the mesh" in result.output
    assert (tmp_path / "here" / "chart.png").is_file()


def test_a_start_that_the_monitor_stops_is_not_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    def with_a_bad_one(*given: Any, **ways: Any) -> list[StudyRun]:
        runs = ensemble(*given, **ways)
        return [*runs[:-1], replace(runs[-1], failure=UnstableError("gone"))]

    monkeypatch.setattr(accuracy, "ensemble", with_a_bad_one)
    ways: dict[str, Any] = {"steps": 1, "curves": True, "instants": 5}
    some, none = (work_precision(hanging_strip(), ["rk4"], 0.01, members=members, **ways) for members in (2, 1))
    assert some.members == 1
    assert some.floors["rate"] > 0.0
    assert none.members == 0
    assert math.isnan(none.floors["rate"])
    assert some.stopped_starts.endswith(
        "1 of 2 starts perturbed by 1e-12 m did not reach the end, the first: gone; they are not counted"
    )
    assert none.stopped_starts.endswith("the first: gone; the spread is unknown, take a smaller shift")
    for found in (some, none):
        assert f"\nWarning: {found.stopped_starts}\n" in found.summary()
        assert found.as_dict()["stopped_starts"] == found.stopped_starts
    monkeypatch.setattr(ablation, "ensemble", with_a_bad_one)
    assert ablation.ablate(hanging_strip(), 0.01, members=2).members == 1
