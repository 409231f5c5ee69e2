import pytest

from colortrack_ros.flow.stamps import NO_TIME
from colortrack_ros.flow.stamps import OF_ONE_MOMENT
from colortrack_ros.flow.stamps import StampWatch


def test_stamps_that_stand_still_are_told_until_they_go_on():
    watch = StampWatch()
    assert [watch.see(0) for _ in range(OF_ONE_MOMENT)] == [''] * OF_ONE_MOMENT
    assert 'the stamps stand still at 0.000 s' in watch.see(0)
    assert watch.see(NO_TIME) == ''


def test_several_messages_of_each_moment_are_usual():
    watch = StampWatch()
    assert not any(watch.see(k // OF_ONE_MOMENT * NO_TIME) for k in range(5 * OF_ONE_MOMENT))


@pytest.mark.parametrize(('unit', 'told'), [(1, True), (33, True), (33_333, True), (10**6, False)])
def test_stamps_in_another_unit_than_nanoseconds_are_told(unit, told):
    """Numbers of pictures, milliseconds and microseconds of 30 Hz; nanoseconds of 1000 Hz."""
    watch = StampWatch()
    seen = [watch.see(k * unit) for k in range(5 * OF_ONE_MOMENT)]
    assert bool(seen[-1]) == told
