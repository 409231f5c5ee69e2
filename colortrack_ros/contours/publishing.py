"""The published rows and outlines of targets."""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.contours.boxes import boxes
from colortrack_ros.contours.config import ContourConfig
from colortrack_ros.contours.deformation import deformation_variance
from colortrack_ros.contours.filters import Contours
from colortrack_ros.contours.foreground import Foreground
from colortrack_ros.contours.position import positions
from colortrack_ros.contours.spline import Spline
from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import TENTATIVE
from colortrack_ros.estimation.boxes import extents
from colortrack_ros.estimation.records import Records
from colortrack_ros.estimation.track_table import TrackTable

CORRELATED_MISFIT = 0.35
"""Share of the misfit between curve and outline that does not average out over the nodes. It
affects only the covariance: with half, once, and twice the value the normalized squared error, 2 if
right, is 0.89, 0.62, 0.28 on `silhouette` and 1.24, 1.06, 0.72 on `approach`
(``benchmark/contours.py --constants publishing.CORRELATED_MISFIT``)."""


GONE_SECONDS = 0.2
"""Time within which the score of a target falls to 0 where the foreground shows nothing [s]; half
of it bridges single frames. Of 259 boxes of coasting targets, six clips and their mirrored copies,
25 were at somebody's place, 24 of 244 after 0.05 s (benchmark/notes/contours.md)."""

LEAST_HEIGHT = 0.5
"""Least share of its usual height that a target shows: with less, most of it is out of sight. Mean
MOTA and precision of 18 clips are 0.460, 0.844; with 0.4, 0.6, and 0 of it 0.455, 0.836; 0.458,
0.848; 0.448, 0.829 (benchmark/notes/contours.md)."""

AREA_SHARE = 0.15
"""Least share of the usual area at its place that a thing has: heads, feet, and arms have less.
Mean MOTA and precision of 21 clips are 0.555, 0.905; with half, twice, and 0 of it 0.545, 0.890;
0.554, 0.922 (four clips lose 0.02 and more); 0.521, 0.873 (benchmark/notes/contours.md)."""

GONE_SIDES = 2.0
"""What has gone this far is no part of something that stays, in units of the side of a square of
the usual area. Half and twice the value: 0.552, 0.901 and 0.556, 0.906 (as above)."""


def published(
    tracks: TrackTable[Contours],
    outlines: Floats,
    spline: Spline,
    config: ContourConfig,
    now: int,
    foreground: Foreground,
) -> tuple[NDArray[np.void], Floats]:
    """Return rows and outlines of all but confirmed tracks that probably no longer exist.

    Targets that nobody has named are tentative while the background that they began before is
    learned: it still contains parts of them, and of others.

    :param outlines: (N, ...) of all tracks.
    :param now: stamp [ns].
    """
    score = _scores(tracks, outlines, config, now, foreground)
    shown = (score >= config.min_score) | (tracks.records['state'] == TENTATIVE)
    tracks, score, outlines = tracks.take(shown), score[shown], outlines[shown]
    contours = tracks.filters
    area = spline.area(contours.nodes)
    misfit = (CORRELATED_MISFIT * tracks.records['misfit']) ** 2 * np.maximum(area, 0.0)
    rows = tracks.rows(now, *positions(contours, spline, config.rate, misfit))
    rows['area'], rows['score'] = area, score
    young = ~tracks.records['told'] & (rows['age'] < config.learn_seconds)
    rows['state'][young & foreground.is_learning] = TENTATIVE
    size = np.ptp(outlines, axis=1)
    rows['covariance'][:, [0, 1], [0, 1]] += deformation_variance(tracks.records, size)
    rows['box_w'], rows['box_h'] = size.T
    rows['box_u'], rows['box_v'] = outlines.min(axis=1).T + 0.5
    return rows, outlines


def _scores(
    tracks: TrackTable[Contours],
    outlines: Floats,
    config: ContourConfig,
    now: int,
    foreground: Foreground,
) -> Floats:
    """Return the scores of targets, (N,): 0 of what shows a part of a thing, or nothing."""
    told, longest = tracks.records['told'], config.max_time_since_update
    fresh = tracks.freshness(now, longest)
    if foreground.is_seen and config.follow_foreground:
        brief = tracks.freshness(now, min(GONE_SECONDS, longest))
        fresh = np.where(told, fresh, brief)
    score = np.clip(tracks.records['edge_share'], 0, 1) * fresh
    score[_are_parts(tracks.records, outlines, foreground, now) & ~told] = 0.0
    is_seen = (tracks.records['updated'] == now) & (tracks.records['state'] != TENTATIVE)
    asked = np.flatnonzero(is_seen & (score > 0) & ~told)
    score[asked[foreground.is_vacant(outlines[asked])]] = 0.0
    return score


def _are_parts(records: Records, outlines: Floats, foreground: Foreground, now: int) -> Bools:
    """Return which targets, (N,), show a part of a thing: a foot in front of its body, what is left
    of somebody behind a sign, an arm of somebody who is in the background, or the side of a car
    whose middle hides a road that has not been seen yet.

    What has gone far from where it began is small, but a thing: a ball, or somebody among cars.

    :param now: stamp [ns].
    """
    own = boxes(outlines)
    part = records['piece'] | (own[:, 3] - own[:, 1] < LEAST_HEIGHT * records['high'])
    part |= foreground.goes_on(own, (now - records['born']) / NANOSECONDS)
    there = foreground.usual_area(own)
    gone = outlines.mean(axis=1) - records['first_at'].mean(axis=1)[:, ::-1]
    stays = np.hypot(*gone.T) < GONE_SIDES * np.sqrt(there)
    return np.asarray(part | stays & (extents(own) < AREA_SHARE * there))
