"""What is shown of a simulation: a line of text, and in notebooks a picture and a table."""

from __future__ import annotations

import math

from membrane_rs._html import Card, HasCard
from membrane_rs.scene.card import lines_of
from membrane_rs.simulation.stopping import StoppableMotion


class ShownMotion(HasCard, StoppableMotion):
    """A motion that says where it is."""

    def __repr__(self) -> str:
        """Scene, method, step and time."""
        stage = f", in {self.stage_name!r}" if self.scene.stages else ""
        what = f"{self.scene.name!r}, {self.integrator}, dt = {self.dt:.4g} s"
        return f"{type(self).__name__}({what}: t = {self.time:.6g} s, {self.step_count} steps{stage})"

    def _card(self) -> Card:
        """What notebooks show: the shape now."""
        rows: list[tuple[str, object]] = [
            ("time [s]", self.time),
            *([("stage", self.stage_name)] if self.scene.stages else []),
            ("method", self.integrator),
            ("step [s]", f"{self.dt:.4g}{', chosen by its error' if self.is_adaptive else ''}"),
            ("steps", self.step_count),
            ("nodes", self.node_count),
            ("hub turned by [deg]", math.degrees(self.hub_angle)),
        ]
        lines = lines_of(self.scene.mesh, self.assembly, self.positions)
        return Card(f"{type(self).__name__} of {self.scene.name}", rows, lines)
