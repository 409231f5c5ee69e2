"""Rendered sequences and their ground truth."""

from collections.abc import Collection
from collections.abc import Mapping
from collections.abc import Sequence
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.scenes.curves import Curve
from colortrack_ros.scenes.options import Options
from colortrack_ros.scenes.patches import draw_patch
from colortrack_ros.scenes.patches import paint_patch
from colortrack_ros.scenes.patches import Patch
from colortrack_ros.scenes.shapes import Ball
from colortrack_ros.scenes.shapes import Cover
from colortrack_ros.scenes.shapes import draw_ball
from colortrack_ros.scenes.shapes import draw_rectangle
from colortrack_ros.scenes.shapes import paint_disc
from colortrack_ros.scenes.shapes import paint_rectangle
from colortrack_ros.scenes.shapes import Prop
from colortrack_ros.scenes.silhouettes import draw_polygon
from colortrack_ros.scenes.silhouettes import paint_polygon
from colortrack_ros.scenes.silhouettes import placed
from colortrack_ros.scenes.silhouettes import Silhouette
from colortrack_ros.scenes.texture import Color
from colortrack_ros.scenes.texture import grain
from colortrack_ros.scenes.texture import uniform

TRUTH = np.dtype(
    [('id', 'u4'), ('u', 'f8'), ('v', 'f8'), ('radius', 'f4'), ('visible', 'f4'), ('color', 'u4')]
)
"""One object in one frame.

id: from 1; u, v: center of its disc in the middle of the exposure [px]; radius: [px]; visible: the
share of the disc that is inside the picture and not covered, 0 hidden, 1 fully visible; color:
index into the scene's colors.
"""

NOISE_SHIFTS = 1 << 18
"""Number of positions in the noise table at which a frame may start. Assumed: among 300 frames, two
start at the same one with a chance of 16 %."""

_SIDE = (np.arange(32) + 0.5) / 16 - 1
_DISC = np.array([(x, y) for y in _SIDE for x in _SIDE if x * x + y * y < 1]).T
"""Points spread evenly over the unit disc, (2, 812)."""


