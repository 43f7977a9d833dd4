"""Small scenes, each poisoned on purpose in one way, at random."""

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

Dice = np.random.Generator
Start = Callable[[Simulation], None]

RUBBER = Material(1e6, 1 / 3, 1000.0, 2e-4)
RUN = RunSettings(until=10.0, watch=20, snapshots=())


@dataclass(frozen=True)
class Poisoned:
    """A run: what it starts from, and what an error must say if there is one."""

    scene: Callable[[], Scene]
    cause: str
    dt: float | None = None
    start: Start | None = None


def strip(dice: Dice, *laws: Law) -> Scene:
    """A strip of rubber with a crease, held at one end, under gravity; `laws` take the place of its own."""
    mesh = Strip(
        0.1, 0.04, 2 * int(dice.integers(2, 5)), 2, creases=(0.5,), fold_angle=float(dice.uniform(0.5, 3))
    ).mesh()
    own: list[Law] = [Springs(), SpringDamping(), Creases(natural_angle=1.0), Gravity()]
    kinds = [law.kind for law in laws]
    return Scene(mesh, RUBBER, [*(law for law in own if law.kind not in kinds), *laws], [Fixed("start")], run=RUN)


def disc(dice: Dice, *laws: Law) -> Scene:
    """A free disc that spins."""
    own: list[Law] = [Springs(buckling=1.0), SpringDamping(), Spin(5.0)]
    kinds = [law.kind for law in laws]
    mesh = Disc(0.1, rings=int(dice.integers(2, 4))).mesh()
    return Scene(mesh, RUBBER, [*(law for law in own if law.kind not in kinds), *laws], run=RUN)


def tether(*laws: Law, **changes: Any) -> Scene:
    """A tip mass on a cord that a hub whirls, beside a spool."""
    values: dict[str, Any] = {"start": (0.1, 0, 0), "end": (0.39, 0.05, 0), "segments": 6, "axial_stiffness": 200.0}
    values |= {"linear_density": 1e-3, "tip_mass": 0.01}
    own: list[Law] = [Spin(3.0), SpringDamping()]
    kinds = [law.kind for law in laws]
    cord = Tether(**(values | changes))
    return Scene(None, None, [*(law for law in own if law.kind not in kinds), *laws], [cord], run=RUN)


def moved(scene: Scene, positions: Any = None, **changes: Any) -> Scene:
    """The scene with its membrane somewhere else, or otherwise folded."""
    old = scene.mesh
    assert old is not None
    values: dict[str, Any] = {"creases": old.creases, "fold_angles": old.fold_angles, "node_sets": old.node_sets}
    points = old.positions if positions is None else positions
    return replace(scene, mesh=Mesh(old.reference, old.triangles, positions=points, **(values | changes)))


def power(dice: Dice, low: float, high: float) -> float:
    """Ten to a power between the two."""
    return float(10.0 ** dice.uniform(low, high))


def limit(scene: Scene) -> float:
    return Simulation(scene).stable_dt()


LIMIT = "stability limit"


def step_too_large(dice: Dice) -> Poisoned:
    scene = strip(dice) if dice.random() < 0.5 else disc(dice)
    return Poisoned(lambda: scene, LIMIT, limit(scene) * power(dice, 0.03, 2.5))


def step_near_the_limit(dice: Dice) -> Poisoned:
    scene = strip(dice) if dice.random() < 0.5 else tether()
    return Poisoned(lambda: scene, LIMIT, limit(scene) * float(dice.uniform(0.8, 1.1)))


def contact_too_stiff(dice: Dice) -> Poisoned:
    scene = strip(dice, Creases(natural_angle=0.0, contact_penalty=power(dice, 4, 12)))
    flat = moved(scene, fold_angles=-scene.mesh.fold_angles if scene.mesh else None)
    return Poisoned(lambda: flat, f"{LIMIT}.*(creases|springs)|energy came from creases", 0.4 * limit(strip(dice)))


def crease_too_stiff(dice: Dice) -> Poisoned:
    scene = strip(dice, Creases(stiffness=power(dice, 3, 12), natural_angle=1.0))
    return Poisoned(lambda: scene, f"{LIMIT}.*creases|energy came from creases", 0.4 * limit(strip(dice)))


def spool_too_stiff(dice: Dice) -> Poisoned:
    scene = tether(SpoolContact(radius=0.2, stiffness=power(dice, 3, 12)))
    return Poisoned(lambda: scene, f"{LIMIT}.*spool_contact|energy came from spool_contact", 0.4 * limit(tether()))


