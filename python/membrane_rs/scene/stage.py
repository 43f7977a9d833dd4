"""A stage of a run: what is at work in it, with which values, and when it ends."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import field
from numbers import Real
from typing import Annotated, Any, ClassVar

from annotated_types import Ge, Le
from pydantic import BeforeValidator, ValidationInfo
from pydantic_core import PydanticCustomError

from membrane_rs._read_only import ReadOnly
from membrane_rs._validation import (
    Count,
    Finite,
    Positive,
    Unit,
    UnitOf,
    build,
    check_kind,
    check_text,
    nearest,
    show,
    validated,
)
from membrane_rs.errors import InputError, InputTypeError
from membrane_rs.scene.run_settings import MOST_INSTANTS, check_duration
from membrane_rs.scene.schedule import Schedule

MEASURE_UNITS = {
    "deployment_rate": "",
    "phase_difference_deg": "deg",
    "kinetic_energy": "J",
    "stored_energy": "J",
    "hub_angle": "rad",
    "hub_rate": "rad/s",
    "hub_force": "N",
    "hub_torque": "N m",
    "contact_force": "N",
    "largest_cord_tension": "N",
    "largest_film_stress": "Pa",
    "largest_speed": "m/s",
}
MEASURES = tuple(MEASURE_UNITS)
"""Names of the measures by whose values a stage may end, as columns of history.csv; `largest_speed` [m/s] is that of
any node."""
LONGEST_NAME = 100
DEEPEST = 5
"""Tables and lists in each other in the longest value of a stage."""
Measure = Callable[[Any], float]
"""A function of the simulation that gives a number, and only reads."""


def _table(value: object, info: ValidationInfo) -> object:
    if not isinstance(value, Mapping) or not all(isinstance(key, str) for key in value):
        raise PydanticCustomError("wrong_type", "must be a table of keys such as 'material.youngs_modulus'")
    return {key: _plain(item, f"Stage.{info.field_name}[{show(key)}]") for key, item in value.items()}


def _plain(value: object, where: str, depth: int = 0) -> object:
    """Lists and arrays as tuples, at any depth, tables of a schedule as one, an empty table as None: as in files."""
    if depth > DEEPEST:
        raise InputError(f"{where[:LONGEST_NAME]}: is nested too deeply; a value is a number, a list or a schedule")
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, Mapping):
        other = next((key for key in value if not isinstance(key, str)), None)
        if other is not None:
            raise InputTypeError(f"{where}: its key {show(other)} must be a text")
        table = {key: _plain(item, f"{where}.{key}", depth + 1) for key, item in value.items()}
        # Text with a unit waits for the scene, which knows the field that the schedule stands in.
        is_schedule = "times" in table and not has_text(table.get("values"))
        return build(Schedule, table, where) if is_schedule else (ReadOnly(table) if table else None)
    if isinstance(value, list | tuple):
        return tuple(_plain(item, f"{where}[{k}]", depth + 1) for k, item in enumerate(value))
    return value


def has_text(value: object) -> bool:
    """Whether a value of a stage is text, or holds some."""
    if isinstance(value, Mapping):
        return any(map(has_text, value.values()))
    return isinstance(value, str) or (isinstance(value, list | tuple) and any(map(has_text, value)))


def _names(value: object) -> object:
    if isinstance(value, list):
        value = tuple(value)
    if not isinstance(value, tuple) or not all(isinstance(name, str) for name in value):
        raise PydanticCustomError("wrong_type", "must be a list of names")
    twice = next((name for name in value if value.count(name) > 1), None)
    if twice is not None:
        raise PydanticCustomError("twice", "must not hold {name} twice", {"name": repr(twice)})
    return value


def _measure(value: object) -> object:
    if value is None or callable(value):
        return value
    if not isinstance(value, str):
        raise PydanticCustomError("wrong_type", "must be the name of a measure, or in Python a function")
    return value


@validated
class Stage:
    """A stage of a run: the scene without some of its laws, parts and bodies, and with other values.

    Parameters
    ----------
    name : str
        Unlike those of other stages; not empty, at most 100 characters in one line.
    duration : float
        How long it lasts [s], at the most where a measure may end it; from 1e-15 to 1e12.
    measure : str or callable, optional
        The stage ends when this passes a value: a name in `MEASURES`; in Python also a function that takes the
        simulation, gives a number, and only reads. No file holds a function.
    below, above : float, optional
        The value, in the unit of the measure: the stage ends as this falls to `below`, or rises to `above`. One of
        them, with `measure`. A measure that is beyond it at the start must come back first.
    without : sequence of str
        Laws by their kind, parts and bodies by their name, that are not at work in this stage.
    scale : dict of str to float, read-only
        Factors [-] above 0 on numbers of the scene, by dotted keys: "material.youngs_modulus", "laws.<kind>.<key>",
        "parts.<name or index>.<key>", "bodies.<name>.<key>".
    set : dict, read-only
        Values in place of those of the scene, by the same keys, and "run.<key>" for method, step and monitor. Times of
        a schedule count from the start of this stage. None, in files {}, takes a value away. What stands in
        place of a schedule, and what sets a hub free or drives it again, holds in later stages too, until one sets
        another; all else holds in this stage alone.
    frames, samples : int, optional
        Shapes written, and rows of the history, evenly spaced over `duration`, both ends among them, in place of those
        of the run in this stage; from 2 to 10^7. What lies after an earlier end falls away.

    Raises
    ------
    InputError, InputTypeError
        A measure without a value or with two, values without a measure, an unknown measure, a factor of 0 or below.

    Examples
    --------
    >>> from membrane_rs import Stage
    >>> settle = Stage("settle", duration=0.1, measure="kinetic_energy", below=1e-7)
    >>> settle.is_past(1e-8), settle.measure_name, Stage.function_name(abs)
    (True, 'kinetic_energy', 'python:abs')
    """

    ONLY_IN_PYTHON: ClassVar[str] = "python:"
    """How a file tells that a measure was a function."""

    name: str
    duration: Annotated[Positive, Unit("s")]
    measure: Annotated[Any, BeforeValidator(_measure)] = None
    below: Annotated[Finite | None, UnitOf("measure", MEASURE_UNITS)] = None
    above: Annotated[Finite | None, UnitOf("measure", MEASURE_UNITS)] = None
    without: Annotated[tuple[str, ...], BeforeValidator(_names)] = ()
    scale: Annotated[dict[str, Positive], BeforeValidator(_table)] = ()  # type: ignore[assignment]
    set: Annotated[dict[str, Any], BeforeValidator(_table)] = ()  # type: ignore[assignment]
    frames: Annotated[Count | None, Ge(2), Le(MOST_INSTANTS)] = field(default=None, kw_only=True)
    samples: Annotated[Count | None, Ge(2), Le(MOST_INSTANTS)] = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        """Check the fields against each other."""
        for name in ("scale", "set"):
            object.__setattr__(self, name, ReadOnly(getattr(self, name)))
        check_text(self.name, "Stage.name =")
        if not 1 <= len(self.name) <= LONGEST_NAME or not self.name.isprintable() or not self.name.strip():
            raise InputError(
                f"Stage.name = {show(self.name)}: must be 1 to {LONGEST_NAME} characters in one line, not all blank"
            )
        check_duration(self.duration, "Stage.duration")
        self._check_end()
        both = next((key for key in self.scale if key in self.set), None)
        if both is not None:
            raise InputError(f"Stage.set: {both!r} is scaled too; leave it out of one of them")

    def _check_end(self) -> None:
        levels = {name: getattr(self, name) for name in ("below", "above")}
        given = [name for name, level in levels.items() if level is not None]
        if self.measure is None:
            if given:
                raise InputError(
                    f"Stage.{given[0]} = {levels[given[0]]:g}: is given without measure; name one, such as "
                    f"{MEASURES[0]!r}, or leave it out"
                )
            return
        if len(given) != 1:
            found = "both below and above are given" if given else "neither below nor above is given"
            raise InputError(f"Stage.measure = {show(self.measure)}: {found}; give one of them")
        if isinstance(self.measure, str) and self.measure not in MEASURES:
            if self.measure.startswith(self.ONLY_IN_PYTHON):
                raise InputError(
                    f"Stage.measure = {show(self.measure)}: was a function, which no file holds; build a scene of "
                    "what is left to run in Python, and go on with Simulation(scene, start=FILE) from a saved state"
                )
            hint = nearest(self.measure, MEASURES)
            raise InputError(f"Stage.measure = {show(self.measure)}: no such measure; {hint}")

    @property
    def level(self) -> float | None:
        """The value that its measure passes, in its unit; None where it ends by time alone."""
        return self.above if self.below is None else self.below

    def is_past(self, value: float) -> bool:
        """Whether a value of the measure lies beyond the one that ends the stage, or on it.

        Parameters
        ----------
        value : float
            Of the measure, in its unit.

        Returns
        -------
        bool
            Whether the stage is over.

        Raises
        ------
        InputTypeError
            No number.
        """
        check_kind(value, Real, "value", "a number")
        return (self.above is not None and value >= self.above) or (self.below is not None and value <= self.below)

    @property
    def measure_name(self) -> str:
        """The measure, as files and messages call it; empty without one."""
        named = self.measure is None or isinstance(self.measure, str)
        return (self.measure or "") if named else self.function_name(self.measure)

    @classmethod
    def function_name(cls, function: Measure) -> str:
        """What a file says in place of a function.

        Parameters
        ----------
        function : callable
            A measure.

        Returns
        -------
        str
            "python:" and its name.
        """
        return f"{cls.ONLY_IN_PYTHON}{getattr(function, '__qualname__', type(function).__name__)}"
