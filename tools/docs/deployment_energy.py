"""Energy balance of each stage of a whole deployment, the work of bars and motor among them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from membrane_rs._markdown import table

WORKS = ("bars", "spring_damping", "mass_damping", "air_drag")


def energy_table(models: Mapping[str, Sequence[Mapping[str, Any]]]) -> str:
    """Work in each stage, what its beginning put in, and the residual of its balance: the "stages" of summaries."""
    body = []
    for model, stages in models.items():
        for one in stages:
            works = [f"{1e3 * one['work_by_law'][law]:.3f}" if law in one["work_by_law"] else "-" for law in WORKS]
            body.append((
                model, one["name"], f"{1e3 * one['motor_work']:.3f}", *works,
                f"{1e3 * math.fsum(one['changes'].values()):.4f}", f"{1e3 * one['reference_energy']:.3f}",
                f"{100.0 * one['error']:+.3f}",
            ))  # fmt: skip
    heads = (
        "sail", "stage", "motor", "bars", "dashpots", "mass damping", "air", "put in at the start", "reference energy",
        "residual [%]",
    )  # fmt: skip
    return table(heads, body, words=(0, 1))
