"""Bad input to Simulation and to the files it reads and writes: a clear error each time, and nothing left
behind.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from membrane_rs import (
    AirDrag,
    Fixed,
    Gravity,
    InputError,
    InputTypeError,
    Material,
    MembraneError,
    Mesh,
    MeshError,
    Scene,
    Simulation,
    SpoolContact,
    SpringDamping,
    Springs,
    UnstableError,
)
from membrane_rs.folding import SquareSail, Strip
from membrane_rs.scene.laws import Law
from small_scenes import FILM, cord, hanging_strip, refused

SCENE = hanging_strip()
COUNT = SCENE.assemble().node_count
NAN, INF = math.nan, math.inf


@pytest.mark.parametrize(
    ("dt", "kind", "words"),
    [
        (0, InputError, r"dt = 0\.0: must be greater than 0"),
        (-1e-5, InputError, "dt = -1e-05: must be greater than 0"),
        (NAN, InputError, "dt = nan: must be finite"),
        (INF, InputError, "dt = inf: must be finite"),
        (10**400, InputError, "dt = inf: must be finite"),
        (
            1.0,
            InputError,
            "times the stability limit .* springs near node .* leave dt out or choose it below",
        ),
        (1e300, InputError, "the stability limit"),
        ("1e-5", InputTypeError, "dt = '1e-5': must be a number"),
        (True, InputTypeError, "dt = True: must be a number"),
        (1j, InputTypeError, "must be a number"),
        ([1e-5], InputTypeError, "must be a number"),
    ],
)
def test_steps(dt: Any, kind: type[Exception], words: str) -> None:
    refused(lambda: Simulation(SCENE, dt=dt), kind, words)


@pytest.mark.parametrize("name", ["", "rk5", "RK4", 5, None.__class__, ["rk4"]])
def test_unknown_integrators(name: Any) -> None:
    refused(lambda: Simulation(SCENE, name), InputError, "no integrator named .*; choose one of: rk4")


@pytest.mark.parametrize("scene", [None, "okuizumi-model-1", 3, Scene, SCENE.mesh])
def test_no_scene(scene: Any) -> None:
    refused(lambda: Simulation(scene), InputTypeError, "must be a Scene, such as scenes.load")


@pytest.mark.parametrize(
    ("law", "kind", "words"),
    [
        (
            "spring",
            InputError,
            'no law in this scene named "spring"; choose one of: springs, spring_damping, gravity',
        ),
        ("air_drag", InputError, "choose one of"),
        (AirDrag, InputError, 'named "air_drag"'),
        (SpoolContact(), InputError, 'named "spool_contact"'),
        (3, InputTypeError, "law = 3: must be the name of a law"),
        (b"springs", InputTypeError, "must be the name of a law"),
        (Scene, InputTypeError, "must be the name of a law"),
    ],
)
def test_unknown_laws(law: Any, kind: type[Exception], words: str) -> None:
    refused(lambda: Simulation(SCENE).forces(law), kind, words)


def motion(**changes: Any) -> np.ndarray:
    """Positions of the scene with one entry changed."""
    points: np.ndarray = SCENE.assemble().positions.copy()
    for place, value in changes.values():
        points[place] = value
    return points


@pytest.mark.parametrize("name", ["positions", "velocities"])
@pytest.mark.parametrize(
    ("values", "kind", "words"),
    [
        (
            np.zeros((COUNT - 1, 3)),
            InputTypeError,
            rf"has shape \({COUNT - 1}, 3\); it must be \({COUNT}, 3\)",
        ),
        (np.zeros((3, COUNT)), InputTypeError, "one row per node"),
        (np.zeros(3 * COUNT), InputTypeError, "one row per node"),
        (np.zeros((0, 3)), InputTypeError, "one row per node"),
        (1.0, InputTypeError, "one row per node"),
        (motion(a=((3, 1), NAN)), InputError, "of node 3 is NaN; every coordinate must be finite"),
        (motion(a=((5, 0), INF), b=((9, 2), NAN)), InputError, "of node 5 is inf"),
        ([[1, 2], [3]], InputTypeError, "must be numbers"),
        ("here", InputTypeError, "must be numbers"),
        (None, InputTypeError, "must be numbers"),
        (np.zeros((COUNT, 3)).astype(str), InputTypeError, "must be numbers"),
        (np.zeros((COUNT, 3), dtype=complex), InputTypeError, "must be numbers"),
        (np.zeros((COUNT, 3), dtype=bool), InputTypeError, "must be numbers"),
    ],
)
def test_motion_that_does_not_fit(name: str, values: Any, kind: type[Exception], words: str) -> None:
    sim = Simulation(SCENE)
    sim.step(3)
    before, moving = sim.positions, sim.velocities
    refused(lambda: setattr(sim, name, values), kind, words)
    assert (sim.positions == before).all()
    assert (sim.velocities == moving).all()


@settings(max_examples=60, deadline=None)
@given(hnp.arrays(st.sampled_from([np.float64, np.int8, np.float32]), (COUNT, 3)))
def test_any_positions_are_taken_or_refused(values: np.ndarray) -> None:
    sim = Simulation(SCENE)
    try:
        sim.positions = values
    except InputError as error:
        refusal = str(error)
    else:
        assert (sim.positions == values.astype(np.float64)).all()
        return
    assert "every coordinate must be finite" in refusal
    assert not np.isfinite(values).all()


@settings(max_examples=40, deadline=None)
@given(hnp.arrays(np.float64, (COUNT, 3), elements=st.floats(-1e200, 1e200, width=64)), st.integers(1, 300))
def test_any_motion_runs_or_stops_by_itself(values: np.ndarray, steps: int) -> None:
    sim = Simulation(SCENE)
    sim.velocities = values
    try:
        sim.step(steps)
        sim.run(until=sim.time + 2 * sim.dt, frames=2, samples=2)
    except UnstableError as error:
        stopped = error
        assert stopped.step <= steps + 3
        assert stopped.place
        assert stopped.law
    assert np.isfinite(sim.positions).all()
    assert np.isfinite(sim.velocities).all()


@pytest.mark.parametrize(
    ("n", "kind"),
    [
        (-1, InputError),
        (2**64, InputError),
        (1.5, InputTypeError),
        ("3", InputTypeError),
        (None, InputTypeError),
    ],
)
def test_step_counts(n: Any, kind: type[Exception]) -> None:
    refused(lambda: Simulation(SCENE).step(n), kind, "must be a whole number of steps")


@pytest.mark.parametrize(
    ("options", "kind", "words"),
    [
        ({"until": -1}, InputError, "is at 0 s already; give a later time"),
        ({"until": NAN}, InputError, "until = nan: must be finite"),
        ({"until": "long"}, InputTypeError, "until = 'long': must be a number"),
        ({"until": [1.0]}, InputTypeError, "must be a number"),
        (
            {"until": 1e300},
            InputError,
            r"until = 1e\+300 s: that is .* steps of dt = .*; give an earlier time",
        ),
        ({"frames": 0}, InputError, "frames = 0: must be from 2"),
        ({"frames": 1}, InputError, "frames = 1: must be from 2"),
        ({"frames": 10**13}, InputError, "frames = 10000000000000: must be from 2 to"),
        ({"frames": 2.5}, InputTypeError, "frames = 2.5: must be a whole number or a list of times"),
        ({"frames": "all"}, InputTypeError, "frames = 'all'"),
        ({"frames": [0.0, NAN]}, InputError, "frames = nan: must be finite"),
        ({"frames": [[0.0]]}, InputTypeError, "must be a number"),
        ({"samples": 1}, InputError, "samples = 1: must be from 2"),
        ({"samples": -3}, InputError, "samples = -3: must be from 2"),
    ],
)
def test_run_options(options: dict[str, Any], kind: type[Exception], words: str, tmp_path: Path) -> None:
    sim = Simulation(SCENE)
    arguments: dict[str, Any] = {"until": 0.001, "out": tmp_path / "run"} | options
    refused(lambda: sim.run(**arguments), kind, words)
    assert sim.step_count == 0
    assert list(tmp_path.iterdir()) == []  # nothing was begun


def test_times_that_are_past_or_beyond_the_end_are_left_out() -> None:
    seen: list[float] = []

    class Frames:
        def start(self, sim: Simulation) -> None:
            pass

        sample = start

        def frame(self, sim: Simulation) -> None:
            seen.append(sim.time)

        def finish(self, sim: Simulation, error: BaseException | None) -> None:
            pass

    sim = Simulation(SCENE, dt=1e-4)
    sim.run(until=0.002, frames=[-5.0, 0.001, 1e300], observers=[Frames()])
    assert seen == pytest.approx([0.0, 0.001, 0.002])
    refused(lambda: sim.run(until=0.001), InputError, "is at 0.002 s already")


@pytest.mark.parametrize("name", ["duration", "rate"])
@pytest.mark.parametrize("value", [0, -1.0, NAN, INF, "x", [1.0]])
def test_settling(name: str, value: Any) -> None:
    arguments = {"duration": 0.001, "rate": 10.0} | {name: value}
    refused(lambda: Simulation(SCENE).relax(**arguments), InputError, f"relax: {name} = .*: must be")


STRIP = Strip(0.1, 0.04, 2, 1).mesh()


def flat(points: list[list[float]], triangles: list[list[int]]) -> Mesh:
    return Mesh([[*p, 0.0] for p in points], triangles)


@pytest.mark.parametrize(
    ("mesh", "laws", "kind", "words"),
    [
        (
            flat([[0, 0], [1, 0], [2, 0]], [[0, 1, 2]]),
            [Springs()],
            MeshError,
            r"triangle 0 \(nodes \[0, 1, 2\]\) .* area",
        ),
        (flat([[0, 0], [0, 0], [0, 0]], [[0, 1, 2]]), [Springs()], MeshError, "triangle 0"),
        (
            flat([[0, 0], [1, 0], [0.5, 0.1]], [[0, 1, 2]]),
            [Springs()],
            MeshError,
            r"1 of 3 spring constants are negative",
        ),
        (
            flat([[0, 0], [1, 0], [0.5, 0.1]], [[0, 1, 2]]),
            [Springs(negative="keep"), SpringDamping()],
            InputError,
            "dashpot on spring .* is undefined",
        ),
        (flat([[0, 0], [1, 0], [0, 1], [5, 5]], [[0, 1, 2]]), [Springs()], InputError, "node 3 has .* mass"),
        (STRIP, [], InputError, "nothing in this scene is stiff.*give dt"),
        (STRIP, [Gravity()], InputError, "nothing in this scene is stiff.*give dt"),
        (SquareSail(layout="fan").mesh(), [Springs()], MeshError, "664 of .* negative"),
        (flat([[0, 0], [1, 0], [0, 1e-300]], [[0, 1, 2]]), [Springs()], MeshError, "triangle 0"),
        (flat([[0, 0], [1e200, 0], [0, 1e200]], [[0, 1, 2]]), [Springs()], MembraneError, "triangle 0"),
    ],
)
def test_meshes_that_cannot_move(mesh: Mesh, laws: list[Law], kind: type[Exception], words: str) -> None:
    refused(lambda: Simulation(Scene(mesh, FILM, laws)), kind, words)


@pytest.mark.parametrize(
    "values",
    [
        {"thickness": -1e-6},
        {"thickness": 0.0},
        {"youngs_modulus": NAN},
        {"youngs_modulus": -1.0},
        {"density": INF},
        {"density": 0.0},
        {"poisson_ratio": 0.5},
        {"poisson_ratio": -1.0},
        {"poisson_ratio": "0.3"},
    ],
)
def test_films(values: dict[str, Any]) -> None:
    good = {"youngs_modulus": 3.2e9, "poisson_ratio": 0.34, "density": 1420.0, "thickness": 7.5e-6}
    name = next(iter(values))
    refused(lambda: Material(**(good | values)), InputError, f"Material.{name} = .*: must be")


@settings(max_examples=60, deadline=None)
@given(
    hnp.arrays(np.float64, (5, 3), elements=st.sampled_from([0.0, 0.3, 1.0, 2.0, -1.0, 1e-200, 1e150])),
    st.lists(st.permutations(range(5)), min_size=1, max_size=5),
    st.sampled_from(["refuse", "clip", "keep"]),
    st.floats(-0.99, 0.49),
)
def test_any_mesh_makes_a_simulation_or_a_clear_error(points: Any, orders: Any, negative: Any, nu: float) -> None:
    mesh = Mesh(points, [order[:3] for order in orders])
    film = Material(1e6, nu, 1000.0, 1e-4)
    try:
        sim = Simulation(Scene(mesh, film, [Springs(negative=negative), Gravity()]))
    except MembraneError as error:
        refusal = str(error)
        assert len(refusal) > 20
        return
    try:
        sim.step(50)
    except UnstableError as error:
        refusal = str(error)
        assert "stopped at t = " in refusal
    assert np.isfinite(sim.positions).all()


@settings(max_examples=40, deadline=None)
@given(
    st.tuples(*[st.floats(-1e3, 1e3)] * 3),
    st.floats(1e-300, 1e300),
    st.floats(0.0, 1e300),
    st.floats(0.0, 1e300),
    st.integers(1, 5),
)
def test_any_cord_makes_a_simulation_or_a_clear_error(
    end: tuple[float, float, float], stiffness: float, density: float, tip: float, segments: int
) -> None:
    try:
        part = cord(end=end, axial_stiffness=stiffness, linear_density=density, tip_mass=tip, segments=segments)
        sim = Simulation(Scene(None, None, [Gravity()], [part]))
        sim.step(50)
    except MembraneError as error:
        refusal = str(error)
        assert len(refusal) > 20
        return
    assert np.isfinite(sim.positions).all()
    assert sim.dt > 0


def test_fully_held_scenes_say_that_nothing_moves() -> None:
    scene = Scene(STRIP, FILM, [Springs()], [Fixed(nodes=list(range(STRIP.node_count)))])
    refused(lambda: Simulation(scene), InputError, "give dt")
    sim = Simulation(scene, dt=1e-3)
    sim.step(5)
    assert (sim.positions == STRIP.positions).all()
