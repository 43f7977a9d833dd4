"""Methods of time integration, as the core describes them."""

from __future__ import annotations

from dataclasses import dataclass

from membrane_rs import _core


@dataclass(frozen=True)
class IntegratorFacts:
    """Properties of a method of time integration.

    Parameters
    ----------
    order : int
        Of the error after a given time.
    evaluations : int
        Of the forces, per step.
    evaluations_at_start : int
        Of the forces, before the first step.
    keeps_energy : bool
        Whether the energy of an undamped motion stays bounded, however long it lasts.
    is_adaptive : bool
        Whether it chooses its own step where none is given.
    imaginary_limit : float
        Largest stable omega dt of an undamped oscillation [-].
    real_limit : float
        Largest stable rate times dt of a pure decay [-].

    Examples
    --------
    >>> from membrane_rs import integrators
    >>> integrators()["leapfrog"].keeps_energy
    True
    """

    order: int
    evaluations: int
    evaluations_at_start: int
    keeps_energy: bool
    is_adaptive: bool
    imaginary_limit: float
    real_limit: float


def integrators() -> dict[str, IntegratorFacts]:
    """Properties of each method, by name.

    Returns
    -------
    dict of str to IntegratorFacts
        By the names that `Simulation` and scenes take.

    Examples
    --------
    >>> from membrane_rs import integrators
    >>> integrators()["rk4"].order, round(integrators()["rk4"].imaginary_limit, 3)
    (4, 2.828)
    """
    return {
        facts.name: IntegratorFacts(
            order=facts.order,
            evaluations=facts.evaluations_per_step,
            evaluations_at_start=facts.evaluations_at_start,
            keeps_energy=facts.conserves_energy,
            is_adaptive=facts.is_adaptive,
            imaginary_limit=facts.imaginary_limit,
            real_limit=facts.real_limit,
        )
        for facts in _core.integrators()
    }
