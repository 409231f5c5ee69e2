"""What is recorded of a target, and whether it has moved."""

import numpy as np

from colortrack_ros.contours.config import ContourConfig
from colortrack_ros.contours.filters import Bools
from colortrack_ros.contours.filters import Contours
from colortrack_ros.contours.filters import Floats
from colortrack_ros.contours.spline import Spline
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import TENTATIVE
from colortrack_ros.estimation.records import Records
from colortrack_ros.estimation.track_table import TrackTable

CONTOUR_FIELDS = [
    ('edge_share', 'f4'), ('placed_area', 'f8'), ('misfit', 'f8'), ('by_area', '?'),
    ('inner', '?'), ('agreed', 'i8'), ('placed', 'i8'), ('moved', '?'), ('from', 'i8'),
    ('from_u', 'f8'), ('from_v', 'f8'), ('told', '?'), ('seen_w', 'f8'), ('seen_h', 'f8'),
    ('single', '?'), ('alone', 'f8'), ('proven', '?'),
]  # fmt: skip
"""What is recorded of a target besides what is of every track.

edge_share: share of its lines that had an edge when it was last measured, 1 by its foreground;
placed_area: when its nodes were placed [px]; misfit: what the curve missed of its outline then
[root of that area]; by_area: whether its nodes are those of its foreground; inner: whether it
began where another one was; agreed: when it was last as large as its foreground, later by as long
as it was unseen since [ns]; placed: when its nodes were last tried to be placed [ns]; moved:
whether it has ever moved by much; from, from_u, from_v: since when and where its motion is counted
[ns, px]; told: whether somebody named it: it may stand still; seen_w, seen_h: the size
that its foreground had until recently, 0 where it had none [px];
single: whether it was an area of its own for ALONE_SECONDS; alone: for how long it was [s];
proven: whether it has moved, and was there for long for its size.
"""

RENEWAL_SCALE = 1.6
"""A contour whose area has become so many times larger or smaller gets new nodes. At twice the
value the mean squared error on `silhouette` is 0.032 instead of 0.037 px^2, on `approach` 0.016
instead of 0.025; at half of it, always renewing, 0.042 and 0.033 (``benchmark/contours.py
--constants records.RENEWAL_SCALE``)."""

MOTION_SECONDS = 3.0
"""Time within which a new target has to move by min_motion: then its motion is counted anew.
Assumed: half and twice the value change nothing on TUD Campus, 0.01 of precision on PETS S3.MF1
(``benchmark/real_contours.py FOLDER --constants records.MOTION_SECONDS``)."""

PROOF_SECONDS = 1.0
"""For so long a new target as small as min_area is tentative [s], one of twice its width and height
for half of that: heads, legs, leaves, and what the background has of walkers are small, and come
and go. The frame before it began counts. MOTA, precision of TUD Campus with half, once and twice
the value, that frame not counted: 0.13, 0.63; 0.18, 0.73; 0.24, 0.92; of `pets` 0.59, 0.88; 0.59,
0.88; 0.57, 0.89 (``benchmark/real_contours.py FOLDER --constants records.PROOF_SECONDS``)."""

CROSSING_SHARE = 0.25
"""What is so fast that this would be more than a quarter of its way across the picture is proven by
then. Assumed; half and twice the value change nothing beyond 0.01 of IDF1 on TUD Campus and S3.MF1,
half of it nothing on `pets` either (as above)."""


def begin(tracks: TrackTable[Contours], contours: Contours, spline: Spline, stamp: int) -> Records:
    """Begin targets; return their records, a view.

    :param contours: of the new targets.
    :param stamp: now [ns].
    """
    records = tracks.initiate(contours, stamp)
    records['edge_share'] = 1.0
    records['agreed'] = records['from'] = stamp
    records['seen_w'], records['seen_h'] = np.ptp(contours.nodes, axis=1).T
    records['placed_area'] = np.maximum(spline.area(contours.nodes), 1.0)
    records['from_u'], records['from_v'] = contours.nodes.mean(axis=1).T
    return records


def hold_unproven(
    records: Records,
    nodes: Floats,
    area: Floats,
    speed: Floats,
    config: ContourConfig,
    size: tuple[int, int],
    stamp: int,
) -> Bools:
    """Keep those tentative that have not moved yet, or were not there for long for their size.

    A size is the root mean square of width and height: a fluttering tape has next to no area.

    :param records: (N,) with CONTOUR_FIELDS; their states are set.
    :param nodes: (N, n, 2) [px].
    :param area: (N,) [px^2].
    :param speed: (N,) as the filters have it [px/s].
    :param size: height and width of the picture [px].
    :param stamp: now [ns].
    :return: which those are, (N,).
    """
    place = nodes.mean(axis=1)
    way = np.hypot(place[:, 0] - records['from_u'], place[:, 1] - records['from_v'])
    least = config.min_motion * np.hypot(*np.ptp(nodes, axis=1).T) / np.sqrt(2)
    records['moved'] |= (way >= least) & (speed * MOTION_SECONDS >= least)
    seconds = PROOF_SECONDS * np.sqrt(config.min_area / np.maximum(area, 1.0))
    seconds = np.minimum(seconds, CROSSING_SHARE * max(size) / np.maximum(speed, 1e-9))
    hits = np.maximum(records['hits'], 2)
    seen = (stamp - records['born']) / NANOSECONDS * hits / (hits - 1)
    lasts = (seen >= seconds) | records['told']
    records['proven'] |= records['moved'] & (lasts | (config.min_motion == 0))
    anew = stamp - records['from'] > round(MOTION_SECONDS * NANOSECONDS)
    records['from'][anew] = stamp
    records['from_u'][anew], records['from_v'][anew] = place[anew].T
    still = ~records['proven']
    records['state'][still] = TENTATIVE
    return np.asarray(still)


def outgrown(records: Records, area: Floats) -> Bools:
    """Which targets have changed their size by much, (N,).

    :param records: (N,) with CONTOUR_FIELDS.
    :param area: (N,) of their contours [px^2].
    """
    log_growth = np.abs(np.log(np.maximum(area, 1.0) / records['placed_area']))
    return np.asarray(log_growth >= np.log(RENEWAL_SCALE))
