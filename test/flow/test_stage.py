"""Stages of the chain, and what overload, disorder and bad input do to one with a thread."""

import threading
import time
from typing import NamedTuple

import numpy as np
import pytest
from support.waiting import PATIENCE

from colortrack_ros.data import Frame
from colortrack_ros.flow.order import OrderConfig
from colortrack_ros.flow.stage import Stage
from colortrack_ros.flow.stage import Worker

MS = 1_000_000
PERIOD, COST = 0.002, 0.01
"""Of arrivals and of the work on one [s]: five times what the worker can do."""


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


def overload(window, *, bad_every=0, seconds=1.5):
    """How old each result of an overloaded worker is [s], how many wait, and what was refused."""
    ages, waiting, refused = [], [], []

    def work(item):
        time.sleep(COST)
        return item

    def read(number):
        if bad_every and number % bad_every == 0:
            raise ValueError('bad')
        return Item(round(number * PERIOD * 1e9), time.monotonic())

    worker = Worker(work, refused.append)
    worker.configure(OrderConfig(reorder_window=window))
    worker.max_lag = 0.02
    born = {}
    worker.then(lambda item, _: ages.append(time.monotonic() - born[item.stamp]))
    start = time.monotonic()
    for number in range(round(seconds / PERIOD)):
        born[round(number * PERIOD * 1e9)] = time.monotonic()
        worker.put_unread(lambda number=number: read(number), 100)
        waiting.append(worker._backlog._unfinished + len(worker._order._waiting))
        time.sleep(max(start + number * PERIOD - time.monotonic(), 0.0))
    worker.close()
    return np.array(ages), np.array(waiting), refused, worker.skipped


@pytest.mark.alone
@pytest.mark.parametrize('window', [0.0, 0.3])
@pytest.mark.parametrize('bad_every', [0, 4, 2])
def test_the_output_of_an_overloaded_worker_is_never_old_and_little_waits(window, bad_every):
    ages, waiting, refused, skipped = overload(window, bad_every=bad_every)
    settled = ages[20:]  # until then nobody can tell what an item costs
    assert len(settled) > 20
    assert settled.max() < 0.02 + window + 10 * COST
    assert waiting[len(waiting) // 2 :].max() <= window / PERIOD + 20
    assert skipped > 100
    assert bool(refused) == bool(bad_every)


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


@pytest.mark.filterwarnings('ignore::pytest.PytestUnhandledThreadExceptionWarning')
def test_nobody_waits_for_a_worker_that_has_died():
    worker = Worker(lambda item: 1 // item.stamp, pytest.fail)
    for stamp in (1, 0, 2):
        worker.put(Item(stamp))
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
