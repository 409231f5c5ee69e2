import numpy as np

from colortrack_ros.data import Detections
from colortrack_ros.data import Tracks
from colortrack_ros.world import TransformError
from colortrack_ros.world.waiting import LONGEST_WAIT
from colortrack_ros.world.waiting import Waiting

MS = 1_000_000


class Scene:
    """What a node has: poses until a time, and a clock."""

    def __init__(self):
        self.now, self.until, self.since = 0.0, 0, 0
        self.out, self.refused = [], []
        self.waiting = Waiting(self.view, self.release, self.refused.append, lambda: self.now)

    def view(self, stamp):
        if stamp > self.until:
            raise TransformError('extrapolation into the future', later=True)
        if stamp < self.since:
            raise TransformError('extrapolation into the past')
        return f'view at {stamp // MS}'

    def release(self, tracks, detections, view, depth):
        assert tracks.stamp == detections.stamp
        self.out.append((tracks.stamp // MS, view, depth is not None))

    def put(self, *stamps):
        for stamp in stamps:
            self.waiting.put_detections(Detections(stamp=stamp * MS))
            self.waiting.put_tracks(Tracks(stamp=stamp * MS))


def test_a_picture_with_all_it_needs_goes_at_once():
    scene = Scene()
    scene.until = 100 * MS
    scene.put(10, 20)
    assert scene.out == [(10, 'view at 10', False), (20, 'view at 20', False)]


def test_detections_may_come_after_their_tracks():
    scene = Scene()
    scene.until = 100 * MS
    scene.waiting.put_tracks(Tracks(stamp=10 * MS))
    assert scene.out == []
    scene.waiting.put_detections(Detections(stamp=10 * MS))
    assert scene.out == [(10, 'view at 10', False)]


def test_late_odometry_is_waited_for_and_the_order_kept():
    scene = Scene()
    scene.put(10, 20)
    assert scene.out == []
    scene.until = 15 * MS
    scene.waiting.look()
    assert [stamp for stamp, *_ in scene.out] == [10]
    scene.until = 30 * MS
    scene.waiting.look()
    assert [stamp for stamp, *_ in scene.out] == [10, 20]
    assert scene.refused == []


def test_odometry_that_stops_is_told_and_nothing_goes_out():
    scene = Scene()
    scene.put(10)
    scene.now = LONGEST_WAIT + 0.1
    scene.waiting.look()
    assert scene.out == []
    assert scene.refused == ['extrapolation into the future']


def test_what_is_older_than_all_poses_is_told_at_once():
    scene = Scene()
    scene.until, scene.since = 100 * MS, 50 * MS
    scene.put(10, 60)
    assert scene.refused == ['extrapolation into the past']
    assert [stamp for stamp, *_ in scene.out] == [60]


def test_a_depth_picture_of_about_the_same_time_is_taken():
    scene = Scene()
    scene.until, scene.waiting.needs_depth = 100 * MS, True
    scene.put(50)
    assert scene.out == []
    scene.waiting.put_depth(80 * MS, np.ones((2, 2), np.float32))
    assert scene.out == []
    scene.waiting.put_depth(58 * MS, np.ones((2, 2), np.float32))
    assert scene.out == [(50, 'view at 50', True)]


def test_without_depth_a_picture_goes_on_late_and_it_is_told():
    scene = Scene()
    scene.until, scene.waiting.needs_depth = 100 * MS, True
    scene.put(50)
    scene.now = LONGEST_WAIT + 0.1
    scene.waiting.look()
    assert scene.out == [(50, 'view at 50', False)]
    assert 'depth_topic' in scene.refused[0]


def test_tracks_whose_detections_never_come_are_told():
    scene = Scene()
    scene.until = 100 * MS
    scene.waiting.put_tracks(Tracks(stamp=10 * MS))
    scene.now = LONGEST_WAIT + 0.1
    scene.waiting.look()
    assert 'no detections came' in scene.refused[0]
