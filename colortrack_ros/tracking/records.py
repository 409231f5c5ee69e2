"""Records: the fields of a track besides its filter, and the rows published for it."""

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import DETECTION_BOX
from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.data import TENTATIVE
from colortrack_ros.data import TRACK
from colortrack_ros.estimation.bank import Bank
from colortrack_ros.estimation.gaussian import maneuvering
from colortrack_ros.estimation.records import Records
from colortrack_ros.estimation.track_table import TrackTable
from colortrack_ros.tracking import maneuvers
from colortrack_ros.tracking import noise
from colortrack_ros.tracking import process_noise
from colortrack_ros.tracking import recent
from colortrack_ros.tracking.camera import CAMERA_FIELDS
from colortrack_ros.tracking.config import TrackerConfig
from colortrack_ros.tracking.population import Population
from colortrack_ros.tracking.second_difference import ACCELERATION_FIELDS
from colortrack_ros.tracking.splinters import SPLINTER_FIELDS

FIELDS = [
    ('color', 'u4'),
    ('origin', 'f8', 2),
    ('seen', 'f8', 2),
    ('misses', 'u4'),
    ('gaps', 'u4'),
    ('area', 'f4'),
    ('box_size', 'f8', 2),
    ('corner', 'f8', 2),
    ('extent', 'f8', (2, 2)),
    ('systematic', 'f8', 2),
    ('growth', 'f8', 2),
    ('partial', '?', 2),
    ('stood', 'f8', (2, 2)),
    ('moved', '?', (2, 2)),
    ('whole', 'f8', (2, 2)),
    ('emerging', '?', 2),
    ('edged', '?', 2),
    ('outside', '?'),
    ('visible', 'f8'),
    ('hidden', 'f8'),
    ('hidden_share', 'f8'),
    ('leaving', 'f8'),
    ('shared', 'i8'),
    ('rival', 'u4'),
    ('met', 'i8'),
    ('apart', 'i8'),
    ('before', 'f8', 4),
    ('before_cov', 'f8', (4, 4)),
    ('before_size', 'f8', 2),
    ('sums', 'f8', 7),
    ('scans', 'u4'),
    ('size_log_ratio', 'f8'),
    ('unsettled', 'f8', (2, 2)),
    ('stray_at', 'i8'),
    ('strays', 'u4'),
    ('aside', 'f8', 2),
    *recent.RECENT_FIELDS,
    *noise.NOISE_FIELDS,
    *maneuvers.MANEUVER_FIELDS,
    *process_noise.STEP_FIELDS,
    *ACCELERATION_FIELDS,
    *CAMERA_FIELDS,
    *SPLINTER_FIELDS,
]
"""Fields of a track besides the COMMON ones.

origin, seen: where it started and where it was last measured [px].
misses, gaps: frames without a detection, and how many of them came right after one with it.
area, box_size: of the last detection of this object alone [px].
corner: of its box, top left, from its centroid [px].
extent: reach of the object to the low and high side, by axis [px], see extents.
systematic: variance by axis of the error that its centroids have in common [px^2].
growth: of the extent [1/s].
partial: never seen completely yet, by axis.
stood, moved: where the sides of its box were, low and high, by axis, and which have moved [px].
whole: its size then, by axis, on that axis and on the other one, see edges [px].
emerging: both sides never have moved, by axis; whole is its size at first.
edged: one side alone has moved, or a part may be behind a cover, by axis.
outside: predicted outside the picture.
visible, hidden: probability that the object exists and is, or is not, visible.
hidden_share: share of the objects lost there that are hidden.
leaving: rate at which objects that go where it went leave the picture [1/s], see traffic.
shared: stamp of the last frame in which it shared its detection, see unresolved; 0 for none [ns].
rival: ID of the track that it may have swapped detections with, 0 for none.
met, apart: stamps of the first and the last frame in which the two were close, or hidden [ns].
before, before_cov, before_size: predicted state at the first, its covariance, and its size [px].
sums: of the weighted line through its scans measurements since the last, see lines.
size_log_ratio: sum over those of the log-likelihood ratio of its sizes, own over rival's.
unsettled: covariance of the velocity due to maneuvers that hardly show yet [px^2/s^2].
stray_at, strays, aside: stamp of its last stray [ns], how many on end went further and further
aside until then, and where that one was from the prediction [px], see strays.
"""


