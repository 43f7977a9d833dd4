"""The bound on the size of a mesh or a scene, checked before memory is taken for it."""

from __future__ import annotations

from membrane_rs.errors import InputError

MOST_NODES = 10**7
"""More nodes than this are taken as an input error: a step of theirs takes seconds, and their arrays some 10 GB."""


def check_nodes(
    count: float, where: str, remedy: str, kind: type[InputError] = InputError, what: str = "nodes"
) -> None:
    """Refuse more than `MOST_NODES` nodes, before anything is allocated.

    `where` names the value at fault, with its number; `remedy` says what to change. Raises `kind`.
    """
    if not count <= MOST_NODES:
        many = f"about {count:.1e}" if count < 1e300 else "countless"
        raise kind(f"{where}: makes {many} {what}; must be at most {MOST_NODES}, more do not fit; {remedy}")
