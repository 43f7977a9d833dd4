"""Checked dataclasses: what they take, what they refuse, and in which words."""

from __future__ import annotations

import copy
import dataclasses
import math
import pickle
from typing import Annotated, Any, Literal, TypeVar

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from membrane_rs import Creases, Fixed, Gravity, Moved, RunSettings, Spin, SpringDamping, Tether
from membrane_rs._other_names import OTHER_NAMES
from membrane_rs._validation import (
    Count,
    Flag,
    Nodes,
    Positive,
    Times,
    Unit,
    Vector,
    Whole,
    build,
    nearest,
    range_of,
    unit_of,
    validated,
)
from membrane_rs.errors import InputError, InputTypeError, MeshError
from membrane_rs.folding import PATTERNS
from membrane_rs.material import Material
from membrane_rs.scene.laws import LAWS
from membrane_rs.scene.parts import PARTS

T = TypeVar("T")

GOOD: dict[str, Any] = {
    "youngs_modulus": 3.2e9,
    "poisson_ratio": 0.34,
    "density": 1420.0,
    "thickness": 7.5e-6,
}


@validated
class Sample:
    """One field of each type."""

    size: Annotated[Positive | None, Unit("m")] = None
    count: Count = 3
    whole: Whole = 0
    flag: Flag = False
    vector: Vector = (0.0, 0.0, 1.0)
    times: Times = ()
    nodes: Nodes = "corners"
    rule: Literal["one", "two"] = "one"

    def __post_init__(self) -> None:
        if self.count == 7:
            raise MeshError("Sample.count = 7: must not be 7")


def test_material_takes_positions_names_and_numpy_scalars() -> None:
    wanted = Material(**GOOD)
    assert wanted == Material(3.2e9, 0.34, 1420, 7.5e-6)
    assert wanted == Material(np.float64(3.2e9), np.float64(0.34), np.int64(1420), thickness=7.5e-6)
    assert type(Material(np.float32(3.2e9), 0.34, 1420, 7.5e-6).youngs_modulus) is float


def test_values_stay_as_they_are() -> None:
    material = Material(**GOOD)
    with pytest.raises(dataclasses.FrozenInstanceError):
        material.thickness = 1.0  # type: ignore[misc]
    assert pickle.loads(pickle.dumps(material)) == copy.deepcopy(material) == material
    assert hash(material) == hash(Material(**GOOD))
    assert dataclasses.replace(material, thickness=1e-6).thickness == 1e-6
    with pytest.raises(InputError, match="thickness"):
        dataclasses.replace(material, thickness=-1e-6)


@pytest.mark.parametrize(
    ("change", "error", "words"),
    [
        ({"thickness": -1e-6}, InputError, r"Material.thickness = -1e-06: must be greater than 0 \(m\)"),
        ({"thickness": 0}, InputError, "Material.thickness = 0: must be greater than 0"),
        ({"youngs_modulus": math.nan}, InputError, "Material.youngs_modulus = nan: must be finite"),
        ({"density": math.inf}, InputError, r"Material.density = inf: must be finite.*kg/m3"),
        ({"density": 10**400}, InputError, "must be finite"),
        ({"poisson_ratio": 0.5}, InputError, "= 0.5: must be greater than -1 and less than 0.5"),
        ({"poisson_ratio": -1}, InputError, "= -1: must be greater than -1 and less than 0.5"),
        ({"density": True}, InputTypeError, "Material.density = True: must be a number"),
        ({"density": "1420"}, InputTypeError, "Material.density = '1420': must be a number"),
        ({"density": None}, InputTypeError, "must be a number"),
        ({"density": np.array([1.0, 2.0])}, InputTypeError, "must be a number"),
        ({"density": 1 + 2j}, InputTypeError, "must be a number"),
        ({"thicknes": 1e-6}, InputTypeError, "Material.thicknes: no such key; did you mean 'thickness'?"),
    ],
)
def test_bad_material(change: dict[str, Any], error: type[InputError], words: str) -> None:
    with pytest.raises(error, match=words):
        Material(**(GOOD | change))


def test_all_faults_are_told_at_once() -> None:
    with pytest.raises(InputError) as caught:
        Material(-1, 2, 3, math.nan)
    assert str(caught.value).count(";") == 2
    assert "\n" not in str(caught.value)
    assert caught.value.__suppress_context__


def test_missing_and_too_many_values() -> None:
    with pytest.raises(InputTypeError, match=r"Material.thickness: is missing; must be greater than 0 \(m\)"):
        Material(3.2e9, 0.34, 1420)  # type: ignore[call-arg]
    words = (
        "too many values .5.; it takes youngs_modulus, poisson_ratio, density, thickness, and by keyword softening, "
    )
    with pytest.raises(InputTypeError, match=words):
        Material(3.2e9, 0.34, 1420, 1e-6, 5)  # type: ignore[call-arg]


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("size", -1, r"size = -1: must be greater than 0 \(m\)"),
        ("count", 0, "must be at least 1"),
        ("count", 2.0, "must be a whole number"),
        ("count", True, "must be a whole number"),
        ("count", 7, "must not be 7"),
        ("whole", -1, "must be at least 0"),
        ("flag", 1, "must be true or false"),
        ("vector", (1, 2), "three numbers"),
        ("vector", "xyz", "three numbers"),
        ("vector", (0, math.nan, 0), r"vector\[1\] = nan: must be finite"),
        ("times", 0.5, "list of numbers"),
        ("times", [0.1, -0.2], r"times\[1\] = -0.2: must be at least 0"),
        ("nodes", "", "name of a node set"),
        ("nodes", 4, "name of a node set or a list"),
        ("nodes", [1.5], "name of a node set or a list"),
        ("nodes", [-1], "none below 0"),
        ("nodes", [], "at least one"),
        ("nodes", [2, 2], "twice"),
        ("rule", "three", "must be 'one' or 'two'"),
    ],
)
def test_bad_fields(name: str, value: object, words: str) -> None:
    with pytest.raises(InputError, match=words) as caught:
        Sample(**{name: value})  # type: ignore[arg-type]
    assert str(caught.value).startswith(f"Sample.{name}")
    with pytest.raises(InputError, match=words) as renamed:
        build(Sample, {name: value}, "parts[2]")
    assert str(renamed.value).startswith(f"parts[2].{name}")
    assert type(renamed.value) is type(caught.value)


