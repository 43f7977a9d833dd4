"""The laws of force that a scene may hold, as plain checked values.

A law here says what a scene wants; the core holds the kernel of the same name, with its equation and its
energy. A law that a scene leaves out costs nothing. Units are SI; angles are in radians.

The model is that of Okuizumi et al. (Trans. JSASS Aerospace Tech. Japan 10, 2012); where the paper leaves a choice
open, the docstring says what was chosen.
"""

from __future__ import annotations

import math
from typing import Annotated, ClassVar, Literal, TypeAlias

from annotated_types import Ge, Le

from membrane_rs._validation import Finite, Flag, NonNegative, Positive, Unit, Vector, validated


@validated
class Springs:
    """Springs along the edges of the membrane, which buckle.

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
        on every mesh. None: buckling_on_creases in place of buckling, a force that goes with the mesh.
    strain_limit : float
        A run stops when a spring is stretched beyond this strain [-].
    negative : str
        What to do with negative spring constants, which obtuse triangles make: "refuse" (an error),
        "clip" (to zero) or "keep".
    """

    kind: ClassVar[str] = "springs"
    buckling: NonNegative = 100.0
    buckling_on_creases: NonNegative = 1000.0
    buckling_length: Annotated[Positive | None, Unit("m")] = None
    crease_length: Annotated[Positive | None, Unit("m")] = None
    strain_limit: Positive = 0.1
    negative: Literal["refuse", "clip", "keep"] = "refuse"


@validated
class Triangles:
    """The film as triangles of uniform strain, which wrinkle; a scene takes it in place of `Springs`.

    St. Venant and Kirchhoff's law in plane stress, with Green's strain: isotropic at any Poisson's ratio, on any
    mesh. Under uniaxial compression the stress falls no lower than -E eps_c, with eps_c the critical strain of eq.
    (2), alpha pi^2 h^2 / (12 L^2), mean over the triangle's sides: the film then wrinkles. With alpha = 0 it bears
    tension only. The forces have a potential, with wrinkles too.

    Parameters
    ----------
    compression : float
        Share of the stiffness that is left in compression [-], from 0 (a film) to 1 (it never buckles).
    buckling : float
        alpha [-] of sides that are no creases, 0 or above.
    buckling_on_creases : float
        alpha [-] along creases, 0 or above. A wrinkle that crosses a crease must buckle it, so that a value above
        `buckling` stiffens the film beside a crease in shear too, far more than springs do. The default brings model
        1 of the paper, on the paper's mesh, nearest to the curves of its springs (docs/mesh_parameters.md).
    buckling_length : float or None
        Length in place of L in the critical strain [m]: the same on every mesh. None: each side's own.
    crease_length : float or None
        Length [m] that makes a crease a line with a buckling force of its own, as in `Springs`.
    strain_limit : float
        A run stops when a triangle is stretched beyond this strain in any direction [-].
    """

    kind: ClassVar[str] = "triangles"
    compression: Annotated[Finite, Ge(0), Le(1)] = 0.0
    buckling: NonNegative = 100.0
    buckling_on_creases: NonNegative = 20.0
    buckling_length: Annotated[Positive | None, Unit("m")] = None
    crease_length: Annotated[Positive | None, Unit("m")] = None
    strain_limit: Positive = 0.1


@validated
class SpringDamping:
    """A dashpot along each spring: c = 2 zeta sqrt(k m), with m the mean of the two nodes' masses.

    With `Triangles` in place of springs, a stress that goes with the rate of strain, of the same strength.

    Parameters
    ----------
    ratio : float
        zeta [-], 0 or above.
    length : float or None
        Length l0 [m] of the film's dashpots: m = rho h l0^2, the mass of a square of film of that side, in place of
        the nodes' masses, so that a rate of strain loses the same on every mesh. Where each node has that mass the two
        forms agree. Tethers keep the masses of their nodes. None: the nodes' masses, the paper's form, whose damping
        fades as the mesh gets finer.
    """

    kind: ClassVar[str] = "spring_damping"
    ratio: NonNegative = 0.02
    length: Annotated[Positive | None, Unit("m")] = None


