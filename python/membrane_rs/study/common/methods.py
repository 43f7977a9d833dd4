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
        The scene goes with none: what the last one says.
    """
    found: list[str] = []
    for name in (names := list(integrators())):
        try:
            Simulation(scene, name)
        except InputError as error:
            if name == names[-1] and not found:
                raise
            tell(f"left out: {name}: {error}")
        else:
            found.append(name)
    return found
