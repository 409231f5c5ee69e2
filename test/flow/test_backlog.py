from colortrack_ros.flow import backlog as module
from colortrack_ros.flow.backlog import Backlog


def full(costs, count, size=0):
    backlog = Backlog(max_lag=0.05)
    for seconds in costs:
        backlog.working.add(seconds)
    for item in range(count):
        backlog.put(item, size)
    return backlog


def left(backlog):
    return list(iter(lambda: backlog.next_arrival(0.0), None))


def test_a_hiccup_of_a_worker_that_is_fast_enough_loses_nothing():
    for costs in ([0.3, 0.2], [0.3, *[0.004] * 5], [0.004] * 10 + [0.3, 0.1]):
        backlog = full(costs, 10)
        assert left(backlog) == list(range(10))
        assert backlog.skipped == 0


def test_a_slow_worker_gets_the_newest_and_the_rest_is_counted():
    backlog = full([0.1] * 20, 4)
    assert left(backlog) == [3]
    assert backlog.skipped == 3


def test_a_worker_that_is_slow_for_some_items_and_refuses_others_is_slow():
    for costs in ([0.2, 0.001] * 10, [0.3, 0.001, 0.001] * 7, [0.1, 0.1, 0.1, 0.0] * 5):
        assert len(left(full(costs, 10))) <= 2


def test_items_whose_turn_it_is_are_skipped_before_newer_arrivals():
    backlog = full([0.03] * 5, 0)
    for item in 'abc':
        backlog.release(item)
    assert backlog.skipped == 0  # nothing newer wants to be worked on
    backlog.put('d')
    assert (backlog.next_ready(), left(backlog), backlog.skipped) == (None, ['d'], 3)


def test_what_waits_is_bounded_however_long_it_may_take(monkeypatch):
    monkeypatch.setattr(module, 'MAX_ITEMS', 7)
    monkeypatch.setattr(module, 'MAX_BYTES', 1000)
    assert left(full([], 20)) == list(range(13, 20))
    assert left(full([], 20, size=300)) == [17, 18, 19]
    assert left(full([], 1, size=3000)) == [0]


def test_closing_ends_the_waiting():
    backlog = full([], 3)
    backlog.close()
    assert backlog.next_arrival(60.0) is None
    backlog.join()


def test_waiting_ends_after_the_timeout():
    assert Backlog().next_arrival(timeout=0.01) is None
