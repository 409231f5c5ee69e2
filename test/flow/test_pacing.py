import threading

import pytest
from support.waiting import PATIENCE
from support.waiting import wait_until

from colortrack_ros.flow.pacing import Pacer
from colortrack_ros.flow.pacing import Window


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


def test_a_new_period_begins_at_once(time):
    pacer, starts = Pacer(time.sleep, lambda: time.now), []
    for period in (0.04, 100.0, 0.04, 0.04):
        pacer.pace(period)
        starts.append(time.now)
        if period > 1:
            time.now -= 90.0  # woken early
            pacer.restart()
    assert starts == pytest.approx([100.0, 200.0, 110.0, 110.04])


def test_a_frame_waits_for_the_answer_to_the_one_before_the_last():
    window, sent = Window(2, patience=10.0), []

    def send():
        for stamp in (10, 20, 30, 40):
            window.send(stamp)
            sent.append(stamp)

    thread = threading.Thread(target=send)
    thread.start()
    wait_until(lambda: len(sent) == 2)
    thread.join(0.1)
    assert sent == [10, 20]
    window.answer(5)
    thread.join(0.1)
    assert sent == [10, 20]
    window.answer(20)
    thread.join(PATIENCE)
    assert sent == [10, 20, 30, 40]


def test_an_answer_that_does_not_come_is_given_up():
    window = Window(1, patience=0.01)
    for stamp in range(5):
        window.send(stamp)
