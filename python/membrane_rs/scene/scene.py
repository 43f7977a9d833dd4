"""A scene: what is simulated, made of what, under which laws, with which parts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, TypeVar, overload

from membrane_rs._files import output_errors, path_of, write_text
from membrane_rs._validation import check_text, computable, show
from membrane_rs.errors import InputTypeError, SceneError
from membrane_rs.folding.pattern import pattern_of
from membrane_rs.material import Material
from membrane_rs.mesh import Mesh
from membrane_rs.scene.assembly import Assembly
from membrane_rs.scene.bodies import BODIES, Body
from membrane_rs.scene.builder import Builder
from membrane_rs.scene.laws import LAWS, Law
from membrane_rs.scene.parts import PARTS, Part
from membrane_rs.scene.run_settings import RunSettings
from membrane_rs.scene.stage import Stage
from membrane_rs.scene.staging import check_same_nodes, check_stages, in_numbers, planned_starts, staged
from membrane_rs.scene.toml import MESH_FILE, SceneContent, pattern_name, read_scene, write_scene
from membrane_rs.scene.values import unit_at, value_at, with_values

SCENE_FILE = "scene.toml"
LONGEST_NAME = 100

L = TypeVar("L", bound=Law)


@dataclass(frozen=True, eq=False)
class Scene:
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
        _check_type("mesh", self.mesh, (Mesh, type(None)), "a Mesh")
        _check_type("material", self.material, (Material, type(None)), "a Material")
        _check_type("name", self.name, (str,), "a text")
        _check_name(self.name)
        _check_type("run", self.run, (RunSettings,), "RunSettings")
        object.__setattr__(self, "laws", _checked("laws", self.laws, tuple(LAWS.values())))
        object.__setattr__(self, "parts", _checked("parts", self.parts, tuple(PARTS.values())))
        object.__setattr__(self, "bodies", _checked("bodies", self.bodies, tuple(BODIES.values())))
        _check_names(self.bodies)
        kinds = [law.kind for law in self.laws]
        twice = next((kind for kind in kinds if kinds.count(kind) > 1), None)
        if twice:
            raise SceneError(f"laws.{twice}: is there {kinds.count(twice)} times; a scene holds one of each kind")
        self._check_part_names()
        object.__setattr__(self, "stages", _checked("stages", self.stages, (Stage,)))
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
            _check_name(part.name, f"parts[{k}].name")
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

        Raises
        ------
        SceneError
            No such stage, or values that the scene refuses.
        """
        if not 0 <= index < len(self.stages):
            raise SceneError(f"stage {show(index)}: must be from 0 to {len(self.stages) - 1}")
        planned = tuple(planned_starts(self.stages)[: index + 1])
        given = planned if starts is None else tuple(float(time) for time in starts)
        if given != planned:
            return staged(self, index, given)
        if index not in self._staged:
            self._staged[index] = staged(self, index, planned)
        return self._staged[index]

    def with_values(self, values: Mapping[str, Any]) -> Scene:
        """The scene with other values, by dotted keys.

        Parameters
        ----------
        values : mapping of str to object
            Values, in SI units or as text with a unit ("7.5 um"), by keys as in scene files: "material.thickness",
            "laws.creases.stiffness", "parts.<name or index>.mass", "bodies.<name>.radius", "run.dt", "name",
            "stages.<name or index>.duration", and "mesh.fold_lines", of the pattern that made the mesh, which is then
            made anew. A key of a law that the scene lacks adds the law, with defaults for all else. A law, part or body
            by itself ("laws.creases") takes True (with its defaults, unless it is there), False (without it), or a
            table of several keys. Keys go into schedules and into what stages set: "laws.spin.schedule.ease",
            "stages.deploy.set.laws.creases.stiffness".
            None takes an optional value away.

        Returns
        -------
        Scene
            A new one; this one is as it was.

        Raises
        ------
        SceneError
            No such key, with the nearest one; two values for one key; values that the rest of the scene refuses.
        InputError, InputTypeError
            A value outside its range, or of a wrong type.

        Examples
        --------
        >>> from membrane_rs import scenes
        >>> scene = scenes.load("okuizumi-model-1").with_values({"laws.creases.stiffness": 20, "mesh.fold_lines": 3})
        >>> scene.law("creases").stiffness, scene.mesh.source.strips
        (20.0, 4)
        """
        return with_values(self, values)

    def value(self, key: str) -> Any:
        """The value of a dotted key, in SI units: what `with_values` sets. Raises SceneError for one without a value.

        >>> from membrane_rs import scenes
        >>> scenes.load("okuizumi-model-1").with_values({"material.thickness": "12.5 um"}).value("material.thickness")
        1.25e-05
        """
        return self.name if key == "name" else value_at(self, key)

    def unit(self, key: str) -> str:
        """The unit of the value of a dotted key; empty for a plain number, and for what is none.

        >>> from membrane_rs import scenes
        >>> scenes.load("okuizumi-model-1").unit("laws.spin.frequency")
        'Hz'
        """
        return "" if key == "name" else unit_at(self, key)

    @cached_property
    def _staged(self) -> dict[int, Scene]:
        return {}

    @classmethod
    def from_toml(cls, path: str | Path) -> Scene:
        """Read a scene file, and the mesh file beside it if it names one.

        Raises
        ------
        MissingFileError
            No such file.
        SceneError
            Anything in it that is wrong, with file, key, value and allowed range.
        """
        path = path_of(path)
        content = read_scene(path)
        try:
            return cls(**vars(content))
        except SceneError as error:
            raise SceneError(f"{path}: {error}") from None

    def to_toml(self) -> str:
        """The scene as TOML, all values resolved. A mesh that no pattern made is named, not written."""
        return write_scene(
            SceneContent(
                self.mesh,
                self.material,
                tuple(self.laws),
                tuple(self.parts),
                self.name,
                self.run,
                stages=tuple(self.stages),
                bodies=tuple(self.bodies),
            )
        )

    def save(self, folder: str | Path) -> None:
        """Write scene.toml into a folder, and mesh.npz if no folding pattern made the mesh.

        Raises
        ------
        OutputError
            The folder cannot be written.
        """
        folder = path_of(folder, "folder")
        with output_errors(folder):
            folder.mkdir(parents=True, exist_ok=True)
        if self.mesh is not None and pattern_name(self.mesh) is None:
            self.mesh.save(folder / MESH_FILE)
        write_text(folder / SCENE_FILE, self.to_toml())

    @overload
    def law(self, kind: type[L]) -> L | None: ...

    @overload
    def law(self, kind: str) -> Law | None: ...

    def law(self, kind: str | type[Law]) -> Law | None:
        """The scene's law of a kind ("springs", ... or `Springs`, ...), or None."""
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
        """
        return self._assembly

    def counts(self) -> dict[str, int]:
        """How large the scene is.

        Returns
        -------
        dict
            "masses", "springs", "elements" as the paper counts them (the petals of a sail apart, cords
            included), and the true counts: "nodes", "edges" (springs), "triangles", "hinges".
        """
        assembly, mesh = self._assembly, self.mesh
        edges = 0 if mesh is None else len(mesh.edges)
        mesh_nodes = 0 if mesh is None else len(mesh.reference)
        own = {"masses": mesh_nodes, "springs": edges, "elements": len(assembly.triangles)}
        pattern = pattern_of(mesh)
        own |= (pattern.counts() if pattern is not None else None) or {}
        cords = len(assembly.cords)
        return {
            "masses": own["masses"] + assembly.node_count - mesh_nodes,
            "springs": own["springs"] + cords,
            "elements": own["elements"],
            "nodes": assembly.node_count,
            "edges": edges + cords,
            "triangles": len(assembly.triangles),
            "hinges": len(assembly.creases.nodes),
        }

    @cached_property
    def _assembly(self) -> Assembly:
        if self.stages:
            return self.staged(0).assemble()
        builder = Builder(self.mesh)
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


OF_PARTS = ("tethers", "bridges", *(part.working_law for part in PARTS.values() if part.working_law is not None))
"""Laws of the core that come with parts."""
OF_ENERGY = ("kinetic", "error", "of_changes", "turned_over")
"""Terms of the energy, and what else history.csv has in a column energy_<name>, by old names too."""


def _check_names(bodies: Sequence[Body]) -> None:
    """Each body has a name of its own among laws, bodies and their frictions, and the terms of the energy."""
    taken = dict.fromkeys((*LAWS, *OF_PARTS), "a law") | dict.fromkeys(OF_ENERGY, "a term of the energy")
    for k, body in enumerate(bodies):
        for name in filter(None, (body.name, body.friction_name)):
            if name in taken:
                what = f"{name} is the name of {taken[name]} too; rename it"
                raise SceneError(f"bodies[{k}].name = {show(body.name)}: {what}")
            taken[name] = f"bodies[{k}]"


def _check_type(name: str, value: object, kinds: tuple[type, ...], wanted: str) -> None:
    if not isinstance(value, kinds):
        raise InputTypeError(f"Scene.{name} = {show(value)}: must be {wanted}")


def _check_name(name: str, where: str = "Scene.name") -> None:
    """The name becomes a folder's, so it must be one plain component of a path, which files can hold."""
    check_text(name, f"{where} =", SceneError)
    if name in ("", ".", "..") or len(name) > LONGEST_NAME or any(sign in name for sign in "/\\\0"):
        raise SceneError(
            f"{where} = {show(name)}: names a folder; must be 1 to {LONGEST_NAME} characters without slash, "
            "backslash or NUL, and neither '.' nor '..'"
        )


def _checked(name: str, items: object, kinds: tuple[type, ...]) -> tuple[object, ...]:
    if isinstance(items, (str, bytes)) or not isinstance(items, Sequence):
        raise InputTypeError(f"Scene.{name} = {show(items)}: must be a list of {name}")
    for i, item in enumerate(items):
        known = ", ".join(kind.__name__ for kind in kinds)
        _check_type(f"{name}[{i}]", item, kinds, f"one of {known}; with its brackets")
    return tuple(items)
