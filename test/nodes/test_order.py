from hypothesis import given
from hypothesis import strategies as st

from colortrack_ros.nodes.order import Order

MS = 1_000_000


def order(window=0.0, max_late=0.25):
    released, refused = [], []
    order = Order(released.append, refused.append)
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
