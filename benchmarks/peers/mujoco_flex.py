"""MuJoCo: a flex of triangles, St. Venant and Kirchhoff's law in plane stress, without bending.

Each node is a body with three slide joints, as MuJoCo's own `flexcomp` makes them. Contact, constraints, dampers and
gravity are off. Its integrators: "Euler" (symplectic), "RK4", and "discrete", implicit in positions and velocities.
"implicit" and "implicitfast" refuse the elasticity of a flex; a stiffness of its edges is for chains only.
"""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from peers.problem import Floats, Problem

mujoco.set_mju_user_warning(lambda _: None)  # it would write of each blown run, to the screen and to a file
METHODS = {"Euler": "mjINT_EULER", "RK4": "mjINT_RK4", "discrete": "mjINT_DISCRETE"}


class Flex:
    """One integrator of MuJoCo. Methods of one problem may share a model: each sets its own integrator at the start."""

    law, bits = "triangles", 64

    def __init__(self, problem: Problem, model: Any, method: str, limit_guess: float | None) -> None:
        self.name, self.limit_guess = f"MuJoCo {method}", limit_guess
        self._problem, self._model = problem, model
        self._integrator = getattr(mujoco.mjtIntegrator, METHODS[method])
        self._data = mujoco.MjData(model)

    def start(self, dt: float) -> None:
        """Flat, turning."""
        self._dt = dt
        self._choose()
        mujoco.mj_resetData(self._model, self._data)
        self._data.qvel[:] = self._problem.velocities.ravel()

    def masses(self) -> Floats:
        """Of the bodies that carry the vertices."""
        return np.array(self._model.body_mass[self._model.flex_vertbodyid])

    def step(self, n: int) -> None:
        """All n in one call."""
        self._choose()
        mujoco.mj_step(self._model, self._data, n)

    def motion(self) -> tuple[Floats, Floats]:
        """Joints are displacements along x, y, z."""
        shape = self._problem.mesh.reference.shape
        return (
            self._problem.mesh.reference + np.array(self._data.qpos).reshape(shape),
            np.array(self._data.qvel).reshape(shape),
        )

    def _choose(self) -> None:
        self._model.opt.integrator, self._model.opt.timestep = self._integrator, self._dt


def model_of(problem: Problem) -> Any:
    """The compiled model, with the nodes' masses."""
    film, mesh = problem.material, problem.mesh
    points = " ".join(f"{value:.17g}" for value in mesh.reference.ravel())
    elements = " ".join(map(str, mesh.triangles.ravel()))
    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco>
          <option gravity="0 0 0">
            <flag contact="disable" constraint="disable" midphase="disable" damper="disable" autoreset="disable"/>
          </option>
          <worldbody>
            <flexcomp name="film" type="direct" dim="2" mass="1" radius="1e-4" inertiabox="1e-3"
                      point="{points}" element="{elements}">
              <contact contype="0" conaffinity="0" selfcollide="none"/>
              <elasticity young="{film.youngs_modulus!r}" poisson="{film.poisson_ratio!r}"
                          thickness="{film.thickness!r}" elastic2d="stretch"/>
            </flexcomp>
          </worldbody>
        </mujoco>"""
    )
    bodies = np.asarray(model.flex_vertbodyid)
    if not np.array_equal(bodies, 1 + np.arange(mesh.node_count)) or model.nv != 3 * mesh.node_count:
        raise RuntimeError(f"MuJoCo {mujoco.__version__} orders bodies otherwise: adapt {__file__}")
    model.body_mass[bodies] = problem.masses
    mujoco.mj_setConst(model, mujoco.MjData(model))
    return model


def programs(problem: Problem, guesses: dict[str, float]) -> list[Flex]:
    """Its three methods; `guesses`: limits of leapfrog and rk4 on the same film [s]."""
    model = model_of(problem)
    limits = {"Euler": guesses["leapfrog"], "RK4": guesses["rk4"], "discrete": None}
    return [Flex(problem, model, method, limits[method]) for method in METHODS]