@validated
class Creases:
    """Creases that turn towards a natural angle, and that resist folding through themselves.

    With theta the crease angle (pi flat, 0 shut, below 0 interpenetrating) and kappa = beta E J L / H:

        U = w_C w_D [ kappa (theta - theta0)^2 / 2 + (gamma - 1) kappa min(theta, 0)^2 / 2 ]

    w = A^2 / (A^2 + (collapse A0)^2) for each wing, A its current area, A0 its reference area: it takes
    away the singular force of a wing that has collapsed to a line.

    Parameters
    ----------
    stiffness : float
        beta [-], 0 or above.
    contact_penalty : float
        gamma [-], how many times stiffer the crease is below 0; 1 or above, 1 meaning no contact.
    natural_angle : float
        theta0 [rad], from 0 (shut) over pi (flat) to 2 pi.
    length_scale : float or None
        H [m]. None: the mean height of the two wings in the reference mesh, crease by crease.
    collapse : float
        The fraction of a wing's area below which its moment fades [-], from 0 (never) to 1.
    """

    kind: ClassVar[str] = "creases"
    stiffness: NonNegative = 10.0
    contact_penalty: Annotated[Finite, Ge(1)] = 100.0
    natural_angle: Annotated[Finite, Ge(0), Le(2 * math.pi), Unit("rad")] = 0.0
    length_scale: Annotated[Positive | None, Unit("m")] = None
    collapse: Annotated[Finite, Ge(0), Le(1)] = 0.05


@validated
class AirDrag:
    """Drag of thin air: rho V^2 S_n / 6 on each node of a triangle, against the node's velocity V.

    S_n is the triangle's area projected on the plane normal to V; rho = p / (287 T).

    Parameters
    ----------
    pressure : float
        p [Pa], 0 or above.
    temperature : float
        T [K], above 0.
    air : str
        "still": at rest in the chamber. "turning": turning with the hub.
    """

    kind: ClassVar[str] = "air_drag"
    pressure: Annotated[NonNegative, Unit("Pa")] = 4.5
    temperature: Annotated[Positive, Unit("K")] = 293.0
    air: Literal["still", "turning"] = "still"


@validated
class Spin:
    """The hub turns about z, and the scene is computed in the frame that turns with it.

    Omega(t) = 2 pi (frequency + acceleration t).

    Parameters
    ----------
    frequency : float
        Turns per second at the start [Hz]; the sign gives the sense.
    acceleration : float
        Its rate of change [Hz/s].
    """

    kind: ClassVar[str] = "spin"
    frequency: Annotated[Finite, Unit("Hz")] = 3.0
    acceleration: Annotated[Finite, Unit("Hz/s")] = 0.0


@validated
class Gravity:
    """A uniform field, fixed in inertial space: F = m g.

    Parameters
    ----------
    acceleration : tuple of float
        g (x, y, z) [m/s2].
    """

    kind: ClassVar[str] = "gravity"
    acceleration: Annotated[Vector, Unit("m/s2")] = (0.0, 0.0, -9.81)


@validated
class SpoolContact:
    """Keeps tether nodes outside the spool, a cylinder about z, by a penalty: F = stiffness * depth.

    Parameters
    ----------
    radius : float
        Radius of the spool [m], above 0.
    stiffness : float
        Of the penalty, for each node [N/m], above 0.
    half_height : float or None
        Half of the spool's height [m]: it reaches from -half_height to +half_height. None: endless.
    membrane : bool
        True: the nodes of the membrane are kept outside too.
    """

    kind: ClassVar[str] = "spool_contact"
    radius: Annotated[Positive, Unit("m")] = 0.025
    stiffness: Annotated[Positive, Unit("N/m")] = 200.0
    half_height: Annotated[Positive | None, Unit("m")] = None
    membrane: Flag = False


@validated
class MassDamping:
    """Friction against the turning frame, F = -rate m v: for bringing a scene to rest.

    Parameters
    ----------
    rate : float
        [1/s], 0 or above.
    """

    kind: ClassVar[str] = "mass_damping"
    rate: Annotated[NonNegative, Unit("1/s")]


Law: TypeAlias = Springs | Triangles | SpringDamping | Creases | AirDrag | Spin | Gravity | SpoolContact | MassDamping

LAWS: dict[str, type[Law]] = {
    law.kind: law
    for law in (Springs, Triangles, SpringDamping, Creases, AirDrag, Spin, Gravity, SpoolContact, MassDamping)
}
"""The one list of laws: the name of its table in a scene file, and its class."""
