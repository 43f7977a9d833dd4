"""Forces on single nodes."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import asdict, field
from typing import Annotated, Any, ClassVar, Literal

from membrane_rs._validation import Nodes, Unit, Vector, validated
from membrane_rs.analysis.extent import span
from membrane_rs.scene.builder import Builder
from membrane_rs.scene.law import Law, Surroundings
from membrane_rs.scene.laws._factor import largest_factor
from membrane_rs.scene.plausible import FILM, STRETCHED, Doubt, implausible
from membrane_rs.scene.schedule import Schedule


@validated
class PointForces(Law):
    """A force on each of some nodes, from outside, such as a pull by hand, a thruster or a load of a test.

    The force is that on each node, not their sum. It keeps its direction in the turning frame or in inertial space,
    and follows a factor of time. Its work is external: that on the velocities in the turning frame, or in space where
    the hub is free. On a free hub its torque is one from outside, and in six degrees of freedom it moves the whole.

    Parameters
    ----------
    nodes : str or sequence of int
        A node set, or node indices.
    force : tuple of float
        On each of the nodes (x, y, z) [N].
    frame : str
        "turning": the force turns with the hub. "inertial": it is fixed in inertial space, as `Gravity` is.
    factor : Schedule or None
        By which the force is multiplied, as a function of time [-]. None: 1. By keyword alone.

    Raises
    ------
    InputError, InputTypeError
        A value outside its range, or of a wrong type.

    Examples
    --------
    >>> from membrane_rs import PointForces, Schedule
    >>> pull = PointForces("end", (0.0, 0.0, 0.01), factor=Schedule([0.0, 0.5], [0.0, 1.0]))
    >>> pull.frame, pull.factor.at(0.25)
    ('turning', 0.5)
    """

    kind: ClassVar[str] = "point_forces"
    exerts_outside_torque: ClassVar[bool] = True
    nodes: Nodes
    force: Annotated[Vector, Unit("N")]
    frame: Literal["turning", "inertial"] = "turning"
    factor: Schedule | None = field(default=None, kw_only=True)

    def core_parameters(self) -> dict[str, Any]:
        """All but the nodes, which are those of the model."""
        return {name: value for name, value in asdict(self).items() if name != "nodes"}

    @property
    def numbering_field(self) -> str | None:
        """The nodes, where they are indices."""
        return None if isinstance(self.nodes, str) else "nodes"

    def add_contacts(self, builder: Builder) -> None:
        """Name its nodes. Raises SceneError for nodes that are not there."""
        builder.load(builder.nodes(self.nodes, f"laws.{self.kind}"))

    def implausible_values(self, scene: Surroundings, where: str) -> Iterator[Doubt]:
        """All forces together stretch a film less than `STRETCHED` where they pull along its whole width."""
        if scene.mesh is None or scene.material is None:
            return
        count, width = len(scene.assemble().loaded), span(scene.mesh.reference)
        most = STRETCHED * scene.material.youngs_modulus * scene.material.thickness * width / max(count, 1)
        size = math.hypot(*self.force) * largest_factor(self.factor)
        reason = f"on {count} nodes it would stretch the film, {width:.4g} m wide, by more than {100 * STRETCHED:g} %"
        units, derived = {"mN": 1e-3, "uN": 1e-6}, (*FILM, f"{where}.nodes")
        yield from implausible(f"{where}.force", size, "N", reason, most=most, units=units, derived_from=derived)

    def why_idle(self, scene: Surroundings) -> str | None:
        """Forces of no strength."""
        if not any(self.force):
            return "its force is 0"
        return "its factor is 0" if largest_factor(self.factor) == 0.0 else None
