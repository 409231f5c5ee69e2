from colortrack_ros.flow.stamps import OF_ONE_MOMENT
from colortrack_ros.flow.stamps import StampWatch


def test_stamps_that_stand_still_are_told_until_they_go_on():
    watch = StampWatch()
    assert [watch.see(0) for _ in range(OF_ONE_MOMENT)] == [''] * OF_ONE_MOMENT
    assert 'the stamps stand still at 0.000 s' in watch.see(0)
    assert watch.see(1) == ''


def test_several_messages_of_each_moment_are_usual():
    watch = StampWatch()
    assert not any(watch.see(k // OF_ONE_MOMENT) for k in range(5 * OF_ONE_MOMENT))
