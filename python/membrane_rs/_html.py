"""What is shown of an object: text in a line, and in a notebook a small picture of its lines, and a table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from html import escape

import numpy as np

from membrane_rs._arrays import Bools, Floats, Ints

SIZE = 180
"""Width and height of a picture [px]."""
MOST_LINES = 2000
"""Lines in a picture; of more, some are left out evenly."""
LONGEST_TEXT = 120
"""Characters of a text in a line or in a table; a longer one is cut."""
_NO_LINES: Ints = np.zeros((0, 2), dtype=np.int64)
_LOOKS = {
    "outline": 'stroke="currentColor" stroke-width="1.2"',
    "creases": 'stroke="#c0504d" stroke-width="0.6"',
    "cords": 'stroke="#3f6fb5" stroke-width="0.9"',
}


@dataclass(frozen=True, eq=False)
class Lines:
    """Lines between nodes (n, 3) [m]: the outline of a membrane, its creases and its cords, each (k, 2) indices."""

    nodes: Floats
    outline: Ints = field(default_factory=_NO_LINES.copy)
    creases: Ints = field(default_factory=_NO_LINES.copy)
    cords: Ints = field(default_factory=_NO_LINES.copy)


@dataclass(frozen=True, eq=False)
class Card:
    """A title, rows of a name and a value, and what the picture shows."""

    title: str
    rows: Sequence[tuple[str, object]]
    lines: Lines | None = None


class HasCard:
    """An object that notebooks show as a picture and a table."""

    def _card(self) -> Card:
        raise NotImplementedError

    def _repr_html_(self) -> str:
        """A small picture and a table, as HTML without scripts or links."""
        card = self._card()
        cell = 'style="text-align: left; vertical-align: top; padding: 1px 8px"'
        rows = "".join(
            f"<tr><th {cell} nowrap>{_text(name)}</th><td {cell}>{_text(value)}</td></tr>" for name, value in card.rows
        )
        drawn = "" if card.lines is None else f'<div style="margin-right: 12px">{svg(card.lines)}</div>'
        table = f"<table><caption {cell}><b>{_text(card.title)}</b></caption><tbody>{rows}</tbody></table>"
        return f'<div style="display: flex; align-items: center">{drawn}<div>{table}</div></div>'


def svg(lines: Lines) -> str:
    """A picture of lines, seen along the axis from which they look largest; along z where others are not larger."""
    known: Bools = np.atleast_1d(np.isfinite(lines.nodes).all(axis=1))
    drawn = {name: kept[known[kept].all(axis=1)] for name in _LOOKS if len(kept := getattr(lines, name))}
    used = np.unique(np.concatenate([_NO_LINES.ravel(), *(pairs.ravel() for pairs in drawn.values())]))
    points = _projected(lines.nodes, lines.nodes[used])
    count = sum(map(len, drawn.values()))
    every = max(1, -(-count // MOST_LINES))
    paths = "".join(f'<path d="{_path(points, drawn[name][::every])}" {_LOOKS[name]}/>' for name in drawn)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{SIZE}" height="{SIZE}" viewBox="0 0 {SIZE} {SIZE}" '
        f'fill="none" stroke-linecap="round" role="img">{paths}</svg>'
    )


_AXES = ((0, 1), (0, 2), (1, 2))
"""To the right and upwards, seen along z, y and x."""
_SHARE = 1.2
"""By how much more area another view than that along z must show."""
_OF_LINES = 1e-3
"""Weight of the squared length beside the area, by which lines without area are judged."""


def _projected(nodes: Floats, used: Floats) -> Floats:
    """(n, 2) places of nodes in the picture [px], as large as it takes those that are used."""
    if not len(used):
        return np.zeros((len(nodes), 2))
    low, high = used.min(axis=0), used.max(axis=0)
    sizes = [_size(used[:, axes]) / (1.0 if axes == _AXES[0] else _SHARE) for axes in _AXES]
    axes = list(_AXES[int(np.argmax(sizes))])
    largest = float((high - low)[axes].max())
    if largest == 0.0:
        return np.full((len(nodes), 2), 0.5 * SIZE)
    shares = (np.nan_to_num(nodes)[:, axes] - 0.5 * (low + high)[axes]) / largest
    places: Floats = np.nan_to_num(0.94 * SIZE * shares * (1.0, -1.0) + 0.5 * SIZE)
    return places


def _size(points: Floats) -> float:
    """How large points (n, 2) [m] look, whichever way they are turned in the plane: an area [m2]."""
    spread = np.cov(points, rowvar=False, bias=True)
    return float(np.sqrt(max(np.linalg.det(spread), 0.0)) + _OF_LINES * np.trace(spread))


def _path(points: Floats, pairs: Ints) -> str:
    """Lines as the data of a path, those that a tenth of a pixel does not tell from others once."""
    ends = np.round(points[pairs], 1).reshape(-1, 4)
    return "".join(f"M{a:g} {b:g}L{c:g} {d:g}" for a, b, c, d in dict.fromkeys(map(tuple, ends.tolist())))


def in_a_line(value: object) -> str:
    """A value as text in one line, cut where it is long; what cannot be printed is replaced."""
    text = f"{value:.6g}" if isinstance(value, float) else str(value)
    text = text if len(text) <= LONGEST_TEXT else f"{text[: LONGEST_TEXT - 3]}..."
    return "".join(sign if sign.isprintable() else "\N{REPLACEMENT CHARACTER}" for sign in text)


def _text(value: object) -> str:
    """A value as text of HTML."""
    return escape(in_a_line(value))
