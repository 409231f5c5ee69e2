"""Rendering by ray casting: one ray per pixel, and the nearest thing on it."""

from dataclasses import dataclass
from itertools import product

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Floats
from colortrack_ros.simulation.config import Thing
from colortrack_ros.simulation.rooms import Room
from colortrack_ros.world.camera import CameraModel
from colortrack_ros.world.poses import Pose

Rays = NDArray[np.float32]

TILE = 0.5
"""Side of the floor tiles [m]. Assumed, for the look of it."""

SURFACES = np.zeros((1, 256, 3), np.uint8)
SURFACES[0, :7] = [
    (96, 92, 88), (116, 112, 106), (196, 200, 204), (184, 188, 192), (206, 208, 210),
    (176, 180, 184), (226, 226, 224),
]  # fmt: skip
"""Blue, green, red of dark and light tiles, of the walls at x, -x, y, -y, and of the ceiling."""

TILES, WALLS_X, WALLS_Y, CEILING = map(np.uint8, (0, 2, 4, 6))
"""Index of the first row of each in SURFACES."""

LAMP = np.array([0.3, -0.2, 0.93], np.float32)
"""Direction to the lamp: above, and a little to the side. Chosen."""

SHADE = 0.65
"""Brightness where the light does not reach, since lamps and walls light a room from all sides.
Assumed, for the look of it; with 1 nothing has a dark side."""

NEAREST = 0.02
"""Least depth [m]; what is nearer is not drawn. Assumed: half or twice as much changes only
pictures of things that touch the lens."""

CORNERS = np.array(list(product((-1, 1), repeat=3)))
"""Corners of a cube around 0."""


@dataclass(frozen=True)
class Sight:
    """A picture.

    :ivar image: (H, W, 3) bgr8.
    :ivar depth: (H, W) along the optical axis [m], NaN where the lens shows nothing.
    :ivar visible: (N,) share of each thing that is inside the picture and not hidden.
    """

    image: NDArray[np.uint8]
    depth: NDArray[np.float32]
    visible: Floats


