"""The sail of IKAROS with devices that curl it, for docs/ikaros_devices.md: how far it bows in sunlight, at the slowest
spin and at others, and what its tethers hold.

Finished runs are kept in the folder `out` and read again; remove it to repeat them, which takes half an hour on two
cores. With `--write` the tables and the picture of docs/ikaros_devices.md are replaced.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

import numpy as np
from ikaros_devices_picture import draw
from ikaros_devices_runs import (
    RPM,
    areal_mass,
    at_spin,
    light_on,
    number,
    on_mesh,
    own,
    places,
    pull_of_quarter,
    rested,
    stiffened,
    with_modulus,
    without_devices,
)
from ikaros_runs import sail_of
from marked import DOCS, MarkedPart
from membrane_rs import Scene
from membrane_rs._arrays import Floats
from membrane_rs._markdown import table
from page_of_runs import Runs, make_page

NAMES = ("scales", "meshes", "values", "spins")
PARTS = {name: MarkedPart(DOCS / "ikaros_devices.md", f"ikaros-devices-{name}") for name in NAMES}
FILM, DEVICES, ALONG = "film alone", "devices", "2 1/m along the strips"
CURVATURE, CELL = "parts.devices.curvature", 5e-6
"""The curvature of devices by its place in a scene; bending stiffness of a solar cell by itself [N m]."""
SPINS = ((0.4, 3.2e7), (2.5, 3.2e8))
"""Spins [rpm], and the Young's modulus of film and tethers at each [Pa]."""
Run = Mapping[str, Floats]
Pairs = dict[str, tuple[Scene, Run]]


class Sails(Runs):
    """Sails at rest, each with its scene."""

    def at_rest(self, scenes: Mapping[str, Scene]) -> Pairs:
        """The runs of scenes."""
        found = self.of({name: partial(rested, scene) for name, scene in scenes.items()})
        return {name: (scenes[name], found[name]) for name in scenes}


def meshes() -> dict[str, Scene]:
    """The film alone and with devices, on two meshes."""
    made: dict[str, Scene] = {}
    for mesh in ("coarse", "as it is"):
        scene = on_mesh(own(), mesh)
        made |= {f"{FILM}, {mesh}": without_devices(scene), f"{DEVICES}, {mesh}": scene}
    return made


def values() -> dict[str, Scene]:
    """The coarse mesh with other values."""
    scene = on_mesh(own(), "coarse")
    curved = {f"{across:g} 1/m": (across, 0.0) for across in (0.0, 0.5, 4.0)}
    made = {f"{FILM}, coarse": without_devices(scene), f"{DEVICES}, coarse": scene}
    made |= {name: scene.with_values({CURVATURE: pair}) for name, pair in curved.items()}
    half = [(1.9, -0.95), (7.0, -3.5), (7.0, 3.5), (1.9, 0.95)]
    return made | {
        "a cell by itself": stiffened(scene, CELL),
        "half of each strip": scene.with_values({"parts.devices.polygon": half}),
        "film ten times as stiff": with_modulus(scene, 3.2e7),
    }


def spins() -> dict[str, Scene]:
    """The coarse mesh at other spins, with and without devices."""
    scene = on_mesh(own(), "coarse")
    made: dict[str, Scene] = {}
    for rpm, modulus in SPINS:
        turning = at_spin(scene, rpm, modulus)
        made |= {f"{FILM}, {rpm:g} rpm": without_devices(turning), f"{DEVICES}, {rpm:g} rpm": turning}
    made[f"{ALONG}, {rpm:g} rpm"] = turning.with_values({CURVATURE: (0.0, 2.0)})
    return made


def scale_table() -> str:
    """Tension of the film by its spin, the length over which it flattens a device, and what a corner would hold."""
    scene = own()
    half = 0.5 * sail_of(scene).outer_width
    stiffness, light = number(scene, "parts.devices.bending_stiffness"), light_on(scene)
    rows = []
    for rpm in (RPM, *(spin for spin, _ in SPINS)):
        rate = math.tau * rpm / 60.0
        tension = 0.5 * areal_mass(scene) * (rate * half) ** 2
        flattened, pull = math.sqrt(stiffness / tension), pull_of_quarter(scene, rate)
        rows.append((f"{rpm:g}", f"{tension:.2g}", f"{flattened:.3f}", f"{1e3 * pull:.3g}", f"{0.25e3 * light:.2g}"))
    heads = (
        "spin [rpm]", "tension of the film, rho h (Omega R)^2 / 2 [N/m]", "(D/T)^(1/2) [m]",
        "pull of a quarter of the sail [mN]", "light on a quarter [mN]",
    )  # fmt: skip
    return table(heads, rows)


def rest_table(runs: Pairs) -> str:
    """Where places of the sail rest along the axis, away from the sun, and what its tethers hold."""
    rows = []
    for name, (scene, run) in runs.items():
        depth = -run["positions"][:, 2]
        at = [f"{depth[nodes].mean():.3f}" for nodes in places(scene).values()]
        tension = f"{1e3 * run['tensions'].mean():.2f}"
        rows.append((name, f"{run['nodes'][0]:,.0f}", *at, f"{depth.std():.3f}", f"{-run['drift'][0]:.3f}", tension))
    heads = (
        "run", "nodes", *(f"{name} [m]" for name in places(next(iter(runs.values()))[0])), "spread [m]",
        "last tenth of the run [m]", "tension of a tether [mN]",
    )  # fmt: skip
    return table(heads, rows, words=(0,))


def scales_part(_: Sails, __: Path) -> str:
    """What is to be expected."""
    return scale_table()


def meshes_part(runs: Sails, picture: Path) -> str:
    """The film alone and with devices, on two meshes, and both shapes."""
    found = runs.at_rest(meshes())
    draw({name: found[f"{name}, as it is"] for name in (FILM, DEVICES)}, picture)
    return rest_table(found)


def values_part(runs: Sails, _: Path) -> str:
    """The coarse mesh with other values."""
    return rest_table(runs.at_rest(values()))


def spins_part(runs: Sails, _: Path) -> str:
    """Other spins."""
    return rest_table(runs.at_rest(spins()))


MAKERS: dict[str, Callable[[Sails, Path], str]] = {
    "scales": scales_part, "meshes": meshes_part, "values": values_part, "spins": spins_part,
}  # fmt: skip

if __name__ == "__main__":
    np.seterr(all="raise")
    make_page("ikaros-devices", __doc__, runs_in=Sails, parts=PARTS, makers=MAKERS, write_shapes=lambda _: None)
