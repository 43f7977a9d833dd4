"""What a sweep varies: lists, ranges, samples; all that is wrong with them is reported before the first run."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from membrane_rs import InputError, InputTypeError, Scene, Stage, scenes
from membrane_rs.study.common.many_runs import MOST_RUNS
from membrane_rs.study.common.sampling import is_sampled, points_of
from membrane_rs.study.common.vary import parameters_of, split_vary
from membrane_rs.study.sweeping import with_starts
from small_scenes import refused

STIFFNESS, BUCKLING = "laws.creases.stiffness", "laws.springs.buckling"


@pytest.fixture(scope="module")
def crease() -> Scene:
    return scenes.load("single-crease")


def values(scene: Scene, key: str, given: Any) -> tuple[Any, ...]:
    (parameter,) = parameters_of(scene, {key: given})
    return parameter.values


@pytest.mark.parametrize(
    ("key", "given", "wanted"),
    [
        (STIFFNESS, "1,3,10,30", (1.0, 3.0, 10.0, 30.0)),
        (STIFFNESS, "1:2:5", (1.0, 1.25, 1.5, 1.75, 2.0)),
        (BUCKLING, "10:1000:log5", (10.0, 31.6227766017, 100.0, 316.227766017, 1000.0)),
        (STIFFNESS, "0.1:0.3:3", (0.1, 0.2, 0.3)),
        ("material.thickness", "5um, 7.5 um,0.00001", (5e-6, 7.5e-6, 1e-5)),
        ("material.thickness", "5um:10 um:3", (5e-6, 7.5e-6, 1e-5)),
        ("run.integrator", "rk4,leapfrog", ("rk4", "leapfrog")),
        ("laws.springs", "true,false", (True, False)),
        ("laws.gravity", "false,true", (False, True)),
        ("run.substeps", "1:8:3", (1, 4, 8)),  # 4.5 is no whole number
        ("run.substeps", "1:3:9", (1, 2, 3)),
        ("run.snapshots", [[0.1], [0.1, 0.2]], ((0.1,), (0.1, 0.2))),
        (STIFFNESS, np.array([1.0, 3.0]), (1.0, 3.0)),
        (STIFFNESS, range(1, 3), (1.0, 2.0)),
    ],
)
def test_values(crease: Scene, key: str, given: Any, wanted: tuple[Any, ...]) -> None:
    found = values(crease, key, given)
    assert found == wanted
    assert [type(value) for value in found] == [type(value) for value in wanted]


def test_units_are_those_of_the_scene(crease: Scene) -> None:
    keys = {"material.thickness": "5um", STIFFNESS: "1", "run.until": "5 ms"}
    assert [parameter.unit for parameter in parameters_of(crease, keys)] == ["m", "", "s"]


def test_values_of_stages() -> None:
    found = parameters_of(scenes.load("okuizumi-whole"), {"stages.3.duration": "20ms,30ms"})
    assert (found[0].key, found[0].values) == ("stages.release.duration", (0.02, 0.03))


@pytest.mark.parametrize(
    ("vary", "words"),
    [
        ({"laws.crease.stiffness": "1"}, "did you mean 'laws.creases.stiffness'"),
        ({"laws.creases.stifness": "1"}, "did you mean 'laws.creases.stiffness'"),
        ({STIFFNESS: "-1,1,-3", "material.thickness": "0"}, "stiffness = -1, -3: must be .*thickness = 0: must be"),
        ({"material.thickness": "5kg,1um,3 s"}, "thickness = '5kg': is a mass; .*thickness = '3 s': is a time"),
        ({"name": "a,b"}, "vary name: is a text that no run depends on; vary a value, such as"),
        ({"name": [1]}, "vary name: is a text"),
        ({"run.integrator": "rk4,leapfrop,rk"}, "run.integrator = 'leapfrop': is no method; did you mean 'leapfrog'"),
        ({STIFFNESS: "nan"}, "must be finite"),
        ({STIFFNESS: "1:inf:3"}, "must be finite"),
        ({STIFFNESS: "1e999:2:3"}, "must be finite"),
        ({STIFFNESS: ""}, "a value is missing"),
        ({STIFFNESS: "1,,2"}, "a value is missing"),
        ({STIFFNESS: "1,1.0"}, "names 1.0 twice"),
        ({STIFFNESS: "1:2"}, "must say how many values"),
        ({STIFFNESS: "1:2:log"}, "must say how many values"),
        ({STIFFNESS: "1:2:"}, "must be a list such as"),
        ({STIFFNESS: "1:2:3:4"}, "must be a list such as"),
        ({STIFFNESS: "1:2:ln5"}, "must be a list such as"),
        ({STIFFNESS: "1:2:-5"}, "must be a list such as"),
        ({STIFFNESS: "1:2:1"}, "must be 2 to 100,000 values"),
        ({STIFFNESS: "1:2:200000"}, "must be 2 to 100,000 values"),
        ({STIFFNESS: "1:2:" + 30 * "9"}, "at most 100,000 values"),
        ({STIFFNESS: "2:1:5"}, "from a lower to a higher value, 2 to 1"),
        ({STIFFNESS: "0:1:log5"}, "must begin above 0"),
        ({STIFFNESS: "soft:stiff:3"}, "stiffness = 'soft', 'stiff': must be a number"),
        ({"run.integrator": "leapfrog:rk4:3"}, "is no number; a range needs two"),
        ({"material.thickness": "5kg"}, "is a mass; must be a length"),
        ({"run.substeps": "1.5"}, "whole number"),
        ({"parts.0": "true", "parts.0.nodes": []}, "0 values; must be 1 to"),
        ({STIFFNESS: 5}, "must be a list of values"),
        ({STIFFNESS: b"1,2"}, "must be a list of values"),
        ({STIFFNESS: bytearray(b"12")}, "must be a list of values"),
        ({STIFFNESS: "1:1:5"}, "from a lower to a higher value, 1 to 1"),
        ({STIFFNESS: "1," * 100_000 + "2"}, "100,001 values; must be 1 to 100,000"),
        ({STIFFNESS: [None]}, "must be a number"),
        ({STIFFNESS: [[1.0]]}, "must be a number"),
        ({STIFFNESS: [1.0] * 200_000}, "200,000 values; must be 1 to"),
        ({"": "1"}, "no value of that name"),
        ({1: "1"}, "must be a name such as"),
        ({f"run.{k}": "1" for k in range(200)}, "200 keys; must be at most 100"),
        ([STIFFNESS], "must be a table of keys"),
    ],
)
def test_wrong_values(crease: Scene, vary: Any, words: str) -> None:
    refused(lambda: parameters_of(crease, vary), InputError, words)


def test_many_faults_are_cut_short(crease: Scene) -> None:
    with pytest.raises(InputError, match=r"stiffness = -100, -99, .*, -91 and 90 more: must be at least 0$"):
        parameters_of(crease, {STIFFNESS: list(range(-100, 0))})
    with pytest.raises(InputError, match="and 40 more faults"):
        parameters_of(crease, {f"laws.{k}": [1] for k in range(50)})


def test_a_wrong_key_is_told_once(crease: Scene) -> None:
    with pytest.raises(InputError) as told:
        parameters_of(crease, {"laws.crease.stiffness": "1,3,10"})
    assert str(told.value).count("no value of that name") == 1
    assert str(told.value).startswith("laws.crease.stiffness = 1, 3, 10: this scene has no value")


def test_one_value_by_two_keys() -> None:
    named = scenes.load("okuizumi-whole")
    name = next(part.name for part in named.parts if part.name)
    index = [part.name for part in named.parts].index(name)
    vary = {f"parts.{name}.axial_stiffness": [1], f"parts.{index}.axial_stiffness": [2]}
    refused(lambda: parameters_of(named, vary), InputError, f"is parts.{name}.axial_stiffness, which is varied too")


def test_texts_of_the_command_line() -> None:
    assert split_vary([f"{STIFFNESS} = 1,3", "a.b=c=d"]) == {STIFFNESS: "1,3", "a.b": "c=d"}
    refused(lambda: split_vary([STIFFNESS]), InputError, "must be KEY=VALUES")
    refused(lambda: split_vary(["=1"]), InputError, "must be KEY=VALUES")
    refused(lambda: split_vary([f"{STIFFNESS}=1", f"{STIFFNESS}=2"]), InputError, "is given twice")


def test_a_grid_has_all_combinations(crease: Scene) -> None:
    vary = {STIFFNESS: "1,3", BUCKLING: "1,2,3", "run.integrator": "rk4"}
    points = points_of(parameters_of(crease, vary))
    assert [tuple(point.values()) for point in points] == [(s, b, "rk4") for s in (1.0, 3.0) for b in (1.0, 2.0, 3.0)]
    assert points_of([]) == [{}]


@pytest.mark.parametrize("sample", ["lhs:16", "sobol:16"])
def test_samples_take_each_range_evenly(crease: Scene, sample: str) -> None:
    vary = {STIFFNESS: "2:6", BUCKLING: "1:10000:log", "run.integrator": "rk4,leapfrog", "run.substeps": "1:1000"}
    parameters = parameters_of(crease, vary, sampled=is_sampled(sample))
    points = points_of(parameters, sample, seed=5)
    assert len(points) == 16
    stiffness = np.sort([point[STIFFNESS] for point in points])
    assert np.all(np.floor((stiffness - 2.0) / 0.25) == np.arange(16))
    buckling = np.sort([np.log10(point[BUCKLING]) for point in points])
    assert np.all(np.floor(buckling / 0.25) == np.arange(16))
    assert [point["run.integrator"] for point in points].count("rk4") == 8
    assert all(isinstance(point["run.substeps"], int) for point in points)
    assert points == points_of(parameters, sample, seed=5) != points_of(parameters, sample, seed=6)


def test_samples_that_round_to_one_are_one(crease: Scene) -> None:
    parameters = parameters_of(crease, {"run.substeps": "1:3"}, sampled=True)
    assert sorted(point["run.substeps"] for point in points_of(parameters, "lhs:50")) == [1, 2, 3]


@pytest.mark.parametrize(
    ("sample", "seed", "words"),
    [
        ("sobol:9", 0, "take 8 or 16"),
        ("sobol:0", 0, "must be 1 to 100,000 samples"),
        ("lhs:1000000", 0, "must be 1 to 100,000 samples"),
        ("lhs:", 0, "must be grid, lhs:20 or sobol:32"),
        ("lhs:-1", 0, "must be grid, lhs:20 or sobol:32"),
        ("random", 0, "must be grid, lhs:20 or sobol:32"),
        (None, 0, "must be grid, lhs:20 or sobol:32"),
        ("lhs:4", -1, "must be from 0"),
        ("lhs:4", 2**63, "must be from 0"),
        ("lhs:4", 1.5, "whole number"),
        ("lhs:4", True, "whole number"),
    ],
)
def test_wrong_designs(crease: Scene, sample: Any, seed: Any, words: str) -> None:
    parameters = parameters_of(crease, {STIFFNESS: "1:2"}, sampled=True)
    refused(lambda: points_of(parameters, sample, seed), InputError, words)


def test_ranges_and_designs_that_do_not_fit(crease: Scene) -> None:
    refused(lambda: points_of([], "lhs:4"), InputError, "samples are taken from ranges, and there is none")
    listed = parameters_of(crease, {STIFFNESS: "1,3"}, sampled=True)
    refused(lambda: points_of(listed, "lhs:5"), InputError, "vary a range such as 10:1000 .*or run all combinations")
    with pytest.raises(InputError, match="leave 5 out"):
        parameters_of(crease, {STIFFNESS: "1:2:log5"}, sampled=True)


def test_a_million_runs_are_refused_with_their_number(crease: Scene) -> None:
    vary = {STIFFNESS: "1:2:1000", BUCKLING: "1:2:1000"}
    with pytest.raises(InputError, match="1,000,000 combinations of values: must be at most 100,000"):
        points_of(parameters_of(crease, vary))
    with pytest.raises(InputError, match="2 combinations of values from 500,000 starts are 1,000,000 runs"):
        with_starts([{}, {STIFFNESS: 1.0}], 500_000)
    assert len(with_starts([{}], MOST_RUNS)) == MOST_RUNS


@pytest.mark.parametrize(
    ("starts", "kind"), [(0, InputError), (-1, InputError), (1.0, InputTypeError), (True, InputTypeError)]
)
def test_starts(starts: Any, kind: type[InputError]) -> None:
    with pytest.raises(kind, match="starts = "):
        with_starts([{}], starts)


def test_a_stage_that_ends_the_run_cannot_be_shortened_by_until() -> None:
    scene = scenes.load("single-crease")
    staged = Scene(scene.mesh, scene.material, scene.laws, scene.parts, stages=[Stage("one", 0.1)])
    refused(lambda: parameters_of(staged, {"run.until": "1,2"}), InputError, "set stages.one.duration")
