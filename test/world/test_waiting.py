import numpy as np

from colortrack_ros.data import Detections
from colortrack_ros.data import Tracks
from colortrack_ros.world import TransformError
from colortrack_ros.world.waiting import LONGEST_WAIT
from colortrack_ros.world.waiting import MAX_DEPTHS
from colortrack_ros.world.waiting import MAX_DETECTIONS
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
    scene.waiting.put_depth(20 * MS, np.ones((2, 2), np.float32))
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


def test_depths_that_are_refused_are_told_as_such_until_one_is_taken():
    scene = Scene()
    scene.until, scene.waiting.needs_depth = 100 * MS, True
    scene.waiting.refuse_depth("depth picture in '64FC1'")
    scene.put(10)
    scene.now = LONGEST_WAIT + 0.1
    scene.waiting.look()
    scene.waiting.put_depth(50 * MS, np.ones((2, 2), np.float32))
    scene.put(90)
    scene.now *= 3
    scene.waiting.look()
    assert scene.refused[0].endswith("0.010 s: depth picture in '64FC1'")
    assert 'depth_topic' in scene.refused[1]


def test_tracks_whose_detections_never_come_are_told():
    scene = Scene()
    scene.until = 100 * MS
    scene.waiting.put_tracks(Tracks(stamp=10 * MS))
    scene.now = LONGEST_WAIT + 0.1
    scene.waiting.look()
    assert 'no detections came' in scene.refused[0]


def test_a_tracker_that_stalls_once_before_a_camera_of_60_hz_costs_no_picture():
    """Those that waited for detections that had been dropped let the next ones be dropped."""
    scene = Scene()
    scene.until = 10_000 * MS
    stamps = [17 * k for k in range(120)]
    for stamp in stamps:
        scene.waiting.put_detections(Detections(stamp=stamp * MS))
    for stamp in stamps:
        scene.waiting.put_tracks(Tracks(stamp=stamp * MS))
    assert [out[0] for out in scene.out] == stamps


def test_depths_of_half_the_rate_of_the_pictures_hold_none_up():
    scene = Scene()
    scene.until, scene.waiting.needs_depth = 1000 * MS, True
    for stamp in (0, 33, 66, 99):
        if stamp in (0, 66):
            scene.waiting.put_depth(stamp * MS, np.ones((2, 2), np.float32))
        scene.put(stamp)
    assert scene.out == [
        (0, 'view at 0', True), (33, 'view at 33', False), (66, 'view at 66', True)
    ]  # fmt: skip
    assert 'slower' in scene.refused[0]


def test_depths_of_1_hz_are_waited_for_as_well_until_they_stop():
    """By method depth nothing was located: each picture went on before its depths came."""
    scene = Scene()
    scene.until, scene.waiting.needs_depth = 10_000 * MS, True
    for stamp in range(0, 5000, 100):
        scene.now = stamp / 1000
        scene.put(stamp)
        if stamp % 1000 == 0:
            scene.waiting.put_depth(stamp * MS, np.ones((2, 2), np.float32))
    assert [stamp for stamp, _, with_depth in scene.out if with_depth] == list(range(0, 5000, 1000))
    scene.now = 6.1
    scene.put(6100)
    assert scene.out[-1][0] == 6100


def test_depths_are_waited_for_from_the_first_picture_on():
    """Not from when the node was made: by a simulator's clock that was an hour ago."""
    scene = Scene()
    scene.until, scene.waiting.needs_depth, scene.now = 10_000 * MS, True, 3600.0
    scene.put(50)
    scene.waiting.put_depth(50 * MS, np.ones((2, 2), np.float32))
    assert scene.out == [(50, 'view at 50', True)]


def test_depths_of_a_bag_that_loops_are_waited_for_anew():
    scene = Scene()
    scene.until, scene.waiting.needs_depth = 1000 * MS, True
    for stamp in (10, 100, 10):
        scene.waiting.put_depth(stamp * MS, np.ones((2, 2), np.float32))
    scene.put(50)
    assert scene.out == []
    scene.waiting.put_depth(50 * MS, np.ones((2, 2), np.float32))
    assert scene.out == [(50, 'view at 50', True)]


def test_without_a_depth_camera_the_first_pictures_wait_for_it_and_no_more():
    """By method fused all locations were 0.5 s late then, and a robot that follows stood."""
    scene = Scene()
    scene.until, scene.waiting.needs_depth = 10_000 * MS, True
    scene.put(0)
    scene.now = LONGEST_WAIT + 0.1
    scene.put(700)
    assert [out[0] for out in scene.out] == [0, 700]
    scene.waiting.put_depth(710 * MS, np.ones((2, 2), np.float32))
    scene.put(750)
    assert [out[0] for out in scene.out] == [0, 700]
    scene.waiting.put_depth(750 * MS, np.ones((2, 2), np.float32))
    assert scene.out[-1] == (750, 'view at 750', True)


def test_what_nobody_takes_is_kept_for_seconds_not_for_good():
    scene = Scene()
    for stamp in range(1000):
        scene.waiting.put_detections(Detections(stamp=stamp * MS))
        scene.waiting.put_depth(stamp * MS, np.ones((2, 2), np.float32))
    assert len(scene.waiting._detections) == MAX_DETECTIONS
    assert list(scene.waiting._depths) == [stamp * MS for stamp in range(1000 - MAX_DEPTHS, 1000)]
