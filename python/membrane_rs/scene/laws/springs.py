"""The film as springs along the edges of the membrane."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal

from membrane_rs._validation import NonNegative, Positive, Unit, validated
from membrane_rs.scene.laws._buckling import FilmOfSprings


@validated
class Springs(FilmOfSprings):
    """Springs along the edges of the membrane, which buckle.

    They represent the film in every direction only on equilateral triangles at nu = 1/3; on right triangles they are
    soft in shear by nearly half (`membrane_rs.mesh.net_moduli`).

    N = k (max(l, l_cr) - L), with l_cr = L - alpha pi^2 h^2 / (12 L): below the critical length the
    force is constant (Euler's strain of a slender column).

    Parameters
    ----------
    buckling : float
        alpha [-] of edges that are no creases, 0 or above. 0: no compression at all.
    buckling_on_creases : float
        alpha [-] of crease edges, 0 or above.
    buckling_length : float or None
        Length in place of L in the critical strain, alpha pi^2 h^2 / (12 L^2) [m]: the same critical strain on
        every edge, and on every mesh. None: each spring's own L, the paper's form, which belongs to one mesh.
    crease_length : float or None
        Length l_c [m] that makes a crease a line with a buckling force of its own beside the film's: it shortens by
        (buckling_on_creases - buckling) pi^2 h^2 / (12 l_c) more than the film before it buckles, at the same force
        on every mesh. None: buckling_on_creases in place of buckling, a force that depends on the mesh.
    strain_limit : float
        A run stops when a spring is stretched beyond this strain [-].
    negative : str
        What to do with negative spring constants, which obtuse triangles make: "refuse" (an error),
        "clip" (to zero) or "keep".

    Raises
    ------
    InputError, InputTypeError
        A value outside its range, or of a wrong type.

    Examples
    --------
    >>> from membrane_rs import Springs
    >>> Springs(buckling=0.0).without_compression().buckling_on_creases
    0.0
    """

    kind: ClassVar[str] = "springs"
    buckling: NonNegative = 100.0
    buckling_on_creases: NonNegative = 1000.0
    buckling_length: Annotated[Positive | None, Unit("m")] = None
    crease_length: Annotated[Positive | None, Unit("m")] = None
    strain_limit: Positive = 0.1
    negative: Literal["refuse", "clip", "keep"] = "refuse"

    def core_parameters(self) -> dict[str, Any]:
        """Those of the law; `negative` goes with the film."""
        return {name: value for name, value in super().core_parameters().items() if name != "negative"}

    @property
    def negative_springs(self) -> str:
        """As the law says."""
        return self.negative
