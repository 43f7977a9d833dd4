"""What a frame of a run shows: its nodes, its cells and the fields on them, whether in memory or in a file.

On nodes: velocity [m/s], displacement [m] from the reference. Other fields are of triangles or of lines:

    triangle_strain       triangles  (2,) principal Green-Lagrange strains, larger first
    petal                 triangles  number of the petal, -1 for none
    stress_1, stress_2    triangles  [Pa] principal stresses, larger first, see `Motion.film_stress`
    stress_direction      triangles  (3,) direction of stress_1 in the present shape
    von_mises             triangles  [Pa] von Mises's equivalent stress
    film_state            triangles  0 taut, 1 wrinkled, 2 slack, see `Motion.film_states`
    spring_strain         lines      l / L - 1
    crease_angle          lines      [rad] pi flat, 0 shut, 2 pi shut against its side; NaN for no crease
    buckled               lines      1 below the critical length, else 0; with `Triangles` see `Motion.buckled`
    tension               lines      [N] elastic tension of the segments of cords; NaN elsewhere

Those of the stress are there only with a law of the film, the state while `Triangles` is at work, and the tension only
with cords; stress and tension are in single precision.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from membrane_rs._arrays import Floats, Ints
from membrane_rs._validation import nearest, show
from membrane_rs.analysis.strain import triangle_strains
from membrane_rs.errors import InputError
from membrane_rs.mesh.queries import find_pairs, petal_of_triangles
from membrane_rs.simulation.motion import Motion

Fields = Mapping[str, NDArray[Any]]
"""Fields by their names."""
ON_NODES = ("velocity", "displacement")
ON_TRIANGLES = ("triangle_strain", "petal", "stress_1", "stress_2", "stress_direction", "von_mises", "film_state")
ON_LINES = ("spring_strain", "crease_angle", "buckled", "tension")


class UnknownFieldError(InputError, KeyError):
    """A name that no field of a frame has."""

    __str__ = InputError.__str__


class FieldTable(dict[str, NDArray[Any]]):
    """The fields of a frame on its nodes, its triangles or its lines, which `place` names, such as "on_lines"."""

    def __init__(self, place: str, fields: Fields) -> None:
        super().__init__(fields)
        self.place = place

    def __missing__(self, name: object) -> NDArray[Any]:
        """Raises UnknownFieldError, which is a KeyError too, and names what there is."""
        places = {"on_nodes": ON_NODES, "on_triangles": ON_TRIANGLES, "on_lines": ON_LINES}
        where = next((place for place, known in places.items() if name in known), None)
        if where is not None and where != self.place:
            hint = f"it is a field {where.replace('_', ' ')}: frame.{where}[{show(name)}]"
        elif where is not None:
            hint = f"this run has none, but {', '.join(self) or 'no fields at all'}"
        else:
            hint = nearest(str(name), self) if self else "there are none"
        raise UnknownFieldError(f"{self.place}[{show(name)}]: no such field; {hint}")

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle and copy by place and fields."""
        return type(self), (self.place, dict(self))


@dataclass(frozen=True, eq=False)
class Frame:
    """What a frame shows of a simulation at `time` [s], copied: the simulation may go on while it is written.

    positions (N, 3) [m], velocities (N, 3) [m/s], spring_strains (S,), buckled (S,), crease_angles (c,) [rad]; stress
    of m triangles: principal (m, 2), direction of the first (m, 3), von_mises (m,) [Pa]; film_states (m,);
    cord_tensions (s,) [N].
    """

    time: float
    positions: Floats
    velocities: Floats
    spring_strains: Floats
    buckled: NDArray[np.bool_]
    crease_angles: Floats
    stress: NDArray[np.float32]
    stress_direction: NDArray[np.float32]
    von_mises: NDArray[np.float32]
    film_states: NDArray[np.int8]
    cord_tensions: NDArray[np.float32]

    @classmethod
    def of(cls, sim: Motion) -> Frame:
        """The state of `sim` now."""
        stress = sim.film_stress()
        return cls(
            time=sim.time,
            positions=sim.positions.copy(),
            velocities=sim.velocities.copy(),
            spring_strains=sim.spring_strains(),
            buckled=sim.buckled(),
            crease_angles=sim.crease_angles(),
            stress=stress.principal.astype(np.float32),
            stress_direction=stress.directions[:, 0].astype(np.float32),
            von_mises=stress.von_mises.astype(np.float32),
            film_states=sim.film_states(),
            cord_tensions=sim.cord_tensions().astype(np.float32),
        )

    @property
    def nbytes(self) -> int:
        """Bytes of all its arrays."""
        return sum(value.nbytes for value in vars(self).values() if isinstance(value, np.ndarray))


