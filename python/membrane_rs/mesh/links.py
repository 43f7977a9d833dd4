"""Nodes that links tie together, and the shortest paths along links."""

from __future__ import annotations

from membrane_rs import _core
from membrane_rs._arrays import Floats, Ints


def groups(links: Ints, node_count: int) -> Ints:
    """(n,) the number of the group that each node is in, when links (k, 2) tie nodes together.

    Groups are numbered by their lowest nodes.
    """
    return _core.groups(links, node_count)


def shortest_paths(links: Ints, lengths: Floats, node_count: int, starts: Ints, longest: Floats) -> Floats:
    """(s, n) length of the shortest path from each of the starts (s,) to each node, along links (k, 2) [m].

    inf where there is none that is no longer than the number in `longest` (s,) of that start.
    """
    return _core.shortest_paths(links, lengths, node_count, starts, longest)