def record_size(
    records: Records, track: Indices | slice, rows: NDArray[np.void], z: Floats
) -> None:
    """Record sizes and boxes of the detections rows, (K,), with centroids z, that tracks took."""
    records['area'][track] = rows['area']
    box = rows.view(DETECTION_BOX)
    size, corner = box['size'], box['corner'] - z
    if np.count_nonzero(size) < size.size:
        corner[size <= 0] = 0.5  # a point
    records['box_size'][track], records['corner'][track] = size, corner


def published(
    tracks: TrackTable[Bank],
    stamp: int,
    config: TrackerConfig,
    population: Population,
    speed: Floats,
    existence: Floats,
) -> NDArray[np.void]:
    """Return the rows of the tracks that are published.

    Tracks are left out if they are outside the picture, if they were confirmed and have probably
    ceased to exist, or if they belong to a known population but have not been identified.

    :param stamp: now [ns].
    :param speed: (2,) standard deviation of a new velocity on each axis [px/s]; 0 for none.
    :param existence: (N,) probabilities.
    :return: of dtype TRACK.
    """
    records, bias = tracks.records, config.centroid_bias
    absent = (existence < config.min_score) | records['outside']
    if np.count_nonzero(absent):
        absent &= (records['state'] != TENTATIVE) | records['outside']
    if population.total:
        absent |= population.is_unnamed(records['track_id'], records['color'])
    mean, covariance = tracks.filters.estimate()
    rows = tracks.rows(stamp, mean[:, :4], covariance[:, :4, :4])
    covariance, since = rows['covariance'], rows['time_since_update']
    if np.count_nonzero(since):
        coasting = ((since > 0) & ~absent).nonzero()[0]
        astray, rate = records['astray'][coasting], records['rate'][coasting]
        speed = speed * config.maneuvers
        covariance[coasting] = _unseen(rows.take(coasting), astray, rate, speed)
    covariance[:, 2:, 2:] += records['unsettled']
    covariance.reshape(-1, 16)[:, :6:5] += records['systematic'] + bias**2
    rows['score'] = existence
    if not np.count_nonzero(absent):
        return rows
    whole = rows.view((np.void, TRACK.itemsize))  # with the padding, which is 0 in every message
    return whole[~absent].view(TRACK)


def _unseen(rows: NDArray[np.void], astray: Floats, rate: Floats, speed: Floats) -> Floats:
    """Return the covariances of coasting tracks, (K, 4, 4), about their predicted states.

    The covariances of the filters are increased by the learned drift of unseen objects, and by the
    mean square of the offset that a maneuver would have caused.

    :param rows: (K,) of dtype TRACK.
    :param astray, rate: (K, 2) and (K,) see maneuvers.MANEUVER_FIELDS.
    :param speed: see published().
    """
    T, P = rows['time_since_update'].astype(float), rows['covariance']
    entries, astray = P.reshape(-1, 16), astray * T[:, None]
    entries[:, :6:5] += astray * T[:, None] ** 2 / 3
    entries[:, 2:8:5] += astray * T[:, None] / 2
    entries[:, 8:14:5] += astray * T[:, None] / 2
    entries[:, 10::5] += astray
    if not speed.any():
        return P
    going_on = rows.view(np.float64).reshape(-1, TRACK.itemsize // 8)[:, :4]  # u, v, du, dv
    chance = maneuvers.maneuver_chance(rate, T)
    mean, P = maneuvering(going_on, P, chance, T, speed)
    aside = mean - going_on
    return np.asarray(P + aside[:, :, None] * aside[:, None, :])
