"""What figures against time are made of: one history or several, each checked, with its label."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from membrane_rs._arrays import Floats
from membrane_rs._given_arrays import numeric
from membrane_rs._validation import check_kind, nearest
from membrane_rs.errors import InputError, InputTypeError
from membrane_rs.plotting.drawable import drawable
from membrane_rs.plotting.stage_records import stage_records
from membrane_rs.results.experiment import Experiment

WANTED = "the columns of a history by name, as read_history gives them"


@dataclass(frozen=True)
class Source:
    """Curves of one run: `table` holds its columns, (samples,) each; `stages` are the names of its stages."""

    label: str
    table: Mapping[str, Any]
    stages: Sequence[str] = ()

    @property
    def time(self) -> Floats:
        """(samples,) [s], NaN where a figure cannot show it."""
        return drawable(self.table["time"])

    def column(self, name: str) -> Floats:
        """(samples,) values of a column, NaN where a figure cannot show them."""
        return drawable(self.table[name])


def sources_of(given: object, labels: Sequence[str] | None, needed: Sequence[str], name: str = "table") -> list[Source]:
    """The runs that are given: a history or a run, a list of them, or a mapping of labels to them.

    Parameters
    ----------
    given : mapping, run or sequence
        A history is a mapping of names of columns, "time" among them, to (samples,) arrays; a run has one as `history`.
    labels : sequence of str, optional
        One for each.
    needed : sequence of str
        Columns that each must have.
    name : str
        What messages call it.

    Raises
    ------
    InputTypeError
        No history, a column that is missing or no list of numbers, columns of different length.
    InputError
        Another number of labels; none of what is given.
    """
    found = _listed(given, name)
    if labels is not None:
        check_kind(labels, Sequence, "labels", "a list of texts, one for each run")
        if isinstance(labels, str) or not all(isinstance(label, str) for label in labels):
            raise InputTypeError(f"labels = {labels!r:.60}: must be a list of texts, one for each run")
        if len(labels) != len(found):
            raise InputError(f"{len(labels)} labels for {len(found)} runs; give one for each, or none at all")
        found = [(label, *rest) for label, (_, *rest) in zip(labels, found, strict=True)]
    sources = []
    for label, item, place in found:
        table = _table_of(item)
        check_table(table, needed, place)
        stages = [stage.name for stage in stage_records(getattr(item, "stages", ()))]
        sources.append(Source(label, table, stages))
    return sources


def check_table(table: object, needed: Sequence[str], name: str = "table") -> None:
    """Refuse what is no history with "time" and some columns. Raises InputTypeError."""
    if not isinstance(table, Mapping):
        check_kind(table, Mapping, name, WANTED)
    assert isinstance(table, Mapping)
    names = tuple(dict.fromkeys(("time", *needed)))
    lengths = set()
    for column in names:
        if column not in table:
            close = nearest(column, map(str, table)) if len(table) else "it is empty"
            raise InputTypeError(f"{name}: has no column {column!r}; give what read_history gives; {close}")
        lengths.add(numeric(table[column], f"{name}[{column!r}]", "fiu", "numbers").shape)
    if len(lengths) > 1 or len(lengths.pop()) != 1:
        raise InputTypeError(
            f"{name}: the columns {', '.join(names)} must be lists of equal length, one entry a sample"
        )


def _listed(given: object, name: str) -> list[tuple[str, Any, str]]:
    """Label, item and its place in messages."""
    if hasattr(given, "history") or isinstance(given, Experiment) or (isinstance(given, Mapping) and "time" in given):
        return [("", given, name)]
    if isinstance(given, Mapping) and given and all(_is_run(item) for item in given.values()):
        return [(str(label), item, f"{name}[{label!r}]") for label, item in given.items()]
    if isinstance(given, Sequence) and not isinstance(given, str | bytes):
        if not given:
            raise InputError(f"{name} = {given!r}: must hold one history or more")
        return [(f"run {k + 1}", item, f"{name}[{k}]") for k, item in enumerate(given)]
    return [("", given, name)]


def _is_run(item: object) -> bool:
    return hasattr(item, "history") or isinstance(item, Mapping | Experiment)


def _table_of(item: Any) -> Any:
    """The history of a run, the curves of an experiment with its units, and anything else as it is."""
    if isinstance(item, Experiment):
        return Measured({"time": item.time, **item.columns}, item.units)
    return getattr(item, "history", item)


class Measured(dict[str, Floats]):
    """Columns by name, and the unit of each where that is known."""

    def __init__(self, columns: Mapping[str, Floats], units: Mapping[str, str]) -> None:
        super().__init__(columns)
        self.units = {name: unit for name, unit in units.items() if unit}
