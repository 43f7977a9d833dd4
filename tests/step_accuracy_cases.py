"""The error of the default step, on the built-in scenes and on random ones, and what `check` says of it.

`python tests/step_accuracy_cases.py` writes docs/step_accuracy.md; it takes some minutes. With `--list` it only names
the scenes.
"""

from __future__ import annotations

import argparse
import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from membrane_rs import (
    Creases,
    Fixed,
    Gravity,
    RunSettings,
    Scene,
    Simulation,
    Spin,
    SpringDamping,
    Springs,
    Tether,
    UnstableError,
    scenes,
)
from membrane_rs._arrays import Floats
from membrane_rs._markdown import table
from membrane_rs.check.step_accuracy import ALLOWED, WORK, step_accuracy
from membrane_rs.folding import Disc, Strip
from membrane_rs.scene.laws import Law
from membrane_rs.scene.parts import Part
from membrane_rs.simulation import integrators
from small_scenes import FILM, RUBBER

SEEDS = range(20)
INSTANTS = 200
"""Times at which positions are compared, as many as `check` takes: fewer miss the extent of a vibration."""
REFERENCE_SHARE = 16.0
"""The step of the reference, rk4, is the default one over this."""
CHAOTIC = ("okuizumi", "hexagon")
"""Names of the sails begin so."""
SAIL_UNTIL = 0.004
"""Time up to which the chaotic sails are compared [s]."""
UNCHECKED = 10**9
"""Steps between two checks of a run that is never checked."""
SHIFT = 1e-12
"""Random displacement of the second start of a sail [m]."""


def random_scene(seed: int) -> Scene:
    """A tether, a strip, a disc or a crease of random size, stiffness, damping, spin and gravity."""
    dice = np.random.default_rng(seed)

    def between(low: float, high: float) -> float:
        return float(np.exp(dice.uniform(math.log(low), math.log(high))))

    kind = ("tether", "strip", "disc", "crease")[seed % 4]
    spin = between(0.1, 1000.0) if kind == "tether" else between(0.1, 10.0)
    gravity = (0.0, 0.0, -9.81) if dice.random() < 0.5 else (0.0, 0.0, 0.0)
    laws: list[Law] = [Spin(spin), Gravity(gravity), SpringDamping(float(dice.uniform(0.0, 0.1)))]
    parts: list[Part] = []
    mesh, material = None, None
    turns = dice.uniform(1.0, 30.0)
    springs = Springs(buckling=1.0, buckling_on_creases=1.0, strain_limit=1e9)
    if kind == "tether":
        angle = dice.uniform(0.0, 0.3)
        end = (0.1 + 0.3 * math.cos(angle), 0.3 * math.sin(angle), 0.0)
        stiffness, mass = between(20.0, 2000.0), between(1e-3, 5e-2)
        count = int(dice.integers(1, 9))
        parts = [Tether((0.1, 0.0, 0.0), end, count, stiffness, 1e-3, tip_mass=mass, strain_limit=1e9)]
    elif kind == "strip":
        mesh, material = Strip(0.2, 0.05, int(dice.integers(2, 9)), 2).mesh(), RUBBER
        laws, parts = [*laws, springs], [Fixed(nodes="start")]
    elif kind == "disc":
        mesh, material = Disc(0.1, rings=int(dice.integers(1, 6))).mesh(), RUBBER
        laws = [*laws, springs]
    else:
        mesh = Strip(0.04, 0.02, 2, 2, creases=(0.5,), fold_angle=float(dice.uniform(0.5, 2.8))).mesh()
        material = FILM
        laws = [*laws, springs, Creases(stiffness=between(1.0, 30.0), natural_angle=math.pi)]
        parts = [Fixed(nodes="start")]
    until = min(turns / spin, 0.3 if kind == "crease" else 2.0)
    name = f"{kind} {seed}: {spin:.3g} Hz{', gravity' if gravity[2] else ''}"
    run = RunSettings(until=float(f"{until:.3g}"), snapshots=(), energy_loss=0.5)
    return Scene(mesh, material, laws, parts, name=name, run=run)


def fast_tether() -> Scene:
    """The built-in tether at 1000 Hz, its cord as long as it gets."""
    scene = scenes.load("spinning-tether")
    laws = [Spin(1000.0) if law.kind == "spin" else law for law in scene.laws]
    parts = [replace(part, strain_limit=1e9) for part in scene.parts]  # type: ignore[call-arg]
    return replace(scene, laws=laws, parts=parts, name="spinning-tether at 1000 Hz")


def short_tether() -> Scene:
    """One segment that its spin stretches."""
    tether = Tether((0.1, 0.0, 0.0), (0.4, 0.0, 0.0), 1, 50.0, 0.0, tip_mass=0.01)
    run = RunSettings(until=1.0, snapshots=())
    return Scene(None, None, [Spin(1.0), SpringDamping(0.02)], [tether], name="tether of one segment", run=run)


