"""Nodes that links tie together, and the shortest paths along links."""

from __future__ import annotations

from membrane_rs import _core
from membrane_rs._arrays import Floats, Ints


def groups(links: Ints, node_count: int) -> Ints:
    """(n,) the number of the group that each node is in, when links (k, 2) tie nodes together.

    Groups are numbered by their lowest nodes.
    """
    return _core.groups(links, node_count)


def shortest_paths(
    links: Ints, lengths: Floats, node_count: int, starts: Ints, *, begun: Floats, longest: float
) -> Floats:
    """(n,) length of the shortest path to each node from any of the starts (s,), along links (k, 2) [m].

    The paths of each start have the length in `begun` (s,) already. inf where there is none that is no longer than
    `longest`.
    """
    return _core.shortest_paths(links, lengths, node_count, starts, begun, longest)
