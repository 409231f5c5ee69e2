"""A live source that is not there is opened again and again, and the end waits for none."""

import threading

import pytest
from support.waiting import wait_until

from colortrack_ros.nodes.camera_source import Reopening
from colortrack_ros.sources import SourceError

GONE = SourceError('gone')


@pytest.fixture
def closing(monkeypatch):
    monkeypatch.setattr('colortrack_ros.nodes.camera_source.PAUSES', (0.001, 0.002))
    return threading.Event()


class Opened:
    """Stands in for a grabber."""

    def __init__(self):
        self.closed = 0

    def close(self):
        self.closed += 1


def test_failures_are_told_while_the_pauses_grow_and_counted_from_then_on(closing):
    def fail():
        raise GONE

    told = []
    reopening = Reopening(fail, told.append, closing)
    assert [reopening.again(GONE) for _ in range(20)] == [None] * 20
    assert reopening.failures == 20
    assert told == [
        'gone. Next try in 0.001 s.',
        'gone. Next try in 0.002 s. It is tried again and again, and counted.',
    ]


def test_the_end_does_not_wait_for_a_source_that_takes_long_to_open_and_it_is_closed(closing):
    """A network camera that is unplugged answers after 5 s, when the process had been killed."""
    hangs, opened, found = threading.Event(), Opened(), []

    def wait_and_open():
        hangs.wait()
        return opened

    reopening = Reopening(wait_and_open, print, closing)
    thread = threading.Thread(target=lambda: found.append(reopening.again(GONE)))
    thread.start()
    closing.wait(0.05)
    closing.set()
    thread.join(timeout=20.0)
    assert found == [None]
    assert not opened.closed
    hangs.set()
    wait_until(lambda: opened.closed)


def test_what_else_goes_wrong_as_it_opens_is_raised(closing):
    with pytest.raises(ZeroDivisionError):
        Reopening(lambda: 1 / 0, print, closing).again(GONE)