def tangled_start(dice: Dice) -> Poisoned:
    scene = strip(dice)
    assert scene.mesh is not None
    tangled = scene.mesh.positions + dice.normal(size=scene.mesh.positions.shape) * power(dice, -3, 1)
    return Poisoned(lambda: moved(scene, tangled), "start with less strain")


def tangled_without_bound(dice: Dice) -> Poisoned:
    scene = strip(dice, Springs(strain_limit=1e9))
    assert scene.mesh is not None
    tangled = scene.mesh.positions + dice.normal(size=scene.mesh.positions.shape) * power(dice, -3, 1)
    return Poisoned(lambda: moved(scene, tangled), f"energy_loss|{LIMIT}")


def not_a_number(dice: Dice) -> Poisoned:
    scene = strip(dice)
    bad = float(dice.choice([np.nan, np.inf, -np.inf]))
    assert scene.mesh is not None
    points = scene.mesh.positions.copy()
    points[dice.integers(len(points)), dice.integers(3)] = bad
    if dice.random() < 0.5:
        return Poisoned(lambda: moved(scene, points), "not finite|must be finite")

    def start(sim: Simulation) -> None:
        name = "positions" if dice.random() < 0.5 else "velocities"
        setattr(sim, name, points)

    return Poisoned(lambda: scene, "not finite|must be finite", start=start)


def node_without_mass(dice: Dice) -> Poisoned:
    if dice.random() < 0.5:
        return Poisoned(lambda: tether(linear_density=0.0), "mass")
    old = strip(dice).mesh
    assert old is not None
    points = np.vstack([old.reference, dice.normal(size=(1, 3))])
    return Poisoned(lambda: Scene(Mesh(points, old.triangles), RUBBER, [Springs()], run=RUN), "node .* mass")


def folds_inverted(dice: Dice) -> Poisoned:
    scene = strip(dice, Creases(stiffness=power(dice, 0, 4), natural_angle=0.0))
    return Poisoned(lambda: moved(scene, fold_angles=-scene.mesh.fold_angles if scene.mesh else None), "creases")


def huge_spin(dice: Dice) -> Poisoned:
    spin = Spin(power(dice, 1.5, 7), float(dice.choice([0.0, power(dice, 2, 6)])))
    scene = [strip(dice, spin), disc(dice, spin), tether(spin)][dice.integers(3)]
    return Poisoned(lambda: scene, "spin")


def huge_gravity(dice: Dice) -> Poisoned:
    scene = strip(dice, Gravity((0.0, 0.0, -power(dice, 3, 9))))
    return Poisoned(lambda: scene, "gravity")


def nodes_in_one_place(dice: Dice) -> Poisoned:
    old = strip(dice).mesh
    assert old is not None
    row = int(dice.integers(len(old.triangles)))
    triangles = old.triangles.copy()
    case = int(dice.integers(3))
    if case == 0:
        triangles[row, 0] = triangles[row, 1]
        return Poisoned(lambda: Scene(Mesh(old.reference, triangles), RUBBER, [Springs()], run=RUN), "twice")
    points = old.reference.copy()
    if case == 1:
        points[triangles[row, 0]] = points[triangles[row, 1]]
        return Poisoned(lambda: Scene(Mesh(points, triangles), RUBBER, [Springs()], run=RUN), "area")
    points = np.vstack([points, points[triangles[row, 0]]])
    triangles[row, 0] = len(points) - 1
    laws: list[Law] = [Springs(negative="clip"), SpringDamping(), Gravity()]
    torn = Scene(Mesh(points, triangles, node_sets=old.node_sets), RUBBER, laws, [Fixed("start")], run=RUN)
    return Poisoned(lambda: torn, "area|negative")


def slivers(dice: Dice) -> Poisoned:
    old = strip(dice).mesh
    assert old is not None
    points = old.reference.copy()
    a, b, c = old.triangles[dice.integers(len(old.triangles))]
    points[a] = 0.5 * (points[b] + points[c]) + (points[a] - points[b]) * power(dice, -12, -1)
    rule: Any = dice.choice(["refuse", "clip"])
    scene = lambda: Scene(Mesh(points, old.triangles), RUBBER, [Springs(negative=rule)], run=RUN)  # noqa: E731
    return Poisoned(scene, "area|negative|singular")


