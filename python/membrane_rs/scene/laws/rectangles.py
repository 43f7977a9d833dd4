"""The film as rectangles with a spring along each side and both diagonals."""

from __future__ import annotations

from typing import Annotated, ClassVar

from membrane_rs._validation import NonNegative, Positive, Unit, validated
from membrane_rs.scene.laws._buckling import FilmOfSprings


@validated
class Rectangles(FilmOfSprings):
    """Springs along the sides and both diagonals of rectangles, which buckle; for meshes of squares or rectangles.

    The triangles of the mesh must form rectangles in pairs, without a crease between the two (`Mesh.find_rectangles`).
    Of plane stress the springs have the stiffness along both sides and in shear, at any Poisson's ratio nu, and a
    coupling of both strains that is the film's at nu = 1/3 alone: a uniform strain in all directions stores
    (3 - nu)/(2 + 2 nu) of the film's energy. Sides that differ by more than sqrt(2/(1 - nu)) times would need negative
    springs, and are refused. Each spring buckles as those of `Springs` do.

    Parameters
    ----------
    buckling : float
        alpha [-] of springs that are no creases, 0 or above. 0: no compression at all.
    buckling_on_creases : float
        alpha [-] of crease edges, 0 or above.
    buckling_length : float or None
        Length in place of a spring's own in the critical strain [m], as in `Springs`.
    crease_length : float or None
        Length [m] that makes a crease a line with a buckling force of its own, as in `Springs`.
    strain_limit : float
        A run stops when a spring is stretched beyond this strain [-].

    Raises
    ------
    InputError, InputTypeError
        A value outside its range, or of a wrong type.

    Examples
    --------
    >>> from membrane_rs import Material, Rectangles, Scene, Simulation
    >>> from membrane_rs.folding import Strip
    >>> film = Material(3.2e9, 0.34, 1420.0, 7.5e-6)
    >>> sim = Simulation(Scene(Strip(0.1, 0.02, columns=10, rows=2).mesh(), film, [Rectangles()]))
    >>> len(sim.spring_pairs), len(sim.scene.mesh.edges), len(sim.scene.mesh.find_rectangles())
    (92, 72, 20)
    """

    kind: ClassVar[str] = "rectangles"
    has_rectangles: ClassVar[bool] = True
    buckling: NonNegative = 100.0
    buckling_on_creases: NonNegative = 1000.0
    buckling_length: Annotated[Positive | None, Unit("m")] = None
    crease_length: Annotated[Positive | None, Unit("m")] = None
    strain_limit: Positive = 0.1

    @property
    def negative_springs(self) -> str:
        """Nothing uses the constants of eq. (1), so none need be refused; the law refuses negative ones of its own."""
        return "unused"
