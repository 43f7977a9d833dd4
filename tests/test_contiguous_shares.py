"""Shares of elements with contiguous nodes: `Simulation.contiguous_shares`, and what `check` says of them."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
from membrane_rs import AirDrag, Material, Mesh, Scene, Simulation, SpringDamping, Triangles, scenes
from membrane_rs.cli import app
from scipy.spatial import Delaunay
from typer.testing import CliRunner


def told(scene: str | Path) -> dict[str, float]:
    """The shares that `check` prints, by law [%]."""
    result = CliRunner().invoke(app, ["check", str(scene), "--until", "1e-4"])
    assert result.exit_code == 0, result.output
    line = next(line for line in result.output.splitlines() if line.startswith("  contiguous "))
    return {law: float(share) for law, share in re.findall(r"(\w+) (\d+) %", line)}


def in_percent(sim: Simulation) -> dict[str, float]:
    return {law: float(f"{100 * share:.0f}") for law, share in sim.contiguous_shares.items()}


def test_a_pattern_falls_into_runs() -> None:
    shares = told("okuizumi-model-1")
    assert shares == in_percent(Simulation(scenes.load("okuizumi-model-1")))
    assert shares.keys() == {"springs", "spring_damping", "creases", "air_drag", "tethers"}
    assert min(share for law, share in shares.items() if law != "tethers") > 90


def test_an_imported_mesh_without_order_is_told_too(tmp_path: Path) -> None:
    points = np.random.default_rng(3).random((400, 2))
    mesh = Mesh(np.pad(points, ((0, 0), (0, 1))), Delaunay(points).simplices)
    film = Material(youngs_modulus=3.2e9, poisson_ratio=1 / 3, density=1420.0, thickness=7.5e-6)
    scene = Scene(mesh, film, laws=[Triangles(), SpringDamping(), AirDrag()], name="imported")
    scene.save(tmp_path)
    shares = told(tmp_path / "scene.toml")
    assert shares == in_percent(Simulation(scene))
    assert shares.keys() == {"triangles", "spring_damping", "air_drag"}
    assert all(0 <= share < 90 for share in shares.values())
