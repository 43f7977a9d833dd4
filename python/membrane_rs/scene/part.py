"""The interface of parts, with default implementations."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import field
from typing import ClassVar

from membrane_rs._validation import show, validated
from membrane_rs.errors import InputError
from membrane_rs.scene.builder import Builder
from membrane_rs.scene.law import Surroundings
from membrane_rs.scene.plausible import Doubt
from membrane_rs.scene.spool import Spool


@validated
class Part:
    """A part as checked values. A part overrides the defaults that do not hold for it.

    Parameters
    ----------
    name : str, optional
        By which a stage names it; unlike those of other parts, and no kind of a law. By keyword alone.

    Raises
    ------
    InputError, InputTypeError
        A value outside its range, or of a wrong type.

    Examples
    --------
    >>> from membrane_rs.scene.parts import PARTS
    >>> PARTS["tip_masses"](mass=1e-3, name="tips").name
    'tips'
    """

    kind: ClassVar[str]
    """Its name in scene files."""
    working_law: ClassVar[str | None] = None
    """The law of the core that comes with it and does work, so that history.csv has a column for it."""
    start_fields: ClassVar[tuple[str, ...]] = ()
    """Fields that say where its nodes lie at the start of the run, which no stage changes."""
    name: str | None = field(default=None, kw_only=True)

    def add_nodes(self, builder: Builder, where: str) -> None:
        """Add its own nodes, cords and links; `where` is its place in the scene, for errors.

        Parameters
        ----------
        builder : Builder
            Of the scene's arrays.
        where : str
            Place in the scene, for errors.
        """

    def add_loads(self, builder: Builder, where: str) -> None:
        """Add masses and supports to nodes, which may be those of a part that stands later in the scene.

        Parameters
        ----------
        builder : Builder
            Of the scene's arrays.
        where : str
            Place in the scene, for errors.
        """

    def check_set(self, given: Part, names: Collection[str]) -> None:
        """Refuse values of these fields that a stage sets in place of those of a part, and that have no effect there.

        Parameters
        ----------
        given : Part
            The part of the scene, in whose place this one stands.
        names : collection of str
            Of the fields.

        Raises
        ------
        InputError
            Such a value, with the remedy.
        """
        for name in self.start_fields:
            value, own = getattr(self, name), getattr(given, name)
            if name in names and value != own:
                what = f"says where nodes lie at the start of the run, and no stage moves them; leave it at {show(own)}"
                raise InputError(f"{type(self).__name__}.{name} = {show(value)}: {what}, or change the part")

    @property
    def spool(self) -> Spool | None:
        """The spool, where the part describes it."""
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

    @property
    def numbering_field(self) -> str | None:
        """The field by which it names nodes, triangles or creases by their numbers, which belong to one mesh; None: it
        names none so.
        """
        return None if isinstance(getattr(self, "nodes", ""), str) else "nodes"

    def resized(self, sizes: Mapping[str, tuple[int, int]]) -> Part:
        """The part for another mesh, whose node sets have the second of these sizes in place of the first.

        Parameters
        ----------
        sizes : mapping of str to (int, int)
            Nodes of each node set, on this mesh and on the other one.

        Returns
        -------
        Part
            Of the same kind.
        """
        return self

    def softened(self, factor: float) -> Part:
        """The part with its stiffness multiplied by `factor`; equal to itself where it has none.

        Parameters
        ----------
        factor : float
            Of the stiffness [-].

        Returns
        -------
        Part
            Of the same kind.
        """
        return self

    @property
    def laws_needed(self) -> Mapping[str, Sequence[str]]:
        """Fields with a value that is felt by some laws alone, and the kinds of these."""
        return {}

    def for_modulus(self, factor: float) -> Part:
        """The part of a film whose Young's modulus is `factor` times as large: as soft as it, and else as strong.

        Parameters
        ----------
        factor : float
            Of Young's modulus [-].

        Returns
        -------
        Part
            Of the same kind.
        """
        return self

    def with_softened_film(self, factor: float) -> Part:
        """The part beside a film that is `factor` times as soft: its own vibrations slower by the root of it.

        Parameters
        ----------
        factor : float
            By which Young's modulus of the film is divided [-].

        Returns
        -------
        Part
            Of the same kind, with as many nodes.
        """
        return self

    def step_advice(self, gain: float) -> str:
        """What would take it out of the limit of the step, which grows by the factor `gain` once it is softened.

        Parameters
        ----------
        gain : float
            Factor of the step [-].

        Returns
        -------
        str
            A remedy, for a message.
        """
        return "make it softer"

    def coarser(self, factor: int) -> tuple[str, Part] | None:
        """What is left out, in words, and the part with `factor` times fewer elements; None where it has too few.

        Parameters
        ----------
        factor : int
            Of the number of elements.

        Returns
        -------
        (str, Part) or None
            Words and part.
        """
        return None
