"""How a scene is run unless the caller says otherwise."""

from __future__ import annotations

from typing import Annotated

from annotated_types import Ge, Le

from membrane_rs import _core
from membrane_rs._renamed import Renamed
from membrane_rs._validation import Auto, Count, NonNegative, Positive, Times, Unit, nearest, show, validated
from membrane_rs.errors import InputError

SHORTEST, LONGEST = 1e-15, 1e12
"""Times at the end of a run [s] beyond which steps cannot be counted."""
MOST_INSTANTS = 10**7
"""More frames or samples than this would not fit into memory."""


def check_duration(duration: float, where: str) -> None:
    """Refuse a time at the end of a run, or a duration [s], from which steps cannot be counted. Raises InputError."""
    if not SHORTEST <= duration <= LONGEST:
        raise InputError(f"{where} = {duration}: must be from {SHORTEST:g} to {LONGEST:g} (s)")


def known_methods() -> list[str]:
    """The names of the methods of integration."""
    return [facts.name for facts in _core.integrators()]


@validated
class RunSettings:
    """How long a scene runs, by which method, and what is written when.

    `short_steps`, `settle` and `settle_rate` are the old names of `substeps`, `relax` and `relax_rate`.

    Parameters
    ----------
    until : float
        Time at the end [s], from 1e-15 to 1e12.
    integrator : str
        Name of the method, one of `membrane_rs.integrators()`.
    dt : float or None
        Step [s]. None, in files "auto": from the stability limit, with a margin, and from the slow motion
        (docs/model.md); "dopri5" then chooses each step by its error. The end and all outputs are met, also where they
        lie between two steps.
    tolerance : float
        Error that a step may make on any node where it is chosen by the error [-]: this share of
        sqrt(tolerance_length^2 + x^2) in position and of sqrt(tolerance_speed^2 + v^2) in velocity, with x and v of
        a piece that nothing holds about its centre of mass.
    tolerance_length : float
        Distance from the origin (of such a piece: from its centre) below which the tolerance is absolute [m].
    tolerance_speed : float
        Speed below which the tolerance is absolute [m/s].
    spectral_radius : float
        By what factor an implicit method shrinks, per step, the vibrations that it cannot resolve [-]; from 0 to 1.
    substeps : int
        Substeps in a step of "leapfrog", from 1 to 1000: laws whose own limit is ten times the step's and more are
        evaluated once a step, the others at each substep. `dt` is the whole step. 4 suit most films.
    frames : int
        Shapes written, evenly spaced from the start to the end; from 2 to 10^7.
    samples : int
        Rows of the history, evenly spaced from the start to the end; from 2 to 10^7.
    snapshots : sequence of float
        Times of the pictures [s]; those after the end are left out.
    relax : float
        Before its start the scene is damped by friction for this long, at the instant of the start, its guide bars
        holding, and then by kinetic damping until it is at rest [s]; 0: not at all.
    relax_rate : float
        Friction while it is relaxed, F = -rate m v [1/s].
    watch : int
        Steps between two checks of energy, strain and finite values; from 1 to 10^9.
    energy_loss : float
        A run stops when the residual of the energy balance, of either sign, exceeds this fraction of the reference
        energy [-]; above 0. Near the stability limit a method damps the fastest vibrations by itself. A spurious gain
        stops a run from 1 % on; with "generalized_alpha", from the larger of 1 % and this fraction on.

    Raises
    ------
    InputError, InputTypeError
        A value outside its range, or of a wrong type.

    Examples
    --------
    >>> from membrane_rs import RunSettings
    >>> RunSettings(until=0.2, integrator="leapfrog", substeps=4).samples
    801
    """

    until: Annotated[Positive, Unit("s")] = 0.8
    integrator: str = "rk4"
    dt: Annotated[Positive | None, Unit("s"), Auto()] = None
    tolerance: Positive = 1e-5
    tolerance_length: Annotated[Positive, Unit("m")] = 0.1
    tolerance_speed: Annotated[Positive, Unit("m/s")] = 1.0
    spectral_radius: Annotated[NonNegative, Le(1)] = 0.8
    substeps: Annotated[Count, Le(1000)] = 1
    frames: Annotated[Count, Ge(2), Le(MOST_INSTANTS)] = 81
    samples: Annotated[Count, Ge(2), Le(MOST_INSTANTS)] = 801
    snapshots: Annotated[Times, Unit("s")] = (0.0, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8)
    relax: Annotated[NonNegative, Unit("s")] = 0.0
    relax_rate: Annotated[NonNegative, Unit("1/s")] = 100.0
    watch: Count = 100
    energy_loss: Positive = 0.05

    short_steps = Renamed("substeps")
    settle = Renamed("relax")
    settle_rate = Renamed("relax_rate")

    def __post_init__(self) -> None:
        """Check the method and the end."""
        methods = known_methods()
        if self.integrator not in methods:
            what = f"RunSettings.integrator = {show(self.integrator)}: is no method"
            raise InputError(f"{what}; {nearest(self.integrator, methods)}")
        check_duration(self.until, "RunSettings.until")
