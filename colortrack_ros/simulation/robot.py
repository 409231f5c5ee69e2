"""A robot with a differential drive: its commands, its motion, and its odometry."""

from dataclasses import dataclass

import numpy as np

from colortrack_ros.world.poses import Pose

ACCELERATION, TURNING = 5.0, 20.0
"""Acceleration of rubber wheels [m/s^2], [rad/s^2]: half of a friction of 1. Assumed."""

TOP_SPEED, TOP_TURN = 1.5, 4.0
"""Top speeds of the motors [m/s], [rad/s]. Assumed: a Jackal drives 2 m/s, a TurtleBot 0.3."""

ROBOT_RADIUS = 0.2
"""Radius of the robot [m]: it stops before anything comes closer to its center. Assumed: a
TurtleBot 4 has 0.17."""


@dataclass
class Place:
    """Pose of a robot on the ground: x, y [m] and heading [rad]."""

    x: float = 0.0
    y: float = 0.0
    yaw: float = 0.0

    def moved(self, way: float, turn: float) -> 'Place':
        """Return the place after an arc of length `way` [m] that turns by `turn` [rad]."""
        # The chord of an arc is shorter by sin(turn/2) / (turn/2), and points along its middle.
        chord = way * np.sinc(turn / (2 * np.pi))
        middle = self.yaw + turn / 2
        return Place(
            self.x + chord * np.cos(middle), self.y + chord * np.sin(middle), self.yaw + turn
        )

    @property
    def pose(self) -> Pose:
        """The same in space."""
        return Pose.of_rpy((self.x, self.y, 0.0), (0.0, 0.0, self.yaw))


class Robot:
    """A robot that starts in the middle of the room, facing along x.

    :param drift: standard deviations of the odometry's error after 1 m [m] and 1 rad [rad].
    :param rng: for the drift.
    :ivar place: true pose.
    :ivar odometry: pose according to its wheels.
    :ivar speed, turn: current speeds [m/s], [rad/s].
    """

    def __init__(self, drift: tuple[float, ...], rng: np.random.Generator) -> None:
        self.place, self.odometry = Place(), Place()
        self.speed = self.turn = 0.0
        self._drift, self._rng = drift, rng
        self._command = (0.0, 0.0)

    def command(self, speed: float, turn: float) -> None:
        """Set the desired speeds [m/s], [rad/s]."""
        self._command = (
            float(np.clip(speed, -TOP_SPEED, TOP_SPEED)),
            float(np.clip(turn, -TOP_TURN, TOP_TURN)),
        )

    def next(self, dt: float) -> Place:
        """Adapt the speeds to the command; return where it gets in dt [s] if the way is free."""
        speed, turn = self._command
        self.speed += float(np.clip(speed - self.speed, -ACCELERATION * dt, ACCELERATION * dt))
        self.turn += float(np.clip(turn - self.turn, -TURNING * dt, TURNING * dt))
        return self.place.moved(self.speed * dt, self.turn * dt)

    def go(self, place: Place, dt: float) -> None:
        """Move there, and update the odometry."""
        way, turn = self.speed * dt, self.turn * dt
        off = self._rng.normal(size=2) * self._drift
        self.odometry = self.odometry.moved(
            way + off[0] * np.sqrt(abs(way)), turn + off[1] * np.sqrt(abs(turn))
        )
        self.place = place

    def bump(self) -> None:
        """Stand: something is in the way."""
        self.speed = 0.0
