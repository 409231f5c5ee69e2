"""Flicker: which tracks are clutter that comes and goes in its place, as gleams and lamps do."""

import numpy as np

from colortrack_ros.data import Bools
from colortrack_ros.data import COASTING
from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.estimation.records import Records
from colortrack_ros.tracking.detection_rate import LEAST_RATE

TELLING_HITS = 10
"""Hits from which what becomes of a track tells of objects: of clutter few tracks last as long, and
none of them returns. As crossings.ESTABLISHED."""

OFTEN = 0.5
"""Share of the frames from which a track that is found in more is surely an object."""

OBJECT_ODDS = 4.0
"""Odds that a confirmed track is an object rather than clutter. Assumed; with 1 and 9, mean IDF1 of
five sets of detections of networks changes by 0.007 at most."""

BLOB_EXPONENT = 4.0
"""The exponent a of flickering() for blobs: those that shade or others cover in part are missed
more often than the rest, and are no clutter. What is found 0.4 times as often as the others then is
as likely clutter. Assumed."""

PRIOR_AT_REST = 2.0
"""The prior count m of objects at rest, and of others that move, in _at_rest(). Assumed: with 1, a
point that lies where three roll, and is found half as often, is no longer shown."""

GAPS_SELDOM = 3
"""Detections of a whole object for each gap from which on it is doubted when it is measured, too.
Assumed; with 2 and 4, mean IDF1 of four sets of detections of networks changes by 0.009 at most."""

COUNTED_MISSES = 9.0
"""Frames after which an object that is still missed is hidden, and being missed tells no more about
how often it is detected. Clutter that is found in a quarter of the frames is missed for longer once
in thirteen times."""

JUST_LOST = 1.5
"""Frames within which an object was measured in the last one."""

MISSES_COUNT = (('misses', COUNTED_MISSES + 0.5), ('gaps', JUST_LOST))
"""Fields in which misses are counted, and frames since the last detection for which they are."""


def take_back_misses(
    records: Records, track: Indices | slice, unmeasured: Floats, period: float
) -> None:
    """Do not count that tracks were missed in this frame.

    :param records: (N,) of all tracks, see records.FIELDS; track: which.
    :param unmeasured: (N,) time since each was measured [s].
    :param period: since the last frame [s].
    """
    for name, frames in MISSES_COUNT:
        records[name][track] -= unmeasured[track] < frames * period


class Flicker:
    """Doubts tracks that are found less often than others, and stay where the others move."""

    def __init__(self) -> None:
        self._best = LEAST_RATE

    def chance(
        self, records: Records, track: Indices, gap: Floats, detected: float, *, whole: bool
    ) -> Floats:
        """Probability, (K,), that confirmed tracks, (K,), are such clutter.

        :param records: (N,) of all tracks, see records.FIELDS.
        :param gap: (K,) frames for which each has been missed by now; blobs may be hidden.
        :param detected: probability of detecting a visible object.
        :param whole: whether the detector finds whole objects.
        """
        hits, misses = _frames(records, whole=whole)
        rate = hits / (hits + misses + 1) * (records['hits'] >= TELLING_HITS)
        self._best = max(self._best, float(rate.max()))
        # A detector that has found nothing more often may miss much; but what coasts has to be
        # where it is expected, too.
        usual = np.where(gap > 0, detected, min(detected, self._best))
        odds = OBJECT_ODDS * _at_rest(records, rate > OFTEN, track)
        hits, misses = hits[track], misses[track]
        if not whole:
            misses = np.maximum(misses - np.minimum(np.rint(gap), COUNTED_MISSES), 0.0)
        return flickering(hits, misses, usual, odds, whole=whole)


def are_seldom(records: Records, *, whole: bool) -> Bools:
    """Which tracks, (N,), are found so seldom that they are doubted when they are measured, too."""
    if whole:
        return np.asarray(records['gaps'] * GAPS_SELDOM >= records['hits'])
    return np.asarray(records['misses'] > records['hits'])


def _frames(records: Records, *, whole: bool) -> tuple[Floats, Floats]:
    """Frames in which tracks were measured and were not, (N,) each, that tell how often they are.

    Of whole objects those right after a detection: what is covered is missed on end, however well
    it is found before and after, and what flickers is missed again and again.
    """
    hits, misses = (records[name].astype(float) for name in ('hits', 'gaps' if whole else 'misses'))
    if whole:
        hits -= misses + (records['state'] != COASTING)  # nothing came after the last one yet
    return np.maximum(hits, 0.0), misses


def _at_rest(records: Records, often: Bools, track: Indices) -> Floats:
    """Factors, (K,), on the odds that tracks are objects: whether objects are as slow.

    Of n objects, k are as slow as such a track. By the rule of succession, another is with a
    probability of (k + m) / (n + 2 m): 1/2 where nothing is known, which then says nothing. What is
    faster than half of them may be clutter all the same, where the camera moves.

    :param often: (N,) tracks that are surely objects.
    """
    way = records['seen'] - records['origin']
    speed = np.hypot(way[:, 0], way[:, 1]) / np.maximum(records['updated'] - records['born'], 1)
    slower = np.sort(speed[often]).searchsorted(speed[track], 'right') - often[track]
    others = np.count_nonzero(often) - often[track]
    return np.asarray(np.minimum((slower + PRIOR_AT_REST) / (others / 2 + PRIOR_AT_REST), 1.0))


def flickering(
    hits: Floats,
    misses: Floats,
    detected: Floats | float,
    odds: Floats | float = OBJECT_ODDS,
    *,
    whole: bool,
) -> Floats:
    """Probability, (K,), that confirmed tracks are clutter that flickers in its place.

    The probabilities p with which objects are detected have the density a p^(a - 1), whose mean is
    a / (a + 1); those of such clutter 2 (1 - p): mostly it is not there. Of a track, p is estimated
    by Laplace's rule of succession; of blobs, relative to that of the others.

    :param hits, misses: (K,) frames in which each was measured, and was not.
    :param detected: mean probability of detecting a visible object, or (K,) of them, below 1.
    :param odds: that each is an object, (K,) or of all, before its hits and misses are known.
    :param whole: whether the detector finds whole objects.
    """
    p = (hits + 1) / (hits + misses + 2)
    a: Floats | float = BLOB_EXPONENT
    if whole:
        a = detected / (1 - detected)
    else:
        p = np.minimum(p / detected, 1.0)
    clutter = 2 - 2 * p
    return np.asarray(clutter / (clutter + odds * a * p ** (a - 1)))
