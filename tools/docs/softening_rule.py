"""The strains by which docs/softening.md bounds the softening, of the scenes in which it was measured."""

from __future__ import annotations

import math

import numpy as np
from membrane_rs import Scene, Simulation, Springs, scenes
from membrane_rs._markdown import table
from softening_cases import MODELS, RULE

MOST_STRAIN, MOST_CRITICAL_STRAIN = 1.7e-4, 4.5e-3
"""A and B, the strains of a softened film up to which it moves as one that is not softened [-]."""


def spin_strain(scene: Scene) -> float:
    """Omega^2 sum m r^2/(E h S), the mean strain of the flat sail under its spin [-], by the virial theorem."""
    assert scene.mesh is not None
    assert scene.material is not None
    omega = 2.0 * math.pi * float(scene.value("laws.spin.frequency"))
    squares = (scene.mesh.reference[:, :2] ** 2).sum(axis=1)
    moment = float(Simulation(scene).masses[: len(squares)] @ squares)
    stiffness = scene.material.youngs_modulus * scene.material.thickness * float(scene.mesh.areas().sum())
    return omega**2 * moment / stiffness


def critical_strain(scene: Scene) -> float:
    """Mean of alpha_c pi^2 h^2/(12 L^2) over the creases [-], eq. (2)."""
    springs = scene.law(Springs)
    assert springs is not None
    assert scene.mesh is not None
    assert scene.material is not None
    ends = scene.mesh.reference[scene.mesh.creases]
    squares = ((ends[:, 1] - ends[:, 0]) ** 2).sum(axis=1)
    euler = math.pi**2 * scene.material.thickness**2 / 12.0
    return float(np.mean(springs.buckling_on_creases * euler / squares))


def rule_table() -> str:
    """Strain under the spin, critical strain of the creases, and the softenings at which they reach their bounds."""
    measured = {name: scenes.load(scene) for name, scene in MODELS.items()}
    measured |= {name: change(scenes.load(MODELS["model 1"])) for name, (change, _) in RULE.items()}
    body = []
    for name, scene in measured.items():
        strains = spin_strain(scene), critical_strain(scene)
        factors = MOST_STRAIN / strains[0], MOST_CRITICAL_STRAIN / strains[1]
        body.append((name, *(f"{strain:.2g}" for strain in strains), *(f"{f:.2g}" for f in (*factors, min(factors)))))
    heads = ("scene", "eps", "eps_c", "A/eps", "B/eps_c", "softening")
    return table(heads, body)
