"""Hashes of motions: whether a change of the program has changed a bit of what it computes.

python tests/golden.py            # compares with tests/golden.json
python tests/golden.py --write    # makes that file anew; say in the commit what has changed the bits

Every built-in scene without stages, by every method, or by its own where it gives its step, and at every width of
vector instructions (of those that this machine lacks, the next narrower), some hundred steps from its start; 20 ms of
the deployment of model 1 with all that a run looks at, and its start with a film of rectangles; bars that press into
the wound sail as they turn; a strip of which one end is moved; and one in flight on a hub in six degrees of freedom,
under every load.
Initial positions are rounded, those of the mesh and of wound cords, for numpy's trigonometric functions differ in the
last bit from processor to processor; what the core does with them does not.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from membrane_rs import (
    AirDrag,
    Fixed,
    Gravity,
    MassDamping,
    Material,
    Mesh,
    Moved,
    PointForces,
    Pressure,
    Rectangles,
    Scene,
    Schedule,
    Simulation,
    SolarPressure,
    Spin,
    SpringDamping,
    Springs,
    Tether,
    _core,
    integrators,
    scenes,
)
from membrane_rs.folding import Strip

FILE = Path(__file__).with_name("golden.json")
WIDTHS = ("baseline", "avx2", "avx512")
STEPS = {"generalized_alpha": 12}
"""Implicit steps are long and dear; other methods take `MOST`."""
MOST = 300
METHODS: dict[str, dict[str, Any]] = {name: {} for name in integrators()} | {"leapfrog-4": {"substeps": 4}}
"""Name here, and what it changes in the settings of the run."""
GRAIN = 2.0**-36
"""Positions are rounded to multiples of this [m]."""


def rounded(scene: Scene) -> Scene:
    """The scene with its mesh's coordinates rounded."""
    mesh = scene.mesh
    if mesh is None:
        return scene
    reference, positions = (np.round(np.asarray(a) / GRAIN) * GRAIN for a in (mesh.reference, mesh.positions))
    return replace(
        scene,
        mesh=Mesh(
            reference,
            mesh.triangles,
            positions=positions,
            creases=mesh.creases,
            fold_angles=mesh.fold_angles,
            node_sets=mesh.node_sets,
            bridges=mesh.bridges,
        ),
    )


def digest(*values: Any) -> str:
    """A short hash of arrays of numbers, to the last bit."""
    found = hashlib.sha256()
    for value in values:
        found.update(np.ascontiguousarray(value, np.float64).tobytes())
    return found.hexdigest()[:16]


def hashes(sim: Simulation) -> dict[str, str]:
    """Of the state and of the energy balance."""
    ledger = sim.ledger()
    by_law = [ledger[name][law] for name in ("stored_by_law", "work_by_law") for law in sorted(ledger[name])]
    balance = [ledger[name] for name in ("kinetic", "stored", "work", "error")]
    return {
        "positions": digest(sim.positions),
        "velocities": digest(sim.velocities),
        "ledger": digest(balance, by_law),
        "step": digest(sim.dt, sim.time),
    }


def simulation(scene: Scene, method: str, width: str) -> Simulation:
    """A simulation at a width of vector instructions."""
    plain = _core.Simulation
    _core.Simulation = partial(plain, instructions=width)  # type: ignore[assignment,misc]
    try:
        return Simulation(replace(scene, run=replace(scene.run, **METHODS[method])), method.partition("-")[0])
    finally:
        _core.Simulation = plain  # type: ignore[misc]


def cases() -> Iterator[tuple[str, Callable[[str], dict[str, str]]]]:
    """The name of each case, and what gives its hashes at a width."""
    by_any_method = scenes.for_any_method()
    for name in scenes.names():
        scene = scenes.load(name)
        if scene.stages:
            continue
        scene = rounded(scene)
        for method in METHODS if name in by_any_method else (scene.run.integrator,):
            yield f"{name}, {method}", partial(_stepped, scene, method)
    yield "okuizumi-model-1, 20 ms", partial(_deployed, rounded(scenes.load("okuizumi-model-1")))
    yield "okuizumi-model-1 of rectangles, leapfrog", partial(_stepped, rounded(_of_rectangles()), "leapfrog")
    yield "okuizumi-whole, bars pressed in, leapfrog", partial(_stepped, rounded(_pressed()), "leapfrog")
    for method in METHODS:
        yield f"moved strip, {method}", partial(_stepped, rounded(_moved()), method)
    for method in ("rk4", "leapfrog"):
        yield f"strip in flight, {method}", partial(_stepped, rounded(_in_flight()), method)


