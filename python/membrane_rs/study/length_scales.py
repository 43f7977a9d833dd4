"""Length scales in place of the lengths that the paper's formulas take from the mesh.

Four of the paper's quantities contain a length of the mesh: the critical strain (alpha pi^2 h^2 / (12 L^2)), the force
at which a crease buckles (k times alpha_c pi^2 h^2 / (12 L)), the stiffness of a crease per length (beta E J / H), and
the dashpots (2 zeta sqrt(k m), where m is proportional to L^2). On a finer mesh each has another value. With length
scales of their own they are properties of the film; docs/mesh_parameters.md shows to which degree. So is the bending
stiffness of the film, which resists the wrinkles that a mesh resolves.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from membrane_rs._renamed import Renamed
from membrane_rs._validation import Flag, Positive, check_kind, validated
from membrane_rs.errors import InputError
from membrane_rs.scene import Scene
from membrane_rs.scene.laws import Bending, SpringDamping, Springs

PLATE = 1.0
"""alpha of a film that bends, near the plate's own 1/(1 - nu^2) [-]."""


@validated
class LengthScales:
    """Physical length scales [m]; None: the length of the mesh, the paper's form.

    Attributes
    ----------
    buckling : float or None
        In the critical strain of the film [m]: `Springs.buckling_length`.
    crease : float or None
        In the force at which a crease buckles [m]: `Springs.crease_length`.
    facet : float or None
        In the stiffness of a crease [m]: `Creases.length_scale`.
    damping : float or None
        Of the dashpots [m]: `SpringDamping.length`.
    tension_only : bool
        The film bears no compression, alpha = alpha_c = 0: a tension field.
    bending : bool
        The film has the bending stiffness of a plate (`Bending`), and buckles as a plate between the nodes does,
        alpha = alpha_c = 1.

    Raises
    ------
    InputError, InputTypeError
        A length that is not above 0, or no number.

    Examples
    --------
    >>> from membrane_rs import scenes
    >>> from membrane_rs.study import LengthScales
    >>> LengthScales(buckling=0.012).of(scenes.load("okuizumi-model-1")).law("springs").buckling_length
    0.012
    """

    buckling: Positive | None = None
    crease: Positive | None = None
    facet: Positive | None = None
    damping: Positive | None = None
    tension_only: Flag = False
    bending: Flag = False

    wing = Renamed("facet")

    def of(self, scene: Scene) -> Scene:
        """The scene with these length scales in its laws.

        Parameters
        ----------
        scene : Scene
            With the mesh's own lengths.

        Returns
        -------
        Scene
            A new one.

        Raises
        ------
        InputTypeError
            No scene.
        """
        check_kind(scene, Scene, "scene", "a Scene")
        lengths = {"buckling": self.buckling, "crease": self.crease, "facet": self.facet, "damping": self.damping}
        laws = [law.with_lengths(lengths) for law in scene.laws]
        if self.tension_only:
            laws = [law.without_compression() for law in laws]
        if self.bending:
            laws = [law.with_buckling(PLATE) for law in laws] + ([] if scene.law(Bending) else [Bending()])
        return replace(scene, laws=laws)


PAPER = LengthScales()
"""The paper's form."""
STRAIN = LengthScales(buckling=0.012, facet=0.011)
"""One critical strain and one crease stiffness on every mesh; dashpots and the creases' own force depend on it."""
PHYSICAL = LengthScales(buckling=0.012, crease=0.010, facet=0.011, damping=0.011)
"""`agreeing` for the paper's model 1, in whole millimetres."""
TENSION = LengthScales(facet=0.011, damping=0.011, tension_only=True)
"""A film that wrinkles at zero compressive stress."""
BENDING = LengthScales(facet=0.011, damping=0.011, bending=True)
"""A film that bends."""
FORMS = {"paper": PAPER, "strain": STRAIN, "physical": PHYSICAL, "tension": TENSION, "bending": BENDING}
"""The forms of a mesh study, by name."""


def agreeing(scene: Scene) -> LengthScales:
    """The length scales with which the physical form equals the paper's on average over the scene's own mesh.

    With e the critical strain and N = k e L the force of an edge at buckling, these sums over edges of the reference
    are equal in both forms:

        film      sum of N L (the mean stress at which the film buckles)
        creases   sum of N L (the mean force along a crease)
        facets    the mean height of the creases' facets
        dashpots  sum of c L^2 (the dissipation at an isotropic rate of strain)

    Parameters
    ----------
    scene : Scene
        With film, springs, creases and damping.

    Returns
    -------
    LengthScales
        [m]

    Raises
    ------
    InputError
        A scene without film, springs, creases or damping, or with creases that are no stronger than its film.

    Examples
    --------
    >>> from membrane_rs import scenes
    >>> from membrane_rs.study import agreeing
    >>> scales = agreeing(scenes.load("okuizumi-model-1"))
    >>> 0.005 < scales.buckling < 0.02
    True
    """
    mesh, film, springs, damping = scene.mesh, scene.material, scene.law(Springs), scene.law(SpringDamping)
    if mesh is None or film is None or springs is None or damping is None or not len(mesh.creases):
        raise InputError(f"scene {scene.name!r}: agreeing lengths need a film of springs, with creases and damping")
    alpha, more = springs.buckling, springs.buckling_on_creases - springs.buckling
    if alpha <= 0.0 or more <= 0.0:
        raise InputError(
            f"scene {scene.name!r}: laws.springs.buckling_on_creases = {springs.buckling_on_creases}: must be greater "
            f"than laws.springs.buckling = {alpha}, which must be greater than 0"
        )
    k, length = mesh.spring_constants(film, clip=scene.negative_springs == "clip"), mesh.edge_lengths
    number = {(int(a), int(b)): row for row, (a, b) in enumerate(mesh.edges)}
    creases = [number[min(a, b), max(a, b)] for a, b in mesh.creases.tolist()]
    plain = np.ones(len(k), dtype=bool)
    plain[creases] = False
    buckling = float(np.sqrt(np.sum(k[plain] * length[plain] ** 2) / np.sum(k[plain])))
    on, of = k[creases], length[creases]
    own = springs.buckling_on_creases * np.sum(on) - alpha * np.sum(on * of**2) / buckling**2
    areas = np.zeros(len(k))
    corners = np.sort(mesh.triangles, axis=1)
    for a, b in ((0, 1), (0, 2), (1, 2)):
        rows = [number[i, j] for i, j in corners[:, [a, b]].tolist()]
        np.add.at(areas, rows, mesh.areas())
    masses = damping.mass_of(mesh.masses(film)[mesh.edges])
    square = damping.mass_of([[film.density * film.thickness] * 2])
    return LengthScales(
        buckling=buckling,
        crease=float(more * np.sum(on * of) / own),
        facet=float(np.mean(areas[creases] / of)),
        damping=float(np.sum(np.sqrt(k * masses) * length**2) / np.sum(np.sqrt(k * square) * length**2)),
    )
