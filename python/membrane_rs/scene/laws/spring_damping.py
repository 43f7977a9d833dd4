"""Damping of springs, or of a film of triangles."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Annotated, ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike

from membrane_rs._arrays import Floats
from membrane_rs._given_arrays import numeric
from membrane_rs._validation import NonNegative, Positive, Unit, validated
from membrane_rs.errors import InputError
from membrane_rs.scene.law import Law, StiffThrough, Surroundings
from membrane_rs.scene.plausible import Doubt, implausible


@validated
class SpringDamping(Law):
    """A dashpot along each spring: c = 2 zeta sqrt(k m), with m the mean of the two nodes' masses.

    With `Triangles` in place of springs, a stress proportional to the rate of strain, of the same strength.

    Parameters
    ----------
    ratio : float
        zeta [-], 0 or above.
    length : float or None
        Length l_d [m] of the film's dashpots: each node counts with rho h l_d^2, the mass of a square of film of that
        side, in place of its own mass, so that a rate of strain loses the same on every mesh. Where each node has that
        mass the two forms agree. Tethers keep the masses of their nodes. None: the nodes' masses, the paper's form,
        whose damping fades as the mesh gets finer.
    mass : str
        m of a dashpot: "mean", (m_i + m_j)/2, the paper's form; or "reduced", m_i m_j/(m_i + m_j), with which zeta is
        the damping ratio of the two nodes as a free pair, and with a held node the mass of the other. In triangles,
        half the harmonic mean of the three masses.
    limited : str
        The dashpots that resist with no more than the elastic tension above that of buckling, k (max(l, l_cr) - l_cr):
        "none", the paper's form everywhere; "cords", so that a slack cord has no force and no cord pushes; or "all",
        those of the film's springs too, so that no spring bears more compression than its buckling force.

    Raises
    ------
    InputError, InputTypeError
        A value outside its range, or of a wrong type.

    Examples
    --------
    >>> from membrane_rs import SpringDamping
    >>> SpringDamping(ratio=0.02, mass="reduced").limited
    'cords'
    """

    kind: ClassVar[str] = "spring_damping"
    stiff_through: ClassVar[StiffThrough] = "law"
    length_fields: ClassVar[Mapping[str, str]] = {"damping": "length"}
    ratio: NonNegative = 0.02
    length: Annotated[Positive | None, Unit("m")] = None
    mass: Literal["mean", "reduced"] = "mean"
    limited: Literal["none", "cords", "all"] = "cords"

    def mass_of(self, masses: ArrayLike) -> Floats:
        """m [kg] of dashpots whose free nodes have these masses (n, 2) [kg].

        Parameters
        ----------
        masses : (s, 2) float64
            Of the two nodes of each dashpot [kg].

        Returns
        -------
        (s,) float64
            m of the equation [kg].

        Raises
        ------
        InputError, InputTypeError
            No pairs of numbers.

        Examples
        --------
        >>> import numpy as np
        >>> from membrane_rs import SpringDamping
        >>> SpringDamping(mass="reduced").mass_of(np.array([[2.0, 2.0]])).tolist()
        [1.0]
        """
        pairs = numeric(masses, "masses", "fiu", "numbers: the masses of both nodes of each dashpot (kg)")
        if pairs.ndim != 2 or pairs.shape[1] != 2:
            raise InputError(f"masses has shape {pairs.shape}; it must be (s, 2): both nodes of each dashpot")
        pairs = pairs.astype(np.float64)
        return np.asarray(pairs.mean(axis=1) if self.mass == "mean" else 1.0 / (1.0 / pairs).sum(axis=1))

    def implausible_values(self, scene: Surroundings, where: str) -> Iterator[Doubt]:
        """From 1 on a pair of masses no longer vibrates along its spring: it creeps."""
        reason = "from 1 on a spring and its masses creep, and do not vibrate; films have some hundredths"
        yield from implausible(f"{where}.ratio", self.ratio, "(a ratio)", reason, most=1.0, units={"%": 0.01})

    def why_idle(self, scene: Surroundings) -> str | None:
        """Without springs, or a ratio, there is no dashpot."""
        if scene.mesh is None and len(scene.assemble().cords) == 0:
            return "the scene has no springs"
        return "its ratio is 0" if self.ratio == 0 else None

    def with_softened_film(self, factor: float) -> SpringDamping:
        """The same c between nodes of equal masses; less beside a heavier one, where the mean mass would set the step.

        c = 2 zeta sqrt(k m), with k in proportion to E, and of equal masses the mean is twice the reduced mass.
        """
        gain = 2.0 * factor if self.mass == "mean" else factor
        return replace(self, ratio=self.ratio * math.sqrt(gain), mass="reduced")

    def simpler(self) -> tuple[str, SpringDamping] | None:
        """The reduced mass, which beside a tip mass is far below the mean, and elsewhere half of it."""
        return None if self.mass == "reduced" else ("mean mass", replace(self, mass="reduced"))

    def step_advice(self, gain: float) -> str:
        """A smaller ratio."""
        return "a smaller ratio makes the step longer"
