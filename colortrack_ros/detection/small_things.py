"""Small things: what the erosion leaves nothing of, while nothing larger of its color is seen.

Noise and texture have specks of a color, too. A speck is a thing if it is compact, one of few, and
comes back close to where it was, picture after picture (track before detect).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.columns import Columns
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.detection.blobs import BlobTable
from colortrack_ros.detection.blobs import clear
from colortrack_ros.detection.blobs import find_blobs
from colortrack_ros.detection.growth import FEWEST_PIXELS
from colortrack_ros.detection.label_image import LabelImage
from colortrack_ros.detection.shape import aspect
from colortrack_ros.detection.usual_areas import USUAL_SECONDS

FIRST_SECONDS = 1.0
"""Time without anything of a color from the start before specks are looked at, and for which one
has to come back [s]. Assumed: together ABSENT_SECONDS, after which it is told that there is
none."""

FIRST_LOOK = round((FIRST_SECONDS - USUAL_SECONDS) * NANOSECONDS)
"""When something was seen of a color that is to be looked at in FIRST_SECONDS, from now [ns]."""

SMALLEST, LARGEST_SPECK = 5, 3 * FEWEST_PIXELS
"""Areas of specks [px]: a disc of 2.5 px; more than what an erosion leaves FEWEST_PIXELS of."""

SPECK_FILLED, SPECK_ASPECT = 0.75, 0.4
"""Least area over that of the ellipse with the same moments, and ratio of its axes. Assumed: discs
of 5 px have 0.9 and 0.6 at their worst places on the grid, chains of noise less."""

MOST_SPECKS = 6
"""Largest number of specks in a picture that are things. Assumed; more are a texture or noise."""

TEXTURE_SPECKS = 10 * MOST_SPECKS
"""Number of specks from which on the next FIRST_SECONDS are not looked at. Chosen: noise has a few
more than MOST_SPECKS now and then, of ground that runs into the color there are thousands, of which
each look at 1920 x 1080 costs as much as all else twice."""

SPECK_CHANCE = 0.02
"""Largest chance that another speck lies where one is expected to come back. HITS in a row by
chance are then a matter of 1e-12 or less; noise that is not even is what HITS is for."""

SPECK_WAY, SPECK_SPEEDUP = 4.0, 2.0
"""Way that a speck may go from picture to picture: this [px], and so many times its last way.
Assumed: a pixel of noise either way, and any maneuver but a bounce."""

HITS, MOST_HITS = 8, 16
"""Pictures in which a speck came back, less those in which it did not, to be a thing, and their
largest number: after half as long out of sight it is no longer one."""


@dataclass
class Specks(Columns):
    """Specks that were seen.

    :param place: (N, 2) u, v when last seen [px].
    :param way: (N,) from the picture before [px]; infinite if seen once.
    :param hits: (N,) pictures with it less those without.
    :param since: (N,) first stamp [ns].
    :param is_thing: (N,) whether it has come back often enough.
    """

    place: NDArray[np.float64]
    way: NDArray[np.float64]
    hits: NDArray[np.int64]
    since: NDArray[np.int64]
    is_thing: NDArray[np.bool_]

    @classmethod
    def of(cls, place: NDArray[np.float64], stamp: int) -> 'Specks':
        """Specks seen for the first time."""
        count = len(place)
        once, since = np.ones(count, np.int64), np.full(count, stamp, np.int64)
        return cls(place, np.full(count, np.inf), once, since, np.zeros(count, bool))

    def update(self, place: NDArray[np.float64], reach: float, stamp: int) -> NDArray[np.bool_]:
        """Take the specks of a picture; return which, (M,), are things.

        :param place: (M, 2) u, v [px].
        :param reach: beyond which others are as likely [px].
        """
        away = np.linalg.norm(self.place[:, None] - place, axis=2)
        most = np.minimum(reach, SPECK_WAY + SPECK_SPEEDUP * self.way)[:, None]
        nearest = (away.min(axis, keepdims=True, initial=np.inf) for axis in (0, 1))
        is_nearest = np.logical_and(*(away == least for least in nearest))
        old, new = (is_nearest & (away < most)).nonzero()
        self.hits -= 1
        self.hits[old] = np.minimum(self.hits[old] + 2, MOST_HITS)
        self.place[old], self.way[old] = place[new], away[old, new]
        is_old = stamp - self.since >= FIRST_SECONDS * NANOSECONDS
        self.is_thing |= is_old & (self.hits >= HITS)
        things = np.zeros(len(place), bool)
        things[new] = self.is_thing[old]
        self.keep(self.hits > 0)
        self.extend(Specks.of(np.delete(place, new, axis=0), stamp))
        return things


class SmallThings:
    """Finds things that are too small for the erosion, of colors of which nothing else is seen.

    :param colors: indices of the colors to find them of.
    :param count: number of all colors.
    :param erosion: size of its square [px].

    others: of which it finds none, as small ones are blobs like all others, or are not wanted.
    """

    def __init__(self, colors: list[int], count: int, erosion: int) -> None:
        self._colors, self._count = colors, count
        (self._largest,) = worn(np.array([LARGEST_SPECK]), erosion)
        self.others = [k for k in range(count) if k not in colors]
        self._specks = dict[int, Specks]()
        self._seen = np.zeros(0, np.int64)
        self._last = 0

    def due(self, stamp: int) -> list[int]:
        """The colors of which nothing has been seen for so long that specks are looked at."""
        if not self._seen.size or stamp < self._last:
            self._specks = {k: Specks.of(np.zeros((0, 2)), 0) for k in self._colors}
            self._seen = np.full(self._count, stamp + FIRST_LOOK, np.int64)
        self._last = stamp
        since = (stamp - self._seen) / NANOSECONDS
        return [k for k in self._colors if since[k] >= USUAL_SECONDS]

    def see(self, blobs: BlobTable, stamp: int) -> None:
        """Take note of the blobs that were found as usual, and are larger than small things.

        Of one of 7 px the erosion leaves enough now and then.
        """
        if len(blobs.label):
            label = blobs.label[blobs.area > self._largest]
            self._seen[label.astype(np.intp) - 1] = stamp

    def find(
        self, image: LabelImage, due: list[int], missing: list[int], stamp: int
    ) -> BlobTable | None:
        """The small things of colors that are due, if any; None if there are none.

        :param image: the labels before the erosion.
        :param missing: colors of which whatever is no small thing is cleared, in place.
        """
        if not due:
            return None
        blobs = find_blobs(image, 1)
        is_thing = np.zeros(len(blobs.label), bool)
        for k in due:
            (mine,) = (blobs.label == k + 1).nonzero()
            reach = np.sqrt(SPECK_CHANCE * image.pixels.size / np.pi / max(len(mine), 1))
            if len(mine) > TEXTURE_SPECKS:
                self._seen[k] = stamp + FIRST_LOOK
            specks = mine[_is_compact(blobs)[mine]] if len(mine) <= MOST_SPECKS else mine[:0]
            is_thing[specks] = self._specks[k].update(blobs.mean[specks], reach, stamp)
        rest = np.isin(blobs.label, np.array(missing, int) + 1) & ~is_thing
        clear(image, blobs.take(rest).runs)
        return blobs.take(is_thing) if is_thing.any() else None


def among(blobs: BlobTable, small: BlobTable | None) -> NDArray[np.bool_]:
    """(N,) which blobs are small things."""
    if small is None:
        return np.zeros(len(blobs.label), bool)
    return np.isin(blobs.runs.start[blobs.first_run], small.runs.start[small.first_run])


def worn(area: NDArray[np.int64], size: int) -> NDArray[np.float64]:
    """(N,) what an erosion by a square leaves of discs, at least a pixel [px].

    :param size: of the square [px]; each pixel of it takes 4 / pi px off the diameter.
    """
    left = np.sqrt(4 * area / np.pi) - 4 / np.pi * (size - 1)
    return np.maximum(np.pi / 4 * np.maximum(left, 0) ** 2, 1.0)


def _is_compact(blobs: BlobTable) -> NDArray[np.bool_]:
    """(N,) whether a blob has the size and the shape of a small thing."""
    minor, major = blobs.axes
    filled = blobs.area >= SPECK_FILLED * 4 * np.pi * np.sqrt(minor * major)
    size = (blobs.area >= SMALLEST) & (blobs.area <= LARGEST_SPECK)
    return np.asarray(size & filled & (aspect(blobs) >= SPECK_ASPECT))
