"""The interface of laws, with default implementations."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import asdict, replace
from typing import Any, ClassVar, Literal, Protocol, TypeAlias

import numpy as np
from typing_extensions import Self

from membrane_rs._arrays import Floats
from membrane_rs._validation import validated
from membrane_rs.material import Material
from membrane_rs.mesh import Mesh
from membrane_rs.scene.assembly import Assembly
from membrane_rs.scene.builder import Builder
from membrane_rs.scene.hub import Hub
from membrane_rs.scene.plausible import Doubt
from membrane_rs.scene.run_settings import RunSettings
from membrane_rs.scene.spool import Spool

StiffThrough: TypeAlias = Literal["law", "film"] | None
"""What scales the stiffness or damping of a law: its own values, or Young's modulus of the film."""


class Surroundings(Protocol):
    """The properties of a scene that its laws and parts use."""

    @property
    def mesh(self) -> Mesh | None:
        """The membrane."""

    @property
    def material(self) -> Material | None:
        """Of the membrane."""

    @property
    def run(self) -> RunSettings:
        """How the scene is run."""

    @property
    def laws(self) -> Sequence[Law]:
        """All laws of the scene."""

    def assemble(self) -> Assembly:
        """The scene as arrays."""


@validated
class Law:
    """A law of force as checked values. A law overrides the defaults that do not hold for it.

    Raises
    ------
    InputError, InputTypeError
        A value outside its range, or of a wrong type.

    Examples
    --------
    >>> from membrane_rs.scene.laws import LAWS
    >>> LAWS["mass_damping"](3.0).core_parameters()
    {'rate': 3.0}
    """

    kind: ClassVar[str]
    """Its name in scene files and in the core."""
    stiff_through: ClassVar[StiffThrough] = None
    """What `check` changes to measure how far the law limits the step; None: it does not vary the law."""
    is_film: ClassVar[bool] = False
    """Whether it is the law of the film's in-plane elasticity, of which a scene has one at most."""
    has_rectangles: ClassVar[bool] = False
    """Whether the springs of the film are those of rectangles, with a second diagonal in each."""
    turns_hub: ClassVar[bool] = False
    """Whether it turns the hub, and the frame of the scene with it."""
    accelerates_all: ClassVar[bool] = False
    """Whether it is a field that accelerates all nodes alike, so that a scene without support falls."""
    exerts_outside_torque: ClassVar[bool] = False
    """Whether it is a load from outside that may change the angular momentum of hub and sail about the hub's axis."""
    held_fields: ClassVar[tuple[str, ...]] = ()
    """Fields that hold in later stages too where a stage sets them, and all that is set beside them."""
    acts_while_relaxing: ClassVar[bool] = True
    """Whether it acts while a scene is damped to rest before its start: False where it vanishes at rest, or does not go
    with a frozen time."""
    methods: ClassVar[tuple[str, ...] | None] = None
    """Methods of integration that it goes with; None: all."""
    goes_with_free_hub: ClassVar[bool] = True
    """Whether it goes with a hub that turns freely."""
    length_fields: ClassVar[Mapping[str, str]] = {}
    """Fields that hold a physical length in place of one of the mesh, by what the length is of: "buckling", ..."""

    def core_parameters(self) -> dict[str, Any]:
        """The parameters that the core is given, by name.

        Returns
        -------
        dict of str to object
            Plain values in SI units.
        """
        return asdict(self)

    def replaced_by(self, name: str) -> tuple[str, ...]:
        """Fields that the field of this name stands in place of, where a stage sets it: they get their defaults.

        Parameters
        ----------
        name : str
            Of the field that is set.

        Returns
        -------
        tuple of str
            Names of fields.
        """
        return ()

    def check_set(self, given: Law, names: Collection[str], *, is_first: bool) -> None:
        """Refuse values of these fields that were set in place of those of a law, and have no effect or no meaning.

        Parameters
        ----------
        given : Law
            The law of the scene, in whose place this one stands.
        names : collection of str
            Of the fields.
        is_first : bool
            Whether they hold from the start of the run on; False: a later stage sets them.

        Raises
        ------
        InputError
            Such a value, with the remedy.
        """

    def carried(self, before: Callable[[], Law | None], time: float) -> Law:
        """The law in a stage, where the motion goes on at a time with which another stage ends.

        Parameters
        ----------
        before : callable
            Gives the law of this kind in the stage before, or None: it was not at work.
        time : float
            Of the boundary [s].

        Returns
        -------
        Law
            Of the same kind.
        """
        return self

    def while_held(self, rate: float) -> Law:
        """The law while the scene is damped to rest at an instant, at which the hub turns at a rate.

        Parameters
        ----------
        rate : float
            Of the hub [rad/s].

        Returns
        -------
        Law
            Of the same kind.
        """
        return self

    def turns_whole(self, hub: Hub) -> bool:
        """Whether it may change the angular momentum that hub and sail would keep without it.

        Parameters
        ----------
        hub : Hub
            A free one.

        Returns
        -------
        bool
            Of what is kept: the component about the axis of the hub, or in six degrees of freedom the vector in space.
        """
        return self.exerts_outside_torque

    @property
    def numbering_field(self) -> str | None:
        """The field by which it names nodes by their numbers, which belong to one mesh; None: it names none so."""
        return None

    @property
    def hub(self) -> Hub | None:
        """The hub, where the law turns it."""
        return None

    @property
    def negative_springs(self) -> str | None:
        """What the core does with negative spring constants: "refuse", "clip", "keep" or "unused"; None: no rule."""
        return None

    @property
    def edge_strain_limit(self) -> float | None:
        """Strain beyond which no edge of the membrane is stretched while a run goes on [-]; None: no limit."""
        return None

    @property
    def hub_frequency(self) -> float | None:
        """Turns of the hub per second [Hz], at the start or the most of a schedule; None: it does not turn the hub."""
        return None

    def fastest_turning(self, until: float) -> float:
        """The largest rate at which it turns the hub up to a time, regardless of the sense.

        Parameters
        ----------
        until : float
            [s]

        Returns
        -------
        float
            Turns per second [Hz]; 0 where it does not turn the hub.
        """
        return abs(self.hub_frequency or 0.0)

    @property
    def spool(self) -> Spool | None:
        """The spool, where the law describes it."""
        return None

    def add_contacts(self, builder: Builder) -> None:
        """Name the nodes and the triangles that it acts on, where it does not act on all.

        Parameters
        ----------
        builder : Builder
            Of the scene's arrays.
        """

    def why_idle(self, scene: Surroundings) -> str | None:
        """Why it has no effect in this scene; None where it may have one.

        Parameters
        ----------
        scene : Surroundings
            The scene.

        Returns
        -------
        str or None
            A reason, for a message.
        """
        return None

    def implausible_values(self, scene: Surroundings, where: str) -> Iterator[Doubt]:
        """Values that are hardly meant; `where` is its place in the scene. The bounds are argued where they stand.

        Parameters
        ----------
        scene : Surroundings
            The scene.
        where : str
            Place in the scene, for messages.

        Returns
        -------
        iterator of Doubt
            One for each value.
        """
        yield from ()

    def step_advice(self, gain: float) -> str:
        """What would take it out of the limit of the step, which grows by the factor `gain` without it.

        Parameters
        ----------
        gain : float
            Factor of the step [-].

        Returns
        -------
        str
            A remedy, for a message.
        """
        return "leave it out, or make it softer"

    def for_modulus(self, factor: float) -> Law:
        """The law that is as strong as this one where Young's modulus of the film is `factor` times as large.

        Parameters
        ----------
        factor : float
            Of Young's modulus [-].

        Returns
        -------
        Law
            Of the same kind.
        """
        return self

    def with_softened_film(self, factor: float) -> Law:
        """The law of a film that is `factor` times as soft in stretch, and as strong in all else.

        Parameters
        ----------
        factor : float
            By which Young's modulus is divided [-].

        Returns
        -------
        Law
            Of the same kind.
        """
        return self.for_modulus(1.0 / factor)

    def critical_strains(self, mesh: Mesh, material: Material) -> Floats:
        """Strains at which the film buckles under compression.

        Parameters
        ----------
        mesh : Mesh
            The membrane.
        material : Material
            Of it.

        Returns
        -------
        (c,) float64
            Of each crease [-], or of each edge where there are no creases; none of a law that is not that of the film.
        """
        return np.zeros(0)

    def simpler(self) -> tuple[str, Law] | None:
        """A form of the law that leaves something out, for studies.

        Returns
        -------
        (str, Law) or None
            What it leaves out, in words, and the law; None where there is no such form.
        """
        return None

    def with_lengths(self, lengths: Mapping[str, float | None]) -> Self:
        """The law with physical lengths [m] in its `length_fields`; None: the mesh's own.

        Parameters
        ----------
        lengths : mapping of str to float or None
            [m], by what the length is of.

        Returns
        -------
        Law
            Of the same kind.
        """
        return replace(self, **{field: lengths[name] for name, field in self.length_fields.items()})

    def within(self, start: float, end: float) -> Law:
        """The law where a stage from `start` to `end` [s] has set values of it that are functions of time.

        Parameters
        ----------
        start, end : float
            Of the stage [s].

        Returns
        -------
        Law
            Of the same kind.
        """
        return self

    def without_compression(self) -> Law:
        """The law of a film that bears no compression.

        Returns
        -------
        Law
            Of the same kind.
        """
        return self.with_buckling(0.0)

    def with_buckling(self, buckling: float) -> Law:
        """The law of a film that buckles with this parameter, on creases as elsewhere.

        Parameters
        ----------
        buckling : float
            alpha [-].

        Returns
        -------
        Law
            Of the same kind.
        """
        return self
