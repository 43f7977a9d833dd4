"""The release from the sail that was reeled out, in place of the ideal cross: rate and phase from several starts."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from membrane_rs import Scene, Simulation
from membrane_rs._arrays import Floats
from membrane_rs._markdown import table
from membrane_rs.analysis.deployment import Corners
from membrane_rs.folding import SquareSail
from membrane_rs.results.features import curve_features
from membrane_rs.study.common.perturbation import SHIFT

RATE, PHASE = "deployment_rate", "phase_difference_deg"
STARTS, INSTANTS = 8, 800
FEATURES = (
    ("first peak of the rate", "first_peak_rate", ".3f"),
    ("at [s]", "first_peak_time", ".3f"),
    ("trough of the phase [deg]", "phase_trough_deg", ".1f"),
    ("at [s]", "phase_trough_time", ".3f"),
    ("phase back at zero, at [s]", "zero_crossing_time", ".3f"),
    ("rate there", "zero_crossing_rate", ".3f"),
)


def release_of(scene: Scene) -> Scene:
    """The last stage of a whole deployment, from time 0."""
    return scene.staged(len(scene.stages) - 1, [0.0] * len(scene.stages))


def from_cross(scene: Scene) -> Scene:
    """The same release from the ideal cross of the same flat mesh."""
    plain = release_of(scene)
    wound = None if plain.mesh is None else plain.mesh.source
    assert isinstance(wound, SquareSail)
    return replace(plain, mesh=replace(wound, stowage="cross").mesh())


def released(scene: Scene, seed: int, start: Mapping[str, Floats] | None = None) -> dict[str, Floats]:
    """Rate and phase of a release from the scene's own start, or from "positions" and "velocities".

    Each free node is displaced at random by a standard deviation of `SHIFT`; with the seed 0 none is.
    """
    sim = Simulation(scene)
    positions = np.array(sim.positions if start is None else start["positions"])
    if seed:
        free = np.setdiff1d(np.arange(len(positions)), sim.assembly.fixed)
        positions[free] += SHIFT * np.random.default_rng(seed).standard_normal((len(free), 3))
    sim.positions = positions
    if start is not None:
        sim.velocities = start["velocities"]
    corners = Corners(sim.assembly)
    rows = []
    for share in np.linspace(0.0, 1.0, INSTANTS + 1):
        sim.reach(scene.run.until * float(share))
        x = sim.positions
        rows.append((sim.time, corners.deployment_rate(x), corners.phase_difference(x)))
    time, rate, phase = np.array(rows).T
    return {"time": time, RATE: rate, PHASE: phase, "error": np.array([sim.ledger()["error"]])}


def release_table(found: Mapping[str, Mapping[str, Sequence[Mapping[str, Floats]]]]) -> str:
    """Features of the curves, mean and standard deviation over the starts, by model and start."""
    body = []
    for model, starts in found.items():
        for start, runs in starts.items():
            each = [curve_features(run) for run in runs]
            cells = []
            for _, key, form in FEATURES:
                values = np.array([math.nan if one[key] is None else one[key] for one in each], dtype=np.float64)
                known = values[np.isfinite(values)]
                text = f"{known.mean():{form}} +- {known.std():{form}}" if len(known) else "-"
                cells.append(text if len(known) == len(values) else f"{text} ({len(known)} of {len(values)})")
            body.append((model, start, *cells))
    return table(("sail", "start", *(label for label, _, _ in FEATURES)), body, words=(0, 1))


def distance_table(found: Mapping[str, Mapping[str, Sequence[Mapping[str, Floats]]]], cross: str) -> str:
    """Root mean square distance of the mean curves from those of the cross, and of single starts from their mean."""
    body = []
    for model, starts in found.items():
        means = {
            start: {key: np.mean([run[key] for run in runs], axis=0) for key in (RATE, PHASE)}
            for start, runs in starts.items()
        }
        for start, runs in starts.items():
            cells = []
            for key, form in ((RATE, ".4f"), (PHASE, ".1f")):
                apart = means[start][key] - means[cross][key]
                spread = np.std([run[key] for run in runs], axis=0)
                cells += [f"{_rms(apart):{form}}" if start != cross else "-", f"{_rms(spread):{form}}"]
            body.append((model, start, *cells))
    heads = ("sail", "start", "rate: from the cross", "spread of starts", "phase [deg]: from the cross", "spread")
    return table(heads, body, words=(0, 1))


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
