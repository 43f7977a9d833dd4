"""Thin membranes, folded, stowed and deployed by spinning: a spring-mass simulator with a Rust core.

>>> from membrane_rs import Simulation, scenes
>>> sim = Simulation(scenes.load("spinning-tether"))
>>> sim.step(10)
>>> sim.step_count
10
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from membrane_rs._on_demand import OnDemand

if TYPE_CHECKING:
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
        Bending,
        CordDrag,
        Creases,
        Gravity,
        MassDamping,
        PointForces,
        Pressure,
        Rectangles,
        SelfContact,
        SolarPressure,
        Spin,
        SpoolContact,
        SpringDamping,
        Springs,
        Triangles,
    )
    from membrane_rs.scene.parts import (
        Boltrope,
        Bridges,
        Cord,
        CreaseSet,
        Fixed,
        Moved,
        Region,
        Tether,
        Tethers,
        TipMasses,
    )
    from membrane_rs.scene.run_settings import RunSettings
    from membrane_rs.scene.schedule import Schedule
    from membrane_rs.scene.stage import Stage
    from membrane_rs.simulation import FoldResult, IntegratorFacts, fold, integrators

    __version__: str

__all__ = [
    "AirDrag",
    "AuditWarning",
    "Bending",
    "Boltrope",
    "Bridges",
    "Cord",
    "CordDrag",
    "CreaseSet",
    "Creases",
    "Cylinder",
    "DisplayError",
    "ExecutorError",
    "Fixed",
    "FoldResult",
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
    "PointForces",
    "Pressure",
    "Rectangles",
    "Region",
    "Run",
    "RunSettings",
    "Scene",
    "SceneError",
    "Schedule",
    "SelfContact",
    "Simulation",
    "SolarPressure",
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
    "fold",
    "folding",
    "integrators",
    "open_run",
    "resume",
    "run",
    "scenes",
    "view",
]

_PLACES = {
    "membrane_rs.errors": (
        "AuditWarning",
        "DisplayError",
        "ExecutorError",
        "InputError",
        "InputTypeError",
        "Interrupted",
        "MembraneError",
        "MeshError",
        "MissingExtraError",
        "MissingFileError",
        "OutputError",
        "SceneError",
        "UnknownAttributeError",
        "UnstableError",
    ),
    "membrane_rs.material": ("Material",),
    "membrane_rs.mesh": ("Mesh",),
    "membrane_rs.runs": ("Run", "Simulation", "open_run", "resume", "run", "view"),
    "membrane_rs.scene": ("Scene",),
    "membrane_rs.scene.bodies": ("Cylinder", "Plane"),
    "membrane_rs.scene.laws": (
        "AirDrag",
        "Bending",
        "CordDrag",
        "Creases",
        "Gravity",
        "MassDamping",
        "PointForces",
        "Pressure",
        "Rectangles",
        "SelfContact",
        "SolarPressure",
        "Spin",
        "SpoolContact",
        "SpringDamping",
        "Springs",
        "Triangles",
    ),
    "membrane_rs.scene.parts": (
        "Boltrope",
        "Bridges",
        "Cord",
        "CreaseSet",
        "Fixed",
        "Moved",
        "Region",
        "Tether",
        "Tethers",
        "TipMasses",
    ),
    "membrane_rs.scene.run_settings": ("RunSettings",),
    "membrane_rs.scene.schedule": ("Schedule",),
    "membrane_rs.scene.stage": ("Stage",),
    "membrane_rs.simulation": ("FoldResult", "IntegratorFacts", "fold", "integrators"),
}
_OLD = {"audit", "laws", "observe", "output", "parts", "run_settings"}
"""Old places of names: modules that are found and not listed."""

if not TYPE_CHECKING:  # a type checker would take every name for one that is there
    _on_demand = OnDemand(__name__, _PLACES)

    def __getattr__(name: str) -> Any:
        """A public name or module of this package, imported when it is first used."""
        if name == "__version__":
            from importlib.metadata import version  # slow to import

            return version(__name__)
        return _on_demand(name)

    def __dir__() -> list[str]:
        """All public names, also those that are not imported yet."""
        return sorted({*_on_demand.names(), "__version__"} - _OLD)
