"""Masses at nodes, such as the tips of a sail."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Annotated, ClassVar

import numpy as np

from membrane_rs._validation import Nodes, Positive, Unit, validated
from membrane_rs.scene.builder import Builder
from membrane_rs.scene.law import Surroundings
from membrane_rs.scene.part import Part
from membrane_rs.scene.plausible import FILM, Doubt, implausible
from membrane_rs.scene.scales import film_mass

HEAVY_TIP, HEAVIEST_TIP = 100.0, 100.0
"""Mass at a tip over that of the whole film [-], and by itself [kg], from which it is hardly meant: in the deployment
experiments it is a sixth of the film, and 0.5 kg on the sail of 14 m that has flown."""
LIGHT_TIP = 1e-6
"""Mass of all tips over that of the film or the cord, below which it has no effect [-]."""


@validated
class TipMasses(Part):
    """The same mass added to each of some nodes.

    Parameters
    ----------
    mass : float
        For each node [kg], above 0.
    nodes : str or sequence of int
        A node set, or node indices.

    Raises
    ------
    InputError, InputTypeError
        A value outside its range, or of a wrong type.

    Examples
    --------
    >>> from membrane_rs import TipMasses
    >>> TipMasses(mass=0.36e-3).nodes
    'corners'
    """

    kind: ClassVar[str] = "tip_masses"
    mass: Annotated[Positive, Unit("kg")]
    nodes: Nodes = "corners"

    def add_loads(self, builder: Builder, where: str) -> None:
        """Add the masses. Raises SceneError for nodes that are not there."""
        builder.add_mass(builder.nodes(self.nodes, where), self.mass)

    def implausible_values(self, scene: Surroundings, where: str) -> Iterator[Doubt]:
        """Each is lighter than `HEAVY_TIP` times the film, which else would be a thread without mass; together they
        weigh more than `LIGHT_TIP` of it, below which they have no effect.
        """
        count = max(1, count_of(self.nodes, scene))
        yield from implausible_tip(f"{where}.mass", self.mass, scene, LIGHT_TIP * film_mass(scene) / count)

    def resized(self, sizes: Mapping[str, tuple[int, int]]) -> TipMasses:
        """Masses on a node set keep their sum."""
        before, now = sizes.get(self.nodes, (1, 1)) if isinstance(self.nodes, str) else (1, 1)
        return replace(self, mass=self.mass * before / now) if before != now else self


def count_of(nodes: str | Sequence[int], scene: Surroundings) -> int:
    """Of a node set, or of node indices."""
    return int(np.size(scene.assemble().node_sets[nodes] if isinstance(nodes, str) else nodes))


def implausible_tip(place: str, mass: float, scene: Surroundings, least: float) -> Iterator[Doubt]:
    """A mass [kg] at a tip that is hardly meant; one of less than `least` has no effect."""
    reason, most, film = f"a mass at a tip is lighter than {HEAVIEST_TIP:g} kg", HEAVIEST_TIP, film_mass(scene)
    if film > 0.0:
        reason, most = f"that is {mass / film:.3g} times the mass of the film, {film:.3g} kg", HEAVY_TIP * film
    if mass < least:
        reason = f"what it hangs on is more than {1.0 / LIGHT_TIP:.0e} times as heavy, so that it has no effect"
    units = {"g": 1e-3, "mg": 1e-6}
    yield from implausible(place, mass, "kg", reason, least=least, most=most, units=units, derived_from=FILM)
