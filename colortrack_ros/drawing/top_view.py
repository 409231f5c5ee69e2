"""A room from above: the robot, what it knows of the things there, and where they are."""

from collections.abc import Iterable

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Floats
from colortrack_ros.data import Locations
from colortrack_ros.data import TENTATIVE
from colortrack_ros.drawing.overlay import BGR
from colortrack_ros.drawing.overlay import track_color
from colortrack_ros.ellipses import outlines

Image = NDArray[np.uint8]

GROUND, INK, GRAY = (245, 245, 245), (60, 60, 60), (190, 190, 190)
ROBOT, TRUE = (150, 90, 30), (120, 120, 120)

ROBOT_SIZE = 0.2
"""Radius of the robot in the picture [m]. Assumed: that of a small robot."""

FRACTION = 4
"""Fractional bits of the coordinates that OpenCV draws."""


class TopView:
    """Pictures of a room from above, x to the right and y up.

    :param half_size: the room goes from -x to x and from -y to y [m].
    :param width: of the pictures [px].
    :param pillars: x, y, diameter of each [m].
    """

    def __init__(
        self,
        half_size: tuple[float, float],
        width: int,
        pillars: Iterable[tuple[float, float, float]] = (),
    ) -> None:
        self._half = np.array(half_size)
        self._scale = width / (2 * half_size[0])
        self._pillars = list(pillars)
        self._size = round(2 * half_size[1] * self._scale), width
        self._ways: dict[int, list[Floats]] = {}

    def draw(self, place: tuple[float, float, float], known: Locations, true: Locations) -> Image:
        """The picture.

        :param place: x, y [m] and heading [rad] of the robot.
        :param known: what is known of things: a dot, the ellipse that holds 95 %, and the ID.
        :param true: where they are: a gray ring.
        """
        image = np.full((*self._size, 3), GROUND, np.uint8)
        for x, y, diameter in self._pillars:
            self._disc(image, (x, y), diameter / 2, GRAY, cv2.FILLED)
        for row in true.rows:
            self._disc(image, (row['x'], row['y']), row['diameter'] / 2, TRUE, 1)
        self._way(image, 0, np.array(place[:2]), ROBOT)
        for row in known.rows[known.rows['state'] != TENTATIVE]:
            self._known(image, row)
        self._disc(image, place[:2], ROBOT_SIZE, ROBOT, 2)
        nose = np.array(place[:2]) + ROBOT_SIZE * np.array([np.cos(place[2]), np.sin(place[2])])
        self._line(image, np.array([place[:2], nose]), ROBOT, 2)
        return image

    def _known(self, image: Image, row: np.void) -> None:
        number = int(row['track_id'])
        color = track_color(number)
        color = (round(color[0] * 0.7), round(color[1] * 0.7), round(color[2] * 0.7))
        center = np.array([row['x'], row['y']], float)
        self._way(image, number, center, color)
        ellipse = outlines(center[None], row['covariance'][None, :2, :2], 33)[0]
        self._line(image, ellipse, color, 1)
        self._disc(image, center, max(row['diameter'] / 2, 0.05), color, cv2.FILLED)
        x, y = self._pixels(center[None])[0] / (1 << FRACTION)
        cv2.putText(
            image, str(number), (int(x) + 8, int(y) - 8), cv2.FONT_HERSHEY_SIMPLEX, 0.5, INK, 1,
            cv2.LINE_AA,
        )  # fmt: skip

    def _way(self, image: Image, number: int, place: Floats, color: BGR) -> None:
        """Draw where something has been."""
        way = self._ways.setdefault(number, [])
        way.append(place)
        self._line(image, np.array(way), color, 1)

    def _disc(
        self, image: Image, center: Iterable[float], radius: float, color: BGR, thickness: int
    ) -> None:
        x, y = self._pixels(np.array([[*center]], float))[0].tolist()
        size = round(radius * self._scale * (1 << FRACTION))
        cv2.circle(image, (x, y), size, color, thickness, cv2.LINE_AA, FRACTION)

    def _line(self, image: Image, points: Floats, color: BGR, thickness: int) -> None:
        pixels = [self._pixels(points)]
        cv2.polylines(image, pixels, False, color, thickness, cv2.LINE_AA, FRACTION)

    def _pixels(self, points: Floats) -> NDArray[np.int32]:
        """Points, (N, 2) [m], as OpenCV draws them."""
        flipped = (points + self._half * (1, -1)) * (1, -1)
        return np.asarray(flipped * self._scale * (1 << FRACTION)).round().astype(np.int32)