class Renderer:
    """A camera in a room.

    :param noise: standard deviation of the noise of each pixel, of 255.
    """

    def __init__(
        self, camera: CameraModel, room: Room, noise: float, rng: np.random.Generator
    ) -> None:
        self._camera, self._room, self._rng = camera, room, rng
        shape = camera.height, camera.width
        v, u = np.mgrid[: shape[0], : shape[1]]
        rays = camera.rays(np.stack([u.ravel(), v.ravel()], axis=1).astype(float))
        # Rays have depth 1, so that the ray parameter of a hit is its depth.
        flat = rays[:, :2] / np.where(rays[:, 2:] > 0, rays[:, 2:], np.nan)
        self._rays = np.concatenate([flat.T, np.ones((1, len(flat)))]).astype(np.float32)
        # The range of X/Z that each column shows, and that of Y/Z for each row.
        planes = flat.T.reshape(2, *shape)
        self._first = [np.nanmin(plane, axis=axis) for axis, plane in enumerate(planes)]
        self._last = [np.nanmax(plane, axis=axis) for axis, plane in enumerate(planes)]
        # Each picture takes its noise from a random part of this one.
        large = rng.normal(0.0, noise, (2 * shape[0], 2 * shape[1], 3))
        self._noise = large.round().astype(np.int16) if noise > 0 else None

    def render(self, optical: Pose, things: list[Thing], centers: Floats) -> Sight:
        """Render the picture.

        :param optical: pose of the optical frame in the room.
        :param things: N things; the pillars of the room are added.
        :param centers: (N, 3) centers of the things [m].
        """
        shape = self._camera.height, self._camera.width
        rays = (optical.R.astype(np.float32) @ self._rays).reshape(3, *shape)
        depth, surface = self._walls(rays, optical.t.astype(np.float32))
        image = np.asarray(cv2.LUT(cv2.merge([surface] * 3), SURFACES), np.uint8)
        pillars = self._room.pillars
        stands = [[*p.config.path, p.config.height / 2] for p in pillars]
        centers = np.concatenate([centers, np.reshape(stands, (-1, 3))])
        nearest = np.full(shape, -1, np.int16)
        for k, (thing, center) in enumerate(zip((*things, *pillars), centers, strict=True)):
            part = self._part(optical, thing, center)
            if part is None:
                continue
            within = (slice(None), *part)
            t, light = _body(rays[within], optical.t - center, thing)
            seen = t < depth[part]
            bright = SHADE + (1 - SHADE) * light[seen]
            image[part][seen] = np.multiply.outer(bright, thing.config.rgb[::-1]).round()
            depth[part][seen], nearest[part][seen] = t[seen], k
        counts = np.bincount(nearest[nearest >= 0], minlength=len(centers))[: len(things)]
        visible = np.minimum(counts / np.maximum(self._sizes(optical, things, centers), 1.0), 1.0)
        return Sight(self._noisy(image), depth, visible)

    def _walls(self, rays: Rays, eye: NDArray[np.float32]) -> tuple[Rays, NDArray[np.uint8]]:
        """Return depth and surface, (H, W) each, of floor, walls, and ceiling."""
        x, y, z = rays
        half_x, half_y = (np.float32(half) for half in self._room.half_size)
        with np.errstate(divide='ignore', invalid='ignore'):
            to_x = (np.copysign(half_x, x) - eye[0]) / x
            to_y = (np.copysign(half_y, y) - eye[1]) / y
            to_z = np.where(z > 0, np.float32(self._room.height) - eye[2], -eye[2]) / z
            aside = np.fmin(to_x, to_y)
            depth = np.fmin(aside, to_z)
        surface = np.where(to_x <= to_y, WALLS_X + (x < 0), WALLS_Y + (y < 0))
        level = to_z <= aside
        np.putmask(surface, level & (z > 0), CEILING)
        floor = np.flatnonzero(level & (z < 0))
        t = depth.take(floor)
        tiles = [np.floor((eye[axis] + t * rays[axis].take(floor)) / TILE) for axis in range(2)]
        surface.put(floor, TILES + ((tiles[0] + tiles[1]).astype(np.int32) & 1))
        return depth, surface

    def _part(self, optical: Pose, thing: Thing, center: Floats) -> tuple[slice, slice] | None:
        """Return the part of the picture that contains a thing, or None if there is none."""
        corners = center + CORNERS * _half_box(thing)
        points = optical.inverse().apply(corners)
        low, high = points.min(axis=0), points.max(axis=0)
        if high[2] < NEAREST:
            return None
        if low[2] > NEAREST:
            flat = points[:, :2] / points[:, 2:]
            first, last = flat.min(axis=0), flat.max(axis=0)
        else:  # it reaches behind the camera, and so beyond the picture on that side
            first = np.where(low[:2] > 0, low[:2] / high[2], -np.inf)
            last = np.where(high[:2] < 0, high[:2] / high[2], np.inf)
        columns, rows = (
            ((self._last[axis] >= first[axis]) & (self._first[axis] <= last[axis])).nonzero()[0]
            for axis in range(2)
        )
        if not len(columns) or not len(rows):
            return None
        return slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)

    def _sizes(self, optical: Pose, things: list[Thing], centers: Floats) -> Floats:
        """Return how many pixels, (N,), each thing would cover if nothing hid it."""
        sizes = np.zeros(len(things))
        for k, thing in enumerate(things):
            away = float(np.linalg.norm(centers[k] - optical.t))
            half = _half_box(thing)
            area = np.pi * half[0] ** 2 if thing.config.shape == 'ball' else 4 * half[0] * half[2]
            sizes[k] = area * (self._camera.K[0, 0] / max(away, NEAREST)) ** 2
        return sizes

    def _noisy(self, image: NDArray[np.uint8]) -> NDArray[np.uint8]:
        if self._noise is None:
            return image
        height, width = image.shape[:2]
        top, left = self._rng.integers(0, (height, width))
        noise = self._noise[top : top + height, left : left + width]
        return np.asarray(cv2.add(image, noise, dtype=cv2.CV_8U), np.uint8)


def _half_box(thing: Thing) -> Floats:
    """Return half of the size of a thing, (3,) [m]."""
    config = thing.config
    radius = config.diameter / 2
    return np.array([radius, radius, radius if config.shape == 'ball' else config.height / 2])


def _body(rays: Rays, eye: Floats, thing: Thing) -> tuple[Rays, Rays]:
    """Return the depth, (h, w), where rays hit a thing, inf if they miss, and its brightness, 0..1.

    :param rays: (3, h, w) in the room.
    :param eye: (3,) the camera relative to the thing's center [m].
    """
    x, y, z = rays
    o = eye.astype(np.float32)
    radius = np.float32(thing.config.diameter / 2)
    is_ball = thing.config.shape == 'ball'
    # |o + t d| = radius in x and y, for a ball also in z
    a, b = x * x + y * y, x * o[0] + y * o[1]
    c = o[0] * o[0] + o[1] * o[1] - radius * radius
    if is_ball:
        a, b, c = a + z * z, b + z * o[2], c + o[2] * o[2]
    with np.errstate(invalid='ignore', divide='ignore'):
        t = (-b - np.sqrt(b * b - a * c)) / a
        up = (o[2] + t * z) / radius if is_ball else np.float32(0)
        light = (LAMP[0] * (o[0] + t * x) + LAMP[1] * (o[1] + t * y)) / radius + LAMP[2] * up
        if not is_ball:
            half = np.float32(thing.config.height / 2)
            side = np.abs(o[2] + t * z) < half
            # From above, a ray may enter through the lid.
            top = (half - o[2]) / z
            lid = np.square(o[0] + top * x) + np.square(o[1] + top * y) < radius * radius
            lid &= (o[2] > half) & ~side
            t = np.where(side, t, np.where(lid, top, np.nan))
            light[lid] = LAMP[2]
        return np.where(t > NEAREST, t, np.inf), np.clip(light, 0, 1)
