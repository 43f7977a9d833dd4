"""A flat elastic membrane that spins freely: what every program is given, and the measure of its error.

The membrane turns as a rigid body at the start, unstretched, in an inertial frame, with nothing around it. It
widens, rings in its own plane and turns on: no creases, no buckling, no contact, no damping, no air. The start is
free of elastic force.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from membrane_rs import Material, Mesh, Scene, TipMasses, scenes
from membrane_rs.scene.laws import Law, Springs, Triangles
from membrane_rs.scene.run_settings import RunSettings
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

NO_STOP = 1e9
"""Share of the energy that may be lost without stopping a run: the other programs do not stop theirs either."""
NO_BUCKLING = 1e9
"""alpha with which no spring of these meshes buckles, however short it gets."""


@dataclass(frozen=True)
class Problem:
    """The simulated problem.

    Attributes
    ----------
    name : str
        For tables.
    mesh : Mesh
        n flat nodes at z = 0 with the node set "corners"; m triangles.
    material : Material
        The film's.
    tip_mass : float
        On each corner [kg].
    spin : float
        Rate about z at the start [rad/s].
    until, instants : float, int
        End [s], and at how many equal intervals positions are compared.
    """

    name: str
    mesh: Mesh
    material: Material
    tip_mass: float
    spin: float
    until: float
    instants: int

    @property
    def interval(self) -> float:
        """Between two instants [s]."""
        return self.until / self.instants

    @cached_property
    def masses(self) -> Floats:
        """(n,) of the nodes, tips included [kg]."""
        masses = np.array(self.mesh.masses(self.material))
        masses[self.mesh.node_sets["corners"]] += self.tip_mass
        return masses

    @cached_property
    def velocities(self) -> Floats:
        """(n, 3) at the start [m/s]."""
        return np.cross([0.0, 0.0, self.spin], self.mesh.reference)

    def kinetic_energy(self, velocities: Floats) -> float:
        """Of all nodes [J]."""
        return 0.5 * float(self.masses @ (velocities**2).sum(axis=1))

    def scene(self, law: str) -> Scene:
        """The scene of membrane_rs: "triangles" (a plate that does not wrinkle) or "springs" (that do not buckle)."""
        film: Law = (
            Triangles(compression=1.0, strain_limit=1.0)
            if law == "triangles"
            else Springs(buckling=NO_BUCKLING, buckling_on_creases=NO_BUCKLING, strain_limit=1.0)
        )
        run = RunSettings(energy_loss=NO_STOP)
        return Scene(self.mesh, self.material, laws=[film], parts=[TipMasses(self.tip_mass, "corners")], run=run)

    def turned(self, time: float) -> Floats:
        """(n, 3) the nodes turned as a rigid body at the rate of the start [m]."""
        c, s = math.cos(self.spin * time), math.sin(self.spin * time)
        turn: Floats = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
        turned: Floats = self.mesh.reference @ turn
        return turned

    @cached_property
    def rigid(self) -> Floats:
        """(instants, n, 3) what a rigid membrane would do [m]."""
        return np.stack([self.turned((k + 1) * self.interval) for k in range(self.instants)])

    def error(self, shapes: Floats, reference: Floats) -> float:
        """RMS over nodes and instants of the distance between two motions (instants, n, 3), over the RMS of what
        the reference moves beyond the rigid rotation: 1 is as wrong as no elasticity at all.
        """
        return float(np.sqrt(np.mean((shapes - reference) ** 2) / np.mean((reference - self.rigid) ** 2)))

    def corner_peak(self, shapes: Floats) -> tuple[float, float]:
        """Largest stretch [-] of the corners' mean radius during the first swing, and its time [s].

        By the parabola through the first maximum and the instants beside it; NaN where there is none.
        """
        corners = self.mesh.node_sets["corners"]
        flat = np.linalg.norm(self.mesh.reference[corners], axis=1).mean()
        stretch = np.linalg.norm(shapes[:, corners], axis=2).mean(axis=1) / flat - 1.0
        peaks = np.flatnonzero((stretch[1:-1] > stretch[:-2]) & (stretch[1:-1] >= stretch[2:])) + 1
        if not len(peaks):
            return math.nan, math.nan
        before, top, after = stretch[peaks[0] - 1 : peaks[0] + 2]
        shift = 0.5 * (before - after) / (before - 2.0 * top + after)
        return float(top - 0.25 * (before - after) * shift), float((peaks[0] + 1 + shift) * self.interval)


def square(cells: int = 32) -> Problem:
    """The square of the diagram: soft rubber, so that single precision can see the stretch, with tip masses."""
    return Problem(
        name=f"square of {cells + 1} x {cells + 1} nodes",
        mesh=_square_mesh(0.2, cells),
        material=Material(youngs_modulus=1e6, poisson_ratio=1 / 3, density=1000.0, thickness=2e-4),
        tip_mass=1e-4,
        spin=2 * math.pi * 5.0,
        until=0.04,
        instants=40,
    )


def sail() -> Problem:
    """Model 1's membrane laid flat, its petals joined, in its own film, at its own rate and with its tip masses."""
    scene = scenes.load("okuizumi-model-1")
    mesh, tips, spin = scene.mesh, next(part for part in scene.parts if isinstance(part, TipMasses)), scene.law("spin")
    if mesh is None or scene.material is None or spin is None:
        raise RuntimeError("okuizumi-model-1 has no mesh, material or spin: the comparison needs all three")
    flat = Mesh(mesh.reference, mesh.triangles, node_sets={"corners": mesh.node_sets["corners"]})
    rate = 2 * math.pi * float(getattr(spin, "frequency"))  # noqa: B009
    return Problem("flat sail of model 1", flat, scene.material, tips.mass, rate, until=0.8, instants=1)


def _square_mesh(side: float, cells: int) -> Mesh:
    """Square cells with diagonals that alternate; node sets "corners" and "edge-middles"."""
    count = cells + 1
    at = np.linspace(-side / 2, side / 2, count)
    index = np.arange(count * count).reshape(count, count)
    a, b, c, d = index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]
    odd = (np.add.outer(np.arange(cells), np.arange(cells)) % 2 == 1)[..., None]
    first = np.where(odd, np.stack([a, b, d], -1), np.stack([a, b, c], -1))
    second = np.where(odd, np.stack([d, b, c], -1), np.stack([a, c, d], -1))
    triangles = np.stack([first, second], axis=2).reshape(-1, 3)
    x, y = np.meshgrid(at, at, indexing="ij")
    corners = index[[0, -1, -1, 0], [0, 0, -1, -1]]
    return Mesh(np.stack([x, y, 0.0 * x], -1).reshape(-1, 3), triangles, node_sets={"corners": corners})
