from hypothesis import given
from hypothesis import strategies as st
import pytest

from colortrack_ros.flow.order import Order

MS = 1_000_000


def order(window=0.0, max_late=0.25, clock=lambda: 0.0):
    released, refused = [], []
    order = Order(released.append, refused.append, clock)
    order.window, order.max_late = window, max_late
    return order, released, refused


def push(order, *milliseconds):
    for stamp in milliseconds:
        order.push(stamp * MS, stamp)


def test_what_comes_in_order_goes_at_once():
    one, released, refused = order()
    push(one, 0, 40, 80, 80, 120)
    assert released == [0, 40, 80, 80, 120]
    assert refused == []


def test_what_is_late_is_dropped_with_a_reason():
    one, released, refused = order()
    push(one, 0, 80, 40, 120)
    assert released == [0, 80, 120]
    assert len(refused) == 1
    assert '0.040 s older' in refused[0]


def test_what_is_late_within_the_window_is_put_in_its_place():
    one, released, refused = order(window=0.1)
    push(one, 0, 80, 40, 120, 160, 200)
    assert released == [0, 40, 80]
    one.flush()
    assert released == [0, 40, 80, 120, 160, 200]
    assert refused == []


def test_time_that_goes_back_by_more_starts_a_new_order():
    for window in (0.0, 0.1):
        one, released, refused = order(window)
        push(one, 5000, 5040, 0, 40)
        one.flush()
        assert released == [5000, 5040, 0, 40]
        assert refused == []


@given(st.permutations(range(0, 400, 40)))
def test_a_wide_window_sorts_everything(stamps):
    one, released, refused = order(window=1.0)
    push(one, *stamps)
    one.flush()
    assert released == sorted(stamps)
    assert refused == []


@pytest.mark.slow
@given(st.lists(st.integers(0, 1000), unique=True), st.randoms(use_true_random=False))
def test_what_comes_within_the_window_is_put_in_its_place(stamps, random):
    stamps.sort()
    # each is delayed by at most 40, and so stands behind stamps that are at most 40 greater
    shuffled = sorted(stamps, key=lambda stamp: stamp + random.uniform(0, 40))
    one, released, refused = order(window=0.04, max_late=10.0)
    push(one, *shuffled)
    one.flush()
    assert released == stamps
    assert refused == []


@given(st.lists(st.integers(0, 200)), st.integers(0, 30))
def test_stamps_never_fall_and_every_item_is_given_out_or_refused(stamps, window):
    one, released, refused = order(window / 1000, max_late=10.0)
    push(one, *stamps)
    one.flush()
    assert released == sorted(released)
    assert len(released) + len(refused) == len(stamps)


@given(st.lists(st.integers(0, 200)), st.integers(0, 30), st.integers(0, 30))
def test_what_is_in_order_already_stays_as_it_is(stamps, window, max_late):
    first, released, _ = order(window / 1000, max_late / 1000)
    push(first, *stamps)
    first.flush()
    second, again, refused = order(window / 1000, max_late / 1000)
    push(second, *released)
    second.flush()
    assert (again, refused) == (released, [])


def test_what_waits_is_released_when_nothing_comes_for_the_time_of_the_window():
    now = [7.0]
    one, released, _ = order(window=0.1, clock=lambda: now[0])
    push(one, 0, 40)
    for later, count in ((0.0, 0), (0.05, 0), (0.1, 2)):
        now[0] += later
        one.look()
        assert len(released) == count
    push(one, 80)
    now[0] = 1.0  # the clock of a recording that plays again
    one.look()
    assert released == [0, 40, 80]
