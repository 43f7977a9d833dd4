"""The methods by which a scene can be run."""

from __future__ import annotations

from membrane_rs.errors import InputError
from membrane_rs.runs import Simulation
from membrane_rs.scene import Scene
from membrane_rs.simulation import integrators
from membrane_rs.study.common.executor import Tell


def methods_of(scene: Scene, tell: Tell) -> list[str]:
    """All methods but those that the scene does not go with, as some do not with a free hub: `tell` says which, and
    why.

    Raises
    ------
    InputError
        The scene goes with none: what the first one says.
    """
    refusals: dict[str, InputError] = {}
    for name in integrators():
        try:
            Simulation(scene, name)
        except InputError as refusal:
            refusals[name] = refusal
    found = [name for name in integrators() if name not in refusals]
    if not found:
        raise next(iter(refusals.values()))
    for name, error in refusals.items():
        tell(f"left out: {name}: {error}")
    return found