def test_arrays_become_tuples() -> None:
    sample = Sample(vector=np.array([1, 2, 3]), nodes=np.array([4, 5]), times=[0, 1])  # type: ignore[arg-type]
    assert (sample.vector, sample.nodes, sample.times) == ((1.0, 2.0, 3.0), (4, 5), (0.0, 1.0))
    assert build(Sample, {"count": 4}, "x") == Sample(count=4)


def test_words_about_fields() -> None:
    assert (unit_of(Sample, "size"), unit_of(Sample, "count"), unit_of(int, "x")) == ("m", "", "")
    assert (range_of(Sample, "size"), range_of(Sample, "rule")) == ("greater than 0", "")
    assert nearest("stifness", ["stiffness", "ratio"]) == "did you mean 'stiffness'?"
    assert nearest("rpm", ["frequency", "ratio"]) == "did you mean 'frequency' (in Hz: rpm / 60)?"
    assert nearest("Omega", ["frequency"]) == "did you mean 'frequency' (in Hz: omega / (2 pi))?"
    assert nearest("beta", ["stiffness", "ratio"]) == "did you mean 'stiffness'?"
    assert nearest("zzz", ["b", "a"]) == "known are: a, b"


def attempt(cls: type[T], values: dict[str, Any], name: str) -> tuple[T | None, str]:
    """What was built, or None and why it was refused."""
    try:
        return build(cls, values, name), ""
    except InputError as error:
        return None, str(error)


ANYTHING = (
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.text()
    | st.binary()
    | st.lists(st.floats())
    | st.dictionaries(st.text(), st.integers())
)


@given(st.sampled_from(sorted(GOOD)), ANYTHING)
def test_any_value_is_taken_or_refused_by_name(name: str, value: object) -> None:
    material, refusal = attempt(Material, GOOD | {name: value}, "film")
    if material is None:
        assert refusal.startswith(f"film.{name} = ")
    else:
        assert math.isfinite(getattr(material, name))
        assert -1 < material.poisson_ratio < 0.5
        assert min(material.youngs_modulus, material.density, material.thickness) > 0


@given(
    st.dictionaries(
        st.sampled_from(["size", "count", "whole", "flag", "vector", "times", "nodes", "rule"]) | st.text(),
        ANYTHING,
    )
)
def test_any_table_is_taken_or_refused_by_name(values: dict[str, object]) -> None:
    sample, refusal = attempt(Sample, values, "table")
    assert (sample is None) == refusal.startswith("table.")


@pytest.mark.parametrize(
    ("kind", "words", "hint"),
    [
        (Spin, "omega angular_velocity spin_rate speed rotation_rate", r"'frequency' \(in Hz: omega / \(2 pi\)\)"),
        (Spin, "rpm RPM", r"'frequency' \(in Hz: rpm / 60\)"),
        (Spin, "spin_hz freq hz", r"'frequency' \(in Hz\)"),
        (Spin, "angular_acceleration omega_dot alpha", r"'acceleration' \(in Hz/s: rad/s2 / \(2 pi\)\)"),
        (Material, "E modulus young elastic_modulus", r"'youngs_modulus' \(in Pa\)"),
        (Material, "nu poisson", "'poisson_ratio'"),
        (Material, "t h", r"'thickness' \(in m\)"),
        (Material, "rho", r"'density' \(in kg/m3\)"),
        (Tether, "rho", r"'linear_density' \(in kg/m\)"),
        (Tether, "EA k stiffness", r"'axial_stiffness' \(in N\)"),
        (Gravity, "g", r"'acceleration' \(in m/s2\)"),
        (SpringDamping, "zeta damping", "'ratio'"),
        (Creases, "rest_angle theta0", r"'natural_angle' \(in rad\)"),
        (RunSettings, "t_end duration", r"'until' \(in s\)"),
        (RunSettings, "time_step", r"'dt' \(in s\)"),
        (RunSettings, "method", "'integrator'"),
    ],
)
def test_names_of_the_field_get_a_hint_in_python_and_in_files(kind: Any, words: str, hint: str) -> None:
    for word in words.split():
        with pytest.raises(InputTypeError, match=rf"{kind.__name__}\.{word}: no such key; did you mean {hint}\?"):
            kind(**{word: 1.0})
        with pytest.raises(InputTypeError, match=rf"table\.{word}: no such key; did you mean {hint}\?"):
            build(kind, {word: 1.0}, "table")


def test_every_name_of_a_hint_exists() -> None:
    classes = [*LAWS.values(), *PARTS.values(), *PATTERNS.values(), Material, RunSettings]
    known = {item.name for kind in classes for item in dataclasses.fields(kind)} | LAWS.keys() | PARTS.keys()
    known |= {"reference", "triangles", "positions", "velocities", "creases", "fold_angles"}
    assert {name for names in OTHER_NAMES.values() for name, _ in names} <= known


@pytest.mark.parametrize("kind", [Fixed, Moved])
def test_a_field_given_by_position_is_named(kind: type[Fixed | Moved]) -> None:
    with pytest.raises(InputError, match=rf"^{kind.__name__}\.nodes = \(\): must hold at least one node"):
        kind(())
