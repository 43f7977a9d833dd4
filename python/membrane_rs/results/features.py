"""What the curves of a history show: those of the deployment, and the energy balance."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from membrane_rs._arrays import Floats

LEAST_PHASE = 1e-6
"""Phase difference below which corners do not turn but by rounding [deg]."""


def curve_features(table: Mapping[str, Floats]) -> dict[str, float | None]:
    """What the paper's Figs. 14 to 17 are read for; None where the run has not come that far.

    The trough is the lowest phase difference; the first peak of the rate is the highest rate before the
    trough; the zero crossing is the first rise of the phase through zero after the trough, interpolated.

    `table` holds (samples,) arrays "time" [s], "deployment_rate" and "phase_difference_deg".
    """
    time, rate, phase = (table[name] for name in ("time", "deployment_rate", "phase_difference_deg"))
    names = ("first_peak_rate", "first_peak_time", "phase_trough_deg", "phase_trough_time")
    after = ("zero_crossing_time", "zero_crossing_rate")
    features: dict[str, float | None] = dict.fromkeys((*names, *after))
    known = np.flatnonzero(np.isfinite(rate) & np.isfinite(phase))
    if not len(known):
        return features
    time, rate, phase = time[known], rate[known], phase[known]
    features |= {
        "initial_rate": float(rate[0]),
        "final_rate": float(rate[-1]),
        "highest_rate": float(rate.max()),
        "final_phase_deg": float(phase[-1]),
    }
    last = len(time) - 1
    trough = int(np.argmin(phase))
    peak = int(np.argmax(rate[: trough + 1]))
    if 0 < peak < last:
        features |= {"first_peak_rate": float(rate[peak]), "first_peak_time": float(time[peak])}
    if 0 < trough < last and phase[trough] < -LEAST_PHASE:
        features |= {"phase_trough_deg": float(phase[trough]), "phase_trough_time": float(time[trough])}
        rises = np.flatnonzero((phase[trough:-1] < 0.0) & (phase[trough + 1 :] >= 0.0))
        if len(rises):
            k = trough + int(rises[0])
            part = -phase[k] / (phase[k + 1] - phase[k])
            features["zero_crossing_time"] = float(time[k] + part * (time[k + 1] - time[k]))
            features["zero_crossing_rate"] = float(rate[k] + part * (rate[k + 1] - rate[k]))
    return features


def energy_balance(table: dict[str, Floats]) -> dict[str, float | None]:
    """Reference energy [J]; the energy error at the end, the lowest (loss) and the highest (gain); the work of the
    motor [J], None where the hub does not turn, or it is not known.
    """
    error, reference = table["energy_error"], table["reference_energy"]
    if not len(error):
        return dict.fromkeys(("reference_energy", "error", "lowest_error", "highest_error", "motor_work"))
    motor = table.get("motor_work")
    return {
        "reference_energy": float(reference[-1]),
        "error": float(error[-1]),
        "lowest_error": float(error.min()),
        "highest_error": float(error.max()),
        "motor_work": None if motor is None or math.isnan(motor[-1]) else float(motor[-1]),
    }
