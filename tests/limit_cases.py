"""Scenes whose largest stable step is predicted and measured.

`python tests/limit_cases.py` writes docs/limits.md; it takes some minutes.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from membrane_rs import Bridges, Fixed, Mesh, Scene, SpringDamping, Springs, scenes
from membrane_rs._markdown import table
from membrane_rs.folding import Disc, Strip
from membrane_rs.scene.laws import Law, MassDamping
from membrane_rs.scene.run_settings import RunSettings
from membrane_rs.simulation import integrators
from membrane_rs.study.limits import Limits, limits
from scipy.spatial import Delaunay
from small_scenes import RUBBER

RATIOS = (0.0, 0.02, 0.2, 0.5, 1.0, 5.0)
LINEAR = 0.02
"""Largest difference of a linear scene's limit from the prediction."""


def random_mesh(seed: int, side: int = 6, jitter: float = 0.4) -> Mesh:
    """Delaunay triangles over a square grid of 1 cm, its nodes moved at random; slivers on the border left out."""
    dice = np.random.default_rng(seed)
    grid = np.stack(np.meshgrid(np.arange(side), np.arange(side)), -1).reshape(-1, 2)
    flat = 0.01 * (grid + dice.uniform(-jitter, jitter, grid.shape))
    mesh = Mesh(np.column_stack([flat, np.zeros(len(flat))]), Delaunay(flat).simplices)
    used, triangles = np.unique(mesh.triangles[mesh.flatness() > 0.1], return_inverse=True)
    return Mesh(mesh.reference[used], triangles.reshape(-1, 3))


def random_scene(seed: int, ratio: float, *more: Law) -> Scene:
    """A random mesh without load: linear, with negative springs clipped."""
    springs = Springs(buckling=1e12, buckling_on_creases=1e12, negative="clip", strain_limit=1e6)
    laws: list[Law] = [springs, *more, *([SpringDamping(ratio)] if ratio else [])]
    name = f"random mesh {seed}, zeta = {ratio:g}"
    return Scene(random_mesh(seed), RUBBER, laws, name=name, run=RunSettings(until=10.0, snapshots=()))


def bridged() -> Scene:
    """A disc with one node split in two, joined by a bridge that sets the step."""
    mesh = Disc(0.05, rings=2).mesh()
    points = np.vstack([mesh.reference, mesh.reference[-1]])
    triangles = mesh.triangles.copy()
    row = np.flatnonzero((triangles == mesh.node_count - 1).any(axis=1))[0]
    triangles[row][triangles[row] == mesh.node_count - 1] = mesh.node_count
    triangles[row] = np.where(triangles[row] == mesh.node_count - 1, mesh.node_count, triangles[row])
    split = Mesh(points, triangles, bridges=[[mesh.node_count - 1, mesh.node_count]])
    laws: list[Law] = [Springs(buckling=1e12), SpringDamping(0.02)]
    return Scene(
        split, RUBBER, laws, [Bridges(1e5)], name="disc with bridges", run=RunSettings(until=10.0, snapshots=())
    )


def stretched(by: float = 2.0) -> Scene:
    """A square network of springs held at its border and stretched evenly, so that tension adds to its stiffness."""
    mesh = Strip(0.1, 0.1, 6, 6).mesh()
    border = np.unique(mesh.boundary_edges)
    laws = [Springs(buckling=1e12, strain_limit=1e6)]
    net = Mesh(mesh.reference, mesh.triangles, positions=by * mesh.reference)
    parts = [Fixed(tuple(int(node) for node in border))]
    return Scene(
        net, RUBBER, laws, parts, name="prestretched spring network", run=RunSettings(until=10.0, snapshots=())
    )


def linear_scenes() -> list[Scene]:
    """Scenes that are linear about their start."""
    random = [random_scene(seed, ratio) for seed in range(4) for ratio in RATIOS]
    friction = replace(random_scene(4, 0.1, MassDamping(5e3)), name="random mesh 4, strong mass-proportional damping")
    return [*random, friction, stretched(), bridged()]


def page(rows: list[Limits]) -> str:
    """docs/limits.md."""
    lines = [
        "# Stability limits, predicted and measured",
        "",
        "Predicted: from the largest eigenvalues of the stiffness and damping at the start (`Simulation.stable_dt`).",
        "Measured: by bisection on the growth of a small disturbance under the method's own steps, to 0.3 %",
        "(`membrane_rs.study.limits`). Random meshes are Delaunay triangles over a perturbed grid, with linear laws",
        "and negative springs set to zero; zeta is the parameter of their dashpots. A ratio below 1 says that the",
        "prediction is too high there, as for dopri5 on the sails; default steps are at most 0.4 of it. Made by",
        "`python tests/limit_cases.py`.",
        "",
    ]
    head = ("scene", "method", "predicted [s]", "measured [s]", "measured / predicted", "limiting law and node")
    body = [
        (row.scene, row.integrator, f"{row.predicted:.4g}", f"{row.measured:.4g}", f"{row.ratio:.3f}", row.part)
        for row in rows
    ]
    lines.append(table(head, body, words=(0, 1, 5)))
    linear = [row.ratio for row in rows if row.scene not in scenes.names()]
    strong = [row.ratio for row in rows if row.scene not in scenes.names() and row.integrator != "dopri5"]
    whole = [row.ratio for row in rows if row.scene in scenes.names()]
    firm = [row.ratio for row in rows if row.scene in scenes.names() and row.integrator != "dopri5"]
    lines += [
        f"Linear scenes: {min(linear):.3f} to {max(linear):.3f}. The growth of dopri5 up to 1.7 times its limit on the",
        "imaginary axis is so slow that some hundred steps hardly show it; the other methods lie within",
        f"{min(strong):.3f} to {max(strong):.3f}.",
        "",
        f"Built-in scenes: {min(whole):.3f} to {max(whole):.3f}, without dopri5 from {min(firm):.3f}. Above 1 the",
        "prediction, with every spring taut and every crease shut, is conservative. Below 1 it is too large: so it",
        "is for dopri5 on folded sails. Damping lengthens the step of dopri5 more than twofold, from its limit on the",
        "imaginary axis, and the prediction counts the dashpots of all cords and triangles, while slack ones have",
        "none. A step of dopri5 that is given should therefore be at most 0.4 of the prediction on such a scene;",
        "steps that it chooses by its error need no limit. The other methods take at most 0.4 of the prediction by",
        "default: this leaves a margin for nonlinearity and accuracy.",
    ]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    names = list(integrators())
    built_in = map(scenes.load, scenes.for_any_method())
    found = [row for scene in [*built_in, *linear_scenes()] for row in limits(scene, names)]
    Path(__file__).parents[1].joinpath("docs", "limits.md").write_text(page(found), encoding="utf-8")
