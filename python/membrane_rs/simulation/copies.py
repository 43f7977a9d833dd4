"""Copies and pickles of a simulation: its scene and its state, from which an independent one has the same bits."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from membrane_rs.scene import Scene

MADE = (
    "scene", "assembly", "_core", "_limit", "_motions_set", "_digest", "masses", "spring_pairs", "_stage_scene",
    "_timeline", "_stage_end", "_stop",
)  # fmt: skip
"""Attributes that follow from scene and state."""


class Copies:
    """What a class needs whose core cannot be copied: it is built anew, and continues from the state."""

    scene: Scene

    def _build(self, scene: Scene, integrator: str | None, dt: float | None) -> None:
        raise NotImplementedError

    def state(self) -> dict[str, Any]:
        """All that changes while the scene moves."""
        raise NotImplementedError

    def set_state(self, state: dict[str, Any]) -> None:
        """Continue from what `state` gave."""
        raise NotImplementedError

    def __reduce__(self) -> tuple[Any, ...]:
        """What copies and pickles hold: scene, method, step, state, and the attributes of a user's own class."""
        own = {name: value for name, value in self.__dict__.items() if name not in MADE}
        return _remade, (type(self), self.scene, self._built_with(), self.state(), own)

    def _built_with(self) -> tuple[str | None, float | None]:
        """Method and step by which it is built again; a step that is chosen by its error is none."""
        core = self.__dict__["_core"]
        return core.integrator, None if core.is_adaptive else core.dt


def _remade(
    kind: type[Copies],
    scene: Scene,
    built_with: tuple[str | None, float | None],
    state: dict[str, Any],
    own: dict[str, Any],
) -> Copies:
    """A simulation as it was when it was copied or pickled."""
    made = kind.__new__(kind)
    made._build(scene, *built_with)
    made.set_state(state)
    made.__dict__.update(own)
    return made
