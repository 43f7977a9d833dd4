"""A scene: what is simulated, made of what, under which laws, with which parts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, TypeVar, overload

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs._files import made_folder, path_of, write_text
from membrane_rs._html import Card, HasCard
from membrane_rs._validation import computable, show
from membrane_rs.errors import InputTypeError, SceneError
from membrane_rs.material import Material
from membrane_rs.mesh import Mesh
from membrane_rs.scene.assembly import Assembly
from membrane_rs.scene.bodies import BODIES, Body
from membrane_rs.scene.builder import Builder
from membrane_rs.scene.card import card_of, text_of
from membrane_rs.scene.counts import counts_of
from membrane_rs.scene.laws import LAWS, Law
from membrane_rs.scene.members import check_name, check_names, check_type, checked
from membrane_rs.scene.parts import PARTS, Part
from membrane_rs.scene.run_settings import RunSettings
from membrane_rs.scene.stage import Stage
from membrane_rs.scene.staging import check_same_nodes, check_stages, checked_starts, in_numbers, planned_starts, staged
from membrane_rs.scene.toml import MESH_FILE, SceneContent, pattern_name, read_scene, write_scene
from membrane_rs.scene.values import Valued

SCENE_FILE = "scene.toml"

L = TypeVar("L", bound=Law)


@dataclass(frozen=True, eq=False)
class Scene(Valued, HasCard):
    """Mesh, material, laws and parts, checked against each other.

    Parameters
    ----------
    mesh : Mesh or None
        The membrane. None: a scene of cords alone.
    material : Material or None
        Of the membrane; needed with a mesh.
    laws : sequence of laws
        At most one of each kind; see `membrane_rs.scene.laws`. A law left out costs nothing.
    parts : sequence of parts
        See `membrane_rs.scene.parts`.
    bodies : sequence of bodies
        Cylinders and planes of prescribed motion; see `membrane_rs.scene.bodies`.
    name : str
        For titles and folders: not empty, no slash or backslash, at most 100 characters.
    run : RunSettings
        How the scene is run unless the caller says otherwise. With stages `until` is their end, whatever is given.
    stages : sequence of Stage
        One after the other in one run, at most 100. What a stage changes holds for that stage; laws, parts and
        bodies must be in the scene, and stages are `without` them.

    Raises
    ------
    SceneError
        Two laws of a kind, two laws of the film, a mesh without material, nothing at all, a node set
        that is not there, a name that is none for a folder, two parts of a name, a stage that the scene does not fit.
    InputTypeError
        Something that is no mesh, material, law or part.

    Examples
    --------
    A strip of rubber that hangs from its start:

    >>> from membrane_rs import Fixed, Gravity, Material, Scene, Springs
    >>> from membrane_rs.folding import Strip
    >>> rubber = Material(youngs_modulus=1e6, poisson_ratio=0.33, density=1000.0, thickness=1e-3)
    >>> strip = Strip(length=0.1, width=0.01, rows=1, columns=10).mesh()
    >>> scene = Scene(strip, rubber, [Springs(), Gravity()], [Fixed("start")], name="strip")
    >>> scene.law("gravity").acceleration
    (0.0, 0.0, -9.81)
    >>> scene.counts()["nodes"], scene.assemble().node_count
    (22, 22)
    >>> print(scene.to_toml().splitlines()[0])
    name = "strip"
    """

    mesh: Mesh | None
    material: Material | None
    laws: Sequence[Law] = ()
    parts: Sequence[Part] = ()
    bodies: Sequence[Body] = field(default=(), kw_only=True)
    name: str = field(default="scene", kw_only=True)
    run: RunSettings = field(default_factory=RunSettings, kw_only=True)
    stages: Sequence[Stage] = field(default=(), kw_only=True)

    def __post_init__(self) -> None:
        """Check the parts of the scene against each other."""
        check_type("mesh", self.mesh, (Mesh, type(None)), "a Mesh")
        check_type("material", self.material, (Material, type(None)), "a Material")
        check_type("name", self.name, (str,), "a text")
        check_name(self.name)
        check_type("run", self.run, (RunSettings,), "RunSettings")
        object.__setattr__(self, "laws", checked("laws", self.laws, tuple(LAWS.values())))
        object.__setattr__(self, "parts", checked("parts", self.parts, tuple(PARTS.values())))
        object.__setattr__(self, "bodies", checked("bodies", self.bodies, tuple(BODIES.values())))
        check_names(self.bodies)
        kinds = [law.kind for law in self.laws]
        twice = next((kind for kind in kinds if kinds.count(kind) > 1), None)
        if twice:
            raise SceneError(f"laws.{twice}: is there {kinds.count(twice)} times; a scene holds one of each kind")
        self._check_part_names()
        object.__setattr__(self, "stages", checked("stages", self.stages, (Stage,)))
        if self.stages:
            self._check_stages()
            return
        films = [f"laws.{law.kind}" for law in self.laws if law.is_film]
        if len(films) > 1:
            raise SceneError(f"{' and '.join(films)}: each is the law of the film; leave all but one out")
        if self.mesh is not None and self.material is None:
            raise SceneError("material: is missing; a mesh needs one")
        if self._assembly.node_count == 0:
            raise SceneError("mesh: is missing, and no part of kind 'tether' replaces it; a scene needs nodes")

    def _check_part_names(self) -> None:
        names = [*LAWS, *(body.name for body in self.bodies)]
        for k, part in enumerate(self.parts):
            if part.name is None:
                continue
            check_name(part.name, f"parts[{k}].name")
            if part.name in names:
                what = "is that of a law, of a body or of another part; rename it"
                raise SceneError(f"parts[{k}].name = {show(part.name)}: {what}")
            names.append(part.name)

    def _check_stages(self) -> None:
        """Check that the stages fit the scene, each as a scene of its own, and end the run with them."""
        check_stages(self)
        object.__setattr__(self, "stages", in_numbers(self))
        object.__setattr__(self, "run", replace(self.run, until=planned_starts(self.stages)[-1]))
        first = self.staged(0).assemble()
        for k in range(1, len(self.stages)):
            check_same_nodes(first, self.staged(k).assemble(), f"stages[{k}]")

    def staged(self, index: int, starts: Sequence[float] | None = None) -> Scene:
        """The scene of one stage, without stages.

        Its mesh has the positions of this scene's start, whichever stage it is: where a later stage begins is known
        only in a run. To go on from there, `Simulation(scene.staged(k), start=other)`.

        Parameters
        ----------
        index : int
            Of the stage, from 0.
        starts : sequence of float, optional
            Start of each stage up to it [s], from which its schedules count. Default: as if no measure ended a stage.

        Returns
        -------
        Scene
            Without stages.

        Raises
        ------
        SceneError
            No such stage, or values that the scene refuses.
        InputError, InputTypeError
            No whole number; starts that are no ascending times, or not one for each stage up to it.

        Examples
        --------
        >>> from membrane_rs import scenes
        >>> scene = scenes.load("okuizumi-stage-1")
        >>> scene.stages[0].name, scene.staged(0).stages
        ('settle in the roll', ())
        """
        if isinstance(index, bool) or not isinstance(index, int):
            raise InputTypeError(f"index = {show(index)}: must be a whole number, from 0 to {len(self.stages) - 1}")
        if not self.stages:
            raise SceneError(f"stage {show(index)}: the scene has no stages; it is the scene of its whole run itself")
        if not 0 <= index < len(self.stages):
            raise SceneError(f"stage {show(index)}: must be from 0 to {len(self.stages) - 1}")
        planned = tuple(planned_starts(self.stages)[: index + 1])
        given = planned if starts is None else checked_starts(starts, index)
        if given != planned:
            return staged(self, index, given)
        if index not in self._staged:
            self._staged[index] = staged(self, index, planned)
        return self._staged[index]

    @cached_property
    def _staged(self) -> dict[int, Scene]:
        return {}

    @classmethod
    def from_toml(cls, path: str | Path) -> Scene:
        """Read a scene file, and the mesh file beside it if it names one.

        Parameters
        ----------
        path : path
            Of the scene file.

        Returns
        -------
        Scene
            As the file says.

        Raises
        ------
        MissingFileError
            No such file.
        SceneError
            Anything in it that is wrong, with file, key, value and allowed range.
        InputError, InputTypeError
            No path.

        Examples
        --------
        >>> import tempfile
        >>> from pathlib import Path
        >>> from membrane_rs import Scene, scenes
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     scenes.load("spinning-tether").save(folder)
        ...     Scene.from_toml(Path(folder) / "scene.toml").name
        'spinning-tether'
        """
        path = path_of(path)
        content = read_scene(path)
        try:
            return cls(**vars(content))
        except SceneError as error:
            raise SceneError(f"{path}: {error}") from None

    def to_toml(self) -> str:
        """The scene as TOML, all values resolved. A mesh that no pattern made is named, not written.

        Returns
        -------
        str
            A scene file, which `from_toml` reads.
        """
        lists: dict[str, Any] = {name: tuple(getattr(self, name)) for name in ("laws", "parts", "stages", "bodies")}
        return write_scene(SceneContent(mesh=self.mesh, material=self.material, name=self.name, run=self.run, **lists))

    def save(self, folder: str | Path) -> None:
        """Write scene.toml into a folder, and mesh.npz if no folding pattern made the mesh.

        Parameters
        ----------
        folder : path
            Where to; it is made.

        Raises
        ------
        OutputError
            The folder cannot be written.
        InputError, InputTypeError
            No path.

        Examples
        --------
        See `from_toml`.

        >>> from membrane_rs import scenes
        >>> scenes.load("spinning-tether").save("tether")
        """
        folder = made_folder(folder)
        if self.mesh is not None and pattern_name(self.mesh) is None:
            self.mesh.save(folder / MESH_FILE)
        write_text(folder / SCENE_FILE, self.to_toml())

    @overload
    def law(self, kind: type[L]) -> L | None: ...

    @overload
    def law(self, kind: str) -> Law | None: ...

    def law(self, kind: str | type[Law]) -> Law | None:
        """The scene's law of a kind ("springs", ... or `Springs`, ...), or None.

        Parameters
        ----------
        kind : str or class of a law
            "springs", ... or `Springs`, ...

        Returns
        -------
        Law or None
            None where the scene has none of that kind.

        Raises
        ------
        InputTypeError
            Neither a name nor a class of a law.
        """
        name = kind if isinstance(kind, str) else getattr(kind, "kind", None)
        if name is None:
            raise InputTypeError(f"kind = {show(kind)}: must be the name or the class of a law, such as 'springs'")
        return next((law for law in self.laws if law.kind == name), None)

    @property
    def negative_springs(self) -> str | None:
        """What is done with negative spring constants, by the law that has a rule; None without one."""
        rules = (law.negative_springs for law in self.laws)
        return next((rule for rule in rules if rule is not None), None)

    def assemble(self) -> Assembly:
        """The scene as plain read-only arrays: nodes of the mesh first, then those of the cords. With stages, that of
        the first one.

        Returns
        -------
        Assembly
            Nodes, triangles, creases, cords, masses and supports.
        """
        return self._assembly

    def membrane_stiffness(self) -> Floats:
        """E h of each triangle, as simulated: those of regions are their own, and softening is carried out.

        Returns
        -------
        (m,) float64
            [N/m]; none without a membrane.

        Examples
        --------
        >>> from membrane_rs import scenes
        >>> scene = scenes.load("okuizumi-model-1")
        >>> stiffness = scene.membrane_stiffness()
        >>> bool((scene.mesh.spring_constants(scene.material, stiffness=stiffness) > 0.0).all())
        True
        """
        if self.stages:
            return self.staged(0).membrane_stiffness()
        material, assembly = self.as_simulated.material, self.assemble()
        whole = 0.0 if material is None else material.youngs_modulus * material.thickness
        found = np.full(len(assembly.triangles), whole)
        for region in assembly.regions:
            found[region.triangles] = region.youngs_modulus * region.thickness
        return found

    def counts(self) -> dict[str, int]:
        """How large the scene is.

        Returns
        -------
        dict
            "masses", "springs", "elements" as the paper counts them (the petals of a sail apart, cords
            included), and the true counts: "nodes", "edges" (springs), "triangles", "hinges".
        """
        return counts_of(self.mesh, self._assembly)

    def __repr__(self) -> str:
        return text_of(self, self._assembly)

    def _card(self) -> Card:
        """What notebooks show: the scene at its start."""
        return card_of(self, self._assembly, self.counts())

    @cached_property
    def as_simulated(self) -> Scene:
        """The scene of one stage with the softening of its material carried out; itself where it has none.

        With f the softening, in-plane stretch alone is softer: the film has E/f, and the springs that buckle, creases
        and dashpots have factors by which their forces stay. Cords have f times their mass, and bridges a stiffness
        over f, so that neither sets the step. `assemble` gives these values.
        """
        material = self.material
        if material is None or material.softening is None or self.stages:
            return self
        factor = material.softening
        laws = [law.with_softened_film(factor) for law in self.laws]
        parts = [part.with_softened_film(factor) for part in self.parts]
        return replace(self, material=material.as_simulated(), laws=laws, parts=parts)

    @cached_property
    def _assembly(self) -> Assembly:
        if self.stages:
            return self.staged(0).assemble()
        if self.as_simulated is not self:
            return self.as_simulated.assemble()
        builder = Builder(self.mesh, self.material)
        for k, part in enumerate(self.parts):
            with computable(f"parts[{k}]", SceneError):
                part.add_nodes(builder, f"parts[{k}]")
        for k, part in enumerate(self.parts):
            part.add_loads(builder, f"parts[{k}]")
        builder.check_links()
        for law in self.laws:
            law.add_contacts(builder)
        with computable("parts", SceneError):
            return builder.assembly()
