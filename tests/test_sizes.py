"""Sums of parameters beyond all memory: refused by name, before memory is taken, by one bound."""

from __future__ import annotations

import tracemalloc
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from membrane_rs import InputError, MeshError, Scene, SceneError, Tether, Tethers
from membrane_rs._bounds import MOST_NODES
from membrane_rs.folding import PATTERNS, Disc, EquilateralLattice, Miura, SpiralHexagon, SquareSail, Strip
from small_scenes import FILM, refused

MANY = 10**9


@pytest.fixture(autouse=True)
def little_memory() -> Iterator[None]:
    """Refusing takes no more than a MB."""
    tracemalloc.start()
    yield
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 20e6


def cord(segments: int) -> Tether:
    return Tether((0, 0, 0), (1, 0, 0), segments, axial_stiffness=1.0, linear_density=1.0)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Strip(1.0, 1.0, 1, MANY), "Strip: columns = 1, rows = 1000000000: makes about 2.0e"),
        (lambda: Strip(1.0, 1.0, MANY, MANY), "must be at most 10000000, more do not fit; take fewer"),
        (lambda: EquilateralLattice(1.0, MANY, 1), "EquilateralLattice: columns = 1000000000"),
        (lambda: EquilateralLattice(1.0, 4000, 4000), "do not fit"),
        (lambda: Miura(1.0, 1.0, 0.5, MANY, 1), "Miura: columns = 1000000000, rows = 1, divisions = 1: makes"),
        (lambda: Miura(1e-300, 1e300, 0.5, 1, 1), "do not fit"),
        (lambda: SquareSail(rows=8 * 10**8), "do not fit"),
        (lambda: SquareSail(fold_lines=MANY), "do not fit"),
        (lambda: SquareSail(columns=MANY), "1e.09 columns"),
        (lambda: SquareSail(outer_width=0.103 + 1e-15), "inf columns along the inner edge"),
        (lambda: SquareSail(outer_width=0.103 + 1e-9, layout="fan"), "columns along the inner edge"),
        (lambda: SquareSail(rows=1200, layout="even"), "do not fit"),
        (lambda: SpiralHexagon(rows=5 * 10**8), "SpiralHexagon: 6 sides, 500000000 rows"),
        (lambda: SpiralHexagon(sides=MANY), "SpiralHexagon: 1000000000 sides"),
        (lambda: Disc(1.0, MANY), "Disc.rings = 1000000000"),
        (lambda: Disc(1.0, MANY, 0.5), "Disc.rings = 1000000000"),
    ],
)
def test_patterns_of_too_many_nodes(make: Callable[[], Any], words: str) -> None:
    refused(make, MeshError, words)


@pytest.mark.parametrize("name", PATTERNS)
@pytest.mark.parametrize("density", [1e6, 1e300, float("inf"), float("nan"), 0, -1, True, "2", 1 + 1j])
def test_refined_patterns_of_too_many_nodes(name: str, density: Any) -> None:
    sizes: dict[str, Any] = {
        "square-sail": {}, "disc": {"radius": 1.0, "rings": 4}, "strip": {"length": 1.0, "width": 1.0, "columns": 2},
        "lattice": {"side": 1.0, "columns": 2, "rows": 2},
        "miura": {"straight_side": 1.0, "zigzag_side": 1.0, "tilt": 0.5, "columns": 2, "rows": 2}, "spiral-hexagon": {},
    }  # fmt: skip
    pattern = PATTERNS[name](**sizes[name])
    refused(lambda: pattern.refined(density), InputError, "do not fit|density = .*: must be")


@pytest.mark.parametrize(
    "parts",
    [[cord(MANY)], [cord(10), cord(10), cord(MOST_NODES)], [Tethers("end", anchor_radius=0.01, segments=MANY)]],
    ids=["one", "three", "tethers"],
)
def test_cords_of_too_many_nodes(parts: list[Any]) -> None:
    mesh = Strip(0.1, 0.02, 2, 1).mesh()
    refused(
        lambda: Scene(mesh, FILM, [], parts), SceneError, r"parts\[\d\].segments = .* do not fit; take fewer segments"
    )
