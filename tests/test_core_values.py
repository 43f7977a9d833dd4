"""Values that the core itself refuses by name, whoever calls it."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from membrane_rs import InputError, MeshError, _core
from membrane_rs.scene.components import Layers
from membrane_rs.simulation.core_input import laws_of, model_of, settings_of
from small_scenes import hanging_strip, refused

SCENE = hanging_strip()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"check_interval": 0}, "check interval = 0e0 .* at least 1 step"),
        ({"tolerance": math.nan}, "tolerance = NaN"),
        ({"tolerance_length": 0.0}, "length of the tolerance"),
        ({"tolerance_speed": math.inf}, "speed of the tolerance"),
        ({"loss_tolerance": math.nan}, "loss tolerance = NaN"),
        ({"energy_tolerance": math.nan}, "energy tolerance = NaN"),
        ({"margin": math.nan}, "margin = NaN"),
        ({"check_interval": 1.5}, "settings.check_interval = 1.5 is of the wrong type"),
    ],
)
def test_settings(change: dict[str, Any], words: str) -> None:
    wrong = replace(settings_of(SCENE), **change)
    model = model_of(SCENE, SCENE.assemble())
    refused(lambda: _core.Simulation(model, laws_of(SCENE), "rk4", None, wrong), InputError, words)


@pytest.mark.parametrize(("name", "value"), [("ratio", "much"), ("length", "long"), ("ratio", [1.0]), ("ratio", None)])
def test_a_parameter_of_the_wrong_type_is_named(name: str, value: Any) -> None:
    laws = [(kind, {**values, name: value} if kind == "spring_damping" else values) for kind, values in laws_of(SCENE)]
    model, settings = model_of(SCENE, SCENE.assemble()), settings_of(SCENE)
    words = f"law spring_damping: {name} = "
    refused(lambda: _core.Simulation(model, laws, "rk4", None, settings), InputError, words)


@pytest.mark.parametrize(
    ("triangles", "kind", "words"),
    [
        ([0, 24], MeshError, r"layer 1 names triangle 24, but there are only 24 triangles \(0 to 23\)"),
        ([-1], InputError, "layers.triangles, row 0: -1 is not an index; give a whole number, 0 or above"),
        ([0.5], InputError, "layers.triangles must be an int64 array"),
    ],
)
def test_layers_of_triangles_that_are_not_there(triangles: list[float], kind: type[InputError], words: str) -> None:
    model, settings = model_of(SCENE, SCENE.assemble()), settings_of(SCENE)
    wrong = replace(model, layers=Layers(np.array(triangles)))
    refused(lambda: _core.Simulation(wrong, laws_of(SCENE), "rk4", None, settings), kind, words)
