"""Who else takes the same detections: sequence -> rows (track_id, u, v) of each frame."""

from functools import partial

import numpy as np

from worlds.textbook import Textbook


def run(make, sequence):
    """A tracker of centroids, built with the largest way from frame to frame, over a sequence."""
    tracker = make(sequence.step)
    return [
        tracker.update(np.stack([message.rows['u'], message.rows['v']], axis=1))
        for message in sequence.detections
    ]


def textbook(**options):
    """With the noise that the detections bring, of 1 px if they bring none."""

    def play(sequence):
        brought = np.concatenate([message.rows['cov_uu'] for message in sequence.detections])
        sigma = float(np.sqrt(np.median(brought))) or 1.0
        return run(lambda step: Textbook(sigma=sigma, **options), sequence)

    return play


class Boxed:
    """A tracker of boxes of the package `trackers`; points become boxes as in peers.py."""

    def __init__(self, make, step):
        self.tracker, self.step = make(), step

    def update(self, rows):
        """Take rows of DETECTION, give rows (track_id, u, v)."""
        import peers
        import supervision

        corner = np.stack([rows['box_u'], rows['box_v']], 1)
        size = np.stack([rows['box_w'], rows['box_h']], 1)
        z = np.stack([rows['u'], rows['v']], 1)
        boxes = np.hstack([corner, corner + size]) if size.any() else peers.boxes_of(z, self.step)
        found = self.tracker.update(
            supervision.Detections(xyxy=boxes.astype(float), confidence=np.ones(len(z)))
        )
        live = found[found.tracker_id >= 0]
        return peers.rows_of(live.tracker_id, (live.xyxy[:, :2] + live.xyxy[:, 2:]) / 2)


def boxed(name):
    """SORTTracker or ByteTrackTracker by its name."""
    import trackers

    def play(sequence):
        tracker = Boxed(partial(getattr(trackers, name), frame_rate=30), sequence.step)
        return [tracker.update(message.rows) for message in sequence.detections]

    return play


def rivals(peers):
    """The textbook; with peers also those of benchmark/requirements.txt."""
    if not peers:
        return [textbook()]
    import peers as others

    linked = [other for other in others.PEERS if other is not others.Trackpy]
    boxes = [boxed(name) for name in ('SORTTracker', 'ByteTrackTracker')]
    return [textbook(), *(partial(run, other) for other in linked), *boxes]
