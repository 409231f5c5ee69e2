from colortrack_ros.flow.backlog import Backlog


def test_nothing_is_skipped_while_the_work_is_fast():
    backlog = Backlog(max_lag=0.05)
    for seconds in (0.3, 0.004, 0.2, 0.004, 0.004):
        backlog.took(seconds)
    for item in range(10):
        backlog.put(item)
    assert [backlog.get() for _ in range(10)] == list(range(10))
    assert backlog.skipped == 0


def test_a_slow_worker_gets_the_newest_and_the_rest_is_counted():
    backlog = Backlog(max_lag=0.05)
    for _ in range(20):
        backlog.took(0.1)
    for item in range(4):
        backlog.put(item)
    assert backlog.get() == 3
    assert backlog.skipped == 3


def test_closing_ends_the_waiting():
    backlog = Backlog()
    backlog.close()
    assert backlog.get() is None
    assert backlog.closed


def test_waiting_ends_after_the_timeout():
    assert Backlog().get(timeout=0.01) is None
