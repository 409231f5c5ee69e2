"""The simulation: the robot drives, things move, the camera takes pictures."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from colortrack_ros.data import COASTING
from colortrack_ros.data import CONFIRMED
from colortrack_ros.data import Floats
from colortrack_ros.data import LOCATION
from colortrack_ros.data import Locations
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.simulation.config import SimulationConfig
from colortrack_ros.simulation.config import Thing
from colortrack_ros.simulation.course import Course
from colortrack_ros.simulation.depth import StereoErrors
from colortrack_ros.simulation.rendering import Renderer
from colortrack_ros.simulation.rendering import Sight
from colortrack_ros.simulation.robot import Place
from colortrack_ros.simulation.robot import Robot
from colortrack_ros.simulation.robot import ROBOT_RADIUS
from colortrack_ros.simulation.rooms import ROOMS
from colortrack_ros.world.poses import OPTICAL
from colortrack_ros.world.poses import Pose
from colortrack_ros.world.view import View

SEEN = 0.3
"""A thing is seen if at least this share of it is visible, enough for a detector. Assumed; only the
truth uses it, to decide whether a half-covered thing counts as seen."""


class Simulation:
    """A robot in a room.

    :ivar time: since the start [ns].
    :ivar robot: the robot.
    :ivar mount: pose of the camera's body on the robot.
    :ivar things: those reported in the truth.
    """

    def __init__(self, config: SimulationConfig) -> None:
        rng = np.random.default_rng(config.seed)
        self._room = ROOMS[config.room]
        self.time = 0
        self.robot = Robot(config.odometry_drift, rng)
        self.camera = config.camera
        self.mount = Pose.of_rpy(config.camera_pose[:3], config.camera_pose[3:])
        self._depths = StereoErrors(config.depth_noise, config.depth_holes, rng)
        self._renderer = Renderer(self.camera, self._room, config.picture_noise, rng)
        self.place(config.objects)

    def place(self, objects: Sequence[Thing]) -> None:
        """Put things into the room, in addition to its initial ones."""
        self.things = [*self._room.things, *objects]
        self._courses = [Course(thing.config) for thing in self.things]
        self._seen = np.full(len(self.things), self.time)

    def advance(self, duration: int) -> None:
        """Advance the simulation.

        :param duration: [ns].
        """
        dt = duration / NANOSECONDS
        self.time += duration
        place = self.robot.next(dt)
        if self._is_free(place):
            self.robot.go(place, dt)
        else:
            self.robot.bump()

    def look(self) -> Sight:
        """Take a picture."""
        optical = self.robot.place.pose @ self.mount @ OPTICAL
        sight = self._renderer.render(optical, self.things, self._states()[:, :3])
        self._seen[sight.visible >= SEEN] = self.time
        return replace(sight, depth=self._depths.of(sight.depth))

    @property
    def view(self) -> View:
        """The camera's view according to odometry."""
        return View(self.camera, self.robot.odometry.pose, self.mount)

    def truth(self, visible: Floats) -> Locations:
        """Return the true locations in the odometry's frame, in which things share its drift.

        :param visible: (N,) visible share of each thing, see Sight; becomes the score.
        """
        off = self.robot.odometry.pose @ self.robot.place.pose.inverse()
        states = self._states()
        rows = np.zeros(len(self.things), LOCATION)
        for at, values in enumerate((off.apply(states[:, :3]), states[:, 3:] @ off.R.T)):
            for name, column in zip(('xyz', ('vx', 'vy', 'vz'))[at], values.T, strict=True):
                rows[name] = column
        colors = list(dict.fromkeys(thing.config.rgb for thing in self.things))
        rows['color'] = [colors.index(thing.config.rgb) for thing in self.things]
        rows['track_id'] = np.arange(1, len(self.things) + 1)
        rows['state'] = np.where(visible >= SEEN, CONFIRMED, COASTING)
        rows['diameter'] = [thing.config.diameter for thing in self.things]
        rows['time_since_update'] = (self.time - self._seen) / NANOSECONDS
        rows['score'] = visible
        return Locations(rows, self.time)

    def _states(self) -> Floats:
        """Return position and velocity of each thing in the room, (N, 6)."""
        now = self.time / NANOSECONDS
        states = [np.concatenate(course.at(now)) for course in self._courses]
        return np.reshape(states, (-1, 6))

    def _is_free(self, place: Place) -> bool:
        """Return whether the robot fits there: no wall, pillar, or low thing is in its way."""
        x, y = self._room.half_size
        inside = abs(place.x) < x - ROBOT_RADIUS and abs(place.y) < y - ROBOT_RADIUS
        states = self._states()
        spots = [*states[:, :2], *(np.array(p.config.path) for p in self._room.pillars)]
        sizes = [t.config.diameter for t in (*self.things, *self._room.pillars)]
        low = [*(states[:, 2] < 2 * ROBOT_RADIUS), *(True for _ in self._room.pillars)]
        return inside and not any(
            near and np.hypot(*(spot - (place.x, place.y))) < ROBOT_RADIUS + size / 2
            for spot, size, near in zip(spots, sizes, low, strict=True)
        )
