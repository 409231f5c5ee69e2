"""Coasting targets that reappear from behind a cover as an unassigned area."""

import numpy as np

from colortrack_ros.contours.areas import Areas
from colortrack_ros.contours.boxes import boxes
from colortrack_ros.contours.filters import Contours
from colortrack_ros.contours.regions import shifts
from colortrack_ros.contours.spline import Spline
from colortrack_ros.data import COASTING
from colortrack_ros.data import CONFIRMED
from colortrack_ros.data import Indices
from colortrack_ros.estimation.track_table import TrackTable


def resume(tracks: TrackTable[Contours], spline: Spline, areas: Areas, stamp: int) -> Indices:
    """Move coasting targets to the unassigned areas as which they reappear.

    The two are each other's nearest, and, as from one frame to the next (De Bem 2007, 5.3), no
    farther apart than the size of the target: while it went behind the cover, its visible part held
    it back by less than that. The area may be only a part of the target, such as a foot; the target
    keeps its shape, and moves so that its nearer side fits.

    :param areas: K areas, unassigned in two frames.
    :param stamp: now [ns].
    :return: the remaining areas.
    """
    records, left = tracks.records, np.arange(len(areas))
    coasting = np.flatnonzero(records['state'] == COASTING)
    if not len(coasting) or not len(areas):
        return left
    nodes = tracks.filters.nodes[coasting]
    gap = np.linalg.norm(nodes.mean(axis=1)[:, None] - areas.center, axis=2)
    nearest = gap.argmin(axis=1)
    mutual = gap.argmin(axis=0)[nearest] == np.arange(len(coasting))
    mutual &= gap.min(axis=1) <= np.sqrt(spline.area(nodes))
    which, found = coasting[mutual], areas.take(nearest[mutual])
    own = boxes(spline.outline(nodes[mutual]))
    tracks.filters.nodes[which] += shifts(own, found.box, found.cut)[:, None]
    tracks.record_hits(which, stamp)
    records['state'][which], records['edge_share'][which] = CONFIRMED, 1.0
    records['agreed'][which] = stamp
    return np.setdiff1d(left, nearest[mutual])
