"""Small scenes, each with one kind of fault injected at random."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from membrane_rs import (
    AirDrag,
    Creases,
    Fixed,
    Gravity,
    MassDamping,
    Material,
    Mesh,
    RunSettings,
    Scene,
    Simulation,
    Spin,
    SpoolContact,
    SpringDamping,
    Springs,
    Tether,
    TipMasses,
)
from membrane_rs.folding import Disc, Strip
from membrane_rs.scene.laws import Law

Generator = np.random.Generator
Start = Callable[[Simulation], None]

RUBBER = Material(1e6, 1 / 3, 1000.0, 2e-4)
RUN = RunSettings(until=10.0, watch=20, snapshots=())


@dataclass(frozen=True)
class Faulty:
    """A run with a fault: scene, step and start, and the cause that an error must name."""

    scene: Callable[[], Scene]
    cause: str
    dt: float | None = None
    start: Start | None = None


def strip(rng: Generator, *laws: Law) -> Scene:
    """A strip of rubber with a crease, fixed at one end, under gravity; `laws` replace its own."""
    mesh = Strip(
        0.1, 0.04, 2 * int(rng.integers(2, 5)), 2, creases=(0.5,), fold_angle=float(rng.uniform(0.5, 3))
    ).mesh()
    own: list[Law] = [Springs(), SpringDamping(), Creases(natural_angle=1.0), Gravity()]
    kinds = [law.kind for law in laws]
    return Scene(mesh, RUBBER, [*(law for law in own if law.kind not in kinds), *laws], [Fixed("start")], run=RUN)


def disc(rng: Generator, *laws: Law) -> Scene:
    """A free disc that spins."""
    own: list[Law] = [Springs(buckling=1.0), SpringDamping(), Spin(5.0)]
    kinds = [law.kind for law in laws]
    mesh = Disc(0.1, rings=int(rng.integers(2, 4))).mesh()
    return Scene(mesh, RUBBER, [*(law for law in own if law.kind not in kinds), *laws], run=RUN)


def tether(*laws: Law, **changes: Any) -> Scene:
    """A tip mass on a tether of a turning hub, beside a spool."""
    values: dict[str, Any] = {"start": (0.1, 0, 0), "end": (0.39, 0.05, 0), "segments": 6, "axial_stiffness": 200.0}
    values |= {"linear_density": 1e-3, "tip_mass": 0.01}
    own: list[Law] = [Spin(3.0), SpringDamping()]
    kinds = [law.kind for law in laws]
    cord = Tether(**(values | changes))
    return Scene(None, None, [*(law for law in own if law.kind not in kinds), *laws], [cord], run=RUN)


def moved(scene: Scene, positions: Any = None, **changes: Any) -> Scene:
    """The scene with other positions or fold angles of its membrane."""
    old = scene.mesh
    assert old is not None
    values: dict[str, Any] = {"creases": old.creases, "fold_angles": old.fold_angles, "node_sets": old.node_sets}
    points = old.positions if positions is None else positions
    return replace(scene, mesh=Mesh(old.reference, old.triangles, positions=points, **(values | changes)))


def inverted(scene: Scene) -> tuple[Scene, Start]:
    """The scene folded to the other side, and its start on the wrong side: a mesh that said so would be refused."""
    assert scene.mesh is not None
    points, mirror = scene.mesh.positions, np.array([1.0, 1.0, -1.0])

    def start(sim: Simulation) -> None:
        sim.positions = points

    return moved(scene, points * mirror, fold_angles=-scene.mesh.fold_angles), start


def power(rng: Generator, low: float, high: float) -> float:
    """Ten to a random power between the two."""
    return float(10.0 ** rng.uniform(low, high))


def limit(scene: Scene) -> float:
    return Simulation(scene).stable_dt()


LIMIT = "stability limit"


def step_too_large(rng: Generator) -> Faulty:
    scene = strip(rng) if rng.random() < 0.5 else disc(rng)
    return Faulty(lambda: scene, LIMIT, limit(scene) * power(rng, 0.03, 2.5))


def step_near_the_limit(rng: Generator) -> Faulty:
    scene = strip(rng) if rng.random() < 0.5 else tether()
    return Faulty(lambda: scene, LIMIT, limit(scene) * float(rng.uniform(0.8, 1.1)))


def contact_too_stiff(rng: Generator) -> Faulty:
    scene = strip(rng, Creases(natural_angle=0.0, contact_penalty=power(rng, 4, 12)))
    other, start = inverted(scene)
    cause = f"{LIMIT}.*(creases|springs)|energy came from creases"
    return Faulty(lambda: other, cause, 0.4 * limit(strip(rng)), start)


def crease_too_stiff(rng: Generator) -> Faulty:
    scene = strip(rng, Creases(stiffness=power(rng, 3, 12), natural_angle=1.0))
    return Faulty(lambda: scene, f"{LIMIT}.*creases|energy came from creases", 0.4 * limit(strip(rng)))


def spool_too_stiff(rng: Generator) -> Faulty:
    scene = tether(SpoolContact(radius=0.2, stiffness=power(rng, 3, 12)))
    return Faulty(lambda: scene, f"{LIMIT}.*spool_contact|energy came from spool_contact", 0.4 * limit(tether()))


def tangled_start(rng: Generator) -> Faulty:
    scene = strip(rng)
    assert scene.mesh is not None
    tangled = scene.mesh.positions + rng.normal(size=scene.mesh.positions.shape) * power(rng, -3, 1)
    return Faulty(lambda: moved(scene, tangled), "start with less strain")


def tangled_without_bound(rng: Generator) -> Faulty:
    scene = strip(rng, Springs(strain_limit=1e9))
    assert scene.mesh is not None
    tangled = scene.mesh.positions + rng.normal(size=scene.mesh.positions.shape) * power(rng, -3, 1)
    return Faulty(lambda: moved(scene, tangled), f"energy_loss|{LIMIT}")


def not_a_number(rng: Generator) -> Faulty:
    scene = strip(rng)
    bad = float(rng.choice([np.nan, np.inf, -np.inf]))
    assert scene.mesh is not None
    points = scene.mesh.positions.copy()
    points[rng.integers(len(points)), rng.integers(3)] = bad
    if rng.random() < 0.5:
        return Faulty(lambda: moved(scene, points), "not finite|must be finite")

    def start(sim: Simulation) -> None:
        name = "positions" if rng.random() < 0.5 else "velocities"
        setattr(sim, name, points)

    return Faulty(lambda: scene, "not finite|must be finite", start=start)


def node_without_mass(rng: Generator) -> Faulty:
    if rng.random() < 0.5:
        return Faulty(lambda: tether(linear_density=0.0), "mass")
    old = strip(rng).mesh
    assert old is not None
    points = np.vstack([old.reference, rng.normal(size=(1, 3))])
    return Faulty(lambda: Scene(Mesh(points, old.triangles), RUBBER, [Springs()], run=RUN), "node .* mass")


def folds_inverted(rng: Generator) -> Faulty:
    scene = strip(rng, Creases(stiffness=power(rng, 0, 4), natural_angle=0.0))
    other, start = inverted(scene)
    return Faulty(lambda: other, "creases", start=start)


def huge_spin(rng: Generator) -> Faulty:
    spin = Spin(power(rng, 1.5, 7), float(rng.choice([0.0, power(rng, 2, 6)])))
    scene = [strip(rng, spin), disc(rng, spin), tether(spin)][rng.integers(3)]
    return Faulty(lambda: scene, "spin")


def huge_gravity(rng: Generator) -> Faulty:
    scene = strip(rng, Gravity((0.0, 0.0, -power(rng, 3, 9))))
    return Faulty(lambda: scene, "gravity")


def nodes_in_one_place(rng: Generator) -> Faulty:
    old = strip(rng).mesh
    assert old is not None
    row = int(rng.integers(len(old.triangles)))
    triangles = old.triangles.copy()
    case = int(rng.integers(3))
    if case == 0:
        triangles[row, 0] = triangles[row, 1]
        return Faulty(lambda: Scene(Mesh(old.reference, triangles), RUBBER, [Springs()], run=RUN), "twice")
    points = old.reference.copy()
    if case == 1:
        points[triangles[row, 0]] = points[triangles[row, 1]]
        return Faulty(lambda: Scene(Mesh(points, triangles), RUBBER, [Springs()], run=RUN), "area")
    points = np.vstack([points, points[triangles[row, 0]]])
    triangles[row, 0] = len(points) - 1
    laws: list[Law] = [Springs(negative="clip"), SpringDamping(), Gravity()]
    torn = Scene(Mesh(points, triangles, node_sets=old.node_sets), RUBBER, laws, [Fixed("start")], run=RUN)
    return Faulty(lambda: torn, "area|negative")


def slivers(rng: Generator) -> Faulty:
    old = strip(rng).mesh
    assert old is not None
    points = old.reference.copy()
    a, b, c = old.triangles[rng.integers(len(old.triangles))]
    points[a] = 0.5 * (points[b] + points[c]) + (points[a] - points[b]) * power(rng, -12, -1)
    rule: Any = rng.choice(["refuse", "clip"])
    scene = lambda: Scene(Mesh(points, old.triangles), RUBBER, [Springs(negative=rule)], run=RUN)  # noqa: E731
    return Faulty(scene, "area|negative|singular")


def negative_springs(rng: Generator) -> Faulty:
    scene = disc(rng, Springs(buckling=1e9, negative="keep"))
    assert scene.mesh is not None
    points = scene.mesh.reference.copy()
    points[:, 0] *= float(rng.uniform(0.05, 0.3))
    laws = [law for law in scene.laws if law.kind == "springs" or rng.random() < 0.5]

    def nudge(sim: Simulation) -> None:
        sim.velocities = 1e-3 * np.random.default_rng(1).normal(size=(sim.node_count, 3))

    squeezed = replace(scene, mesh=Mesh(points, scene.mesh.triangles), laws=laws)
    return Faulty(lambda: squeezed, "negative|dashpot|energy_loss", start=nudge)


def tether_without_length(rng: Generator) -> Faulty:
    if rng.random() < 0.3:
        return Faulty(lambda: tether(end=(0.1, 0.0, 0.0)), "must differ from start")
    length = power(rng, -320, -1) if rng.random() < 0.5 else power(rng, -6, -1)
    return Faulty(lambda: tether(length=length), "stretched|rest length|stiffness|mass|length")


def damping_too_strong(rng: Generator) -> Faulty:
    scene = strip(rng, SpringDamping(power(rng, 0.5, 10)))
    dt = None if rng.random() < 0.5 else 0.4 * limit(strip(rng))
    return Faulty(lambda: scene, f"{LIMIT}.*spring_damping", dt)


def friction_too_strong(rng: Generator) -> Faulty:
    scene = strip(rng, MassDamping(power(rng, 2, 14)))
    dt = None if rng.random() < 0.5 else 0.4 * limit(strip(rng))
    return Faulty(lambda: scene, f"{LIMIT}.*mass_damping", dt)


def enormous_strain(rng: Generator) -> Faulty:
    scene = strip(rng)
    assert scene.mesh is not None
    return Faulty(lambda: moved(scene, scene.mesh.positions * power(rng, 0.1, 6)), "start with less strain")  # type: ignore[union-attr]


def enormous_strain_without_bound(rng: Generator) -> Faulty:
    scene = strip(rng, Springs(strain_limit=1e9))
    assert scene.mesh is not None
    return Faulty(lambda: moved(scene, scene.mesh.positions * power(rng, 0.1, 4)), f"energy_loss|{LIMIT}")  # type: ignore[union-attr]


def collapsed_facet(rng: Generator) -> Faulty:
    scene = strip(rng, Creases(natural_angle=3.0, collapse=float(rng.choice([0.0, 0.05]))))
    assert scene.mesh is not None
    a, b = scene.mesh.creases[0]
    facet = next(t for t in scene.mesh.triangles if {a, b} <= set(t.tolist()))
    apex = next(n for n in facet if n not in (a, b))
    points = scene.mesh.positions.copy()
    middle = 0.5 * (points[a] + points[b])
    points[apex] = middle + (points[apex] - middle) * power(rng, -9, -2)
    laws = [Springs(strain_limit=1e9), *(law for law in scene.laws if law.kind != "springs")]
    cause = f"collapse|{LIMIT}.*creases|energy_loss|energy came from springs"
    return Faulty(lambda: replace(moved(scene, points), laws=laws), cause)


def thick_air(rng: Generator) -> Faulty:
    scene = strip(rng, AirDrag(pressure=power(rng, 5, 16)))

    def throw(sim: Simulation) -> None:
        sim.velocities = rng.normal(size=(sim.node_count, 3))

    return Faulty(lambda: scene, "air_drag|pressure", start=throw)


def fast_start(rng: Generator) -> Faulty:
    speed = power(rng, 1, 7)

    def throw(sim: Simulation) -> None:
        sim.velocities = speed * rng.normal(size=(sim.node_count, 3))

    scene = strip(rng) if rng.random() < 0.5 else disc(rng)
    return Faulty(lambda: scene, "velocities at the start", start=throw)


def masses_far_apart(rng: Generator) -> Faulty:
    scene = disc(rng)
    heavy = replace(scene, parts=[TipMasses(power(rng, -20, 8), nodes=(0,))])
    return Faulty(lambda: heavy, LIMIT)


def light_cord(rng: Generator) -> Faulty:
    density = power(rng, -18, -5)
    return Faulty(lambda: tether(linear_density=density), LIMIT, None if rng.random() < 0.5 else 1e-5)


FAULTS: list[Callable[[Generator], Faulty]] = [
    step_too_large,
    step_near_the_limit,
    contact_too_stiff,
    crease_too_stiff,
    spool_too_stiff,
    tangled_start,
    tangled_without_bound,
    not_a_number,
    node_without_mass,
    folds_inverted,
    huge_spin,
    huge_gravity,
    nodes_in_one_place,
    slivers,
    negative_springs,
    tether_without_length,
    damping_too_strong,
    friction_too_strong,
    enormous_strain,
    enormous_strain_without_bound,
    collapsed_facet,
    thick_air,
    fast_start,
    masses_far_apart,
    light_cord,
]