@dataclass(frozen=True)
class Shapes:
    """Positions at instants: (k, N, 3) [m]."""

    positions: Floats

    def distance(self, other: Shapes) -> float:
        """The largest distance of any node at any instant [m]."""
        return float(np.linalg.norm(self.positions - other.positions, axis=2).max())

    def extent(self) -> float:
        """The largest distance of any node from its start [m]."""
        return float(np.linalg.norm(self.positions - self.positions[0], axis=2).max())


def shapes(scene: Scene, method: str, dt: float | None = None, shift: float = 0.0) -> Shapes:
    """A run, at evenly spaced instants. Raises UnstableError."""
    sim = Simulation(scene, method, dt)
    if shift:
        moved = np.random.default_rng(0).normal(0.0, shift, (sim.node_count, 3))
        moved[sim.assembly.fixed] = 0.0
        sim.positions = sim.positions + moved
    kept = [sim.positions]
    for instant in np.linspace(0.0, scene.run.until, INSTANTS + 1)[1:].tolist():
        sim.reach(instant)
        kept.append(sim.positions)
    if scene.run.watch < UNCHECKED:
        sim._core.check(True)
    return Shapes(np.array(kept))


def reference(scene: Scene) -> Shapes:
    """A run by tiny steps, without monitor."""
    free = replace(scene, run=replace(scene.run, energy_loss=1e9, watch=UNCHECKED))
    return shapes(free, "rk4", Simulation(scene, "rk4").dt / REFERENCE_SHARE)


def row(scene: Scene, method: str, true: Shapes, work: float = 2.5 * WORK) -> tuple[str, float, str]:
    """Step, error as a share of the motion (NaN for a run that stops), and the first words of the warning."""
    own = replace(scene, run=replace(scene.run, integrator=method, dt=None))
    warning = step_accuracy(own, work=work).warning() or ""
    try:
        error = shapes(own, method).distance(true) / true.extent()
    except UnstableError:
        error = math.nan
    sim = Simulation(own)
    return ("by tolerance" if sim.is_adaptive else f"{sim.dt:.3g}"), error, warning


def said(warning: str) -> str:
    """A warning in a word."""
    known = {"is wrong by": "wrong", "stops by itself": "stops", "too long": "not known to the end"}
    return next((short for words, short in known.items() if words in warning), "")


def rows_of(scene: Scene, spread: str) -> list[list[str]]:
    """The rows of a scene, by method."""
    true = reference(scene)
    found = []
    for method in integrators():
        step, error, warning = row(scene, method, true)
        if not (error <= ALLOWED or warning or spread):
            raise SystemExit(f"{scene.name}, {method}: an error of {100 * error:.2g} % without a warning")
        percent = "stops" if math.isnan(error) else f"{100 * error:.2g}"
        found.append([scene.name, method, step, f"{scene.run.until:g}", percent, spread, said(warning)])
    return found


def all_scenes() -> list[Scene]:
    """Those of the page: the built-in ones that each method can run by a default step, and others."""
    built_in = map(scenes.load, scenes.for_any_method())
    return [*built_in, fast_tether(), short_tether(), *map(random_scene, SEEDS)]


def page() -> str:
    """docs/step_accuracy.md."""
    rows: list[list[str]] = []
    for scene in all_scenes():
        spread = ""
        bare = replace(scene, run=replace(scene.run, relax=0.0, snapshots=()))
        if scene.name.startswith(CHAOTIC):
            bare = replace(bare, run=replace(bare.run, until=SAIL_UNTIL))
            both = [shapes(bare, "leapfrog", shift=shift) for shift in (0.0, SHIFT)]
            spread = f"{100 * both[0].distance(both[1]) / both[0].extent():.2g}"
        rows += rows_of(bare, spread)
        print(rows[-1][0], [line[4] for line in rows[-4:]], [line[6] for line in rows[-4:]], flush=True)  # noqa: T201
    heads = ["scene", "method", "step [s]", "until [s]", "error [%]", "spread [%]", "`check`"]
    return f"""# The error of the default step

The largest distance of any node from where it should be, at any of {INSTANTS} instants, as a share of the extent of the
motion (the largest distance of any node from its start). The reference is rk4 with a {REFERENCE_SHARE:g}th of its
default step. A default step is right to {100 * ALLOWED:g} % of the motion, or `membrane-rs check` warns (last column):
it runs the scene with the step and with half of it, to the end or as long as it has time. The sails are chaotic: they
are compared over {1e3 * SAIL_UNTIL:g} ms and against the spread of two starts that differ by {SHIFT:g} m, and `check`
says that it knows their error up to a part of the run only. Twenty scenes are random. This page is written by
`python tests/step_accuracy_cases.py`.

{table(heads, rows)}
"""


def main() -> None:
    """Write the page, or name its scenes."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--list", action="store_true", help="name the scenes, without a run")
    if parser.parse_args().list:
        print("\n".join(scene.name for scene in all_scenes()))  # noqa: T201
        return
    Path(__file__).parent.parent.joinpath("docs", "step_accuracy.md").write_text(page(), encoding="utf-8")


if __name__ == "__main__":
    main()
