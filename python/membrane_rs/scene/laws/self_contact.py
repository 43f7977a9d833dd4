"""Contact between layers of the film, and between cords and film."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict
from typing import Annotated, Any, ClassVar

import numpy as np

from membrane_rs._validation import Count, Flag, Fraction, NodeSets, NonNegative, Positive, Unit, show, validated
from membrane_rs.scene.builder import Builder
from membrane_rs.scene.law import Law, Surroundings
from membrane_rs.scene.plausible import FILM, Doubt, implausible

THINNEST, THICKEST = 0.1, 1000.0
"""Distance at which layers touch over the thickness of the film, beyond which it is hardly meant: wrinkles of a real
film keep its layers further apart than its thickness."""
ROUGHEST = 10.0
"""Coefficient of friction beyond which it is hardly meant."""
_OF_PYTHON = ("only", "without")
"""Fields from which the triangles follow that the core is given."""


@validated
class SelfContact(Law):
    """Layers of the film that cannot pass through each other, nor cords through the film.

    Nodes near triangles and edges near edges exchange impulses, along the normal between them and by Coulomb's law
    across it, in each kick of "leapfrog": it goes with that method alone, and not with a free hub. Layers touch at a
    distance of their mid-surfaces, and may come as near as half of that, or of what they were apart at most, at the
    start and in some shapes since, where that was less. Stages and simulations that start from another one keep these
    distances. A start with crossings is refused, and a run is stopped where layers pass through each other, or approach
    by more than 16 thicknesses in a step. The law does not act while a scene is relaxed before its start.

    Parameters
    ----------
    thickness : float or None
        Distance of the mid-surfaces of two layers at which they touch [m], above 0. None: the thickness of the film.
    cord_thickness : float
        Diameter of the cords [m], 0 or above: cord and film touch at half of the sum of both. 0: a line.
    cords : bool
        Whether cords and film feel each other.
    friction : float
        Coulomb's coefficient [-], 0 or above.
    restitution : float
        Speed of separation over that of approach [-], from 0 to 1. 0: inelastic.
    crossing_interval : int
        Steps between two exact counts of crossings, of which any stops a run; 1 or above. Layers that approach by more
        than a thickness in a step are counted sixteen steps later at the latest.
    only : str, sequence of str or sequence of int, or None
        The name of a node set, names of several, or node indices: only triangles whose nodes all belong to one of these
        sets feel each other and the cords. None: all.
    without : str, sequence of str or sequence of int, or None
        The same of triangles that are left out, of those of `only` where both are given. None: none.

    Raises
    ------
    InputError, InputTypeError
        A value outside its range, or of a wrong type.

    Examples
    --------
    >>> from membrane_rs import SelfContact
    >>> SelfContact(friction=0.3, without="on_hub").friction
    0.3
    """

    kind: ClassVar[str] = "self_contact"
    methods: ClassVar[tuple[str, ...] | None] = ("leapfrog",)
    goes_with_free_hub: ClassVar[bool] = False
    acts_while_relaxing: ClassVar[bool] = False
    thickness: Annotated[Positive | None, Unit("m")] = None
    cord_thickness: Annotated[NonNegative, Unit("m")] = 0.0
    cords: Flag = True
    friction: NonNegative = 0.0
    restitution: Fraction = 0.0
    crossing_interval: Count = 1000
    only: NodeSets | None = None
    without: NodeSets | None = None

    def core_parameters(self) -> dict[str, Any]:
        """All but the node sets, from which the triangles of the model follow."""
        return {name: value for name, value in asdict(self).items() if name not in _OF_PYTHON}

    @property
    def numbering_field(self) -> str | None:
        """Of the two choices of triangles the first that holds node indices."""
        for name in _OF_PYTHON:
            wanted = getattr(self, name)
            if wanted is not None and not isinstance(wanted, str) and not isinstance(wanted[0], str):
                return name
        return None

    def add_contacts(self, builder: Builder) -> None:
        """The triangles of its choice. Raises SceneError for node sets and nodes that are not there."""
        where = f"laws.{self.kind}"
        found = np.arange(0 if builder.mesh is None else len(builder.mesh.triangles))
        if self.only is not None:
            found = builder.triangles(self.only, where, "only")
        if self.without is not None:
            found = np.setdiff1d(found, builder.triangles(self.without, where, "without"))
        builder.add_layers(found)

    def implausible_values(self, scene: Surroundings, where: str) -> Iterator[Doubt]:
        """Layers touch at a distance near the thickness of the film, and nearer than its edges are long; a cord is
        thinner than its segments are long; no film is rougher than `ROUGHEST`.
        """
        units = {"mm": 1e-3, "um": 1e-6}
        if self.thickness is not None and scene.mesh is not None and scene.material is not None:
            film, edge = scene.material.thickness, float(scene.mesh.edge_lengths.min())
            reason = f"the film is {film:.4g} m thick, and its shortest edge {edge:.4g} m long"
            bounds = {"least": THINNEST * film, "most": max(film, min(THICKEST * film, edge))}
            place = f"{where}.thickness"
            yield from implausible(place, self.thickness, "m", reason, **bounds, units=units, derived_from=FILM)
        lengths = scene.assemble().cords.rest_length
        if self.cords and len(lengths):
            longest = float(lengths.max())
            reason = f"the segments of the cords are no longer than {longest:.4g} m"
            place, derived = f"{where}.cord_thickness", ("mesh", "parts")
            yield from implausible(
                place, self.cord_thickness, "m", reason, most=longest, units=units, derived_from=derived
            )
        reason = f"more than {ROUGHEST:g} is hardly met: rubber on rubber has about 1"
        yield from implausible(f"{where}.friction", self.friction, "", reason, most=ROUGHEST)

    def why_idle(self, scene: Surroundings) -> str | None:
        """Without triangles, or with a single one and no cord that meets it."""
        if scene.mesh is None or not len(scene.mesh.triangles):
            return "there is no film"
        assembly = scene.assemble()
        chosen = ", ".join(f"{name} = {show(getattr(self, name))}" for name in _OF_PYTHON if getattr(self, name))
        if not len(assembly.layers):
            return f"no triangle belongs to it, with {chosen}"
        is_alone = len(assembly.layers) == 1 and not (self.cords and len(assembly.cords))
        return "a single triangle has nothing to meet" if is_alone else None
