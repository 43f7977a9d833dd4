"""The text of a scene file with other values, its comments kept.

Lines are changed one by one, as files of this package are written: a heading, then a key in each line. The result is
read again; where it is not the scene that was wanted, because its file is written otherwise, the scene is written anew,
without comments.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from pathlib import Path
from typing import Any

from membrane_rs.errors import MembraneError
from membrane_rs.scene.scene import Scene
from membrane_rs.scene.toml import content_of, toml_value

SCHEMA_LINE = "#:schema "
"""How a file names its JSON schema, for editors."""
_HEADING = re.compile(r"\s*\[")


@dataclass(frozen=True)
class Difference:
    """What two scenes differ in."""

    heading: str
    """Of its table; empty above all headings."""
    number: int
    """Of the heading among equal ones."""
    field: str | None
    """None: the whole table."""
    old: Any
    new: Any


def with_comments(text: str, before: Scene, after: Scene, path: Path) -> tuple[str, bool]:
    """The text of a scene file with other values.

    Parameters
    ----------
    text : str
        Of the file that `before` was read from.
    before, after : Scene
        The scene of that file, and the one that is wanted.
    path : Path
        Where it will stand, for a mesh file beside it.

    Returns
    -------
    text : str
        The file of the scene that is wanted.
    kept : bool
        Whether it has the comments.
    """
    lines = [line for line in text.splitlines() if not line.startswith(SCHEMA_LINE)]
    for each in _differences(before, after):
        lines = _with_block(lines, each) if each.field is None else _with_line(lines, each, each.field)
    made = "\n".join(lines) + "\n"
    try:
        if Scene(**vars(content_of(made, path))).to_toml() == after.to_toml():
            return made, True
    except MembraneError:
        pass
    return after.to_toml(), False


def _differences(before: Scene, after: Scene) -> Iterator[Difference]:
    """What two scenes differ in; their lists of parts, bodies and stages are compared one by one."""
    if before.name != after.name:
        yield Difference("", 0, "name", before.name, after.name)
    yield from _changes("[mesh]", getattr(before.mesh, "source", None), getattr(after.mesh, "source", None))
    yield from _changes("[material]", before.material, after.material)
    yield from _changes("[run]", before.run, after.run, ("until",) if after.stages else ())
    laws = {law.kind: law for law in before.laws}
    for law in after.laws:
        heading, old = f"[laws.{law.kind}]", laws.pop(law.kind, None)
        if old is None:
            yield Difference(heading, 0, None, None, law)
        yield from _changes(heading, old, law)
    for kind, law in laws.items():
        yield Difference(f"[laws.{kind}]", 0, None, law, None)
    lists: list[tuple[str, Sequence[Any], Sequence[Any]]] = [
        ("[[parts]]", before.parts, after.parts),
        ("[[bodies]]", before.bodies, after.bodies),
        ("[[stages]]", before.stages, after.stages),
    ]
    for heading, olds, news in lists:
        for k, (one, other) in enumerate(zip(olds, news, strict=False)):
            yield from (replace(each, number=k) for each in _changes(heading, one, other))


def _changes(heading: str, old: Any, new: Any, left_out: Sequence[str] = ()) -> Iterator[Difference]:
    """Fields in which two of one class differ."""
    if type(old) is not type(new) or not is_dataclass(new):
        return
    for entry in fields(new):
        one, other = getattr(old, entry.name), getattr(new, entry.name)
        if one != other and entry.name not in left_out:
            yield Difference(heading, 0, entry.name, one, other)


def _block(lines: list[str], heading: str, number: int) -> tuple[int, int] | None:
    """The lines behind a heading, up to the next one; None without such a heading."""
    starts = [k for k, line in enumerate(lines) if line.partition("#")[0].strip() == heading]
    if heading and number >= len(starts):
        return None
    start = starts[number] + 1 if heading else 0
    end = next((k for k in range(start, len(lines)) if _HEADING.match(lines[k])), len(lines))
    return start, end


def _with_line(lines: list[str], change: Difference, field: str) -> list[str]:
    """The lines with a field set in its own, whose comment says what it was, or in a new one below the heading."""
    block = _block(lines, change.heading, change.number)
    if block is None:
        lines = [*lines, "", change.heading]
        block = (len(lines), len(lines))
    pattern = re.compile(rf"\s*{re.escape(field)}\s*=\s*(?P<value>.*?)\s*(?:#\s*(?P<comment>.*))?")
    new = f"{field} = {toml_value(change.new)}"
    for k in range(*block):
        found = pattern.fullmatch(lines[k])
        if found is not None:
            said = f"was {found['value']}" + (f": {found['comment']}" if found["comment"] else "")
            made = [] if change.new is None else [f"{new}  # {said}" if change.heading else new]
            return [*lines[:k], *made, *lines[k + 1 :]]
    if change.new is None:
        return lines
    default = f"  # was {toml_value(change.old)}, the default" if change.old is not None and change.heading else ""
    # Above the name of the whole scene stand its own comments.
    place = block[0] if change.heading else next((k for k in range(*block) if not lines[k].startswith("#")), block[1])
    return [*lines[:place], f"{new}{default}", *lines[place:]]


def _with_block(lines: list[str], change: Difference) -> list[str]:
    """The lines without a table, or with a new one, of all its values."""
    if change.new is None:
        block = _block(lines, change.heading, 0)
        return lines if block is None else lines[: block[0] - 1] + lines[block[1] :]
    values = {entry.name: getattr(change.new, entry.name) for entry in fields(change.new)}
    own = [f"{name} = {toml_value(value)}" for name, value in values.items() if value is not None]
    return [*lines, "", change.heading, *own]
