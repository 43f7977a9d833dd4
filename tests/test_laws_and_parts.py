"""Laws and parts: the lists of them, their defaults, and what they refuse."""

from __future__ import annotations

import math
import re
from typing import Any

import numpy as np
import pytest
from example_of import example_of, needed
from hypothesis import example, given
from hypothesis import strategies as st
from membrane_rs import _core, scenes
from membrane_rs.errors import InputError, InputTypeError
from membrane_rs.scene.bodies import BODIES, CORE_KINDS
from membrane_rs.scene.cords import cord_positions
from membrane_rs.scene.laws import LAWS, Creases, Gravity, Springs
from membrane_rs.scene.parts import PARTS, Tether, Tethers
from membrane_rs.simulation.core_input import model_of, settings_of

KINDS: dict[str, Any] = {**LAWS, **PARTS, **BODIES}


def test_lists_hold_each_kind_once() -> None:
    assert len(KINDS) == len(LAWS) + len(PARTS) + len(BODIES)
    assert all(cls.kind == kind for kind, cls in KINDS.items())


def test_python_and_the_core_hold_the_same_laws() -> None:
    scene = scenes.load("spinning-tether")
    unknown: list[tuple[str, dict[str, Any]]] = [("no law", {})]
    with pytest.raises(InputError, match="unknown variant `no law`") as caught:
        _core.Simulation(model_of(scene, scene.assemble()), unknown, "rk4", None, settings_of(scene))
    names = re.findall("`([^`]+)`", str(caught.value).split("expected one of")[1])
    assert sorted(names) == sorted([*LAWS, *CORE_KINDS])


@pytest.mark.parametrize("kind", KINDS)
def test_number_fields_refuse_what_is_no_number(kind: str) -> None:
    cls: Any = KINDS[kind]
    made = example_of(cls)
    for name in cls.__dataclass_fields__:
        if isinstance(getattr(made, name), float):
            for bad in (math.nan, math.inf, -math.inf, "1", True, [1.0]):
                with pytest.raises(InputError, match=f"{cls.__name__}.{name} = "):
                    example_of(cls, **{name: bad})


@pytest.mark.parametrize("kind", KINDS)
def test_unknown_key_and_hash(kind: str) -> None:
    cls: Any = KINDS[kind]
    values = needed(cls)
    assert cls(**values) == cls(**values)
    assert hash(cls(**values)) == hash(cls(**values))
    with pytest.raises(InputTypeError, match="nonsense: no such key"):
        cls(**values, nonsense=1)


@pytest.mark.parametrize(
    ("kind", "values", "words"),
    [
        ("springs", {"buckling": -1}, "buckling = -1: must be at least 0"),
        ("springs", {"strain_limit": 0}, "strain_limit = 0: must be greater than 0"),
        ("springs", {"negative": "ignore"}, "must be 'refuse', 'clip' or 'keep'"),
        ("springs", {"buckling_length": 0}, r"buckling_length = 0: must be greater than 0 \(m\)"),
        ("triangles", {"compression": 1.5}, "at least 0 and at most 1"),
        ("triangles", {"buckling": -1}, "buckling = -1: must be at least 0"),
        ("triangles", {"buckling_length": -1}, r"greater than 0 \(m\)"),
        ("springs", {"crease_length": -0.01}, r"crease_length = -0.01: must be greater than 0 \(m\)"),
        ("triangles", {"crease_length": 0}, r"crease_length = 0: must be greater than 0 \(m\)"),
        ("spring_damping", {"ratio": -0.1}, "at least 0"),
        ("spring_damping", {"length": 0}, r"length = 0: must be greater than 0 \(m\)"),
        ("creases", {"stiffness": -1}, "stiffness = -1: must be at least 0"),
        ("creases", {"contact_penalty": 0.5}, "at least 1"),
        ("creases", {"natural_angle": 7}, r"at least 0 and at most 6.28319 \(rad\)"),
        ("creases", {"length_scale": 0}, r"length_scale = 0: must be greater than 0 \(m\)"),
        ("creases", {"collapse": 2}, "at least 0 and at most 1"),
        ("air_drag", {"pressure": -1}, r"at least 0 \(Pa\)"),
        ("air_drag", {"temperature": 0}, r"greater than 0 \(K\)"),
        ("air_drag", {"air": "windy"}, "'still' or 'turning'"),
        ("gravity", {"acceleration": 9.81}, "three numbers"),
        ("spool_contact", {"radius": 0}, "greater than 0"),
        ("spool_contact", {"half_height": -1}, "greater than 0"),
        ("spool_contact", {"membrane": 1}, "true or false"),
        ("self_contact", {"thickness": 0}, r"greater than 0 \(m\)"),
        ("self_contact", {"restitution": 2}, "at least 0 and at most 1"),
        ("mass_damping", {"rate": -1}, r"at least 0 \(1/s\)"),
        ("tip_masses", {"mass": 0}, r"greater than 0 \(kg\)"),
        ("tethers", {"segments": 0}, "at least 1"),
        ("tethers", {"segments": 2.5}, "whole number"),
        ("tethers", {"length": -1}, "greater than 0"),
        ("tether", {"start": (0, 0, 0), "end": (0, 0, 0)}, "Tether.end = .*must differ from start"),
        ("tether", {"start": (0, 0)}, "three numbers"),
        ("tether", {"tip_mass": -1}, "at least 0"),
        ("fixed", {"nodes": []}, "at least one"),
        ("bridges", {"stiffness": 0}, r"greater than 0 \(N/m\)"),
    ],
)
def test_bad_values(kind: str, values: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        example_of(KINDS[kind], **values)


def test_defaults_are_those_of_table_2() -> None:
    assert (Springs().buckling, Springs().buckling_on_creases) == (100.0, 1000.0)
    assert (Creases().stiffness, Creases().contact_penalty, Creases().natural_angle) == (10.0, 100.0, 0.0)
    assert Gravity().acceleration == (0.0, 0.0, -9.81)
    assert Tethers().segments == 19
    assert Tether((0, 0, 0), (1, 0, 0), 1, 1.0, 0.0).fixed


@given(
    st.tuples(*[st.floats(-1, 1)] * 3),
    st.tuples(*[st.floats(-1, 1)] * 3),
    st.floats(0.01, 5.0),
    st.integers(2, 40),
)
@example((5e-324, 5e-324, 0.0), (0.0, 0.0, 0.0), 1.0, 3)
def test_slack_cords_hang_without_strain(
    start: tuple[float, float, float], end: tuple[float, float, float], length: float, segments: int
) -> None:
    a, b = np.array(start), np.array(end)
    span = float(np.linalg.norm(b - a))
    nodes = cord_positions(a, b, length, segments)
    assert nodes.shape == (segments + 1, 3)
    assert (nodes[0] == a).all()
    assert (nodes[-1] == b).all()
    steps = np.linalg.norm(np.diff(nodes, axis=0), axis=1)
    assert steps * segments == pytest.approx(max(length, span), rel=1e-9)


def test_slack_cord_hangs_below_and_between_its_ends() -> None:
    a, b = np.array([0.025, 0.0, 0.0]), np.array([0.030, 0.0, 0.0])
    nodes = cord_positions(a, b, 0.05, 19)
    assert (nodes[1:-1, 2] < 0).all()
    assert (nodes[:, 0] >= 0.025 - 1e-12).all()  # it keeps off the spool
    assert nodes[:, 1] == pytest.approx(0, abs=1e-15)
    with pytest.raises(InputError, match="2 segments or more"):
        cord_positions(a, b, 0.05, 1)
