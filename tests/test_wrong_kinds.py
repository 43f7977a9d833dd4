"""What is given to public functions and is of another kind altogether: an error of the type that they document."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import membrane_rs
import numpy as np
import pytest
from membrane_rs import Simulation, check, plotting, scenes, study
from membrane_rs.errors import InputError, InputTypeError
from membrane_rs.results import Experiment

WRONG: tuple[Any, ...] = (object(), "nonsense", None, [[]], b"x", {"a": 1})
TETHER, STRIP = scenes.load("spinning-tether"), scenes.load("hanging-strip")
STAGED, MESH = scenes.load("okuizumi-stage-1"), STRIP.mesh
assert MESH is not None
MEASURED = Experiment("measured", np.arange(2.0), {"hub_force": np.ones(2)}, {"hub_force": "N"})
CALLS: dict[str, Callable[[Any], object]] = {
    "masses": MESH.masses,
    "spring_constants": MESH.spring_constants,
    "staged": STAGED.staged,
    "reach_within: time": lambda value: Simulation(TETHER).reach_within(value, 1.0),
    "reach_within: seconds": lambda value: Simulation(TETHER).reach_within(0.001, value),
    "audit": check.audit,
    "audit_of_motion": check.audit_of_motion,
    "facts": check.facts,
    "unaccepted_errors": check.unaccepted_errors,
    "save_run_figures": lambda value: plotting.save_run_figures(value, "figures"),
    "ablate: scene": study.ablate,
    "ablate: tolerance": lambda value: study.ablate(TETHER, tolerance=value),
    "work_precision: scene": study.work_precision,
    "work_precision: steps": lambda value: study.work_precision(TETHER, steps=value),
}


@pytest.mark.parametrize("value", WRONG, ids=lambda value: type(value).__name__)
@pytest.mark.parametrize("call", CALLS.values(), ids=CALLS)
def test_another_kind_is_refused(call: Callable[[Any], object], value: object) -> None:
    with pytest.raises(InputTypeError, match="must be"):
        call(value)


def test_a_column_that_is_no_name_is_refused() -> None:
    with pytest.raises(InputError, match=r"column \[\]"):
        MEASURED.curve([])  # type: ignore[arg-type]


@pytest.mark.parametrize("value", ["nonsense", [[]], b"x"])
def test_a_time_that_is_none_is_refused_by_the_viewer(value: Any) -> None:
    run = membrane_rs.run(STRIP, 0.001, frames=2)
    with pytest.raises(InputTypeError, match="time = "):
        run.view(time=value, where="picture")
