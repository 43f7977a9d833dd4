"""The strains by which docs/softening.md bounds the softening, of the scenes in which it was measured."""

from __future__ import annotations

from membrane_rs import scenes
from membrane_rs._markdown import table
from membrane_rs.check import softening_advice
from membrane_rs.check.softening import MOST_CRITICAL_STRAIN, MOST_STRAIN
from softening_cases import MODELS, RULE


def rule_table() -> str:
    """Strain under the spin, critical strain of the creases, and the softenings at which they reach their bounds."""
    measured = {name: scenes.load(scene) for name, scene in MODELS.items()}
    measured |= {name: change(scenes.load(MODELS["model 1"])) for name, (change, _) in RULE.items()}
    body = []
    for name, scene in measured.items():
        advice = softening_advice(scene)
        strains = advice.spin_strain, advice.critical_strain
        factors = MOST_STRAIN / strains[0], MOST_CRITICAL_STRAIN / strains[1]
        body.append((name, *(f"{strain:.2g}" for strain in strains), *(f"{f:.3g}" for f in (*factors, advice.factor))))
    heads = ("scene", "eps", "eps_c", "A/eps", "B/eps_c", "softening")
    return table(heads, body)
