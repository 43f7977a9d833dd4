"""Fields by which a membrane is coloured: their values, where they lie, their ranges."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import membrane_rs
import meshio
import numpy as np
import pytest
from fake_simulation import small_sail
from membrane_rs import Fixed, Scene, Simulation, Triangles
from membrane_rs.folding import Strip
from membrane_rs.plotting.fields import FIELDS, STEPS, Field, fields_of, value_ranges
from membrane_rs.plotting.viewer import Viewer
from membrane_rs.results.vtk import write_frame
from numpy.typing import NDArray
from small_scenes import RUBBER

SQUARE: dict[str, Any] = {
    "triangles": np.array([[0, 1, 2], [0, 2, 3]]),
    "lines": np.array([[0, 1], [0, 2], [2, 1], [2, 3], [3, 0]]),
}


@dataclass(frozen=True)
class Frame:
    """What fields read of a frame."""

    triangles: NDArray[np.int64]
    lines: NDArray[np.int64]
    on_nodes: Mapping[str, NDArray[Any]] = field(default_factory=dict)
    on_triangles: Mapping[str, NDArray[Any]] = field(default_factory=dict)
    on_lines: Mapping[str, NDArray[Any]] = field(default_factory=dict)


def written(sim: Simulation, path: Path) -> Frame:
    """The frame of a simulation that a VTU file holds."""
    write_frame(path, sim)
    mesh = meshio.vtu.read(path)
    triangles, lines = (np.asarray(block.data, np.int64) for block in mesh.cells)
    on_triangles, on_lines = ({name: blocks[k] for name, blocks in mesh.cell_data.items()} for k in (0, 1))
    return Frame(triangles, lines, mesh.point_data, on_triangles, on_lines)


def test_a_sail_has_all_fields_where_they_belong(tmp_path: Path) -> None:
    sim = Simulation(small_sail())
    sim.step(200)
    frame = written(sim, tmp_path / "frame.vtu")
    assert [found.name for found in fields_of(frame)] == list(FIELDS)
    counts = {"nodes": sim.node_count, "triangles": len(frame.triangles), "lines": len(frame.lines)}
    values = {}
    for found in FIELDS.values():
        value = found.values(frame)
        assert value is not None
        assert value.shape == (counts[found.place],)
        values[found.name] = value
    stress = sim.film_stress()
    assert values["largest_principal_stress"] == pytest.approx(stress.principal[:, 0], rel=1e-6)
    assert values["von_mises"] == pytest.approx(stress.von_mises, rel=1e-6)
    assert values["speed"] == pytest.approx(np.linalg.norm(sim.velocities, axis=1))
    assert np.nanmin(values["crease_angle"]) == pytest.approx(np.degrees(sim.crease_angles().min()))
    assert values["tension"][-len(sim.cord_tensions()) :] == pytest.approx(sim.cord_tensions(), rel=1e-6)
    assert np.isnan(values["tension"][: -len(sim.cord_tensions())]).all()


def test_the_state_of_springs_is_that_of_the_sides() -> None:
    for buckled, expected in (
        ((0, 0, 0, 0, 0), (0, 0)), ((1, 0, 0, 0, 0), (1, 0)), ((0, 1, 0, 0, 0), (1, 1)), ((1, 1, 1, 0, 0), (2, 1)),
        ((1, 1, 1, 1, 1), (2, 2)), ((0, 1, 0, 1, 1), (1, 2)),
    ):  # fmt: skip
        values = FIELDS["state"].values(Frame(**SQUARE, on_lines={"buckled": np.array(buckled, np.int8)}))
        assert values is not None
        assert tuple(values) == expected


def test_the_state_of_triangles_is_that_of_their_law(tmp_path: Path) -> None:
    scene = Scene(Strip(0.1, 0.04, 4, 2).mesh(), RUBBER, [Triangles()], [Fixed("start")])
    sim = Simulation(scene)
    x = np.array(sim.positions)
    for stretch, expected in (((1.01, 1.01), 0), ((1.01, 0.9), 1), ((0.9, 0.9), 2)):
        sim.positions = x * (*stretch, 1.0)
        values = FIELDS["state"].values(written(sim, tmp_path / f"{expected}.vtu"))
        assert values is not None
        assert (values == sim.film_states()).all()
        assert (values == expected).all()


def test_what_a_frame_lacks_is_no_field() -> None:
    bare = Frame(**SQUARE)
    assert fields_of(bare) == []
    assert value_ranges([bare]) == {}
    of_nan = replace(bare, on_triangles={"von_mises": np.array([np.nan, np.nan])}, on_nodes={"velocity": np.eye(4, 3)})
    assert [found.name for found in fields_of(of_nan)] == ["speed"]
    cords = Frame(np.zeros((0, 3), np.int64), SQUARE["lines"], on_lines={"tension": np.arange(5.0)})
    assert [found.name for found in fields_of(cords)] == ["tension"]
    assert (
        fields_of(Frame(np.zeros((0, 3), np.int64), np.zeros((0, 2), np.int64), on_lines={"tension": np.zeros(0)}))
        == []
    )


def test_ranges_hold_all_frames_or_a_share_of_each() -> None:
    first = Frame(**SQUARE, on_lines={"spring_strain": np.linspace(0.0, 1.0, 101), "buckled": np.zeros(5)})
    second = Frame(**SQUARE, on_lines={"spring_strain": np.append(np.linspace(-2.0, 0.0, 101), np.nan)})
    assert value_ranges(iter([first, second])) == {
        "state": (0.0, 2.0), "spring_strain": (-2.0, 1.0), "buckled": (0.0, 1.0)
    }  # fmt: skip
    assert value_ranges([first, second], share=0.9)["spring_strain"] == pytest.approx((-1.9, 0.95))


def test_a_field_has_a_title_and_colours() -> None:
    assert FIELDS["von_mises"].title == "Von Mises stress [Pa]"
    state = FIELDS["state"]
    assert state.title == "State of the film"
    assert len(state.colors()) == len(state.categories) == 3
    shades = FIELDS["speed"].colors(5)
    assert shades.shape == (5, 3)
    assert (np.diff(luminance(shades)) > 10.0).all()
    assert len(FIELDS["speed"].colors()) == STEPS


@pytest.mark.parametrize("field", FIELDS.values(), ids=list(FIELDS))
def test_scales_are_told_apart_without_seeing_colours(field: Field) -> None:
    """The luminance of a scale goes one way, so that it serves every kind of colour vision, and prints."""
    steps = np.diff(luminance(field.colors(9)))
    assert (steps > 5.0).all() or (steps < -5.0).all()


def luminance(colors: np.ndarray) -> np.ndarray:
    """Of sRGB colours (k, 3), 0 to 255: the luma of ITU-R BT.709."""
    return np.asarray(colors @ np.array([0.2126, 0.7152, 0.0722]))


def test_values_of_damaged_files_are_missing() -> None:
    frame = Frame(**SQUARE, on_lines={"spring_strain": np.array([1e308, -np.inf, np.nan, 0.5, 0.1])})
    values = FIELDS["spring_strain"].values(frame)
    assert values is not None
    assert np.isnan(values).tolist() == [True, True, True, False, False]
    assert FIELDS["crease_angle"].values(Frame(**SQUARE, on_lines={"crease_angle": np.full(5, 1e308)})) is None


def test_a_field_is_chosen_by_the_array_of_frames_too_as_the_page_of_the_viewer_says() -> None:
    run = membrane_rs.run("hanging-strip", 0.01, frames=2)
    viewer, frame = Viewer(run), run.frames[1]
    arrays = {"film_state", *frame.on_nodes, *frame.on_triangles, *frame.on_lines}  # the first with the law Triangles
    page = (Path(__file__).parent.parent / "docs/viewer.md").read_text("utf-8")
    for name, found in FIELDS.items():
        array = found.array or name
        assert f"| `{name}` | {found.title} | `{array}` |" in page
        if name in viewer.colors:
            assert array in arrays
            viewer.choose(array)
            assert viewer.color == name
