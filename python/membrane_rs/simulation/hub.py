"""What is read of the hub: how it turns, what the sail exerts on it, its motor, and angular momentum."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from membrane_rs import _core
from membrane_rs._arrays import Floats
from membrane_rs._validation import check_kind
from membrane_rs.analysis.attitude import Turn, rotation_of
from membrane_rs.mesh.triangulation import frozen
from membrane_rs.scene import Scene
from membrane_rs.scene.hub import hub_of


@dataclass(frozen=True, eq=False)
class HubLoad:
    """What the sail exerts on the hub, in the frame that turns with the hub.

    The sail is all nodes, held ones included. The hub holds these, and touches others at the spool and at the bodies
    that it drives. The load is

        sum over held nodes of (forces of all laws, inertial forces of the turning frame included)
        - sum over all nodes of the forces of contact with spool and bodies,

    so that it balances the rate of change of the sail's momentum and of its angular momentum in an inertial frame,
    less the loads from outside: gravity, air, pressure, sunlight, point forces and mass damping; friction on bodies
    is contact.

    Attributes
    ----------
    force : (3,) float
        Components along the axes of the turning frame [N].
    torque : (3,) float
        About the origin, along the same axes; the third is about the hub's axis [N m].
    contact : float
        Sum of the magnitudes of the forces of spool and bodies on the nodes [N].

    Examples
    --------
    >>> from membrane_rs import Simulation, scenes
    >>> load = Simulation(scenes.load("spinning-tether")).hub_load()
    >>> load.force.shape, load.contact
    ((3,), 0.0)
    """

    force: Floats
    torque: Floats
    contact: float


@dataclass(frozen=True)
class HubMotor:
    """What the motor of the hub exerts on it about its axis: on a free hub the given torque, on a driven one what turns
    it as prescribed against the load of the sail, so that it needs no inertia of its own.

    Attributes
    ----------
    torque : float
        [N m]
    power : float
        The torque times the rate of the hub [W].

    Examples
    --------
    >>> from membrane_rs import Simulation, scenes
    >>> sim = Simulation(scenes.load("spinning-tether"))
    >>> motor = sim.hub_motor()
    >>> bool(motor.torque == -sim.hub_torque()[2]), motor.power == motor.torque * sim.hub_rate
    (True, True)
    """

    torque: float
    power: float


@dataclass(frozen=True)
class AngularMomentum:
    """Angular momentum in inertial space.

    Attributes
    ----------
    hub : float
        Of a free hub about its axis, inertia times rate, without the nodes that it holds; 0 of a driven one
        [kg m2/s]. Of a hub in six degrees of freedom it is the component along its axis, about the point in space where
        its centre of mass began.
    sail : float
        Of all nodes, likewise [kg m2/s].
    in_space : (3,) float
        Of the whole, along axes fixed in space [kg m2/s]. All three components are constant with a hub in six degrees
        of freedom, but for loads from outside; a bearing holds the axis of another hub, so that the third alone is.

    Examples
    --------
    >>> from membrane_rs import Simulation, scenes
    >>> found = Simulation(scenes.load("spinning-tether")).angular_momentum()
    >>> found.hub, found.total == found.sail > 0.0
    (0.0, True)
    """

    hub: float
    sail: float
    in_space: Floats

    @property
    def total(self) -> float:
        """Of hub and sail [kg m2/s]: constant but for the torque on the hub and loads from outside."""
        return self.hub + self.sail


class HubReadings:
    """Readings of the hub of a scene in motion."""

    _core: _core.Simulation

    @property
    def stage_scene(self) -> Scene:
        """The scene of the present stage."""
        raise NotImplementedError

    @property
    def hub_angle(self) -> float:
        """The angle that the hub has turned since time 0 [rad]."""
        return self._core.hub_angle

    @property
    def hub_rate(self) -> float:
        """The rate at which the hub turns about its axis now [rad/s], counter-clockwise seen from +z."""
        return self._core.hub_rate

    @property
    def hub_attitude(self) -> Floats:
        """(4,) unit quaternion (w, x, y, z) of the hub [-]: it turns vectors along its axes into those in space."""
        return frozen(np.array(self._core.hub().attitude))

    @property
    def hub_rotation(self) -> Floats:
        """(3, 3) rotation matrix of the hub [-]: `(positions - c) @ hub_rotation.T + hub_displacement` lie in space.

        In six degrees of freedom c is the centre of mass of the hub and the nodes held on it: the origin, where these
        lie evenly about it. Of a hub on its axis c is 0.
        """
        return frozen(rotation_of(self.hub_attitude))

    @property
    def hub_turn(self) -> Turn:
        """How the frame of the hub is turned in space, for pictures: the angle about z, or a quaternion."""
        return self.hub_attitude if self._is_body else self.hub_angle

    @property
    def hub_displacement(self) -> Floats:
        """(3,) displacement in space of the centre of mass of hub and nodes held on it [m]; 0 of a hub on its axis."""
        return frozen(np.array(self._core.hub().centre))

    @property
    def nutation_angle(self) -> float:
        """Angle between the axis of the hub and the angular momentum of the whole [rad], 0 to pi.

        Of a hub that a bearing holds on its axis it is 0.
        """
        hub = self._core.hub()
        total = np.add(hub.momentum, hub.sail_momentum)
        if not self._is_body or not total.any():
            return 0.0
        return float(np.arctan2(np.hypot(total[0], total[1]), total[2]))

    @property
    def _is_body(self) -> bool:
        """Whether the hub moves in six degrees of freedom now."""
        hub = hub_of(self.stage_scene)
        return hub is not None and hub.mass is not None

    def hub_load(self) -> HubLoad:
        """Force, torque and force of contact that the sail exerts on the hub now, from one evaluation of the laws.

        Returns
        -------
        HubLoad
            [N, N m, N]
        """
        load = self._core.hub_load()
        return HubLoad(np.array(load.force), np.array(load.torque), load.contact)

    def hub_force(self) -> Floats:
        """(3,) force of the sail on the hub now [N], in the turning frame; see `HubLoad`.

        Returns
        -------
        (3,) float64
            [N]
        """
        return self.hub_load().force

    def hub_torque(self) -> Floats:
        """(3,) torque of the sail on the hub about the origin now [N m], in the turning frame; see `HubLoad`.

        Returns
        -------
        (3,) float64
            [N m]
        """
        return self.hub_load().torque

    def hub_motor(self, load: HubLoad | None = None) -> HubMotor:
        """Torque and power of the motor of the hub now.

        Parameters
        ----------
        load : HubLoad, optional
            That of `hub_load` now, where it is at hand: the motor of a driven hub bears it. None: it is evaluated.

        Returns
        -------
        HubMotor
            [N m, W]

        Raises
        ------
        InputTypeError
            No load.
        """
        if load is not None:
            check_kind(load, HubLoad, "load", "what hub_load() gives")
        torque = self._core.hub().motor_torque
        if torque is None:
            torque = -float((load or self.hub_load()).torque[2])
        return HubMotor(torque, torque * self.hub_rate)

    def angular_momentum(self) -> AngularMomentum:
        """Angular momentum of hub and sail now, about the axis of the hub in inertial space.

        Returns
        -------
        AngularMomentum
            [kg m2/s]
        """
        hub = self._core.hub()
        in_space = rotation_of(np.array(hub.attitude)) @ np.add(hub.momentum, hub.sail_momentum)
        return AngularMomentum(hub.momentum[2], hub.sail_momentum[2], in_space)
