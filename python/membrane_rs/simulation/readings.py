"""What is read off the laws of a scene: stress of the film, tension of the cords, loads on bodies."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from membrane_rs._arrays import Floats, Ints
from membrane_rs._renamed import RenamedKeys
from membrane_rs._validation import check_text, show
from membrane_rs.errors import InputTypeError
from membrane_rs.mesh.crossings import LISTED, Crossings, crossings
from membrane_rs.scene import Scene
from membrane_rs.scene.assembly import Assembly
from membrane_rs.scene.bodies import Body
from membrane_rs.scene.laws import Law
from membrane_rs.simulation.hub import HubReadings


@dataclass(frozen=True, eq=False)
class FilmStress:
    """Stress of the film by its law, for each of m triangles: the second Piola-Kirchhoff stress, per reference area.

    Attributes
    ----------
    principal : (m, 2) float
        Principal stresses, the larger first [Pa].
    directions : (m, 2, 3) float
        Their directions in the present shape [-], unit vectors in the plane of the triangle; 0 where a triangle that
        has collapsed to a line or a point leaves them undefined.

    Examples
    --------
    >>> from membrane_rs import Simulation, scenes
    >>> stress = Simulation(scenes.load("spinning-disc")).film_stress()
    >>> stress.principal.shape[1], stress.von_mises.shape == stress.principal.shape[:1]
    (2, True)
    """

    principal: Floats
    directions: Floats

    @property
    def von_mises(self) -> Floats:
        """(m,) von Mises's equivalent stress in plane stress, sqrt(s1^2 - s1 s2 + s2^2) [Pa]."""
        large, small = self.principal.T
        equivalent: Floats = np.sqrt(large * large - large * small + small * small)
        return equivalent


@dataclass(frozen=True, eq=False)
class BodyLoad:
    """What film and cords exert on a body, all its copies together, friction and damping included.

    Attributes
    ----------
    force : (3,) float
        Components along the axes of the turning frame [N].
    torque : (3,) float
        About the origin, along the same axes; the third is what a motor that turns the body about the hub's axis has
        to hold against [N m].
    contact : float
        Sum of the magnitudes of the forces on the nodes [N].

    Examples
    --------
    >>> import dataclasses
    >>> from membrane_rs import Plane, Simulation, scenes
    >>> scene = dataclasses.replace(scenes.load("hanging-strip"), bodies=[Plane("floor", centre=(0.0, 0.0, -1.0))])
    >>> load = Simulation(scene).body_loads()["floor"]
    >>> load.force, load.contact
    (array([-0., -0., -0.]), 0.0)
    """

    force: Floats
    torque: Floats
    contact: float


