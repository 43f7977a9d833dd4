"""The shape of a cord between two points."""

from __future__ import annotations

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs.errors import InputError


def cord_positions(start: Floats, end: Floats, length: float, segments: int) -> Floats:
    """Nodes of a cord from `start` to `end`: straight if taut, else hanging below without strain.

    A slack cord is a chain of equal segments that turn by equal angles, so its nodes lie on a circle, in
    the plane of the chord and the z axis, below the chord. Where the circle would bulge beyond the two
    ends, the cord runs at right angles to the chord first, so that it keeps off the spool behind `start`.

    Parameters
    ----------
    start, end : (3,) float
        The two ends [m].
    length : float
        Of the cord without load [m].
    segments : int
        1 or above.

    Returns
    -------
    (segments + 1, 3) float
        The first row is `start`, the last is `end` [m].

    Raises
    ------
    InputError
        A slack cord of one segment, which has nothing to bend.
    """
    chord = end - start
    span = float(np.linalg.norm(chord))
    if span >= length * (1.0 - 1e-9):
        return np.linspace(start, end, segments + 1)
    if segments == 1:
        raise InputError(f"a cord of length {length} m spans {span:.6g} m: give it 2 segments or more to hang")
    along = chord / span if span > 1e-12 * length else _outward(start)  # coinciding ends give no direction
    down = np.array([0.0, 0.0, -1.0])
    down -= (down @ along) * along
    if np.linalg.norm(down) < 1e-6:
        down = _outward(start)
        down -= (down @ along) * along
    down /= np.linalg.norm(down)
    headings = _headings(span / length * segments, segments)
    steps = np.outer(np.cos(headings), along) - np.outer(np.sin(headings), down)
    positions = start + np.vstack([np.zeros(3), np.cumsum(steps, axis=0) * (length / segments)])
    positions[-1] = end
    return positions


def cord_along(path: Floats, length: float, segments: int) -> Floats:
    """Nodes of a cord that lies along a path (k, 3) [m]: evenly on it if taut, else hanging below it, slack.

    It is `cord_positions` of the path laid out straight. So what is below a bend of the path is a little shorter than
    without load. Returns (segments + 1, 3) [m]; raises as `cord_positions` does.
    """
    at = np.append(0.0, np.cumsum(np.hypot(*np.diff(path[:, :2], axis=0).T)))
    end = np.array([at[-1], 0.0, path[-1, 2] - path[0, 2]])
    flat = cord_positions(np.zeros(3), end, length, segments)
    plan = [np.interp(flat[:, 0], at, path[:, k]) for k in range(2)]
    return np.stack([*plan, path[0, 2] + flat[:, 2]], axis=1)


def cord_round_axis(start: Floats, length: float, segments: int, *, clockwise: bool) -> Floats:
    """Nodes of a cord that lies without strain on the circle about the z axis through `start`: chords of equal length.

    Parameters
    ----------
    start : (3,) float
        Its first node [m], off the axis.
    length : float
        Of the cord without load, the sum of its chords [m].
    segments : int
        1 or above.
    clockwise : bool
        The sense in which it lies from `start` on, seen from +z.

    Returns
    -------
    (segments + 1, 3) float
        The first row is `start` [m].

    Raises
    ------
    InputError
        Chords longer than the radius, which do not follow the circle.
    """
    radius, chord = float(np.hypot(start[0], start[1])), length / segments
    if chord > radius * (1.0 + 1e-9):
        fewest = int(np.ceil(length / radius * (1.0 - 1e-9)))
        raise InputError(
            f"each is {chord:.6g} m long, and the radius of the circle {radius:.6g} m: give the cord {fewest} segments "
            "or more to lie round the axis"
        )
    turn = 2.0 * np.arcsin(0.5 * chord / radius) * (-1.0 if clockwise else 1.0)
    azimuths = np.arctan2(start[1], start[0]) + turn * np.arange(segments + 1)
    positions = np.column_stack([radius * np.cos(azimuths), radius * np.sin(azimuths), np.full(segments + 1, start[2])])
    positions[0] = start
    return positions


def _headings(target: float, segments: int) -> Floats:
    """Angles of the segments to the chord, evenly turning, whose cosines add up to `target` [rad]."""
    offsets = np.arange(segments) - 0.5 * (segments - 1)
    straight_legs = target >= segments % 2
    limit, high = (0.5 * np.pi, np.pi) if straight_legs else (np.pi, 2.0 * np.pi / segments)
    low = 0.0
    for _ in range(100):  # halving: the sum falls as the turn grows
        turn = 0.5 * (low + high)
        if np.cos(np.clip(turn * offsets, -limit, limit)).sum() > target:
            low = turn
        else:
            high = turn
    result: Floats = np.clip(0.5 * (low + high) * offsets, -limit, limit)
    return result


def _outward(point: Floats) -> Floats:
    """The direction away from the z axis at a point; x on the axis itself."""
    radius = float(np.hypot(point[0], point[1]))
    if radius < np.finfo(float).tiny:  # subnormal numbers divide badly
        return np.array([1.0, 0.0, 0.0])
    return np.array([point[0] / radius, point[1] / radius, 0.0])
