import pytest

from colortrack_ros.nodes.pacer import Pacer


class Time:
    def __init__(self):
        self.now = 100.0

    def sleep(self, seconds):
        self.now += seconds


@pytest.fixture
def time():
    return Time()


def test_small_delays_do_not_shift_the_schedule(time):
    pacer, starts = Pacer(time.sleep, lambda: time.now), []
    for work in (0.01, 0.09, 0.0, 0.05, 0.02):
        pacer.pace(0.04)
        starts.append(time.now)
        time.now += work
    assert starts == pytest.approx([100.0, 100.04, 100.13, 100.13, 100.18])


def test_after_a_long_stop_it_goes_on_from_now(time):
    pacer = Pacer(time.sleep, lambda: time.now)
    pacer.pace(0.04)
    time.now += 10.0
    for _ in range(3):
        pacer.pace(0.04)
    assert time.now == pytest.approx(110.08)
