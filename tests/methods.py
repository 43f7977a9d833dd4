"""Every method of integration, its order, and the ways in which it steps."""

from __future__ import annotations

from membrane_rs import integrators

METHODS = list(integrators())
ORDER = {name: facts.order for name, facts in integrators().items()}
WAYS = [(name, 1) for name in METHODS] + [("leapfrog", 4)]
"""Methods and substeps."""
