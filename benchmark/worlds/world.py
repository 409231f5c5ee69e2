"""What worlds are made of: truth, the detections drawn from it, and the figures that come out."""

from dataclasses import dataclass
from dataclasses import fields
import math

import numpy as np
from points import Sequence

from colortrack_ros.data import Detections
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.evaluation import Score
from colortrack_ros.evaluation import Tally
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig

RATE = 30
SIZE = (1280, 720)


@dataclass(frozen=True)
class Figure:
    """A number of a world.

    before: what the issue states; now: of this checkout; rival: of the textbook or the best peer;
    low, high: what is to be reached; nan for what there is not.
    """

    what: str
    now: float
    before: float = math.nan
    rival: float = math.nan
    low: float = -math.inf
    high: float = math.inf


@dataclass(frozen=True)
class World:
    """N objects over K frames.

    position: (K, N, 2) [px]; velocity: (K, N, 2) [px/s]; exists: (K, N); z: (K, N, 2) where each
    was measured, nan where it was not; detections: K messages of these.
    """

    position: np.ndarray
    velocity: np.ndarray
    exists: np.ndarray
    z: np.ndarray
    detections: list[Detections]

    @property
    def seen(self):
        """(K, N)."""
        return ~np.isnan(self.z[..., 0])

    def sequence(self, reach=20.0):
        """As the scoring takes it: who is not seen need not be found.

        :param reach: largest distance of a track from its object [px].
        """
        names = np.arange(self.position.shape[1])
        truth = [
            np.column_stack([names, p])[s] for p, s in zip(self.position, self.seen, strict=True)
        ]
        hidden = (self.exists & ~self.seen).sum(axis=1).tolist()
        step = float(np.hypot(*(self.velocity / RATE).T).max())
        return Sequence(truth, hidden, self.detections, SIZE, step, reach)


def message(z, k, sigma=1.0, box=None, rate=RATE):
    """Detections at z, (M, 2), in frame k.

    :param sigma: of the covariance that they bring [px]; 0 for none.
    :param box: (M, 2) width and height around z [px], None for none.
    """
    found = Detections.from_points(z, round(k * NANOSECONDS / rate), sigma=sigma)
    if box is not None:
        rows = found.rows
        rows['box_w'], rows['box_h'] = box.T
        rows['box_u'], rows['box_v'] = (z - box / 2).T
        rows['area'] = box.prod(axis=1)
    return found


def observe(path, rng, noise=1.0, given=None, seen=None, size=None, exists=None):
    """Detect what moves along a path, position and velocity.

    :param noise: true standard deviation [px].
    :param given: what the detections say of it, as much if None [px]; 0 for nothing.
    :param seen: (K, N), all if None.
    :param size: (N,) of the boxes [px], None for points.
    """
    position, velocity = path
    exists = np.ones(position.shape[:2], bool) if exists is None else exists
    seen = exists if seen is None else seen & exists
    z = position + rng.normal(0, noise, position.shape)
    z[~seen] = np.nan
    detections = []
    for k in range(len(z)):
        order = rng.permutation(np.flatnonzero(seen[k]))
        box = None if size is None else np.repeat(size[order, None], 2, axis=1)
        detections.append(message(z[k, order], k, noise if given is None else given, box))
    return World(position, velocity, exists, z, detections)


def lasting(white, rho):
    """Errors of which that share stays from frame to frame, of white ones, (K, ...)."""
    e = white.copy()
    for k in range(1, len(e)):
        e[k] = rho * e[k - 1] + np.sqrt(1 - rho**2) * e[k]
    return e


def tracker(**options):
    """Ours; options that this checkout does not have (yet) are left out."""
    known = {field.name for field in fields(TrackerConfig)}
    return Tracker(TrackerConfig(**{k: v for k, v in options.items() if k in known}))


def play(detections, **options):
    """The rows of each frame that a user is shown: confirmed or coasting, likely enough."""
    ours = tracker(**options)
    least = getattr(ours.config, 'min_score', 0.0)
    frames = (ours.update(message).rows for message in detections)
    return [rows[(rows['state'] > 0) & (rows['score'] >= least)] for rows in frames]


def places(frames):
    """Rows of tracks -> rows (track_id, u, v), frame by frame."""
    return [np.stack([rows['track_id'], rows['u'], rows['v']], axis=1) for rows in frames]


def judge(sequence, frames) -> Score:
    """Score rows (track_id, u, v) of each frame."""
    tally = Tally(sequence.max_distance)
    for truth, rows, hidden in zip(sequence.truth, frames, sequence.hidden, strict=True):
        tally.add(truth, rows, hidden)
    return tally.score()


def identity(
    what, sequence, rivals, idf1=math.nan, switches=math.nan, peer=None, at_least=None, **options
):
    """IDF1 [%] and switches of ours and of the rival with the best IDF1.

    :param idf1, switches: what the issue states.
    :param peer: what it states of the best peer, to reach where no peer runs.
    :param at_least: the IDF1 to reach; None for that of the best rival.
    """
    ours = judge(sequence, places(play(sequence.detections, **options)))
    theirs = [judge(sequence, rival(sequence)) for rival in rivals]
    best = max(theirs, key=lambda score: score.idf1)
    goal = 100 * best.idf1 if at_least is None else at_least
    if peer is not None and len(rivals) < 2:
        goal = peer
    yield Figure(f'{what}: IDF1 %', 100 * ours.idf1, idf1, 100 * best.idf1, goal)
    yield Figure(f'{what}: switches', ours.switches, switches, best.switches, high=best.switches)