def _moved() -> Scene:
    """A strip of film in a turning frame, one end of which is moved; it bears gravity, and mass damping."""
    prescribed = Moved("start", x=Schedule((0.0, 0.01), (0.0, 1e-3), 0.3))
    laws = [Springs(), SpringDamping(0.01), Spin(frequency=3.0), Gravity((0.0, 0.0, -1.0)), MassDamping(5.0)]
    film = Material(youngs_modulus=3.2e9, poisson_ratio=0.34, density=1420.0, thickness=7.5e-6)
    return Scene(Strip(0.05, 0.02, 5, 2, (0.4,), 0.6).mesh(), film, laws, [prescribed])


def _in_flight() -> Scene:
    """A strip of film held at one end on a hub in six degrees of freedom, with light, air, weight and forces."""
    hub = Spin(frequency=3.0, inertia=1e-5, mass=0.02, transverse_inertia=0.8e-5, tumble=0.2)
    laws = [
        *(Springs(), SpringDamping(0.01), hub, MassDamping(5.0), AirDrag(100.0), Pressure(0.1)),
        *(SolarPressure(0.84, 0.04, sun=(0.6, 0.0, 0.8), distance=1e9), Gravity((1.0, 0.5, -1.0))),
        PointForces("end", (1e-4, 0.0, 2e-4), frame="inertial"),
    ]
    return replace(_moved(), laws=laws, parts=[Fixed("start")])


def _of_rectangles() -> Scene:
    """Model 1 with a film of rectangles."""
    scene = scenes.load("okuizumi-model-1")
    return replace(scene, laws=[Rectangles() if law.is_film else law for law in scene.laws])


def _pressed() -> Scene:
    """The wound sail as its bars begin to turn, nearer to the hub and with friction."""
    scene = scenes.load("okuizumi-whole").staged(1, [0.0, 0.0])
    bodies = [
        replace(body, centre=_nearer(body.centre), friction=0.3) if body.name == "bars" else body
        for body in scene.bodies
    ]
    return replace(scene, bodies=bodies, run=replace(scene.run, substeps=1))


def _nearer(point: tuple[float, float, float]) -> tuple[float, float, float]:
    x, y, z = point
    return 0.96 * x, 0.96 * y, 0.96 * z


def _stepped(scene: Scene, method: str, width: str) -> dict[str, str]:
    sim = simulation(scene, method, width)
    if any(isinstance(part, Tether) and part.wound is not None for part in scene.parts):
        sim.positions = np.round(sim.positions / GRAIN) * GRAIN
    sim.step(STEPS.get(method, MOST))
    return hashes(sim)


def _deployed(scene: Scene, width: str) -> dict[str, str]:
    class Looks:
        """Keeps a hash of all that it sees."""

        def __init__(self) -> None:
            self.seen: list[str] = []

        def start(self, sim: Simulation) -> None:
            self.sample(sim)

        def sample(self, sim: Simulation) -> None:
            self.seen += hashes(sim).values()

        def frame(self, sim: Simulation) -> None:
            self.seen += [digest(sim.spring_strains(), sim.buckled(), sim.crease_angles())]

        def finish(self, sim: Simulation, error: BaseException | None) -> None:
            self.sample(sim)

    sim, looks = simulation(scene, "rk4", width), Looks()
    sim.run(until=0.02, frames=5, samples=21, observers=[looks])
    return {**hashes(sim), "on the way": hashlib.sha256("".join(looks.seen).encode()).hexdigest()[:16]}


def measured(
    widths: Sequence[str] = WIDTHS, *, tell: Callable[[str], None] = lambda _: None
) -> dict[str, dict[str, str]]:
    """The hashes of every case, which are the same at every width, or an error."""
    found: dict[str, dict[str, str]] = {}
    for name, run in cases():
        by_width = {width: run(width) for width in widths}
        first = by_width[widths[0]]
        for width, other in by_width.items():
            if other != first:
                raise SystemExit(f"{name}: {width} differs from {widths[0]}: {other} {first}")
        found[name] = first
        tell(name)
    return found


def differences(found: dict[str, dict[str, str]], known: dict[str, dict[str, str]]) -> list[str]:
    """Cases and quantities whose hashes are not those that are known."""
    return [
        f"{name}: {what}"
        for name in sorted(found.keys() | known.keys())
        for what in sorted(found.get(name, {}).keys() | known.get(name, {}).keys())
        if found.get(name, {}).get(what) != known.get(name, {}).get(what)
    ]


def tell(text: str) -> None:
    """Print a line at once."""
    sys.stdout.write(text + "\n")
    sys.stdout.flush()


def main() -> None:
    """Measure, and compare or write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write", action="store_true", help="make the file anew")
    chosen = parser.parse_args()
    found = measured(tell=tell)
    if chosen.write:
        FILE.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
        return
    apart = differences(found, json.loads(FILE.read_text(encoding="utf-8")))
    tell("\n".join(apart) or f"equal: {len(found)} cases at {', '.join(WIDTHS)}")
    sys.exit(bool(apart))


if __name__ == "__main__":
    main()
