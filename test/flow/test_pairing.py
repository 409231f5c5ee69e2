import numpy as np

from colortrack_ros.data import Detections
from colortrack_ros.data import Frame
from colortrack_ros.flow.pairing import Pairing
from colortrack_ros.flow.pairing import WAITING


def frame(stamp):
    return Frame(np.zeros((1, 1), np.uint8), 'mono8', stamp)


def stamps(pairs):
    return [(f.stamp, d and d.stamp) for f, d in pairs]


def test_a_picture_waits_for_its_detections_or_later_ones():
    pairing = Pairing()
    assert pairing.put_frame(frame(1)) == []
    assert pairing.put_frame(frame(2)) == []
    assert stamps(pairing.put_detections(Detections(stamp=1))) == [(1, 1)]
    assert pairing.put_frame(frame(3)) == []
    assert stamps(pairing.put_detections(Detections(stamp=3))) == [(2, None), (3, 3)]


def test_detections_may_come_before_their_picture():
    pairing = Pairing()
    assert pairing.put_detections(Detections(stamp=5)) == []
    assert pairing.put_detections(Detections(stamp=6)) == []
    assert stamps(pairing.put_frame(frame(5))) == [(5, 5)]
    assert stamps(pairing.put_frame(frame(6))) == [(6, 6)]


def test_a_detector_that_has_ended_stops_nobody():
    pairing = Pairing()
    out = [pair for k in range(100) for pair in pairing.put_frame(frame(k))]
    assert stamps(out) == [(k, None) for k in range(100 - WAITING)]


def test_a_loop_changes_no_pair_whoever_is_ahead():
    for ahead in range(-5, 6):
        pairing, out = Pairing(), []
        loops = [*range(10)] * 3
        for k in range(-5, 40):
            if 0 <= k < len(loops):
                out += pairing.put_frame(frame(loops[k]))
            if 0 <= k + ahead < len(loops):
                out += pairing.put_detections(Detections(stamp=loops[k + ahead]))
        assert stamps(out) == [(k, k) for k in loops]
