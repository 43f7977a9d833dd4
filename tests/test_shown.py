"""What is shown of meshes, scenes, simulations and runs: a line of text, a picture and a table, safe for any name."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from membrane_rs import Mesh, Scene, Simulation, Stage, run, scenes
from membrane_rs._html import MOST_LINES, SIZE, Lines, svg
from membrane_rs.scenes import names
from small_scenes import hanging_strip

HOSTILE = "<script>alert(1)<b>&\"'\a\u202e"


def parsed(item: Any) -> ElementTree.Element:
    """The HTML of an object, which must be well formed."""
    return ElementTree.fromstring(item._repr_html_().replace(" nowrap>", ">"))


def numbers_in(picture: ElementTree.Element) -> list[float]:
    paths = [path for path in picture.iter() if path.tag.endswith("path")]
    return [float(word) for path in paths for word in re.findall(r"-?[\d.]+", path.attrib["d"])]


@pytest.mark.parametrize("name", names())
def test_every_scene_is_shown_by_a_small_picture(name: str) -> None:
    scene = scenes.load(name)
    for item in (scene, *([scene.mesh] if scene.mesh is not None else [])):
        html, tree = item._repr_html_(), parsed(item)
        numbers = numbers_in(tree)
        assert len(html) < 60_000
        assert numbers
        assert 0.0 <= min(numbers) <= max(numbers) <= SIZE
        assert max(numbers) - min(numbers) > 0.9 * SIZE
    assert repr(scene).startswith(f"Scene({name!r}: {scene.assemble().node_count} nodes; laws ")


def test_names_of_users_are_text(tmp_path: Any) -> None:
    scene = replace(hanging_strip(), name=HOSTILE, stages=[Stage("</td>", 1e-3)])
    result = run(scene, frames=2, samples=2)
    for item in (scene, Simulation(scene), result):
        html = item._repr_html_()
        assert "<script" not in html
        assert "<b>&" not in html
        assert "\a" not in html
        assert "\u202e" not in html
        assert "&lt;script&gt;alert(1)" in html
        text = "".join(parsed(item).itertext())
        assert "<script>alert(1)<b>&\"'" in text
    assert "&lt;/td&gt;" in scene._repr_html_()


def test_a_line_stays_a_line_whatever_a_run_says(tmp_path: Path) -> None:
    scene = replace(hanging_strip(), stages=[Stage(f"stage-{k}", 1e-3 * (k + 1)) for k in range(100)])
    result = run(scene, 1e-3, frames=2, samples=2, out=tmp_path / "a\nb", pictures=False)
    result.summary["outcome"] = "failed: " + 1000 * "long\n"
    for item in (scene, result):
        assert len(repr(item)) < 400
        assert repr(item).isprintable()


def test_what_is_shown_of_a_simulation_and_of_a_run() -> None:
    scene = replace(hanging_strip(), name="strip")
    sim = Simulation(scene)
    sim.step(3)
    assert repr(sim).startswith(f"Simulation('strip', rk4, dt = {sim.dt:.4g} s: t = {sim.time:.6g} s, 3 steps")
    result = run(scene, 2e-3, frames=3, samples=5)
    assert repr(result) == "Run('strip', finished: 5 samples, 3 frames)"
    assert repr(result.frames) == "RunFrames(3, 0 to 0.002 s)"
    assert repr(result.frames[1]).startswith("RunFrame(t = 0.001 s, ")
    words = "".join(parsed(result).itertext())
    assert "outcomefinished" in words
    assert "time [s]0 to 0.002" in words


def test_a_picture_is_bounded_whatever_the_mesh() -> None:
    count = 20_000
    nodes = np.random.default_rng(1).uniform(size=(count, 3))
    pairs = np.random.default_rng(2).integers(0, count, size=(count, 2))
    picture = svg(Lines(nodes, pairs))
    assert picture.count("M") <= MOST_LINES
    assert len(picture) < 30 * MOST_LINES
    assert "nan" not in svg(Lines(np.full((2, 3), np.nan), np.array([[0, 1]])))
    assert "path" not in svg(Lines(np.zeros((0, 3))))
    assert "nan" not in svg(Lines(np.ones((2, 3)), np.array([[0, 1]])))


@pytest.mark.parametrize("axes", [(0, 1, 2), (0, 2, 1), (2, 0, 1)])
def test_a_flat_mesh_is_seen_from_its_broad_side(axes: tuple[int, int, int]) -> None:
    points = np.zeros((4, 3))
    points[:, [axes[0], axes[1]]] = [[0, 0], [2, 0], [2, 1], [0, 1]]
    numbers = np.array(numbers_in(parsed(Mesh(points, [[0, 1, 2], [0, 2, 3]])))).reshape(-1, 2)
    extent = np.sort(np.ptp(numbers, axis=0))
    assert extent[1] == pytest.approx(2.0 * extent[0], abs=0.3)


def test_a_strip_that_hangs_askew_is_seen_from_its_broad_side() -> None:
    scene = scenes.load("hanging-strip")
    points = np.array(numbers_in(parsed(scene))).reshape(-1, 2)
    width, height = np.ptp(points, axis=0)
    assert scene.mesh is not None
    extent = np.ptp(scene.mesh.positions, axis=0)
    assert width / height == pytest.approx(extent[1] / extent[2], rel=0.05)


def test_a_line_is_seen_from_the_side() -> None:
    lines = Lines(np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]]), cords=np.array([[0, 1]]))
    numbers = [float(word) for word in re.findall(r"-?[\d.]+", svg(lines).partition(' d="')[2].partition('"')[0])]
    assert np.ptp(numbers) > 0.9 * SIZE


def test_a_scene_is_no_longer_shown_by_all_its_values() -> None:
    assert len(repr(Scene(None, None, parts=scenes.load("spinning-tether").parts))) < 100


def test_a_scene_shows_its_film_with_prefixes() -> None:
    assert "7.5 um thick, E = 3.2 GPa" in scenes.load("okuizumi-model-1")._repr_html_()