class Readings(HubReadings):
    """Readings of a scene in motion, each by the laws of the scene."""

    scene: Scene
    assembly: Assembly

    @property
    def positions(self) -> Floats:
        """(N, 3) positions now [m]."""
        raise NotImplementedError

    @cached_property
    def spring_pairs(self) -> Ints:
        """(S, 2) ends of each spring."""
        raise NotImplementedError

    def forces(self, law: str | Law | type[Law] | Body | None = None) -> Floats:
        """(N, 3) forces now [N], of one law or of all.

        Parameters
        ----------
        law : str, law, class of a law or body, optional
            "springs", "creases", ..., the name of a body, or "tethers" and "bridges", which come with those parts.
            Default: all.

        Returns
        -------
        (N, 3) float64
            [N], in the turning frame.

        Raises
        ------
        InputError
            A law that the scene does not hold.
        """
        kind = getattr(law, "kind", None)  # a body has a name of its own beside it
        name = law if law is None or isinstance(law, str) else kind and getattr(law, "name", kind)
        if law is not None and name is None:
            raise InputTypeError(f"law = {show(law)}: must be the name of a law, such as 'springs'")
        check_text(str(name), "law")
        return self._core.forces(name)

    def energies(self) -> dict[str, float]:
        """Energies now [J]: "kinetic", and one for each law that has a potential. Their sum is the mechanical energy.

        "kinetic" is that of the motion relative to the turning frame, and "spin" the centrifugal potential.

        Returns
        -------
        dict of str to float
            [J]
        """
        return self._core.energies()

    def ledger(self) -> dict[str, Any]:
        """The energy balance since the start, or since positions or velocities were last set.

        Returns
        -------
        dict
            "kinetic", "stored" (potential energy of all laws), "work" (done on the system, below zero where damping
            takes energy out), "reference_energy" (the largest change of a single term of the balance so far), all [J];
            "error", the residual of the balance as a share of the reference energy, negative where the method loses
            energy; "stored_by_law", of the laws that have a potential, and "work_by_law", {law: J}; "motor_work" [J],
            that of the motor which turns the hub, on the sail, or of the torque on a free hub: no term of this
            balance, which is that of the turning frame. None where it goes on from a state of an earlier version,
            which did not count it. Once jumps of schedules have put in energy, "changes", {term: J}, where a term is
            "kinetic" or a law.
            "turned_over" is the old name of "reference_energy".
        """
        balance = self._core.ledger()
        terms = {
            "kinetic": balance.kinetic,
            "stored": balance.stored,
            "work": math.fsum(balance.work_by_law.values()),
            "reference_energy": balance.reference_energy,
            "error": balance.error,
            "stored_by_law": balance.stored_by_law,
            "work_by_law": balance.work_by_law,
            "motor_work": balance.motor_work,
            **({"changes": balance.changes} if balance.changes else {}),
        }
        return RenamedKeys("ledger()", terms, {"turned_over": "reference_energy"})

    def spring_strains(self) -> Floats:
        """(S,) strain of each spring, in the order of `spring_pairs`.

        Returns
        -------
        (S,) float64
            [-]
        """
        d = self.positions[self.spring_pairs[:, 1]] - self.positions[self.spring_pairs[:, 0]]
        rest: Floats = np.zeros(0) if self.scene.mesh is None else self.scene.mesh.edge_lengths
        cords = self.assembly.cords.rest_length
        if self.scene.mesh is not None and len(rest) + len(cords) < len(d):
            ends = self.scene.mesh.reference[self.spring_pairs[len(rest) : len(d) - len(cords)]]
            rest = np.concatenate([rest, np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)])
        lengths: Floats = np.concatenate([rest, cords])
        strains: Floats = np.sqrt(np.einsum("ij,ij->i", d, d)) / lengths - 1.0
        hauled = self._core.link_readings("winches")
        if hauled is not None:
            strains[len(rest) + self._hauled] = hauled.strain
        return strains

    @property
    def _hauled(self) -> Ints:
        """Segments of cords whose length changes with time."""
        return self.assembly.cords.winch[:, 0]

    def buckled(self) -> NDArray[np.bool_]:
        """(S,) whether each spring is shorter than its critical length; a slack cord counts as buckled.

        With `Triangles`, an edge is buckled where it is shorter than in the flat mesh, beside a triangle that is
        wrinkled or slack.

        Returns
        -------
        (S,) bool
            In the order of `spring_pairs`.
        """
        found = np.zeros(len(self.spring_pairs), dtype=np.bool_)
        edges = len(self.spring_pairs) - len(self.assembly.cords.nodes)
        of_film = [(law.kind, slice(None, edges)) for law in self.scene.laws if law.is_film]
        for name, rows in (*of_film, ("tethers", slice(edges, None))):
            readings = self._core.link_readings(name)
            if readings is not None:
                found[rows] = readings.buckled
        hauled = self._core.link_readings("winches")
        if hauled is not None:
            found[edges + self._hauled] = hauled.buckled
        films = self._core.film_states()
        if films is not None:
            found[:edges] = films.buckled
        return found

    def film_states(self) -> NDArray[np.int8]:
        """(m,) state of the film in each triangle, by the law `Triangles`: 0 taut, 1 wrinkled, 2 slack; -1 without it.

        A film of springs has no such state: its springs buckle one by one, see `buckled`.

        Returns
        -------
        (m,) int8
            One for each triangle.
        """
        films = self._core.film_states()
        if films is None:
            return np.full(len(self.assembly.triangles), -1, np.int8)
        return films.state.astype(np.int8)

    def crease_angles(self) -> Floats:
        """(c,) crease angles [rad]: pi flat, 0 shut, below 0 where the facets interpenetrate; NaN without the law.

        Returns
        -------
        (c,) float64
            [rad] A crease that is folded against its side has more than pi, and is shut at 2 pi.
        """
        angles = self._core.crease_angles()
        return np.full(len(self.assembly.creases.nodes), np.nan) if angles is None else angles

    def film_stress(self) -> FilmStress:
        """Stress of the film now, elastic, by its law; that of dashpots is not included.

        Of a film of triangles it is the law's own stress, with wrinkles. Of a film of springs it is the mean stress
        of a triangle by the tensions along its sides, each side with the triangle's own part of its spring constant;
        of a film of rectangles that of a rectangle, by its six springs, in both of its triangles.

        Returns
        -------
        FilmStress
            One row per triangle [Pa]; NaN without a law of the film.
        """
        found = self._core.film_stress()
        if found is None:
            count = len(self.assembly.triangles)
            return FilmStress(np.full((count, 2), np.nan), np.full((count, 2, 3), np.nan))
        return FilmStress(found.principal, np.stack([found.first, found.second], axis=1))

    def largest_film_stress(self) -> float:
        """The largest principal stress of `film_stress` now [Pa]; 0 where none is in tension, NaN without a film law.

        Of a film of springs `membrane_rs.results.peak_stress` is another number: that of the film they stand for.

        Returns
        -------
        float
            [Pa]
        """
        found = self._core.largest_film_stress()
        return float("nan") if found is None else found

    def cord_tensions(self) -> Floats:
        """(s,) elastic tension of each segment of the cords now [N], in the order of `assembly.cords`; 0 where slack.

        That of dashpots is not included.

        Returns
        -------
        (s,) float64
            [N]
        """
        found, hauled = self._core.link_readings("tethers"), self._core.link_readings("winches")
        if found is None:
            return np.zeros(0)
        tensions: Floats = found.tension.copy()
        if hauled is not None:
            tensions[self._hauled] = hauled.tension
        return tensions

    def body_loads(self) -> dict[str, BodyLoad]:
        """Force and torque of film and cords on each body now, by its name.

        Returns
        -------
        dict of str to BodyLoad
            By the names of the bodies.
        """
        positions = self._core.positions()
        loads = {}
        for body in self.stage_scene.bodies:
            names = filter(None, (body.name, body.friction_name))
            forces = np.sum([self._core.forces(name) for name in names], axis=0)
            contact = float(np.linalg.norm(forces, axis=1).sum())
            loads[body.name] = BodyLoad(-forces.sum(axis=0), -np.cross(positions, forces).sum(axis=0), contact)
        return loads

    def contact_forces(self) -> Floats:
        """(N, 3) forces of contact of spool and bodies on each node now [N], in the turning frame; 0 without contact.

        The force on spool and bodies is the negative sum over the nodes.

        Returns
        -------
        (N, 3) float64
            [N]
        """
        return self._core.contact_forces()

    def crossings(self, *, limit: int = LISTED) -> Crossings:
        """Pairs of the membrane's triangles that pass through each other now; see `Mesh.crossings`.

        Parameters
        ----------
        limit : int
            Pairs that are listed at most; all are counted.

        Returns
        -------
        Crossings
            As that of a mesh.
        """
        return crossings(self.assembly.triangles, self._core.positions(), limit)
