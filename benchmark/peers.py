"""Other trackers from PyPI, made to take centroids and give rows of (track_id, u, v).

Each is built with the largest way of an object from frame to frame, ``step`` [px], and what its
documentation advises for that.
"""

import filterpy.kalman
import motpy
import norfair
import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.spatial.distance import cdist
import supervision
import trackers
from trackpy.linking.linking import Linker

RATE = 30.0


def rows_of(names, z):
    return np.column_stack([np.asarray(names, float), np.reshape(z, (-1, 2))])


def boxes_of(z, step):
    """Squares around points, large enough to overlap from frame to frame."""
    half = max(12.0, 2.0 * step)
    return np.hstack([z - half, z + half])


class Filterpy:
    """A filter for each object and the Hungarian method, as SORT does."""

    name = 'filterpy, as SORT'

    def __init__(self, step):
        self.reach = 3.0 * step + 5.0
        self.tracks, self.next = [], 1

    def start(self, z):
        """Start a track."""
        kf = filterpy.kalman.KalmanFilter(4, 2)
        kf.x[:2, 0] = z
        kf.F[0, 2] = kf.F[1, 3] = 1.0
        kf.H[0, 0] = kf.H[1, 1] = 1.0
        kf.P[2:, 2:] *= 100.0
        kf.Q *= 0.05
        self.tracks.append([self.next, kf, 1, 0])
        self.next += 1

    def update(self, z):
        """Take centroids (M, 2), give rows (track_id, u, v)."""
        for track in self.tracks:
            track[1].predict()
        predicted = np.array([t[1].x[:2, 0] for t in self.tracks]).reshape(-1, 2)
        cost = cdist(predicted, z)
        pairs = [(i, j) for i, j in zip(*linear_sum_assignment(cost), strict=True)]
        pairs = [(i, j) for i, j in pairs if cost[i, j] < self.reach]
        hit = {i for i, _ in pairs}
        for i, j in pairs:
            self.tracks[i][1].update(z[j])
            self.tracks[i][2] += 1
            self.tracks[i][3] = 0
        for i, track in enumerate(self.tracks):
            track[3] += i not in hit
        taken = {j for _, j in pairs}
        self.tracks = [t for t in self.tracks if t[3] <= (10 if t[2] >= 3 else 1)]
        for j in range(len(z)):
            if j not in taken:
                self.start(z[j])
        live = [t for t in self.tracks if t[2] >= 3]
        return rows_of([t[0] for t in live], [t[1].x[:2, 0] for t in live])


class Norfair:
    """Point tracking with its own filter and greedy matching."""

    name = 'norfair'

    def __init__(self, step):
        self.tracker = norfair.Tracker('euclidean', 3.0 * step + 5.0, initialization_delay=2)

    def update(self, z):
        """Take centroids (M, 2), give rows (track_id, u, v)."""
        live = self.tracker.update([norfair.Detection(points=p[None]) for p in z])
        return rows_of([t.id for t in live], [t.estimate[0] for t in live])


class Motpy:
    """Boxes by IoU, a Kalman filter each, the Hungarian method."""

    name = 'motpy'

    def __init__(self, step):
        self.step, self.names = step, {}
        self.tracker = motpy.MultiObjectTracker(
            1 / RATE, active_tracks_kwargs={'min_steps_alive': 2, 'max_staleness': 10}
        )

    def update(self, z):
        """Take centroids (M, 2), give rows (track_id, u, v)."""
        live = self.tracker.step([motpy.Detection(box=b) for b in boxes_of(z, self.step)])
        live = self.tracker.active_tracks(min_steps_alive=2, max_staleness=10)
        names = [self.names.setdefault(t.id, len(self.names) + 1) for t in live]
        return rows_of(names, [(t.box[:2] + t.box[2:]) / 2 for t in live])


class Roboflow:
    """SORT: boxes by IoU."""

    name = 'trackers (roboflow)'

    def __init__(self, step):
        self.step = step
        self.tracker = trackers.SORTTracker(frame_rate=RATE, minimum_iou_threshold=0.1)

    def update(self, z):
        """Take centroids (M, 2), give rows (track_id, u, v)."""
        found = self.tracker.update(
            supervision.Detections(xyxy=boxes_of(z, self.step), confidence=np.ones(len(z)))
        )
        live = found[found.tracker_id >= 0]
        return rows_of(live.tracker_id, (live.xyxy[:, :2] + live.xyxy[:, 2:]) / 2)


class Trackpy:
    """Linking of points; no filter, no tracks that coast."""

    name = 'trackpy (linking only)'

    def __init__(self, step):
        self.linker, self.frame = Linker(1.5 * step + 3.0, memory=3), 0

    def update(self, z):
        """Take centroids (M, 2), give rows (track_id, u, v)."""
        (self.linker.next_level if self.frame else self.linker.init_level)(z, self.frame)
        self.frame += 1
        return rows_of(self.linker.particle_ids, z)


PEERS = (Filterpy, Norfair, Motpy, Roboflow, Trackpy)