def negative_springs(dice: Dice) -> Poisoned:
    scene = disc(dice, Springs(buckling=1e9, negative="keep"))
    assert scene.mesh is not None
    points = scene.mesh.reference.copy()
    points[:, 0] *= float(dice.uniform(0.05, 0.3))
    laws = [law for law in scene.laws if law.kind == "springs" or dice.random() < 0.5]

    def nudge(sim: Simulation) -> None:
        sim.velocities = 1e-3 * np.random.default_rng(1).normal(size=(sim.node_count, 3))

    squeezed = replace(scene, mesh=Mesh(points, scene.mesh.triangles), laws=laws)
    return Poisoned(lambda: squeezed, "negative|dashpot|energy_loss", start=nudge)


def tether_without_length(dice: Dice) -> Poisoned:
    if dice.random() < 0.3:
        return Poisoned(lambda: tether(end=(0.1, 0.0, 0.0)), "must differ from start")
    length = power(dice, -320, -1) if dice.random() < 0.5 else power(dice, -6, -1)
    return Poisoned(lambda: tether(length=length), "stretched|rest length|stiffness|mass|length")


def damping_too_strong(dice: Dice) -> Poisoned:
    scene = strip(dice, SpringDamping(power(dice, 0.5, 10)))
    dt = None if dice.random() < 0.5 else 0.4 * limit(strip(dice))
    return Poisoned(lambda: scene, f"{LIMIT}.*spring_damping", dt)


def friction_too_strong(dice: Dice) -> Poisoned:
    scene = strip(dice, MassDamping(power(dice, 2, 14)))
    dt = None if dice.random() < 0.5 else 0.4 * limit(strip(dice))
    return Poisoned(lambda: scene, f"{LIMIT}.*mass_damping", dt)


def enormous_strain(dice: Dice) -> Poisoned:
    scene = strip(dice)
    assert scene.mesh is not None
    return Poisoned(lambda: moved(scene, scene.mesh.positions * power(dice, 0.1, 6)), "start with less strain")  # type: ignore[union-attr]


def enormous_strain_without_bound(dice: Dice) -> Poisoned:
    scene = strip(dice, Springs(strain_limit=1e9))
    assert scene.mesh is not None
    return Poisoned(lambda: moved(scene, scene.mesh.positions * power(dice, 0.1, 4)), f"energy_loss|{LIMIT}")  # type: ignore[union-attr]


def collapsed_wing(dice: Dice) -> Poisoned:
    scene = strip(dice, Creases(natural_angle=3.0, collapse=float(dice.choice([0.0, 0.05]))))
    assert scene.mesh is not None
    a, b = scene.mesh.creases[0]
    wing = next(t for t in scene.mesh.triangles if {a, b} <= set(t.tolist()))
    apex = next(n for n in wing if n not in (a, b))
    points = scene.mesh.positions.copy()
    middle = 0.5 * (points[a] + points[b])
    points[apex] = middle + (points[apex] - middle) * power(dice, -9, -2)
    laws = [Springs(strain_limit=1e9), *(law for law in scene.laws if law.kind != "springs")]
    cause = f"collapse|{LIMIT}.*creases|energy_loss|energy came from springs"
    return Poisoned(lambda: replace(moved(scene, points), laws=laws), cause)


def thick_air(dice: Dice) -> Poisoned:
    scene = strip(dice, AirDrag(pressure=power(dice, 5, 16)))

    def throw(sim: Simulation) -> None:
        sim.velocities = dice.normal(size=(sim.node_count, 3))

    return Poisoned(lambda: scene, "air_drag|pressure", start=throw)


def fast_start(dice: Dice) -> Poisoned:
    speed = power(dice, 1, 7)

    def throw(sim: Simulation) -> None:
        sim.velocities = speed * dice.normal(size=(sim.node_count, 3))

    scene = strip(dice) if dice.random() < 0.5 else disc(dice)
    return Poisoned(lambda: scene, "velocities at the start", start=throw)


def masses_far_apart(dice: Dice) -> Poisoned:
    scene = disc(dice)
    heavy = replace(scene, parts=[TipMasses(power(dice, -20, 8), nodes=(0,))])
    return Poisoned(lambda: heavy, LIMIT)


def light_cord(dice: Dice) -> Poisoned:
    density = power(dice, -18, -5)
    return Poisoned(lambda: tether(linear_density=density), LIMIT, None if dice.random() < 0.5 else 1e-5)


POISONS: list[Callable[[Dice], Poisoned]] = [
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
    collapsed_wing,
    thick_air,
    fast_start,
    masses_far_apart,
    light_cord,
]
