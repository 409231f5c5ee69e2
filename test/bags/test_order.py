from hypothesis import given
from hypothesis import strategies as st

from colortrack_ros.bags import StampOrder


def played(order: StampOrder, stamps: list[int]) -> list[int]:
    out = [item for stamp in stamps for item in order.put(stamp, stamp)]
    return out + list(order.rest())


@given(st.lists(st.integers(0, 1000), unique=True), st.randoms(use_true_random=False))
def test_what_comes_within_the_window_is_put_in_its_place(stamps, random):
    stamps.sort()
    # each is delayed by at most 40, and so stands behind stamps that are at most 40 greater
    shuffled = sorted(stamps, key=lambda stamp: stamp + random.uniform(0, 40))
    order = StampOrder(window=40, restart=10**6)
    assert played(order, shuffled) == stamps
    assert order.late == order.duplicates == 0


@given(st.lists(st.integers(0, 200)), st.integers(0, 30))
def test_stamps_always_rise_and_every_item_is_given_out_or_counted(stamps, window):
    order = StampOrder(window, restart=10**6)
    out = played(order, stamps)
    assert out == sorted(set(out))
    assert len(out) + order.late + order.duplicates == len(stamps)


def test_what_comes_later_than_the_window_is_dropped_and_counted():
    order = StampOrder(window=10, restart=100)
    assert played(order, [0, 20, 40, 15, 60, 41]) == [0, 20, 40, 41, 60]
    assert (order.late, order.duplicates) == (1, 0)


def test_the_first_of_two_with_the_same_stamp_is_the_one():
    order: StampOrder[str] = StampOrder(window=10, restart=100)
    arrivals = [(0, 'a'), (20, 'b'), (20, 'c'), (15, 'd'), (40, 'e'), (20, 'f')]
    out = [item for stamp, item in arrivals for item in order.put(stamp, item)]
    assert [*out, *order.rest()] == ['a', 'd', 'b', 'e']
    assert order.duplicates == 2


def test_a_jump_far_back_is_a_new_start_and_nothing_is_dropped():
    order = StampOrder(window=10, restart=100)
    assert played(order, [1000, 1020, 1010, 0, 20, 10]) == [1000, 1010, 1020, 0, 10, 20]
    assert order.late == order.duplicates == 0
