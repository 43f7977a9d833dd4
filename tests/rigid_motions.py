"""Rigid motion added to sound and to faulty scenes: the monitor must judge each as it judges the same scene at rest.

`python tests/rigid_motions.py` writes docs/rigid_motions.md, in a few minutes of one core.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import ceil, inf, log10
from pathlib import Path
from textwrap import wrap

import numpy as np
from membrane_rs import (
    Creases,
    Gravity,
    Mesh,
    RunSettings,
    Scene,
    Simulation,
    Spin,
    SpringDamping,
    Springs,
    Triangles,
    UnstableError,
)
from membrane_rs._markdown import table
from membrane_rs.folding import Disc, Strip
from membrane_rs.scene.laws import Law
from membrane_rs.simulation import integrators
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components
from small_scenes import RUBBER, UNBUCKLED, Floats

Generator = np.random.Generator

STEPS = 600
"""Of each run, or their duration where steps are chosen by their error."""
SEEDS = 5
WRONG = 0.5
"""Difference from the energy of the reference run, over the largest exchange, at which a run is wrong."""
SMALL = 1e-4
"""Share of the energy itself below which a difference does not count: the floor of the monitor, tenfold."""
SHARE = 0.4
"""Step over the limit."""
RESOLVED = 0.1
"""Step of an implicit method over the limit of rk4."""
FASTEST = 1000.0
"""Largest speed of the whole [m/s]."""
LARGEST_RATE = 100.0
"""Largest rate of rotation [rad/s]: the film is then stretched by 1e-3."""
RUN = RunSettings(until=10.0, watch=20, snapshots=())


@dataclass(frozen=True)
class Case:
    """A free scene about its centre of mass: velocities [m/s], and the step over the limit where it is the fault."""

    scene: Scene
    velocities: Floats
    share: float | None = None


def film(rng: Generator, *laws: Law, damped: bool = True) -> Scene:
    """A free strip or disc of rubber."""
    mesh = Strip(0.1, 0.06, int(rng.integers(3, 6)), 2).mesh() if rng.random() < 0.5 else Disc(0.05, 3).mesh()
    return Scene(mesh, RUBBER, [*laws, *([SpringDamping()] if damped else [])], run=RUN)


def smooth(scene: Scene, rng: Generator) -> Floats:
    """Velocities of a slow stretch along x and y, of a few millimetres a second."""
    assert scene.mesh is not None
    x = scene.mesh.positions - scene.mesh.positions.mean(axis=0)
    field: Floats = x * [0.1 * rng.uniform(0.5, 1), -0.1 * rng.uniform(0.5, 1), 0.0]
    return field


def noise(scene: Scene, rng: Generator, speed: float = 1e-2) -> Floats:
    """Random velocities of every node in the plane of the film."""
    assert scene.mesh is not None
    field: Floats = speed * rng.normal(size=scene.mesh.positions.shape) * [1, 1, 0]
    return field


def at_rest(rng: Generator, _: str) -> Case:
    scene = film(rng, [Springs(), Triangles()][rng.integers(2)])
    return Case(scene, 0.0 * smooth(scene, rng))


def stretched_springs(rng: Generator, _: str) -> Case:
    scene = film(rng, Springs())
    return Case(scene, smooth(scene, rng))


def stretched_triangles(rng: Generator, _: str) -> Case:
    scene = film(rng, Triangles())
    return Case(scene, smooth(scene, rng))


def folded(rng: Generator, _: str) -> Case:
    mesh = Strip(0.12, 0.04, 6, 2, creases=(0.5,), fold_angle=float(rng.uniform(0.5, 2))).mesh()
    creases = Creases(stiffness=10.0, natural_angle=1.0)
    scene = Scene(mesh, RUBBER, [Springs(), SpringDamping(), creases], run=RUN)
    return Case(scene, smooth(scene, rng))


def two_pieces(rng: Generator, _: str) -> Case:
    one = Strip(0.1, 0.04, 3, 1).mesh()
    points = np.vstack([one.reference, one.reference + np.array([0.3, 0.1, 0.0])])
    mesh = Mesh(points, np.vstack([one.triangles, one.triangles + len(one.reference)]))
    scene = Scene(mesh, RUBBER, [Springs(), SpringDamping()], run=RUN)
    own = np.repeat(rng.normal(size=(2, 3)), len(one.reference), axis=0)
    return Case(scene, smooth(scene, rng) * 0 + 0.1 * own)


def falling(rng: Generator, _: str) -> Case:
    scene = film(rng, Springs(), Gravity((0.0, 3.0, -9.0)))
    return Case(scene, smooth(scene, rng))


def step_above_the_limit(rng: Generator, method: str) -> Case | None:
    if not np.isfinite(integrators()[method].imaginary_limit):
        return None
    scene = film(rng, UNBUCKLED, damped=bool(rng.random() < 0.5))
    return Case(scene, noise(scene, rng, 1e-3), float(rng.uniform(1.02, 2.0)))


def noise_that_is_lost(rng: Generator, method: str) -> Case | None:
    # Leapfrog keeps the noise, and the short steps of the implicit method here resolve it.
    if method in ("leapfrog", "generalized_alpha"):
        return None
    scene = film(rng, UNBUCKLED, damped=False)
    return Case(scene, noise(scene, rng), float(rng.uniform(0.6, 0.9)))


def negative_springs(rng: Generator, method: str) -> Case | None:
    if not np.isfinite(integrators()[method].imaginary_limit):
        return None
    mesh = Disc(0.05, 3).mesh()
    points = mesh.reference * [float(rng.uniform(0.05, 0.2)), 1, 1]
    scene = Scene(Mesh(points, mesh.triangles), RUBBER, [Springs(buckling=1e9, negative="keep")], run=RUN)
    return Case(scene, noise(scene, rng, 1e-3))


def crease_too_stiff(rng: Generator, method: str) -> Case | None:
    if not np.isfinite(integrators()[method].imaginary_limit):
        return None
    mesh = Strip(0.12, 0.04, 6, 2, creases=(0.5,), fold_angle=1.0).mesh()
    laws: list[Law] = [Springs(), Creases(stiffness=float(10.0 ** rng.uniform(4, 6)), natural_angle=0.9)]
    scene = Scene(mesh, RUBBER, laws, run=RUN)
    return Case(scene, smooth(scene, rng), float(rng.uniform(1.5, 10)))


Kind = Callable[[Generator, str], Case | None]
SOUND: list[Kind] = [at_rest, stretched_springs, stretched_triangles, folded, two_pieces, falling]
FAULTY: list[Kind] = [step_above_the_limit, noise_that_is_lost, negative_springs, crease_too_stiff]
MOTIONS = ("at rest", "thrown", "spun about z", "spun about any axis", "thrown and spun", "in a turning frame")


@dataclass(frozen=True)
class Verdict:
    """Outcome of a run: whether it was stopped, and by how much its internal energy differs from the reference run."""

    kind: str
    is_sound: bool
    motion: str
    method: str
    seed: int
    is_stopped: bool
    message: str = ""
    apart: float = 0.0

    @property
    def is_false_stop(self) -> bool:
        return self.is_sound and self.is_stopped

    @property
    def is_missed(self) -> bool:
        return not self.is_stopped and abs(self.apart) > WRONG


def moving(case: Case, motion: str, rng: Generator) -> tuple[Scene, Floats, Floats]:
    """Scene, positions and velocities of a case with a random rigid motion."""
    scene = case.scene
    assert scene.mesh is not None
    x = scene.mesh.positions.copy()
    speed, rate = 10.0 ** rng.uniform(-1, log10(FASTEST)), rng.uniform(0.1, 1) * LARGEST_RATE
    direction, axis = (v / np.linalg.norm(v) for v in rng.normal(size=(2, 3)))
    v = case.velocities.copy()
    arm = x - x.mean(axis=0)
    if "spun" in motion:
        v += np.cross(rate * (np.array([0, 0, 1.0]) if motion.endswith("z") else axis), arm)
    if "thrown" in motion:
        v += speed * direction
    if motion == "in a turning frame":
        scene = replace(scene, laws=[*scene.laws, Spin(rate / (2 * np.pi))])
        # Half of them at rest in the frame, the others in inertial space.
        v -= np.cross([0, 0, rate if rng.random() < 0.5 else 0.0], x)
    return scene, x, v


def verdict(kind: Kind, motion: str, method: str, seed: int, is_compared: bool = True) -> Verdict | None:
    """Run one case with one motion by one method; None where the kind has no case for this method."""
    kinds = [*SOUND, *FAULTY]
    rng = np.random.default_rng([kinds.index(kind), seed, list(integrators()).index(method)])
    case = kind(rng, method)
    if case is None:
        return None
    scene, positions, velocities = moving(case, motion, rng)
    name = kind.__name__.replace("_", " ")
    limit = Simulation(scene, "rk4" if integrators()[method].imaginary_limit == inf else method, dt=1e-9).stable_dt()
    # The default step of an implicit method would damp the vibrations, and that of so few nodes resolves them all.
    share = case.share or (RESOLVED if integrators()[method].imaginary_limit == inf else SHARE)
    is_adaptive = case.share is None and Simulation(scene, method).is_adaptive
    sim = Simulation(scene, method, None if is_adaptive else share * limit)
    step = share * limit
    sim.velocities = velocities
    made = (name, kind in SOUND, motion, method, seed)
    try:
        sim.run(until=STEPS * step, frames=2, samples=3)
    except UnstableError as error:
        return Verdict(*made, True, str(error))
    return Verdict(*made, False, "", _apart(scene, sim, step, positions, velocities) if is_compared else 0.0)


def internal_energy(sim: Simulation) -> float:
    """Kinetic energy about the centre of mass of each piece in inertial space, and of the internal laws [J]."""
    mesh = sim.scene.mesh
    assert mesh is not None
    x, v, m = sim.positions, sim.velocities, sim.masses
    rate = 2 * np.pi * sum(getattr(law, "frequency", 0.0) for law in sim.scene.laws)
    v = v + np.cross([0, 0, rate], x)
    links = csr_array((np.ones(len(mesh.edges)), mesh.edges.T), shape=(len(x), len(x)))
    piece_of = connected_components(links, directed=False)[1]
    kinetic = 0.0
    for piece in np.unique(piece_of):
        own = piece_of == piece
        kinetic += 0.5 * (m[own] @ (v[own] - m[own] @ v[own] / m[own].sum()) ** 2).sum()
    stored = sim.ledger()["stored_by_law"]
    return float(kinetic + sum(energy for law, energy in stored.items() if law not in ("spin", "gravity")))


def _apart(scene: Scene, sim: Simulation, dt: float, positions: Floats, velocities: Floats) -> float:
    """Difference of the internal energy from that of rk4 at a tenth of its limit without monitor, over the exchange."""
    calm = replace(scene, run=replace(scene.run, watch=10**9, energy_loss=1e9))
    steps = ceil(sim.time / min(dt / 5, 0.1 * Simulation(calm, "rk4").stable_dt()))
    fine = Simulation(calm, "rk4", sim.time / steps)
    fine.positions, fine.velocities = positions, velocities
    fine.step(steps)
    found, right = internal_energy(sim), internal_energy(fine)
    exchange = max(fine.ledger()["reference_energy"], sim.ledger()["reference_energy"])
    small = SMALL * (abs(right) + _carried(sim)) + _rounding(sim, steps)
    return 0.0 if abs(found - right) <= small else (found - right) / exchange


def _carried(sim: Simulation) -> float:
    """Energy of a rotation with the frame, in which the methods step [J]."""
    rate = 2 * np.pi * sum(getattr(law, "frequency", 0.0) for law in sim.scene.laws)
    x = sim.positions[:, :2] - sim.masses @ sim.positions[:, :2] / sim.masses.sum()
    return float(0.5 * rate**2 * (sim.masses @ x**2).sum())


def _rounding(sim: Simulation, steps: int) -> float:
    """Energy of nodes whose velocities lose some last digits in each step [J]."""
    largest = np.abs(sim.velocities).max() + np.abs(sim.positions).max() / sim.stable_dt()
    return float(0.5 * sim.masses.sum() * steps * (16 * np.finfo(float).eps * largest) ** 2)


def verdicts(seeds: range = range(SEEDS)) -> list[Verdict]:
    """All runs."""
    found = [
        verdict(kind, motion, method, seed)
        for kind in [*SOUND, *FAULTY]
        for method in integrators()
        for motion in MOTIONS
        for seed in seeds
    ]
    return [each for each in found if each is not None]


def page(found: list[Verdict]) -> str:
    """docs/rigid_motions.md."""
    lines = [
        f"# Rigid motion: {len(found)} runs of free scenes at rest, thrown and spun",
        "",
        "Each run is of a small free scene of rubber film, of one kind (fixed seeds), to which a random rigid motion",
        f"is added: a speed from 0.1 to {FASTEST:g} m/s, a rate of rotation up to {LARGEST_RATE:g} rad/s about the",
        f"axis of the hub or any other, a frame that turns. Methods: {', '.join(integrators())}; {STEPS} steps of",
        f"{SHARE:g} of the limit (`generalized_alpha`: {RESOLVED:g} of that of rk4), or of the step that is the fault.",
        "A false stop is one of a sound scene. A missed fault is a run to its end whose energy about the centres of",
        "mass differs from that of a reference run (rk4 at a tenth of its limit, without monitor) by more than",
        f"{100 * WRONG:g} % of the largest exchange and {100 * SMALL:g} % of itself, with what a rotation with the",
        "frame would add. A kind of fault may do no harm:",
        "with dopri5, whose steps are chosen by their error, a scene may vibrate within the tolerance; the tension",
        "of a film that turns holds what negative springs would drive apart; noise that is lost is a small share",
        "of what a fast rotation exchanges. Made by",
        "`python tests/rigid_motions.py`; a part of it is `tests/test_rigid_motions.py`. How the monitor judges:",
        "[model.md](model.md#energy-error-and-monitor).",
    ]
    head = ("kind", *(f"{motion}: stopped of" for motion in MOTIONS), "false stops", "missed faults")
    for is_sound, title in ((True, "Sound scenes"), (False, "Scenes with a fault")):
        body = []
        own = [each for each in found if each.is_sound == is_sound]
        for kind in dict.fromkeys(each.kind for each in own):
            rows = [each for each in own if each.kind == kind]
            cells = [_share([each for each in rows if each.motion == motion]) for motion in MOTIONS]
            body.append((kind, *cells, *_counts(rows)))
        cells = [_share([each for each in own if each.motion == motion]) for motion in MOTIONS]
        body.append((f"**all {len(own)}**", *cells, *_counts(own)))
        lines += ["", f"## {title}", "", table(head, body).rstrip()]
    rest = [each for each in found if each.is_false_stop or each.is_missed]
    if rest:
        lines += ["", "## The remainder", ""]
        for each in rest:
            text = f"{each.kind}, {each.motion}, {each.method}, seed {each.seed}: "
            text += each.message or f"energy apart by {100 * each.apart:.0f} % of the largest exchange"
            lines += wrap(f"- {text}", 118, subsequent_indent="  ", break_long_words=False, break_on_hyphens=False)
    return "\n".join(lines) + "\n"


def _share(rows: list[Verdict]) -> str:
    return f"{sum(each.is_stopped for each in rows)} of {len(rows)}"


def _counts(rows: list[Verdict]) -> tuple[str, str]:
    return str(sum(each.is_false_stop for each in rows)), str(sum(each.is_missed for each in rows))


if __name__ == "__main__":
    Path(__file__).parents[1].joinpath("docs", "rigid_motions.md").write_text(page(verdicts()), encoding="utf-8")