class Scene:
    """A sequence that gives frames and ground truth in any order.

    Frame k is exposed for the share `exposure` of a frame period around k / rate.

    :param name: of the scene.
    :param options: its size, rate, noise, seed and duration.
    :param background: (H, W, 3) BGR, behind everything.
    :param colors: names and R, G, B of the objects' colors.
    :param things: moving things, far to near.
    :param covers: still things in front of everything.
    :param light: factors on blue, green and red over time; None: 1.
    :param exposure: share of a frame period during which the shutter is open.
    """

    def __init__(
        self,
        name: str,
        options: Options,
        background: NDArray[np.uint8],
        colors: Mapping[str, Color],
        things: Sequence[Ball | Prop],
        covers: Sequence[Cover] = (),
        light: Curve | None = None,
        exposure: float = 0.5,
    ) -> None:
        self.name = name
        self.width, self.height, self.rate = options.width, options.height, options.rate
        self.colors = dict(colors)
        self._things, self._covers, self._background = things, covers, background
        self._cover_boxes = [_box_of(cover) for cover in covers]
        t = np.arange(options.count) / self.rate
        paths = [thing.path.value(t) for thing in things]
        self._center = np.stack([path[:, :2] for path in paths])
        self._half = np.stack([path[:, [2, -1]] for path in paths])
        self._smear = np.stack([thing.path.slope(t)[:, :2] for thing in things])
        self._smear *= exposure / self.rate
        # Things whose blur would cover the whole picture have just been moved elsewhere.
        self._smear[np.abs(self._smear).max(axis=2) > max(self.width, self.height)] = 0.0
        self._bgr = np.stack([self._brightness(thing, t) for thing in things])
        self._balls = np.array([i for i, x in enumerate(things) if isinstance(x, Ball)])
        self._first, self._last = self._stay()
        self._light = None if light is None else light.value(t)
        self._shift = (uniform((options.seed, 2), options.count) * NOISE_SHIFTS).astype(int)
        self._noise = (
            _noise(options.seed, background.size, options.noise) if options.noise > 0 else None
        )

    def __len__(self) -> int:
        return self._center.shape[1]

    def render(self, k: int) -> NDArray[np.uint8]:
        """Return frame k, (H, W, 3) BGR, a new array.

        :raises IndexError: when k is not in 0..len - 1.
        """
        k = self._checked(k)
        image: NDArray[np.uint8] = self._background.copy()
        for thing, center, smear, half, bgr in zip(
            self._things, self._center[:, k], self._smear[:, k], self._half[:, k], self._bgr[:, k],
            strict=True,
        ):  # fmt: skip
            if isinstance(thing, Patch):
                draw_patch(image, center, float(half[0]), self._turn(thing, k), thing)
            elif isinstance(thing, Silhouette):
                self._draw_silhouette(image, thing, center, float(half[0]), bgr, k)
            elif isinstance(thing, Ball) or thing.round:
                draw_ball(image, center, smear, float(half[0]), bgr)
            else:
                draw_rectangle(image, center, smear, half, bgr)
        for cover in self._covers:
            height, width = cover.picture.shape[:2]
            image[cover.row : cover.row + height, cover.column : cover.column + width] = (
                cover.picture
            )
        if self._light is not None:
            levels = np.arange(256)[:, None] * self._light[k]
            cv2.LUT(image, np.clip(levels, 0, 255).astype(np.uint8)[:, None, :], dst=image)
        if self._noise is not None:
            window = slice(self._shift[k], self._shift[k] + image.size)
            plus, minus = (part[window].reshape(image.shape) for part in self._noise)
            cv2.add(image, plus, dst=image)
            cv2.subtract(image, minus, dst=image)
        return image

    def truth(self, k: int) -> NDArray[np.void]:
        """Return (N,) of dtype TRUTH: the objects between their first entry and last exit.

        :raises IndexError: when k is not in 0..len - 1.
        """
        k = self._checked(k)
        present = np.flatnonzero((self._first <= k) & (k <= self._last))
        rows = np.zeros(len(present), TRUTH)
        names = list(self.colors)
        for row, number in zip(rows, present, strict=True):
            i = self._balls[number]
            row['id'] = number + 1
            row['u'], row['v'] = self._center[i, k]
            row['radius'] = self._half[i, k, 0]
            row['visible'] = self._visible(i, k)
            row['color'] = names.index(self._things[i].color)
        return rows

    def segments(self, k: int, unseen: Collection[int] = ()) -> NDArray[np.uint8]:
        """Return (H, W), a perfect color segmentation of frame k.

        Pixels of an object that nothing nearer covers have the object's color index plus 1, all
        others 0.

        :param unseen: IDs of objects to leave out.
        :raises IndexError: when k is not in 0..len - 1.
        """
        k = self._checked(k)
        mask = np.zeros((self.height, self.width), np.uint8)
        names, number = list(self.colors), 0
        for thing, center, half in zip(
            self._things, self._center[:, k], self._half[:, k], strict=True
        ):
            if isinstance(thing, Ball):
                number += 1
                if number in unseen:
                    continue
                value = names.index(thing.color) + 1
                if isinstance(thing, Patch):
                    paint_patch(mask, center, half[0], self._turn(thing, k), value)
                elif isinstance(thing, Silhouette):
                    corners = placed(thing.outline, center, float(half[0]), self._turn(thing, k))
                    paint_polygon(mask, corners, value)
                else:
                    paint_disc(mask, center, half[0], value)
            elif thing.round:
                paint_disc(mask, center, half[0], 0)
            else:
                paint_rectangle(mask, center, half, 0)
        for cover in self._covers:
            height, width = cover.picture.shape[:2]
            mask[cover.row : cover.row + height, cover.column : cover.column + width] = 0
        return mask

    def outlines(self, k: int) -> dict[int, NDArray[np.float64]]:
        """Return the corners (P, 2) [px] of each silhouette of truth(k), by its ID.

        :raises IndexError: when k is not in 0..len - 1.
        """
        corners = {}
        for number in (self.truth(k)['id'] - 1).tolist():
            i = self._balls[number]
            thing = self._things[i]
            if isinstance(thing, Silhouette):
                place = self._center[i, k], float(self._half[i, k, 0]), self._turn(thing, k)
                corners[number + 1] = placed(thing.outline, *place)
        return corners

    def _draw_silhouette(
        self,
        image: NDArray[np.uint8],
        thing: Silhouette,
        center: NDArray[np.float64],
        radius: float,
        bgr: NDArray[np.float32],
        k: int,
    ) -> None:
        turn = self._turn(thing, k)
        draw_polygon(image, placed(thing.outline, center, radius, turn), bgr)
        for mark, color in thing.marks:
            draw_polygon(image, placed(mark, center, radius, turn), color[::-1])

    def _checked(self, k: int) -> int:
        if not 0 <= k < len(self):
            raise IndexError(f'frame {k} of scene {self.name}: expected 0 to {len(self) - 1}')
        return k

    def _turn(self, thing: Patch | Silhouette, k: int) -> float:
        return float(thing.turn.value(np.array([k / self.rate]))[0, 0])

    def _brightness(self, thing: Ball | Prop, t: NDArray[np.float64]) -> NDArray[np.float32]:
        """Return (K, 3), the BGR color of a thing at each frame."""
        if isinstance(thing, Prop):
            return np.broadcast_to(np.array(thing.color[::-1], np.float32), (len(t), 3))
        bgr = np.array(self.colors[thing.color][::-1], float)
        return (thing.gain.value(t) * bgr).astype(np.float32)

    def _stay(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Return (balls,) the first and the last frame that contains each ball's disc."""
        center, radius = self._center[self._balls], self._half[self._balls, :, :1]
        reach = radius * _DISC.max() - 0.5
        inside = ((center + reach > -1) & (center - reach < [self.width, self.height])).all(axis=2)
        first, last = np.argmax(inside, axis=1), len(self) - 1 - np.argmax(inside[:, ::-1], axis=1)
        last[~inside.any(axis=1)] = -1
        for number, i in enumerate(self._balls):
            while first[number] <= last[number] and self._visible(i, first[number]) == 0:
                first[number] += 1
        return first, last

    def _visible(self, i: int, k: int) -> float:
        """Return the visible part of the disc of thing i."""
        gap = np.abs(self._center[i + 1 :, k] - self._center[i, k])
        near = (gap < self._half[i + 1 :, k] + self._half[i, k]).all(axis=1)
        if not near.any() and self._is_clear(i, k):
            return 1.0
        u, v = self._center[i, k][:, None] + self._half[i, k, 0] * _DISC
        seen = (u > -0.5) & (u < self.width - 0.5) & (v > -0.5) & (v < self.height - 0.5)
        for left, top, right, bottom in self._cover_boxes:
            seen &= (u < left) | (u > right) | (v < top) | (v > bottom)
        for j in (np.flatnonzero(near) + i + 1).tolist():
            x, y = u - self._center[j, k, 0], v - self._center[j, k, 1]
            half_width, half_height = self._half[j, k]
            other = self._things[j]
            if isinstance(other, Ball) or other.round:
                seen &= x * x + y * y > half_width * half_width
            else:
                seen &= (np.abs(x) > half_width) | (np.abs(y) > half_height)
        return float(np.mean(seen))

    def _is_clear(self, i: int, k: int) -> bool:
        """Whether the disc of thing i is wholly in the picture and touches no cover."""
        (u, v), reach = self._center[i, k].tolist(), float(self._half[i, k, 0])
        inside = reach - 0.5 < u < self.width - 0.5 - reach
        inside &= reach - 0.5 < v < self.height - 0.5 - reach
        return inside and all(
            u + reach < left or u - reach > right or v + reach < top or v - reach > bottom
            for left, top, right, bottom in self._cover_boxes
        )


def _box_of(cover: Cover) -> tuple[float, float, float, float]:
    """Left, top, right and bottom border of a cover [px]."""
    height, width = cover.picture.shape[:2]
    column, row = cover.column - 0.5, cover.row - 0.5
    return column, row, column + width, row + height


@lru_cache(maxsize=1)
def _noise(seed: int, size: int, sigma: float) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """Return what noise adds and what it subtracts, as fields larger than a picture."""
    pool = grain((seed, 1), size + NOISE_SHIFTS, sigma)
    return np.maximum(pool, 0).astype(np.uint8), np.maximum(-pool, 0).astype(np.uint8)
