import numpy as np

from colortrack_ros.data import Detections
from colortrack_ros.data import Frame
from colortrack_ros.flow.pairing import MAX_UNPAIRED
from colortrack_ros.flow.pairing import Pairing


class Stamps:
    """A pairing and the stamps of what it hands on."""

    def __init__(self, *most):
        self.out = []
        self.pairing = Pairing(lambda pair, context: self.out.append((pair, context)), *most)

    def frame(self, stamp):
        frame = Frame(np.zeros((1, 1), np.uint8), 'mono8', stamp)
        return self._taken(self.pairing.put_frame, frame, f'of {stamp}')

    def detections(self, stamp):
        return self._taken(self.pairing.put_detections, Detections(stamp=stamp))

    def _taken(self, put, *arguments):
        self.out.clear()
        put(*arguments)
        assert all(context == f'of {pair.stamp}' for pair, context in self.out)
        return [(pair.stamp, pair.detections and pair.detections.stamp) for pair, _ in self.out]


def test_a_picture_waits_for_its_detections_or_later_ones():
    stamps = Stamps()
    assert stamps.frame(1) == []
    assert stamps.frame(2) == []
    assert stamps.detections(1) == [(1, 1)]
    assert stamps.frame(3) == []
    assert stamps.detections(3) == [(2, None), (3, 3)]


def test_detections_may_come_before_their_picture():
    stamps = Stamps()
    assert stamps.detections(5) == []
    assert stamps.detections(6) == []
    assert stamps.frame(5) == [(5, 5)]
    assert stamps.frame(6) == [(6, 6)]


def test_a_detector_that_has_ended_stops_nobody():
    stamps = Stamps()
    out = [pair for k in range(100) for pair in stamps.frame(k)]
    assert out == [(k, None) for k in range(100 - MAX_UNPAIRED)]


def test_a_detector_far_behind_misses_no_picture_where_as_many_may_wait():
    stamps = Stamps(100)
    assert [stamps.frame(k) for k in range(100)] == [[]] * 100
    assert [stamps.detections(k) for k in range(100)] == [[(k, k)] for k in range(100)]


def test_a_loop_changes_no_pair_whoever_is_ahead():
    for ahead in range(-25, 26):
        stamps, out = Stamps(), []
        loops = [*range(10)] * 3
        for k in range(-25, 60):
            if 0 <= k < len(loops):
                out += stamps.frame(loops[k])
            if 0 <= k + ahead < len(loops):
                out += stamps.detections(loops[k + ahead])
        assert out == [(k, k) for k in loops]
