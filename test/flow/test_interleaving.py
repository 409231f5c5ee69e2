from colortrack_ros.flow.interleaving import Interleaving
from colortrack_ros.flow.interleaving import LONGEST_SILENCE

MS = 1_000_000


class Cameras:
    """So many sources, and a clock of its own [s]."""

    def __init__(self, count):
        self.now, self.out, self.refused = 100.0, [], []
        self.order = Interleaving(count, self.out.append, self.refused.append, lambda: self.now)

    def put(self, source, *stamps):
        for stamp in stamps:
            self.order.put(source, stamp * MS, stamp)


def test_items_of_two_sources_come_in_the_order_of_their_stamps():
    cameras = Cameras(2)
    cameras.put(0, 10)
    cameras.put(1, 35)
    cameras.put(0, 40, 70)
    cameras.put(1, 65, 80)
    assert cameras.out == [10, 35, 40, 65, 70]


def test_one_source_waits_for_nobody():
    cameras = Cameras(1)
    cameras.put(0, 10, 20)
    assert cameras.out == [10, 20]


def test_a_source_that_has_fallen_silent_holds_the_others_up_for_a_moment_only():
    cameras = Cameras(2)
    cameras.put(1, 10)
    cameras.put(0, 15, 20)
    assert cameras.out == [10]
    cameras.now += LONGEST_SILENCE + 0.1
    cameras.order.look()
    assert cameras.out == [10, 15, 20]
    cameras.put(0, 30)
    assert cameras.out[-1] == 30


def test_what_comes_too_late_is_refused_with_a_reason():
    cameras = Cameras(2)
    cameras.put(0, 100)
    cameras.put(1, 50)
    assert cameras.out == [100]
    assert 'it came too late' in cameras.refused[0]


def test_a_clock_that_goes_back_begins_again():
    cameras = Cameras(2)
    cameras.put(0, 1000)
    cameras.put(1, 1001)
    cameras.put(0, 5, 30)
    cameras.put(1, 10)
    assert cameras.out[0] == 1000
    assert cameras.out[-2:] == [5, 10]
    assert cameras.refused == []
