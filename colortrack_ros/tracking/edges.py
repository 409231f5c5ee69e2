"""Edges of covers: what a cover cuts is published with the error that its hidden part may make.

One side of its box is the cover's edge, and stands still, while the other one moves. The same is
seen of what turns, or shrinks, as fast as it moves. Where the center is depends on which of both it
is, so the ellipse holds both. What recedes keeps its aspect, which what is cut does not. It changes
nothing but what is published.
"""

import numpy as np

from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.tracking.centers import centers
from colortrack_ros.tracking.extents import most_growth
from colortrack_ros.tracking.hypotheses import Hypotheses
from colortrack_ros.tracking.measurements import both_axes
from colortrack_ros.tracking.measurements import either_axis
from colortrack_ros.tracking.measurements import Measurements
from colortrack_ros.tracking.prediction import LAST_FRAME
from colortrack_ros.tracking.prediction import Prediction
from colortrack_ros.tracking.sizes import both_ways
from colortrack_ros.tracking.sizes import TOLERANCE
from colortrack_ros.tracking.sizes import total

EDGE_STANDS = 1.5
"""Most that a side that stands still is away from where it was [px]: it is rounded to whole pixels,
and may come out as the next one."""

YOUNG = 4
"""Hits up to which the first size is not the one that something emerges with if it remains larger:
two for the velocity, and two more in case that the size does not remain the same at once."""

AS_LIKELY = 0.5
"""Mean square of the published center's error over that of its distance from the center if the side
that stands is a cover's edge, where either is as likely."""

TO_COME = 2.5
"""How much more of what emerges from behind a cover may come out than has come out so far. Assumed:
nothing is known of its size. The ellipse holds it if at least a fifth is visible."""


def doubt_covered(prediction: Prediction, blobs: Measurements, taken: Hypotheses) -> None:
    """Learn edges of covers from measured tracks, and add what they may hide to `systematic`.

    :param taken: K pairs whose sizes are not those learned, or that are edged.
    """
    moves = _learn_edges(prediction, blobs, taken.track, taken.blob)
    hidden = _hidden_variance(prediction, blobs, taken.track, taken.blob)
    hidden[moves] = 0.0
    moved = prediction.records['moved'][taken.track]
    prediction.records['edged'][taken.track] = (hidden > 0) | (moved[:, 0] != moved[:, 1])
    blobs.systematic[taken.blob] += hidden


def _learn_edges(
    prediction: Prediction, blobs: Measurements, track: Indices, blob: Indices
) -> Bools:
    """Learn which sides stand still, and the size that the object had before the others moved.

    Once both sides have moved, all of it is visible, and edges are sought anew; so they are of what
    is seen again, but with the size that it had before.

    :return: (K, 2) where both have moved.
    """
    records = prediction.records
    box, stood, whole = blobs.box[blob], records['stood'][track], records['whole'][track]
    moved = records['moved'][track] | (np.abs(box - stood) > EDGE_STANDS)
    lost = (prediction.unseen[track] > LAST_FRAME * prediction.step.period)[:, None]
    both = moved[:, 0] & moved[:, 1] & ~lost
    size, emerging = both_ways(prediction.size[track]), records['emerging'][track] & ~both
    known = (lost & ~records['edged'][track]) | (size[..., 0] > _expected(whole, size))
    known = both | (known & ~emerging)
    first = _is_first(prediction, blobs, track, blob)[:, None]
    whole = np.where((emerging & first)[..., None], both_ways(blobs.size[blob]), whole)
    records['whole'][track] = np.where(known[..., None], size, whole)
    records['emerging'][track] = emerging
    anew = (both | lost | first & emerging)[:, None]
    records['stood'][track], records['moved'][track] = np.where(anew, box, stood), moved & ~anew
    return np.asarray(both)


def _is_first(prediction: Prediction, blobs: Measurements, track: Indices, blob: Indices) -> Bools:
    """Whether only a part was detected before of what had come out from behind a cover, (K,).

    It was if the object suddenly is larger, or has been so since it was first detected, when its
    velocity was unknown, and remains the same.
    """
    records, size = prediction.records, blobs.size[blob]
    change = size - records['box_size'][track]
    same = both_axes(np.abs(change) <= EDGE_STANDS) & (records['hits'][track] < YOUNG)
    same &= either_axis(size - records['whole'][track, :, 0] > YOUNG * EDGE_STANDS)
    return np.asarray(same | either_axis(change > most_growth(prediction, track)))


def _expected(whole: Floats, size: Floats) -> Floats:
    """Sizes of whole objects, (K, 2), as near or far as the size on the other axis says.

    :param whole, size: (K, 2, 2) once and now, see both_ways() [px].
    """
    once, now = whole[..., 1], size[..., 1]
    now = now + (once - now).clip(-EDGE_STANDS, EDGE_STANDS)
    return np.asarray(whole[..., 0] * now / np.maximum(once, 1.0))


def _hidden_variance(
    prediction: Prediction, blobs: Measurements, track: Indices, blob: Indices
) -> Floats:
    """Variance of centers due to what may be hidden, (K, 2), by axis [px^2]."""
    records, size = prediction.records, blobs.size[blob]
    once, emerging = records['whole'][track], records['emerging'][track]
    whole = _expected(once, both_ways(size))
    # what has come out of what emerges, or what is missing of the rest
    part = np.where(emerging, size - whole, np.minimum(whole, once[..., 0]) - size)
    low, high = records['moved'][track].swapaxes(0, 1)
    cut = part > np.where(low | high, TOLERANCE, prediction.slack[track])
    cut &= ~emerging | (low | high) & (part > size / (1.0 + TO_COME))
    extent, whole = records['extent'][track], size + np.where(emerging, TO_COME, 1.0) * part
    extent *= (whole / np.maximum(total(extent), 1.0))[:, None]
    away = centers(blobs.z[blob], blobs.box[blob], extent)
    away -= prediction.bank.estimate()[0][track, :2]
    away *= away
    nearer = np.minimum(away[0], away[2])  # if neither side has moved
    return AS_LIKELY * cut * np.where(high, away[2], np.where(low, away[0], nearer))
