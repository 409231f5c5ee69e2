"""A robot with a differential drive: what it is told, where it goes, and what its wheels tell."""

from dataclasses import dataclass

import numpy as np

from colortrack_ros.world.poses import Pose

ACCELERATION, TURNING = 5.0, 20.0
"""What wheels with rubber can do [m/s^2], [rad/s^2]: half of friction 1 times gravity. Assumed."""

TOP_SPEED, TOP_TURN = 1.5, 4.0
"""As fast as the motors turn [m/s], [rad/s]. Assumed: a Jackal drives 2 m/s, a TurtleBot 0.3."""

ROBOT_RADIUS = 0.2
"""Of the robot [m]: it stops where something is nearer to its middle. Assumed: a
TurtleBot 4 has 0.17."""


@dataclass
class Place:
    """Of a robot on the ground: x, y [m] and heading [rad]."""

    x: float = 0.0
    y: float = 0.0
    yaw: float = 0.0

    def moved(self, way: float, turn: float) -> 'Place':
        """After driving on an arc of so many m, turning by so many rad."""
        # the chord of an arc is sin(turn/2) / (turn/2) as long, in the direction of its middle
        chord = way * np.sinc(turn / (2 * np.pi))
        middle = self.yaw + turn / 2
        return Place(
            self.x + chord * np.cos(middle), self.y + chord * np.sin(middle), self.yaw + turn
        )

    @property
    def pose(self) -> Pose:
        """In space."""
        return Pose.of_rpy((self.x, self.y, 0.0), (0.0, 0.0, self.yaw))


class Robot:
    """A robot that begins in the middle of the room and looks along x.

    :param drift: standard deviations of what odometry is off by after 1 m [m] and 1 rad [rad].
    :param rng: for the drift.
    :ivar place: where it is.
    :ivar odometry: where its wheels say that it is.
    :ivar speed, turn: of now [m/s], [rad/s].
    """

    def __init__(self, drift: tuple[float, ...], rng: np.random.Generator) -> None:
        self.place, self.odometry = Place(), Place()
        self.speed = self.turn = 0.0
        self._drift, self._rng = drift, rng
        self._command = (0.0, 0.0)

    def command(self, speed: float, turn: float) -> None:
        """Take the speeds to drive with [m/s], [rad/s]."""
        self._command = (
            float(np.clip(speed, -TOP_SPEED, TOP_SPEED)),
            float(np.clip(turn, -TOP_TURN, TOP_TURN)),
        )

    def next(self, dt: float) -> Place:
        """Change the speeds towards the command; where it is after dt [s] if nothing is there."""
        speed, turn = self._command
        self.speed += float(np.clip(speed - self.speed, -ACCELERATION * dt, ACCELERATION * dt))
        self.turn += float(np.clip(turn - self.turn, -TURNING * dt, TURNING * dt))
        return self.place.moved(self.speed * dt, self.turn * dt)

    def go(self, place: Place, dt: float) -> None:
        """Be there, with the odometry that the wheels count."""
        way, turn = self.speed * dt, self.turn * dt
        off = self._rng.normal(size=2) * self._drift
        self.odometry = self.odometry.moved(
            way + off[0] * np.sqrt(abs(way)), turn + off[1] * np.sqrt(abs(turn))
        )
        self.place = place

    def bump(self) -> None:
        """Stand: something is in the way."""
        self.speed = 0.0
