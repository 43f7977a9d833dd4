"""What is given to public functions and is of another kind altogether: an error of the type that they document."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import membrane_rs
import numpy as np
import pytest
from membrane_rs import Simulation, check, folding, plotting, scenes, study, units
from membrane_rs.errors import InputError, InputTypeError, MembraneError
from membrane_rs.plotting.fields import FIELDS
from membrane_rs.results import Experiment, RunHistory, read_experiment, write_pvd

WRONG: tuple[Any, ...] = (object(), "nonsense", None, [[]], b"x", {"a": 1})
TETHER, STRIP = scenes.load("spinning-tether"), scenes.load("hanging-strip")
STAGED, MESH = scenes.load("okuizumi-stage-1"), STRIP.mesh
assert MESH is not None
SAIL = scenes.load("okuizumi-model-1")
MEASURED = Experiment("measured", np.arange(2.0), {"hub_force": np.ones(2)}, {"hub_force": "N"})
OTHER = Experiment("other", np.arange(2.0), {"hub_force": np.ones(2)}, {"hub_force": "N"})
SHORT = membrane_rs.run(TETHER, 1e-3, frames=2)
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
NO_LISTS: dict[str, Callable[[Any], object]] = {
    "lengths_in": MESH.lengths_in,
    "find_edges": MESH.find_edges,
    "staged: starts": lambda value: STAGED.staged(0, starts=value),
    "write_pvd": lambda value: write_pvd("list.pvd", value),
    "compare: columns": lambda value: study.compare([MEASURED, OTHER], value),
    "compare: labels": lambda value: study.compare([MEASURED, OTHER], labels=value),
    "work_precision: methods": lambda value: study.work_precision(TETHER, value),
    "work_precision: densities": lambda value: study.work_precision(TETHER, densities=value, curves=True),
    "work_precision: softenings": lambda value: study.work_precision(STRIP, softenings=value),
    "RunHistory": RunHistory,
    "mass_of": membrane_rs.SpringDamping().mass_of,
    "Audit.of": check.Audit.of,
    "Audit.find": check.Audit(()).find,
    "in_units": MEASURED.in_units,
    "length scales": study.LengthScales().of,
    "units.convert: unit": lambda value: units.convert(1.0, value, "m"),
}
"""What takes lists or texts: neither raises an error of Python or numpy."""
NO_NUMBERS: dict[str, Callable[[Any], object]] = {
    "at": lambda value: SHORT.history.at(value, "time"),
    "near": SHORT.frames.near,
    "is_past": membrane_rs.Stage("first", 1.0, "kinetic_energy", below=1.0).is_past,
    "size": plotting.Style().size,
}
TOO_MANY: dict[str, Callable[[int], object]] = {
    "repeats": lambda count: study.work_precision(TETHER, repeats=count),
    "steps": lambda count: study.work_precision(TETHER, steps=count),
    "members": lambda count: study.work_precision(TETHER, members=count),
    "instants": lambda count: study.work_precision(TETHER, instants=count),
    "jobs": lambda count: study.work_precision(TETHER, jobs=count),
    "members of an ablation": lambda count: study.ablate(TETHER, members=count),
    "members of a mesh study": lambda count: study.jobs_of([8], members=count),
    "tries": lambda count: study.match_scene(SAIL, "laws.springs.buckling", (1.0, 2.0), SAIL, "x", tries=count),
    "starts of a sweep": lambda count: study.sweep(TETHER, {"laws.spin.frequency": [1.0]}, starts=count),
    "starts of an ensemble": lambda count: study.ensemble(TETHER, count),
    "samples": lambda count: membrane_rs.run(TETHER, 0.01, samples=count),
    "frames": lambda count: membrane_rs.run(TETHER, 0.01, frames=count),
    "colours": FIELDS["speed"].colors,
    "values": study.Parameter("key", "", (0.0, 1.0), is_range=True).spaced,
    "columns of a mesh": lambda count: folding.Strip(0.1, 0.01, columns=count).mesh(),
    "pictures": lambda count: plotting.plot_snapshots(SHORT, times=count),
}
"""Each takes a number that would need days or all memory."""


@pytest.mark.parametrize("value", WRONG, ids=lambda value: type(value).__name__)
@pytest.mark.parametrize("call", CALLS.values(), ids=CALLS)
def test_another_kind_is_refused(call: Callable[[Any], object], value: object) -> None:
    with pytest.raises(InputTypeError, match="must be"):
        call(value)


KINDS = ("object", "number", "table", "bytes", "array", "ragged")


@pytest.mark.parametrize("value", [object(), 1.5, {"a": object()}, b"x", np.array(3.0), [[1], [2, 3]]], ids=KINDS)
@pytest.mark.parametrize("call", NO_LISTS.values(), ids=NO_LISTS)
def test_what_is_no_list_is_refused(call: Callable[[Any], object], value: object) -> None:
    with pytest.raises(MembraneError, match=r"must|no regular array|name"):
        call(value)


@pytest.mark.parametrize(
    "value", [object(), "fast", None, [1.0], {"a": 1.0}, 1j], ids=lambda value: type(value).__name__
)
@pytest.mark.parametrize("call", NO_NUMBERS.values(), ids=NO_NUMBERS)
def test_what_is_no_number_is_refused(call: Callable[[Any], object], value: object) -> None:
    with pytest.raises(InputTypeError, match="must be a number"):
        call(value)


@pytest.mark.parametrize("count", [10**9, 10**30, 10**400], ids=["1e9", "1e30", "1e400"])
@pytest.mark.parametrize("call", TOO_MANY.values(), ids=TOO_MANY)
def test_a_number_without_bound_is_refused(call: Callable[[int], object], count: int) -> None:
    with pytest.raises(InputError, match=r"from .* to |at most|must be less|fewer"):
        call(count)


@pytest.mark.parametrize("flag", ["no", 2, None, np.array([True, False]), float("nan")], ids=repr)
@pytest.mark.parametrize("name", ["overwrite", "pictures", "crossings"])
def test_a_flag_that_is_neither_true_nor_false_is_refused(name: str, flag: Any) -> None:
    with pytest.raises(InputTypeError, match=f"{name} = .*: must be True or False"):
        membrane_rs.run(TETHER, 0.01, out="run", **{name: flag})
    with pytest.raises(InputTypeError, match=f"{name} = .*: must be True or False"):
        Simulation(TETHER).run(0.01, out="run", **{name: flag})


@pytest.mark.parametrize("name", ["x" * 5000, "\ud800"], ids=["long", "surrogate"])
def test_a_text_that_no_file_and_no_core_takes_is_refused(name: str) -> None:
    for call in (scenes.load, membrane_rs.open_run, lambda text: Simulation(TETHER, text), read_experiment):
        with pytest.raises(MembraneError):
            call(name)


def test_a_column_that_is_no_name_is_refused() -> None:
    with pytest.raises(InputError, match=r"column \[\]"):
        MEASURED.curve([])  # type: ignore[arg-type]


@pytest.mark.parametrize("value", ["nonsense", [[]], b"x"])
def test_a_time_that_is_none_is_refused_by_the_viewer(value: Any) -> None:
    run = membrane_rs.run(STRIP, 0.001, frames=2)
    with pytest.raises(InputTypeError, match="time = "):
        run.view(time=value, where="picture")
