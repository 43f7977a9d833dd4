"""The methods of time integration that can run a scene."""

from __future__ import annotations

from collections.abc import Iterable

from membrane_rs.errors import InputError
from membrane_rs.runs import Simulation
from membrane_rs.scene import Scene
from membrane_rs.scene.hub import has_free_hub

SHORT = 1e-9
"""Share of the run that is given as a step, so that no limit is computed."""


def methods_of(scene: Scene, names: Iterable[str]) -> tuple[list[str], dict[str, str]]:
    """Of some methods those that can run a scene, and of the others why not: some do not move a free hub, and some laws
    go with few of them.

    Raises InputError where none of them can.
    """
    found, left_out = list(names), {}
    if not has_free_hub(scene) and all(law.methods is None for law in scene.laws):
        return found, {}
    for name in found:
        try:
            Simulation(scene, name, SHORT * scene.run.until)
        except InputError as error:
            left_out[name] = str(error)
    fitting = [name for name in found if name not in left_out]
    if found and not fitting:
        raise InputError(left_out[found[0]])
    return fitting, left_out
