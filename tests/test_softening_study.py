"""The study of softened films: distances of ensembles, shares inside a band, fronts, and scenes that it compares."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import softening_pictures
from matplotlib.figure import Figure
from membrane_rs import Scene, Simulation, SpringDamping, Tethers, scenes
from membrane_rs._arrays import Floats
from membrane_rs.check import softening_advice
from membrane_rs.scene.softened import with_softening
from membrane_rs.study.common.perturbation import MODEL_SHIFT, perturbation
from softening_cases import (
    ALIKE,
    FAST_SCENES,
    MODELS,
    Case,
    coarse,
    fast,
    fast_scene,
    ratio_kept,
    spun,
    symmetric,
    weak_creases,
)
from softening_distance import (
    Distance,
    chance,
    distance,
    expected_inside,
    front,
    mean_distance,
    shares_inside,
    spread,
    standard_error,
)
from softening_pictures import Groups, draw_distances, draw_front
from softening_runs import CURVES, RATE, Ensemble, Extent, Run, Runs, deployed, prepared
from softening_substeps import DESIGNS, deployed_design, substeps_table
from softening_symmetry import Petals
from softening_tables import (
    cost_table,
    displacement_table,
    distance_table,
    fast_table,
    front_table,
    petals_table,
    starts_table,
)

SAMPLES = 50


def noisy(starts: int, seed: int, offset: float = 0.0) -> Floats:
    """Curves of independent noise of unit variance about a constant."""
    return np.asarray(offset + np.random.default_rng(seed).standard_normal((starts, SAMPLES)))


def test_the_distance_of_constant_curves_is_their_difference() -> None:
    one, other = np.full((3, SAMPLES), 2.0), np.full((4, SAMPLES), 5.0)
    found = distance(one, other)
    assert (found.value, found.error, found.net) == (3.0, 0.0, 3.0)
    assert found.chance == pytest.approx(1 / 35, abs=0.015)  # one allocation of 7 starts to 3 and 4


def test_the_distance_of_means_is_the_root_of_the_mean_square_over_samples() -> None:
    one, other = np.zeros((2, 4)), np.array([[3.0, 0.0, 0.0, 4.0], [3.0, 0.0, 0.0, 4.0]])
    assert mean_distance(one, other) == 2.5


def test_the_standard_error_is_the_distance_of_two_ensembles_of_one_model() -> None:
    pairs = [(noisy(16, 2 * k), noisy(16, 2 * k + 1)) for k in range(200)]
    squares = np.mean([mean_distance(*pair) ** 2 for pair in pairs])
    errors = np.mean([standard_error(*pair) ** 2 for pair in pairs])
    assert squares == pytest.approx(2 / 16, rel=0.03)
    assert errors == pytest.approx(2 / 16, rel=0.03)


def test_the_net_distance_is_that_without_chance() -> None:
    assert Distance(5.0, 3.0, 0.0).net == 4.0
    assert Distance(2.0, 3.0, 0.0).net == 0.0
    found = distance(noisy(16, 1), noisy(16, 2, offset=0.5))
    assert found.net == pytest.approx(0.5, abs=0.1)
    assert found.value > found.net


def test_equal_models_are_apart_by_chance_and_others_are_not() -> None:
    of_equal = [chance(noisy(8, 2 * k), noisy(8, 2 * k + 1), 200) for k in range(40)]
    assert 0.35 < np.mean(of_equal) < 0.65
    assert chance(noisy(8, 1), noisy(8, 2, offset=1.0), 200) == 1 / 200


def test_spread_and_error_of_one_start_are_unknown() -> None:
    assert math.isnan(spread(noisy(1, 0)))
    assert math.isnan(standard_error(noisy(1, 0), noisy(8, 1)))
    assert spread(noisy(400, 0)) == pytest.approx(1.0, rel=0.02)


def test_shares_inside_count_the_bounds() -> None:
    band = np.array([[0.0, 0.0, 0.0, 0.0], [1.0, 1.0, 1.0, 1.0]])
    curves = np.array([[0.0, 1.0, 0.5, 2.0], [-1.0, 2.0, 0.5, 1.5]])
    assert shares_inside(curves, band).tolist() == [0.75, 0.25]


@pytest.mark.parametrize("count", [2, 8, 16])
def test_a_start_of_the_same_model_is_inside_as_often_as_counting_says(count: int) -> None:
    found = [shares_inside(noisy(1, 2 * k), noisy(count, 2 * k + 1))[0] for k in range(400)]
    assert np.mean(found) == pytest.approx(expected_inside(count), abs=0.02)


def test_the_front_has_the_points_that_none_beats_by_ascending_cost() -> None:
    costs, errors = [5.0, 1.0, 3.0, 2.0, 2.0, 6.0], [0.1, 1.0, 0.5, 0.4, 0.6, 0.1]
    assert front(costs, errors) == [1, 3, 0]
    assert front([], []) == []
    assert front([1.0, 1.0], [2.0, 2.0]) == [0]


def ensemble(seed: int, offset: float = 0.0, seconds: float = 2.0) -> Ensemble:
    times = np.linspace(0.0, 0.8, SAMPLES)
    numbers = {"steps": np.array(100.0 * seconds), "seconds": np.array(seconds), "error": np.array(-1e-3)}
    return Ensemble([
        {"time": times, RATE: rate, "phase_difference_deg": phase, **numbers}
        for rate, phase in zip(noisy(4, seed, offset), noisy(4, seed + 100, offset), strict=True)
    ])  # fmt: skip


def test_tables_show_distances_costs_and_what_was_stopped() -> None:
    found = {
        "model 1": {
            "full model": ensemble(0), "full model, other starts": ensemble(1), "full model, 1e-12 m": ensemble(2),
            "softened 3": ensemble(3, 5.0, seconds=0.5), "softened 10": Ensemble([{}]),
        }
    }  # fmt: skip
    rows = distance_table(found).splitlines()
    assert [row.split(" | ")[1] for row in rows[2:]] == list(found["model 1"])[1:]
    assert float(rows[4].split(" | ")[2]) == pytest.approx(5.0, abs=0.3)
    assert rows[-1].count("stopped") == 8
    costs = cost_table(found).splitlines()
    assert "| softened 3 | 50 | 4.00 | 0.50 | 4.00 | -0.10 |" in costs[4]
    assert "60 % of the samples" in starts_table(found)
    assert front_table(found).splitlines()[2].startswith("| model 1 | softened 3 | 0.50 | 4.0 | 5.")
    assert displacement_table(found).count("1e-12") == 2


@pytest.mark.parametrize(
    "draw", [lambda found, file: draw_distances(found, dict.fromkeys(found, (3,)), file), draw_front]
)
def test_no_point_of_a_picture_lies_beyond_its_axes(
    draw: Callable[[Groups, Path], None], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn: list[Figure] = []
    monkeypatch.setattr(softening_pictures, "save_figure", lambda figure, _: drawn.append(figure))
    found = {
        name: {
            "full model": ensemble(0),
            "full model, other starts": ensemble(1),
            "softened 3": ensemble(2, offset, 0.5),
        }
        for name, offset in (("near", 1.0), ("far", 5.0))
    }
    draw(found, tmp_path / "picture.png")
    panels = drawn[0].axes
    assert len(panels) == 4
    for axes in panels:
        low, high = axes.get_ylim()
        values = np.concatenate([np.ravel(line.get_ydata()) for line in axes.get_lines()])
        assert low == 0.0 <= values.min() < values.max() < high


def test_fast_scenes_are_beside_their_full_models() -> None:
    full = {"full model": ensemble(0), "full model, other starts": ensemble(2, 2.0)}
    found = {"model 2": {**full, "softened 10": ensemble(1, 5.0, seconds=0.5)}}
    lines = fast_table(found, FAST_SCENES).splitlines()
    assert lines[0].startswith("Mean curves of 4 starts, against 8 of the full model")
    assert lines[3] == "Starts inside with both curves throughout: 0."
    cells = lines[-1].strip("| ").split(" | ")
    assert cells[:2] == ["`okuizumi-model-2-fast`", "softened 10"]
    assert [float(cells[k]) for k in (2, 6)] == pytest.approx([4.0, 4.0], abs=0.3)
    assert max(float(cells[k]) for k in (5, 9)) < 10.0
    assert cells[-1] == "4.0"
    for model, name in FAST_SCENES.items():
        scene = scenes.load(name)
        label = f"softened {scene.value('material.softening'):g}, {scene.run.substeps} substeps"
        own = fast_scene(model)
        assert list(own) == ["full model", "full model, other starts", label]
        assert prepared(own[label])[1] == scene.run.dt


def test_a_petal_with_twice_the_spread_of_the_whole_sail_saves_nothing() -> None:
    full = {"full model": ensemble(0), "full model, other starts": ensemble(2)}
    wide = [
        {**run, **{name: 2.0 * run[name] for name in CURVES}} for run in (*full["full model"].runs, *ensemble(2).runs)
    ]
    lines = petals_table({"model 1": {**full, ALIKE: Ensemble(wide)}, "model 2": {**full, ALIKE: Ensemble([{}])}})
    *_, made, stopped = lines.splitlines()
    cells = made.strip("| ").split(" | ")
    assert len(cells) == 11
    assert (cells[5], cells[10]) == ("1.00", "1.00")
    assert stopped.count("stopped") == 10


class MadeRuns(Runs):
    """Runs that are given: all with 2 substeps are stopped, and those with 4 of the softest creases. Others are the
    faster, the more substeps, and the longer their step."""

    def of(self, jobs: Mapping[str, Callable[[], Run]]) -> dict[str, Run]:
        return {name: self.made(*name.split()[-4:-1]) for name in jobs}

    @staticmethod
    def made(substeps: str, of_limit: str, beta: str) -> Run:
        if substeps == "2" or (substeps == "4" and float(beta) == DESIGNS[0]):
            return {}
        return {"seconds": np.array(6.4 / int(substeps) / float(of_limit)), "error": np.array(-1e-3 * float(beta))}


def test_designs_that_are_stopped_are_counted_by_substeps(tmp_path: Path) -> None:
    lines = substeps_table(MadeRuns(tmp_path, Extent(1))).splitlines()
    rows = [[cell.strip() for cell in line.strip("| ").split("|")] for line in lines[2:]]
    assert [row[1:3] for row in rows] == [["1", "0.8"], ["2", "0.8"], ["3", "0.8"], ["4", "0.8"], ["3", "0.91"]] * 2
    assert [row[3] for row in rows] == ["0 of 8", "8 of 8", "0 of 8", "1 of 8", "0 of 8"] * 2
    assert [row[6] for row in rows] == ["1.00", "-", "3.00", "4.00", f"{3.0 * 0.91 / 0.8:.2f}"] * 2
    assert rows[0][5] == f"{0.1 * DESIGNS[-1]:.2f}"


def test_a_design_runs_with_its_substeps_at_the_share_of_its_own_limit() -> None:
    found = deployed_design(FAST_SCENES["model 2"], 2, 0.8, DESIGNS[0], 0.001)
    assert found["seconds"] > 0.0
    assert abs(float(found["error"])) < 0.01


def test_the_coarse_mesh_has_half_the_lines_and_the_film_of_the_fine_one() -> None:
    fine = fast(scenes.load(MODELS["model 1"]))
    found = coarse(fine)
    assert fine.mesh is not None
    assert found.mesh is not None
    assert found.mesh.node_count < 0.4 * fine.mesh.node_count
    assert found.mesh.areas().sum() == pytest.approx(fine.mesh.areas().sum(), rel=1e-3)
    assert [part.segments for part in found.parts if isinstance(part, Tethers)] == [9]
    assert with_softening(found, 10.0).as_simulated.material.youngs_modulus == pytest.approx(3.2e8)  # type: ignore[union-attr]


def test_variants_change_what_their_names_say() -> None:
    scene = fast(scenes.load(MODELS["model 1"]))
    damping = ratio_kept(scene, 10).law(SpringDamping)
    assert damping is not None
    assert (damping.ratio, damping.mass) == (0.02, "reduced")
    assert spun(scene).value("laws.spin.frequency") == 6.0
    assert spun(scene).run.until == 0.4
    assert weak_creases(scene).value("laws.springs.buckling_on_creases") == pytest.approx(100.0)


def test_a_start_is_repeated_to_the_bit_and_another_is_another() -> None:
    case = Case("brief", lambda: coarse(fast(scenes.load(MODELS["model 2"]))))
    one, again, other = (deployed(case, seed, share=0.005) for seed in (1, 1, 2))
    assert np.array_equal(one[RATE], again[RATE])
    assert 0.0 < np.abs(one[RATE] - other[RATE]).max() < 100 * MODEL_SHIFT / 0.1
    assert one["steps"] > 0
    limit = Simulation(case.make()).stable_dt()
    assert float(one["time"][-1]) / float(one["steps"]) == pytest.approx(0.8 * limit, rel=0.1)


def test_one_strain_of_the_rule_is_another_in_each_of_its_scenes() -> None:
    scene = fast(scenes.load(MODELS["model 1"]))

    def strains(one: Scene) -> tuple[float, float]:
        advice = softening_advice(one)
        return advice.spin_strain, advice.critical_strain

    spin, critical = strains(scene)
    assert spin == pytest.approx(1.7e-5, rel=0.02)
    assert strains(spun(scene)) == pytest.approx((4.0 * spin, critical))
    weak = weak_creases(scene)
    assert strains(weak) == pytest.approx((spin, 0.1 * critical))


def test_petals_that_are_given_their_mean_motion_are_alike() -> None:
    scene = coarse(fast(scenes.load(MODELS["model 2"])))
    sim = Simulation(scene)
    petals, still = Petals(sim.positions), sim.positions
    assert np.array_equal(petals.mean(still), still)
    displaced = petals.alike(perturbation(scene, 3, MODEL_SHIFT))
    assert np.abs(petals.mean(displaced) - displaced).max() < 1e-15
    assert displaced.std() == pytest.approx(MODEL_SHIFT, rel=0.1)
    sim.positions = still + perturbation(scene, 3, MODEL_SHIFT)
    sim.step(2)
    before, speeds = sim.positions, sim.velocities
    petals.average(sim)
    assert np.abs(before - petals.mean(before)).max() > 0.1 * MODEL_SHIFT
    assert np.abs(sim.positions - petals.mean(before)).max() < 1e-15
    assert np.abs(sim.velocities - petals.mean(speeds)).max() < 1e-12


def test_a_run_of_petals_alike_differs_from_that_of_the_whole_sail() -> None:
    case = symmetric("model 1")[ALIKE]
    brief = replace(case, make=lambda: coarse(fast(scenes.load(MODELS["model 1"]))))
    alike, whole = (deployed(one, 1, share=0.005) for one in (brief, replace(brief, alike=False)))
    assert np.array_equal(alike["time"], whole["time"])
    assert 0.0 < np.abs(alike[RATE] - whole[RATE]).max() < 100 * MODEL_SHIFT / 0.1
