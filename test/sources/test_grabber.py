from pathlib import Path
import threading

import numpy as np
import pytest
from support.waiting import PATIENCE

from colortrack_ros.data import Frame
from colortrack_ros.sources import Grabber
from colortrack_ros.sources import Source
from colortrack_ros.sources import SourceError


class Scripted(Source):
    """Plays a list of frames (ints), errors, and None for the end."""

    period = 40

    def __init__(self, script, live=False):
        self.live = live
        self.script, self.at, self.closed = script, 0, threading.Event()
        self.dry = threading.Event()

    @staticmethod
    def accepts(spec):
        return False

    def read(self):
        if self.at == len(self.script):
            self.dry.set()
            if self.live:
                self.closed.wait(PATIENCE)
            return None
        item = self.script[self.at]
        self.at += 1
        if isinstance(item, Exception):
            raise item
        return Frame(np.zeros((1, 1, 3), np.uint8), stamp=item)

    def rewind(self):
        self.at = 0

    def close(self):
        self.closed.set()


def stamps(grabber, count):
    return [grabber.read().stamp for _ in range(count)]


def test_every_frame_of_a_recording_comes_in_order_then_the_end():
    grabber = Grabber(Scripted(list(range(50))))
    assert stamps(grabber, 50) == list(range(50))
    assert grabber.read() is None
    assert grabber.read() is None
    assert grabber.skipped == 0


def test_a_recording_starts_again_while_loop_says_so():
    rounds = iter([True, True, False])
    grabber = Grabber(Scripted([1, 2]), loop=lambda: next(rounds))
    assert stamps(grabber, 6) == [1, 2, 1, 2, 1, 2]
    assert grabber.read() is None


def test_a_recording_without_frames_ends_also_in_a_loop():
    assert Grabber(Scripted([]), loop=lambda: True).read() is None


def test_an_unreadable_picture_is_told_and_the_next_one_comes():
    grabber = Grabber(Scripted([1, SourceError('bad'), 3]))
    assert grabber.read().stamp == 1
    with pytest.raises(SourceError, match='bad'):
        grabber.read()
    assert grabber.read().stamp == 3


def test_a_live_source_gives_the_newest_frame_and_counts_the_others():
    source = Scripted([1, 2, 3, 4], live=True)
    grabber = Grabber(source)
    assert source.dry.wait(PATIENCE)
    assert grabber.read().stamp == 4
    assert grabber.skipped == 3
    grabber.close()


def test_a_failure_of_a_live_source_stays():
    grabber = Grabber(Scripted([SourceError('gone')], live=True))
    for _ in range(2):
        with pytest.raises(SourceError, match='gone'):
            grabber.read()


def test_closing_ends_a_waiting_read_and_closes_the_source():
    source = Scripted([], live=True)
    grabber = Grabber(source)
    thread = threading.Thread(target=grabber.read)
    thread.start()
    source.closed.set()
    grabber.close()
    thread.join(PATIENCE)
    assert not thread.is_alive()


FAULTS = (MemoryError(), OSError(5, 'Input/output error'), RecursionError(), ValueError('what'))


@pytest.mark.parametrize('fault', FAULTS, ids=repr)
@pytest.mark.parametrize('live', [False, True], ids=['recording', 'live'])
def test_any_exception_of_a_source_ends_it_and_is_told(fault, live):
    source = Scripted([fault, 2, 3], live)
    grabber = Grabber(source)
    with pytest.raises(SourceError, match=type(fault).__name__):
        grabber.read()
    if live:  # until it is opened again
        with pytest.raises(SourceError):
            grabber.read()
    else:
        assert grabber.read() is None
        assert grabber.lost == 1
    assert source.closed.wait(PATIENCE)


def test_a_source_that_cannot_start_over_ends():
    source = Scripted([1])
    source.rewind = lambda: Path('/nowhere').read_text()
    grabber = Grabber(source, loop=lambda: True)
    assert grabber.read().stamp == 1
    with pytest.raises(SourceError, match='FileNotFoundError'):
        grabber.read()
    assert grabber.read() is None
