"""Records of targets, and the test whether they have moved."""

import numpy as np

from colortrack_ros.contours.changes import has_changed
from colortrack_ros.contours.config import ContourConfig
from colortrack_ros.contours.deformation import form
from colortrack_ros.contours.displaced import AREA_PIXELS
from colortrack_ros.contours.filters import Contours
from colortrack_ros.contours.spline import Spline
from colortrack_ros.data import Bools
from colortrack_ros.data import Floats
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import TENTATIVE
from colortrack_ros.detection.background_model import Picture
from colortrack_ros.estimation.records import Records
from colortrack_ros.estimation.track_table import TrackTable

CONTOUR_FIELDS = [
    ('edge_share', 'f4'), ('placed_area', 'f8'), ('misfit', 'f8'), ('by_area', '?'),
    ('inner', '?'), ('agreed', 'i8'), ('placed', 'i8'), ('moved', '?'), ('from', 'i8'),
    ('from_u', 'f8'), ('from_v', 'f8'), ('told', '?'), ('seen_w', 'f8'), ('seen_h', 'f8'),
    ('single', '?'), ('alone', 'f8'), ('high', 'f8'), ('piece', '?'), ('proven', '?'),
    ('form', 'f8'), ('deformed', 'f8'),
    ('first_at', 'i4', (AREA_PIXELS, 2)), ('first_level', 'f4', (AREA_PIXELS,)),
]  # fmt: skip
"""Fields of a target, in addition to those of every track.

edge_share: share of its lines with an edge when last measured; 1 if measured by its foreground.
placed_area: area when its nodes were placed [px].
misfit: RMS distance of curve and outline then [square root of that area].
by_area: whether its nodes come from its foreground.
inner: whether it started inside another target.
agreed: stamp when it last was as large as its foreground, plus the time unseen since [ns].
placed: stamp of the last attempt to place its nodes [ns].
moved: whether it has ever moved far enough.
from, from_u, from_v: start of its motion, stamp and place [ns, px].
told: whether it was started by a box; it may stand still.
seen_w, seen_h: size of its foreground until recently, 0 without one [px].
single, alone: whether it was a separate area for ALONE_SECONDS, and for how long it was [s].
high: its mean height as a separate area lately [px].
piece: whether it is above or below a much larger target in an area that both share.
proven: whether it has moved, and has existed long enough for its size.
form, deformed: logarithm of its mean aspect ratio, and mean squared deviation from it.
first_at, first_level: places, row and column, and levels of AREA_PIXELS pixels when it began.
"""

RENEWAL_SCALE = 1.6
"""A contour gets new nodes when its area has changed by this factor. At twice the value the mean
squared error on `silhouette` is 0.032 instead of 0.037 px^2, on `approach` 0.016 instead of 0.025;
at half of it, always renewing, 0.042 and 0.033 (``benchmark/contours.py --constants
records.RENEWAL_SCALE``)."""

MOTION_SECONDS = 3.0
"""Time within which a new target has to move by min_motion; after it, counting starts again.
Assumed: half and twice the value change nothing on TUD Campus, 0.01 of precision on PETS S3.MF1
(``benchmark/real_contours.py FOLDER --constants records.MOTION_SECONDS``)."""

PROOF_SECONDS = 1.0
"""Time for which a new target of min_area is tentative [s]; one of twice the width and height, half
of that. Heads, legs, leaves, and traces of walkers in the background are small, and come and go.
The frame before the target started counts. MOTA, precision of TUD Campus with half, once and twice
the value, that frame not counted: 0.13, 0.63; 0.18, 0.73; 0.24, 0.92; of `pets` 0.59, 0.88; 0.59,
0.88; 0.57, 0.89 (``benchmark/real_contours.py FOLDER --constants records.PROOF_SECONDS``)."""

CROSSING_SHARE = 0.25
"""A target so fast that it would cross more than this share of the picture in that time is proven
when it has. Assumed; half and twice the value change nothing beyond 0.01 of IDF1 on TUD Campus and
S3.MF1, half of it nothing on `pets` either (as above)."""


def begin(tracks: TrackTable[Contours], contours: Contours, spline: Spline, stamp: int) -> Records:
    """Start targets, and return a view of their records.

    :param contours: of the new targets.
    :param stamp: now [ns].
    """
    records = tracks.initiate(contours, stamp)
    records['edge_share'] = 1.0
    records['agreed'] = records['from'] = stamp
    size = np.ptp(contours.nodes, axis=1)
    records['seen_w'], records['seen_h'] = size.T
    records['form'] = form(size)
    records['placed_area'] = np.maximum(spline.area(contours.nodes), 1.0)
    records['from_u'], records['from_v'] = contours.nodes.mean(axis=1).T
    return records


def hold_unproven(
    records: Records,
    nodes: Floats,
    area: Floats,
    speed: Floats,
    config: ContourConfig,
    picture: Picture,
    stamp: int,
) -> Bools:
    """Keep targets tentative that have not moved yet, or have not existed long enough for their
    size.

    The size is the RMS of width and height, since fluttering tape has hardly any area.

    :param records: (N,) with CONTOUR_FIELDS; their states are set.
    :param nodes: (N, n, 2) [px].
    :param area: (N,) [px^2].
    :param speed: (N,) according to the filters [px/s].
    :param picture: (H, W, channels).
    :param stamp: now [ns].
    :return: which targets are unproven, (N,).
    """
    place = nodes.mean(axis=1)
    way = np.hypot(place[:, 0] - records['from_u'], place[:, 1] - records['from_v'])
    least = config.min_motion * np.hypot(*np.ptp(nodes, axis=1).T) / np.sqrt(2)
    moves = (way >= least) & (speed * MOTION_SECONDS >= least)
    records['moved'] |= moves & ((config.min_motion == 0) | has_changed(records, picture))
    seconds = PROOF_SECONDS * np.sqrt(config.min_area / np.maximum(area, 1.0))
    seconds = np.minimum(seconds, CROSSING_SHARE * max(picture.shape[:2]) / np.maximum(speed, 1e-9))
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
    """Return which targets, (N,), need new nodes after a change of size.

    :param records: (N,) with CONTOUR_FIELDS.
    :param area: (N,) of their contours [px^2].
    """
    log_growth = np.abs(np.log(np.maximum(area, 1.0) / records['placed_area']))
    return np.asarray(log_growth >= np.log(RENEWAL_SCALE))
