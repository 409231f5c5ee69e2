"""Fast starts: initiation of objects faster than any so far, from three detections on a line.

An object faster than believed possible is in no gate: each of its detections starts a track that
ends with the next. Three unassociated detections in successive frames, evenly spaced on a line,
indicate such an object where clutter hardly ever forms one (three-point initiation; Bar-Shalom and
Li 1995, 3.3).
"""

from typing import NamedTuple

import numpy as np

from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import TENTATIVE
from colortrack_ros.estimation.bank import Bank
from colortrack_ros.estimation.track_table import marked
from colortrack_ros.estimation.track_table import TrackTable
from colortrack_ros.tracking.adaptation import Adaptation
from colortrack_ros.tracking.measurements import Measurements
from colortrack_ros.tracking.measurements import median
from colortrack_ros.tracking.prediction import Prediction
from colortrack_ros.tracking.records import record_size
from colortrack_ros.tracking.rectangles import points_inside
from colortrack_ros.tracking.sizes import total

COINCIDENCES = 1e-4
"""Expected number of equally good lines in random clutter below which a line counts as an object.
Assumed: one false start in minutes."""

ENDED = np.iinfo(np.int32).max
"""Misses of a track that proved to be no object: more than any confirm_window."""

MOST_NEXT = 10
"""Second detections considered for each first one, to bound the time. Assumed."""


class ThreePoints(NamedTuple):
    """L lines of three detections.

    :param first, second: (L,) single-hit tracks on the first two detections.
    :param blob: (L,) the third.
    :param velocity: (L, 2) [px/s].
    :param aside: (L,) distance of the third from the line's extrapolation, noise included [px].
    :param by_chance: (L,) expected number of equally good lines in clutter.
    """

    first: Indices
    second: Indices
    blob: Indices
    velocity: Floats
    aside: Floats
    by_chance: Floats


def start_fast(
    tracks: TrackTable[Bank],
    prediction: Prediction,
    blobs: Measurements,
    new: Indices,
    learned: Adaptation,
) -> Indices:
    """Start tracks of fast objects from three detections; return the blobs left over.

    The speed of objects is learned from these tracks as from all others, not at once: now and then
    three false detections form a line.

    :param tracks: after their update.
    :param new: unassociated blobs.
    :return: those left over.
    """
    records = tracks.records
    if not len(new) or prediction.step.again:
        return new
    once = (records['state'] == TENTATIVE) & (records['hits'] == 1)
    first, second = ((once & (records['misses'] == count)).nonzero()[0] for count in (2, 1))
    if not len(first) or not len(second):
        return new
    density = max(learned.density, (len(new) - 1) / learned.area)  # clutter may just have set in
    lines = _find(prediction, blobs, first, second, new, density)
    if lines is None or not len(lines.blob):
        return new
    _start(tracks, lines, blobs, prediction)
    return new[~marked(lines.blob, len(blobs))[new]]


def _start(
    tracks: TrackTable[Bank], lines: ThreePoints, blobs: Measurements, prediction: Prediction
) -> None:
    """Continue the first track of each line with three measurements, and end the second."""
    records, track, z = tracks.records, lines.first, blobs.z[lines.blob]
    spread = np.zeros(tracks.filters.model.size)
    spread[2:] = lines.aside.max() / prediction.step.period
    started = tracks.filters.at_rest(z, blobs.R[lines.blob], spread)
    started.set_velocity(np.arange(len(z)), lines.velocity)
    tracks.filters.put(track, started)
    for name, value in (
        ('hits', 3), ('misses', 0), ('gaps', 0), ('updated', prediction.step.now), ('seen', z),
        ('extent', blobs.reach(lines.blob)), ('visible', 1 - lines.by_chance), ('hidden', 0.0),
    ):  # fmt: skip
        records[name][track] = value
    record_size(records, track, blobs.rows[lines.blob], z)
    records['misses'][lines.second] = ENDED


def _find(
    prediction: Prediction,
    blobs: Measurements,
    first: Indices,
    second: Indices,
    new: Indices,
    density: float,
) -> ThreePoints | None:
    """Return the lines, each detection in one at most, the least likely by chance first; or None.

    :param density: of unassociated detections [1/px^2].
    """
    records, now = prediction.records, prediction.step.now
    seen, since = records['seen'], (now - records['updated']) / NANOSECONDS
    noise = 6 * float(median(blobs.variance[new].ravel()))  # 1 + 4 + 1 variances
    rare = COINCIDENCES / (np.pi * density) ** 2
    reach = np.full((len(first), 2), np.sqrt(rare / noise))
    one, other = points_inside(seen[first], reach, seen[second], MOST_NEXT)
    one, other = first[one], second[other]
    step = seen[other] - seen[one]
    velocity = step / (since[one] - since[other])[:, None]
    ahead = seen[other] + velocity * since[other][:, None]
    way2 = (step * step).sum(axis=1)
    half = np.sqrt(rare / np.maximum(way2, noise))[:, None].repeat(2, axis=1)
    pair, third = points_inside(ahead, half, blobs.z[new], MOST_NEXT)
    if not len(pair):
        return None  # as nearly always
    one, other, blob = one[pair], other[pair], new[third]
    aside2 = np.square(blobs.z[blob] - ahead[pair]).sum(axis=1) + noise
    by_chance = (np.pi * density) ** 2 * way2[pair] * aside2
    good = (by_chance < COINCIDENCES) & (aside2 < way2[pair] / 4)
    good &= _are_alike(prediction, blobs, one, other, blob)
    order = good.nonzero()[0]
    order = order[by_chance[order].argsort(kind='stable')]
    for names in (one, other, blob):
        order = order[np.sort(np.unique(names[order], return_index=True)[1])]
    speed = (blobs.z[blob] - seen[one]) / since[one][:, None]
    of = (one, other, blob, speed, np.sqrt(aside2), by_chance)
    return ThreePoints(*(column[order] for column in of))


def _are_alike(
    prediction: Prediction, blobs: Measurements, one: Indices, other: Indices, blob: Indices
) -> Bools:
    """Return whether two single-hit tracks and a blob agree in color and in size."""
    color = prediction.records['color']
    alike = (color[one] == color[other]) & (color[one] == blobs.rows['color'][blob])
    if prediction.sized:
        size = total(prediction.records['extent'])
        for this in (size[other], blobs.size[blob]):
            alike &= ~prediction.sizes.difference(size[one], this).any(axis=1)
    return np.asarray(alike)
