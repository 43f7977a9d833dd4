"""The spin of IKAROS by the balance of angular momentum, against what was reported; which sail and hub would match."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from ikaros_runs import first_beyond, flat_moments, stage_ends
from membrane_rs import Scene
from membrane_rs._arrays import Floats
from membrane_rs._markdown import table

BODY = 0.79
"""Radius of the body [m]."""
ARM = 5.3
"""Reported length of the arms after the first stage [m]."""
BEFORE, CROSS, FLAT = 25.0, 7.4, 2.5
"""Reported spin before the first stage, after it, and after the second [rpm]."""
SETTLED, REELED = 0, 2
"""Stages of the whole deployment: at the end of the first the tips are out, at that of the third there is a cross."""
SWING = 20.0
"""Time at the end of a run over which the spin of the flat sail is averaged [s]: about a swing."""


@dataclass(frozen=True)
class State:
    """A state of the sail: where in the run, its moments of inertia (film, and tips with cords) [kg m2], the reported
    spin [rpm], NaN without one.
    """

    label: str
    at: slice
    film: float
    rest: float
    reported: float = math.nan

    @property
    def moment(self) -> float:
        """Of the sail [kg m2]."""
        return self.film + self.rest


def states_of(scene: Scene, run: Mapping[str, Floats]) -> list[State]:
    """The states of a whole deployment that are compared."""
    ends = stage_ends(run)
    instants = [
        ("wound", 0, BEFORE),
        ("tips let go, settled", ends[SETTLED], math.nan),
        (f"arms to {ARM:g} m from the axis", first_beyond(run, ARM), CROSS),
        (f"arms to {ARM:g} m from the body", first_beyond(run, BODY + ARM), CROSS),
        ("cross, reeled out", ends[REELED], CROSS),
    ]
    found = [
        State(label, slice(k, k + 1), float(run["film"][k]), float(run["moment"][k] - run["film"][k]), reported)
        for label, k, reported in instants
    ]
    last = int(np.searchsorted(run["time"], run["time"][-1] - SWING))
    return [*found, State("flat", slice(last, None), *flat_moments(scene), FLAT)]


def predicted(run: Mapping[str, Floats], inertia: float, state: State) -> float:
    """Spin by the balance of angular momentum from the start of a run [rpm]."""
    return float(run["rpm"][0]) * (inertia + float(run["moment"][0])) / (inertia + state.moment)


def predicted_curve(run: Mapping[str, Floats], inertia: float) -> Floats:
    """The same at each sample, of the sail as it is there."""
    curve: Floats = run["rpm"][0] * (inertia + run["moment"][0]) / (inertia + run["moment"])
    return curve


def spin_table(scene: Scene, runs: Mapping[float, Mapping[str, Floats]]) -> str:
    """Spin in each state, by inertia of the hub [kg m2]: of the run and by the balance, beside the reported one."""
    body = []
    listed = {inertia: states_of(scene, run) for inertia, run in runs.items()}
    for k, state in enumerate(next(iter(listed.values()))):
        cells = []
        for inertia, run in runs.items():
            own = listed[inertia][k]
            cells += [f"{run['rpm'][own.at].mean():.2f}", f"{predicted(run, inertia, own):.2f}"]
        reported = "-" if math.isnan(state.reported) else f"{state.reported:g}"
        body.append((state.label, f"{state.moment:.1f}", *cells, reported))
    heads = [f"{what} {inertia:g} kg m2" for inertia in runs for what in ("run,", "L/(I + J),")]
    return table(("sail", "J [kg m2]", *heads, "reported"), body, words=(0,))


def needed_table(states: Sequence[State], start: State, inertia: float) -> str:
    """What I + J the reported spins need, of a hub of this inertia and from this state, and what the scene has."""
    momentum = BEFORE * (inertia + start.moment)
    body = [
        (
            state.label, f"{state.reported:g}", f"{momentum / state.reported:.0f}", f"{inertia + state.moment:.0f}",
            f"{momentum / (inertia + state.moment):.2f}",
        )
        for state in states
        if state.reported < BEFORE
    ]  # fmt: skip
    return table(("sail", "reported [rpm]", "I + J needed [kg m2]", "I + J here", "spin here [rpm]"), body, words=(0,))


def matching(start: State, middle: State, flat: State) -> tuple[float, float]:
    """The factor of the film's mass, and the hub's inertia [kg m2], with which both reported spins follow from the
    first: two linear equations.
    """
    rows, right = [], []
    for state in (middle, flat):
        share = state.reported / start.reported
        rows.append((1.0 - share, start.film - share * state.film))
        right.append(share * state.rest - start.rest)
    inertia, factor = np.linalg.solve(rows, right)
    return float(factor), float(inertia)


def matching_hub(before: State, after: State) -> float:
    """The inertia of the hub with which one reported spin follows from another, with the sail as it is [kg m2]."""
    gained = after.reported * after.moment - before.reported * before.moment
    return gained / (before.reported - after.reported)


def match_table(states: Sequence[State], film: float) -> str:
    """The inertia of the hub that matches two of the reported spins, and all three with another mass of the film, which
    is `film` [kg] here.
    """
    starts, middles, flat = [replace(state, reported=BEFORE) for state in states[:2]], states[2:5], states[5]
    body = []
    for start in starts:
        for middle in middles:
            factor, inertia = matching(start, middle, flat)
            is_possible = factor > 0.0 and inertia > 0.0
            both = (f"{factor * film:.1f}", f"{inertia:.0f}") if is_possible else ("none", "none")
            pairs = ((start, middle), (middle, flat), (start, flat))
            hubs = [f"{hub:.0f}" if (hub := matching_hub(*pair)) > 0.0 else "none" for pair in pairs]
            body.append((start.label, middle.label, *hubs, *both))
    spins = (f"{BEFORE:g} and {CROSS:g}", f"{CROSS:g} and {FLAT:g}", f"{BEFORE:g} and {FLAT:g}")
    heads = (
        f"{BEFORE:g} rpm are those of", f"{CROSS:g} rpm are those of",
        *(f"hub for {pair} rpm [kg m2]" for pair in spins),
        "film and devices for all three [kg]", "with a hub of [kg m2]",
    )  # fmt: skip
    return table(heads, body, words=(0, 1))
