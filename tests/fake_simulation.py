"""A simulation that does not compute: its shape is set by the test. For tests of what looks on."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, cast

import numpy as np
from membrane_rs import (
    Creases,
    Material,
    RunSettings,
    Scene,
    Spin,
    SpringDamping,
    Springs,
    Tethers,
    TipMasses,
)
from membrane_rs._arrays import Floats, Ints
from membrane_rs.folding import SquareSail
from membrane_rs.runs import RunFolder
from membrane_rs.scene.assembly import Assembly
from membrane_rs.simulation import AngularMomentum, FilmStress, HubLoad, HubMotor
from numpy.typing import NDArray


def small_sail(**run: Any) -> Scene:
    """A sail with one fold line, its tethers and tip masses."""
    return Scene(
        SquareSail(outer_width=0.2, inner_width=0.1, fold_lines=1, rows=2, columns=2).mesh(),
        Material(3.2e9, 0.34, 1420.0, 7.5e-6),
        [Springs(), SpringDamping(), Creases(), Spin()],
        [TipMasses(0.36e-3), Tethers(segments=3)],
        name="small-sail",
        run=RunSettings(**run),
    )


@dataclass
class FakeSimulation:
    """What observers read of a simulation; `show` sets time and shape."""

    scene: Scene = field(default_factory=small_sail)
    time: float = 0.0
    until: float | None = None
    hub_angle: float = 0.0
    hub_rate: float = 6.0 * np.pi
    dt: float = 1e-5
    given_dt: float | None = None
    integrator: str = "rk4"
    step_count: int = 0
    evaluation_count: int = 0
    rejected_count: int = 0
    statistics: dict[str, int] = field(default_factory=dict)
    limiting_part: str = "springs near node 0"

    def __post_init__(self) -> None:
        self.stage_scene = self.scene
        self.assembly: Assembly = self.scene.assemble()
        self.positions: Floats = self.assembly.positions.copy()
        self.velocities: Floats = np.zeros_like(self.positions)
        assert self.scene.mesh is not None
        self.spring_pairs: Ints = np.vstack([self.scene.mesh.edges, self.assembly.cords.nodes])
        self.stored = {"springs": 0.1, "creases": 0.2, "spin": -0.5, "tethers": 0.0}

    def show(self, time: float, positions: Floats) -> None:
        self.time, self.positions = time, positions
        self.hub_angle = 6.0 * np.pi * time
        self.step_count = round(time / self.dt)

    stage = 0
    stage_name = ""
    stopped_by = None
    boundaries = ()
    stages = ()
    law_names = ()

    @property
    def hub_turn(self) -> float:
        return self.hub_angle

    @property
    def potential_names(self) -> tuple[str, ...]:
        return tuple(self.ledger()["stored_by_law"])

    def energies(self) -> dict[str, float]:
        return {"kinetic": 0.3, **self.stored}

    def ledger(self) -> dict[str, Any]:
        work = {"spring_damping": -0.1} if self.time > 0 else {}
        return {
            "kinetic": 0.3,
            "stored": -0.2,
            "work": -0.1,
            "reference_energy": 1.0,
            "error": -1e-3,
            "stored_by_law": self.stored,
            "work_by_law": work,
            "motor_work": 0.7,
        }

    def spring_strains(self) -> Floats:
        return 1e-4 * np.arange(-10.0, len(self.spring_pairs) - 10.0, dtype=np.float64)

    def buckled(self) -> NDArray[np.bool_]:
        return self.spring_strains() < 0.0

    def crease_angles(self) -> Floats:
        return 0.1 * np.arange(len(self.assembly.creases), dtype=np.float64)

    def film_stress(self) -> FilmStress:
        count = len(self.assembly.triangles)
        values = 1e3 * np.arange(2.0 * count).reshape(count, 2)[:, ::-1]
        return FilmStress(values, np.tile(np.eye(3)[:2], (count, 1, 1)))

    def largest_film_stress(self) -> float:
        return float(self.film_stress().principal.max())

    def film_states(self) -> NDArray[np.int8]:
        return np.full(len(self.assembly.triangles), -1, np.int8)

    def cord_tensions(self) -> Floats:
        return 0.01 * np.arange(len(self.assembly.cords), dtype=np.float64)

    def hub_load(self) -> HubLoad:
        return HubLoad(np.array([3.0, 4.0, 0.0]), np.array([0.0, 0.0, -0.5]), 0.25)

    def hub_motor(self, load: HubLoad | None = None) -> HubMotor:
        return HubMotor(0.5, 0.5 * self.hub_rate)

    def angular_momentum(self) -> AngularMomentum:
        return AngularMomentum(0.0, 2e-3, np.array([0.0, 0.0, 2e-3]))

    def stable_dt(self) -> float:
        return 2e-5

    def save(self, path: Path) -> None:
        path.write_bytes(b"state")


def turned_flat(assembly: Assembly, angle_deg: float, scale: float = 1.0) -> Floats:
    """The reference, turned about z and drawn in or out from the axis."""
    c, s = np.cos(np.radians(angle_deg)), np.sin(np.radians(angle_deg))
    turn = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    turned: Floats = np.matmul(scale * assembly.reference, turn)
    return turned


def run(folder: RunFolder, times: list[float], error: BaseException | None = None) -> Any:
    """Show a turning, shrinking sail to a folder: each time a sample and a frame."""
    sim: Any = FakeSimulation(small_sail(snapshots=[0.0, 0.1]))
    folder.start(sim)
    for when in times:
        sim.show(when, turned_flat(sim.assembly, -100.0 * np.sin(4.0 * when), 1.0 - 0.3 * when))
        folder.sample(sim)
        folder.frame(sim)
    folder.finish(sim, error)
    return sim


def summary(path: Path) -> dict[str, Any]:
    """summary.json of a run's folder."""
    return cast(dict[str, Any], json.loads((path / "summary.json").read_text()))
