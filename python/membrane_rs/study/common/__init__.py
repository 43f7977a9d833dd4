"""What studies share: runs, the pool that makes them, variations of a scene, differences between runs."""

from __future__ import annotations

from typing import TYPE_CHECKING

from membrane_rs._on_demand import OnDemand

if not TYPE_CHECKING:
    _on_demand = OnDemand(__name__, {})
    __getattr__, __dir__ = _on_demand, _on_demand.names
