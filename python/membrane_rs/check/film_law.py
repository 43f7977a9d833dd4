"""Whether the film has a law."""

from __future__ import annotations

import math
from collections.abc import Iterator

from membrane_rs.material import Material
from membrane_rs.mesh import Finding
from membrane_rs.scene import Scene
from membrane_rs.scene.laws import LAWS


def two_moduli(scene: Scene) -> Iterator[Finding]:
    """The moduli of a film that has two, as a fact."""
    words = None if scene.material is None else moduli_in_words(scene.material)
    if words is not None:
        yield Finding("info", "two_moduli", 1, f"the film has two moduli: {words}", "")


def moduli_in_words(material: Material) -> str | None:
    """The moduli of a film of two and their direction; None of one modulus."""
    if material.youngs_modulus_across is None:
        return None
    degrees = math.degrees(material.direction or 0.0)
    along = f"E {material.youngs_modulus:.4g} Pa at {degrees:.4g} degrees from x, nu {material.poisson_ratio:g}"
    return f"{along}; {material.youngs_modulus_across:.4g} Pa across; G {material.shear_modulus:.4g} Pa"


def film_law(scene: Scene) -> Iterator[Finding]:
    """A membrane without a law of the film is a set of masses that nothing holds together."""
    if scene.mesh is not None and not any(law.is_film for law in scene.laws):
        names = " or ".join(f"[laws.{kind}]" for kind, law in LAWS.items() if law.is_film)
        yield Finding(
            "warning",
            "film_law",
            1,
            "there is no law of the film: nothing holds its nodes together, and it stretches without a force",
            f"add {names}",
        )
