"""Thin membranes, folded, stowed and deployed by spinning: a spring-mass simulator with a Rust core.

>>> from membrane_rs import Simulation, scenes
>>> sim = Simulation(scenes.load("spinning-tether"))
>>> sim.step(10)
>>> sim.step_count
10
"""

from __future__ import annotations

from importlib import import_module
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

from membrane_rs import folding, scenes
from membrane_rs.errors import (
    AuditWarning,
    DisplayError,
    ExecutorError,
    InputError,
    InputTypeError,
    Interrupted,
    MembraneError,
    MeshError,
    MissingExtraError,
    MissingFileError,
    OutputError,
    SceneError,
    UnknownAttributeError,
    UnstableError,
)
from membrane_rs.material import Material
from membrane_rs.mesh import Mesh
from membrane_rs.runs import Run, Simulation, open_run, resume, run, view
from membrane_rs.scene import Scene
from membrane_rs.scene.bodies import Cylinder, Plane
from membrane_rs.scene.laws import (
    AirDrag,
    Creases,
    Gravity,
    MassDamping,
    Pressure,
    Spin,
    SpoolContact,
    SpringDamping,
    Springs,
    Triangles,
)
from membrane_rs.scene.parts import Bridges, Fixed, Moved, Tether, Tethers, TipMasses
from membrane_rs.scene.run_settings import RunSettings
from membrane_rs.scene.schedule import Schedule
from membrane_rs.scene.stage import Stage
from membrane_rs.simulation import IntegratorFacts, integrators

__version__ = version("membrane_rs")

__all__ = [
    "AirDrag",
    "AuditWarning",
    "Bridges",
    "Creases",
    "Cylinder",
    "DisplayError",
    "ExecutorError",
    "Fixed",
    "Gravity",
    "InputError",
    "InputTypeError",
    "IntegratorFacts",
    "Interrupted",
    "MassDamping",
    "Material",
    "MembraneError",
    "Mesh",
    "MeshError",
    "MissingExtraError",
    "MissingFileError",
    "Moved",
    "OutputError",
    "Plane",
    "Pressure",
    "Run",
    "RunSettings",
    "Scene",
    "SceneError",
    "Schedule",
    "Simulation",
    "Spin",
    "SpoolContact",
    "SpringDamping",
    "Springs",
    "Stage",
    "Tether",
    "Tethers",
    "TipMasses",
    "Triangles",
    "UnknownAttributeError",
    "UnstableError",
    "__version__",
    "folding",
    "integrators",
    "open_run",
    "resume",
    "run",
    "scenes",
    "view",
]

_PACKAGES = (
    "analysis",
    "check",
    "mesh",
    "plotting",
    "report",
    "results",
    "runs",
    "scene",
    "simulation",
    "study",
    "units",
)

if not TYPE_CHECKING:  # a type checker would take every name for one that is there

    def __getattr__(name: str) -> Any:
        """A package of this one, imported when it is first named, such as `membrane_rs.study`."""
        if name in _PACKAGES:
            return import_module(f"{__name__}.{name}")
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")

    def __dir__() -> list[str]:
        """All public names, the packages that are not imported yet among them."""
        return sorted({*__all__, *_PACKAGES, *(name for name in globals() if name.startswith("__"))})
