"""Sets of creases: parts that give some creases properties of their own."""

from __future__ import annotations

import math
from dataclasses import field, replace
from typing import Annotated, ClassVar, Literal

import numpy as np
from annotated_types import Ge, Le

from membrane_rs._validation import Finite, NodeSets, NonNegative, Rows, Unit, show, validated
from membrane_rs.errors import InputError, SceneError
from membrane_rs.scene.builder import Builder
from membrane_rs.scene.part import Part
from membrane_rs.scene.selection import has_numbers


@validated
class CreaseSet(Part):
    """Creases with stiffness, contact or natural angle of their own, in place of those of the law `Creases`.

    Parameters
    ----------
    creases : sequence of int, optional
        Rows of `Mesh.creases`. None: all, or those of the nodes.
    nodes : str, sequence of str or sequence of int, optional
        A node set, names of several, or node indices: creases both of whose nodes belong to one of them.
    fold : str, optional
        "valley" or "mountain": those of them alone.
    stiffness : float or None
        beta [-], 0 or above.
    contact_penalty : float or None
        gamma [-], 1 or above.
    natural_angle : float or None
        theta0 [rad], from 0 (shut) over pi (flat) to 2 pi; also in place of a `fold_fraction` of the law.

    Raises
    ------
    InputError, InputTypeError
        A value outside its range, or of a wrong type; creases named in two ways, no property given.

    Examples
    --------
    >>> from membrane_rs import CreaseSet
    >>> CreaseSet(fold="mountain", stiffness=20.0).natural_angle is None
    True
    """

    kind: ClassVar[str] = "crease_set"
    creases: Rows | None = None
    nodes: NodeSets | None = field(default=None, kw_only=True)
    fold: Literal["valley", "mountain"] | None = field(default=None, kw_only=True)
    stiffness: NonNegative | None = field(default=None, kw_only=True)
    contact_penalty: Annotated[Finite, Ge(1)] | None = field(default=None, kw_only=True)
    natural_angle: Annotated[Annotated[Finite, Ge(0), Le(2 * math.pi)] | None, Unit("rad")] = field(
        default=None, kw_only=True
    )

    def __post_init__(self) -> None:
        """Check fields against each other."""
        if self.creases is not None and self.nodes is not None:
            raise InputError(f"CreaseSet.nodes = {show(self.nodes)}: creases are given too; leave one of them out")
        if not self._own:
            raise InputError("CreaseSet: no property is given; give stiffness, contact_penalty or natural_angle")

    @property
    def _own(self) -> dict[str, float]:
        """The properties that are given."""
        names = ("stiffness", "contact_penalty", "natural_angle")
        return {name: getattr(self, name) for name in names if getattr(self, name) is not None}

    def add_loads(self, builder: Builder, where: str) -> None:
        """Give the creases their properties.

        Raises
        ------
        SceneError
            Creases, node sets or nodes that are not there, no crease at all, one of another set.
        """
        count = 0 if builder.mesh is None else len(builder.mesh.creases)
        if builder.mesh is None or not count:
            raise SceneError(f"{where}: the scene has no creases; leave the part out")
        found = np.arange(count)
        if self.creases is not None:
            found = np.unique(np.array(self.creases, np.int64))
            if found[-1] >= count:
                raise SceneError(f"{where}.creases: crease {found[-1]} is not there; must be from 0 to {count - 1}")
        elif self.nodes is not None:
            found = builder.elements_inside(builder.mesh.creases, self.nodes, where, "nodes")
        if self.fold is not None:
            is_mountain = np.asarray(builder.mesh.fold_angles)[found] < 0.0
            found = found[is_mountain == (self.fold == "mountain")]
        if not len(found):
            given = {name: getattr(self, name) for name in ("creases", "nodes", "fold")}
            said = " and ".join(f"{name} = {show(value)}" for name, value in given.items() if value is not None)
            raise SceneError(f"{where}: no crease of the mesh is meant by {said}; correct that")
        for name, value in self._own.items():
            builder.set_creases(found, name, value, where)

    @property
    def numbering_field(self) -> str | None:
        """The field by which it names creases or nodes by their numbers."""
        if self.creases is not None:
            return "creases"
        return "nodes" if has_numbers(self.nodes) else None

    @property
    def laws_needed(self) -> dict[str, tuple[str, ...]]:
        """All properties are those of the law of creases."""
        return dict.fromkeys(self._own, ("creases",))

    def for_modulus(self, factor: float) -> CreaseSet:
        """Moments as they were: kappa is proportional to E."""
        return self if self.stiffness is None else replace(self, stiffness=self.stiffness / factor)

    def with_softened_film(self, factor: float) -> CreaseSet:
        """Moments as they were."""
        return self.for_modulus(1.0 / factor)
