"""Stages of the chain, and what overload, disorder and bad input do to one with a thread."""

import itertools
import random
import threading
from types import SimpleNamespace
from typing import NamedTuple

import numpy as np
import pytest
from support.waiting import PATIENCE

from colortrack_ros.data import Frame
from colortrack_ros.flow import stage
from colortrack_ros.flow.order import OrderConfig
from colortrack_ros.flow.stage import Stage
from colortrack_ros.flow.stage import Worker

MS = 1_000_000
PERIOD, READING, COST = 0.002, 0.0001, 0.01
"""Of arrivals, and of reading and of working on one [s]: five times what the worker can do."""


class Item(NamedTuple):
    stamp: int
    born: float = 0.0


def test_results_go_to_all_takers_in_turn_with_the_context_of_their_item():
    taken = []
    stage = Stage(lambda item: item.stamp * 2, pytest.fail)
    stage.then(lambda *result: taken.append(('first', *result)))
    stage.then(lambda *result: taken.append(('second', *result)))
    stage.put(Item(3), 'context')
    stage.hand_on(8)
    assert taken == [
        ('first', 6, 'context'), ('second', 6, 'context'), ('first', 8, None), ('second', 8, None)
    ]  # fmt: skip


@pytest.mark.parametrize('kind', [Stage, Worker])
def test_both_kinds_put_in_order_and_refuse_alike(kind):
    done, refused = [], []
    stage = kind(lambda item: item.stamp // MS, refused.append)
    stage.configure(OrderConfig(reorder_window=0.03))
    stage.then(lambda stamp, _: done.append(stamp))
    for stamp in (0, 40, 20, 60, 100, 140, 10):
        stage.put(Item(stamp * MS))
    stage.settle()
    assert done == [0, 20, 40, 60, 100]
    assert len(refused) == 1
    stage.flush()
    assert done == [0, 20, 40, 60, 100, 140]
    stage.close()


class Overload:
    """A worker that gets more than it can do, in a time of its own: one second of it takes 20 ms.

    :ivar ages: how old each result is [s].
    :ivar waiting: how many items wait, at each arrival.
    :ivar refused: reasons.
    """

    def __init__(self, monkeypatch, window: float, bad_every: int) -> None:
        self.now, self.ages, self.waiting, self.refused = 0.0, [], [], []
        monkeypatch.setattr(stage, 'time', SimpleNamespace(monotonic=lambda: self.now))
        self._costs, self._bad_every = random.Random(3), bad_every
        self._next = itertools.count()
        self._number = next(self._next)
        self.worker = Worker(self._work, self.refused.append, lambda: self.now)
        self.worker._thread = SimpleNamespace(ident=1)
        self.worker.configure(OrderConfig(reorder_window=window))
        self.worker.max_lag = 0.02
        self.worker.then(lambda item, _: self.ages.append(self.now - item.born))

    def run(self, seconds: float) -> None:
        while self.now < seconds:
            self._arrive()
            if self.worker._backlog._unfinished:
                self.worker._step()
            else:
                self.now = self._number * PERIOD

    def _arrive(self) -> None:
        """All that comes until now."""
        while self._number * PERIOD <= self.now:
            number, self._number = self._number, next(self._next)
            self.worker.put_unread(lambda n=number: self._read(n), 100)
            self.waiting.append(self.worker._backlog._unfinished + len(self.worker._order._waiting))

    def _read(self, number: int) -> Item:
        self.now += READING
        if self._bad_every and number % self._bad_every == 0:
            raise ValueError('bad')
        return Item(round(number * PERIOD * 1e9), number * PERIOD)

    def _work(self, item: Item) -> Item:
        self.now += self._costs.choice((0.1, 1.3, 1.3, 1.3)) * COST
        self._arrive()
        return item


@pytest.mark.parametrize('window', [0.0, 0.3])
@pytest.mark.parametrize('bad_every', [0, 4, 2])
def test_the_output_of_an_overloaded_worker_is_never_old_and_little_waits(
    monkeypatch, window, bad_every
):
    overload = Overload(monkeypatch, window, bad_every)
    overload.run(10.0)
    settled = overload.ages[20:]  # until then nobody can tell what an item costs
    assert len(settled) > 500
    assert max(settled) < 0.02 + window + 1.5 * COST
    assert max(overload.waiting[len(overload.waiting) // 2 :]) <= window / PERIOD + 8
    assert overload.worker.skipped > 1000
    assert bool(overload.refused) == bool(bad_every)


def test_a_worker_that_is_fast_enough_skips_nothing_in_a_wide_window():
    done = []
    worker = Worker(lambda item: item, pytest.fail)
    worker.configure(OrderConfig(reorder_window=10.0))
    worker.then(lambda item, _: done.append(item))
    for number in range(900):
        worker.put(Item(number * 10 * MS))
        worker.settle()  # what waits for its turn is no backlog
    assert done == []
    worker.flush()
    assert len(done) == 900
    assert worker.skipped == 0
    worker.close()


def test_a_paused_worker_drops_what_arrives_and_settles():
    worker = Worker(pytest.fail, pytest.fail)
    worker.paused = True
    worker.put(Item(0))
    worker.flush()
    worker.close()


def test_an_item_on_which_the_work_or_the_reading_fails_is_refused_and_the_next_are_not():
    done, refused = [], []
    worker = Worker(lambda item: {1: 6, 2: 3}[item.stamp], refused.append)
    worker.then(lambda result, _: done.append(result))
    for stamp in (1, 0, 2):
        worker.put(Item(stamp))
        worker.put_unread(lambda: Item([][0]), 1)
    worker.flush()
    assert done == [6, 3]
    faults = sorted(reason.split('please report it: ')[1] for reason in refused)
    assert faults == [*['IndexError: list index out of range'] * 3, 'KeyError: 0']
    assert all('test_stage.py:' in reason for reason in refused)
    worker.close()


@pytest.mark.filterwarnings('ignore::pytest.PytestUnhandledThreadExceptionWarning')
def test_nobody_waits_for_a_worker_that_has_died():
    def give_up(_):
        raise SystemExit

    worker = Worker(give_up, pytest.fail)
    worker.put(Item(1))
    ended = threading.Thread(target=worker.flush)
    ended.start()
    ended.join(PATIENCE)
    assert not ended.is_alive()
    worker.close()


def test_pictures_that_wait_for_others_take_no_more_memory_than_is_allowed(monkeypatch):
    picture = np.zeros((100, 100), np.uint8)
    monkeypatch.setattr('colortrack_ros.flow.order.MAX_BYTES', 5 * picture.nbytes)
    done = []
    stage = Stage(lambda frame: done.append(frame.stamp), pytest.fail)
    stage.configure(OrderConfig(reorder_window=10.0))
    for k in range(20):
        stage.put(Frame(picture, 'mono8', k * MS))
    assert done == [k * MS for k in range(15)]
