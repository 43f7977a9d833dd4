"""What folding a pattern gives: the folded mesh, how near it is to the pattern's angles, and what is wrong with it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs.mesh import Crossings, Mesh
from membrane_rs.mesh.fold_angles import TOLERANCE, largest_bend
from membrane_rs.simulation.relaxation import AT_REST

LEAST = 0.25
"""Mean fraction reached, over the one that was to be reached, below which a pattern has hardly folded."""


@dataclass(frozen=True)
class FoldIncrement:
    """One of the equal parts by which a pattern is folded.

    Attributes
    ----------
    fraction : float
        Of its fold angles that the creases turned to [-].
    steps : int
        Of the relaxation.
    remainder : float
        Largest net force on a node over the largest force of a law [-]: what was left at its end.

    Examples
    --------
    >>> from membrane_rs.simulation import FoldIncrement
    >>> FoldIncrement(fraction=0.1, steps=2000, remainder=0.02).steps
    2000
    """

    fraction: float
    steps: int
    remainder: float


@dataclass(frozen=True, eq=False)
class FoldResult:
    """A pattern folded from flat, with the angles that its creases have reached.

    Attributes
    ----------
    mesh : Mesh
        Its `positions` are folded, its `fold_angles` those reached; where a crease is shut, of the side of the pattern.
    fraction : float
        Of the pattern's fold angles that the creases were to reach [-].
    pattern_angles : (c,) float
        Fold angles of the pattern [rad]; 0 where a crease is free.
    angles : (c,) float
        Fold angles reached [rad], beyond pi where facets interpenetrate at a crease.
    increments : tuple of FoldIncrement
        The path.
    strain_limit : float
        Largest strain of a side that is no fault [-].

    Examples
    --------
    >>> from membrane_rs import fold
    >>> from membrane_rs.folding import Miura
    >>> found = fold(Miura(straight_side=0.02, zigzag_side=0.02, tilt=1.2, columns=2, rows=2).mesh())
    >>> found.faults, len(found.increments), found.crossings.count
    ((), 10, 0)
    """

    mesh: Mesh
    fraction: float
    pattern_angles: Floats
    angles: Floats
    increments: tuple[FoldIncrement, ...]
    strain_limit: float

    @property
    def targets(self) -> Floats:
        """(c,) fold angles that the creases were to reach, `fraction` times those of the pattern [rad]."""
        return self.fraction * self.pattern_angles

    @cached_property
    def errors(self) -> Floats:
        """(c,) fold angles reached less those that were to be reached [rad]; 0 where a crease is free."""
        errors: Floats = np.where(self.pattern_angles == 0.0, 0.0, self.angles - self.targets)
        return errors

    @property
    def mean_fraction(self) -> float:
        """Fraction of the pattern's angles reached, in the mean by their squares [-]."""
        return float(self.angles @ self.pattern_angles / np.square(self.pattern_angles).sum())

    @property
    def worst_crease(self) -> int:
        """The crease that is furthest from its angle, a row of `Mesh.creases`."""
        return int(np.argmax(np.abs(self.errors)))

    @cached_property
    def largest_strain(self) -> float:
        """Largest strain of a side of a triangle, stretched or compressed [-]."""
        return float(np.abs(self.mesh.strain()).max())

    @cached_property
    def largest_bend(self) -> float:
        """Largest angle between two triangles of one panel [rad]; 0 where all panels are flat."""
        return largest_bend(self.mesh, self.mesh.positions)

    @cached_property
    def crossings(self) -> Crossings:
        """Triangles that pass through each other. In shut layers, which coincide, rounding decides what crosses."""
        return self.mesh.crossings()

    @property
    def steps(self) -> int:
        """Steps of all increments."""
        return sum(increment.steps for increment in self.increments)

    @cached_property
    def faults(self) -> tuple[str, ...]:
        """In what the pattern did not fold as asked, in words.

        Wrong sides, facets that pass through each other at their crease, angles too far from theirs, strain.

        On a path from flat to its angles by rigid panels, no crease folding further than its angle phi, there is for
        each crease a shape in which that one has fraction phi and none is further from its own than (1 - fraction)
        phi or so. The shape at rest has the least sum of L e^2 over all creases, of lengths L and errors e; so that
        e^2 <= (1 - fraction)^2 (sum L phi^2) / L for each. What exceeds that by 5 degrees is a fault. Flat shapes
        satisfy it up to a fraction of a half; they are faults as such.
        """
        found = (
            self._wrong_side(),
            self._passed_through(),
            self._flat(),
            self._far_off(),
            self._strained(),
            self._moving(),
        )
        return tuple(words for words in found if words)

    def _wrong_side(self) -> str:
        turned = np.where(self.pattern_angles < 0.0, -self.angles, self.angles)
        wrong = np.flatnonzero((self.pattern_angles != 0.0) & (turned < -TOLERANCE))
        if not len(wrong):
            return ""
        k = wrong[np.argmin(turned[wrong])]
        return (
            f"{self._crease(k)} has folded to {_degrees(self.angles[k])}, to the other side than its pattern says, "
            f"{_degrees(self.targets[k])} ({len(wrong)} such creases); correct the mountains and valleys at its ends"
        )

    def _passed_through(self) -> str:
        beyond = np.abs(self.angles) - np.pi
        passed = np.flatnonzero(beyond > TOLERANCE)
        if not len(passed):
            return ""
        k = passed[np.argmax(beyond[passed])]
        return (
            f"{self._crease(k)} has folded to {_degrees(self.angles[k])}: beyond 180, its facets have passed through "
            f"each other, or it has folded to the other side ({len(passed)} such creases); correct the angles at its "
            "ends, or fold less"
        )

    def _flat(self) -> str:
        if self.mean_fraction >= LEAST * self.fraction:
            return ""
        return (
            f"the creases have hardly folded: in the mean, to {self.mean_fraction:.2g} of the pattern's angles, and "
            f"{self._crease(self.worst_crease)} to {_degrees(self.angles[self.worst_crease])} of "
            f"{_degrees(self.targets[self.worst_crease])}; a vertex needs four creases or more, and angles that go "
            "together"
        )

    def _far_off(self) -> str:
        mesh = self.mesh
        lengths = mesh.edge_lengths[mesh.find_edges(mesh.creases)[0]]
        bound = (1.0 - self.fraction) * np.sqrt(lengths @ np.square(self.pattern_angles) / lengths) + TOLERANCE
        beyond = np.abs(self.errors) - bound
        far = np.flatnonzero(beyond > 0.0)
        if not len(far):
            return ""
        k = far[np.argmax(beyond[far])]
        return (
            f"{self._crease(k)} has folded to {_degrees(self.angles[k])} and was to reach {_degrees(self.targets[k])} "
            f"({len(far)} such creases): its facets do not let it; correct the angles at its ends, divide the facets "
            "where they must bend, or take more increments"
        )

    def _strained(self) -> str:
        strain = self.mesh.strain()
        k = int(np.argmax(np.abs(strain)))
        if abs(strain[k]) <= self.strain_limit:
            return ""
        return (
            f"the side of nodes {_both(self.mesh.edges[k])} is strained by {strain[k]:.2g}, and strain_limit is "
            f"{self.strain_limit:g}: its facets resist; correct the angles of the creases near it, fold less, or "
            "give a larger strain_limit"
        )

    def _moving(self) -> str:
        left = self.increments[-1].remainder
        if left <= AT_REST:
            return ""
        return (
            f"it is not at rest after {self.increments[-1].steps:,} steps of the last increment: the largest net force "
            f"on a node is {left:.2g} of the largest force of a law; take more increments"
        )

    def _crease(self, k: int) -> str:
        return f"creases[{k}] (nodes {_both(self.mesh.creases[k])})"

    def as_dict(self) -> dict[str, Any]:
        """Numbers of the result, angles in radians.

        Returns
        -------
        dict
            By name.

        Examples
        --------
        >>> from membrane_rs import fold
        >>> from membrane_rs.folding import Miura
        >>> found = fold(Miura(straight_side=0.02, zigzag_side=0.02, tilt=1.2, columns=2, rows=2).mesh())
        >>> found.as_dict()["crossings"], found.as_dict()["faults"]
        (0, [])
        """
        return {
            "fraction": self.fraction,
            "mean_fraction": self.mean_fraction,
            "largest_error": float(np.abs(self.errors).max()),
            "rms_error": float(np.sqrt(np.square(self.errors).mean())),
            "worst_crease": self.worst_crease,
            "largest_strain": self.largest_strain,
            "largest_bend": self.largest_bend,
            "crossings": self.crossings.count,
            "steps": self.steps,
            "faults": list(self.faults),
            "targets": self.targets.tolist(),
            "angles": self.angles.tolist(),
        }

    def __str__(self) -> str:
        k = self.worst_crease
        rms = np.sqrt(np.square(self.errors).mean())
        return (
            f"Folded to {self.fraction:g} of the pattern's angles in {self.steps:,} steps: angles within "
            f"{_degrees(abs(self.errors[k]))} of that, {_degrees(rms)} rms, the worst {self._crease(k)} at "
            f"{_degrees(self.angles[k])} of {_degrees(self.targets[k])}; strain {self.largest_strain:.2g}; panels bent "
            f"by {_degrees(self.largest_bend)}; {self.crossings.count:,} crossings"
        )


def _degrees(angle: float) -> str:
    return f"{np.degrees(angle):.3g} degrees"


def _both(nodes: Any) -> str:
    return " and ".join(map(str, nodes.tolist()))