@dataclass(frozen=True, eq=False)
class FrameData:
    """A frame as arrays.

    Attributes
    ----------
    positions, velocities : (N, 3) float
        Of the nodes, in the frame that turns with the hub [m], [m/s].
    triangles : (m, 3) int
        Corners of the triangles.
    lines : (s, 2) int
        Ends of the springs: the edges of the membrane, then the segments of the cords.
    on_nodes, on_triangles, on_lines : Mapping of str to array
        Fields by their names, one row for each node, triangle or line: see `membrane_rs.results.frame_fields`.
    """

    positions: Floats
    velocities: Floats
    triangles: Ints
    lines: Ints
    on_nodes: Fields
    on_triangles: Fields
    on_lines: Fields


class FrameFields:
    """Makes the fields of the frames of one simulation. What is the same in all of them is worked out once.

    It keeps nothing of the simulation that changes, so that it can be used in another thread.
    """

    def __init__(self, sim: Motion) -> None:
        self.reference = sim.assembly.reference
        self.triangles: Ints = np.asarray(sim.assembly.triangles, dtype=np.int64)
        self.lines: Ints = np.asarray(sim.spring_pairs, dtype=np.int64)
        rows = find_pairs(self.lines, sim.assembly.creases.nodes)
        self._creases, self._crease_rows = rows >= 0, rows[rows >= 0]
        self._petals = petal_of_triangles(self.triangles, sim.assembly.node_sets)
        self._has_stress = any(law.is_film for law in sim.scene.laws) and len(self.triangles) > 0

    def of(self, frame: Frame) -> FrameData:
        """A frame with its fields."""
        return FrameData(
            positions=frame.positions,
            velocities=frame.velocities,
            triangles=self.triangles,
            lines=self.lines,
            on_nodes=FieldTable(
                "on_nodes", {"velocity": frame.velocities, "displacement": frame.positions - self.reference}
            ),
            on_triangles=FieldTable("on_triangles", self._on_triangles(frame) if len(self.triangles) else {}),
            on_lines=FieldTable("on_lines", self._on_lines(frame) if len(self.lines) else {}),
        )

    def _on_triangles(self, frame: Frame) -> Fields:
        found: dict[str, NDArray[Any]] = {
            "triangle_strain": triangle_strains(self.reference, frame.positions, self.triangles),
            "petal": self._petals,
        }
        if self._has_stress:
            found |= {
                "stress_1": frame.stress[:, 0],
                "stress_2": frame.stress[:, 1],
                "stress_direction": frame.stress_direction,
                "von_mises": frame.von_mises,
            }
        if (frame.film_states >= 0).any():
            found["film_state"] = frame.film_states
        return found

    def _on_lines(self, frame: Frame) -> Fields:
        crease_angle = np.full(len(self.lines), np.nan)
        crease_angle[self._crease_rows] = frame.crease_angles[self._creases]
        found: dict[str, NDArray[Any]] = {
            "spring_strain": frame.spring_strains,
            "crease_angle": crease_angle,
            "buckled": frame.buckled.astype(np.int8),
        }
        if len(frame.cord_tensions):
            tension = np.full(len(self.lines), np.nan, np.float32)
            tension[-len(frame.cord_tensions) :] = frame.cord_tensions
            found["tension"] = tension
        return found
