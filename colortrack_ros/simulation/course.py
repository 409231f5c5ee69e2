"""Motion of a thing over time: along a closed path, and bouncing."""

import numpy as np

from colortrack_ros.data import Floats
from colortrack_ros.simulation.config import ThingConfig
from colortrack_ros.world.state import GRAVITY

LOWEST_HOP = 0.3
"""A ball that leaves the ground slower than this [m/s] has stopped bouncing: it would rise by
v^2 / 2g, 5 mm, and land after 2v / g, 0.06 s, two pictures at 30 Hz."""


class Course:
    """The motion of a thing, as a function of time.

    It follows its path at constant speed, around sharp corners, again and again. A bouncing thing
    is in free fall; a flight takes 2 v / g, and the next one starts at `restitution` times its
    speed v.
    """

    def __init__(self, config: ThingConfig) -> None:
        corners = np.asarray(config.path).reshape(-1, 2)
        self._corners = np.concatenate([corners, corners[:1]])
        self._sides = np.diff(self._corners, axis=0)
        self._lengths = np.linalg.norm(self._sides, axis=1)
        self._ends = np.cumsum(self._lengths)
        self._speed = config.speed
        self._rest = (config.diameter if config.shape == 'ball' else config.height) / 2
        first, speeds = np.sqrt(2 * GRAVITY * config.bounce_height), []
        while first > LOWEST_HOP:
            speeds.append(first)
            first *= config.restitution
        self._hops = np.array(speeds)
        self._landings = np.cumsum(2 * self._hops / GRAVITY)

    def at(self, time: float) -> tuple[Floats, Floats]:
        """Return position of the center and velocity, (3,) each [m], [m/s].

        :param time: since the start [s].
        """
        position, velocity = np.empty(3), np.zeros(3)
        position[:2] = self._corners[0]
        if self._ends[-1] > 0 and self._speed > 0:
            way = self._speed * time % self._ends[-1]
            side = int(np.searchsorted(self._ends, way, side='right'))
            direction = self._sides[side] / self._lengths[side]
            position[:2] = self._corners[side + 1] - (self._ends[side] - way) * direction
            velocity[:2] = self._speed * direction
        position[2], velocity[2] = self._rest, 0.0
        if len(self._hops):
            phase = time % self._landings[-1]
            hop = int(np.searchsorted(self._landings, phase, side='right'))
            start = self._landings[hop] - 2 * self._hops[hop] / GRAVITY
            since = phase - start
            position[2] += self._hops[hop] * since - GRAVITY * since**2 / 2
            velocity[2] = self._hops[hop] - GRAVITY * since
        return position, velocity
