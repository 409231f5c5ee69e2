"""Pictures that were sent and did not come are counted, and told if they are many."""

from colortrack_ros.node_kit.losses import Losses


def seen(*numbers, alone=True):
    losses = Losses()
    for number in numbers:
        losses.see(number, lambda: alone)
    return losses


def test_gaps_in_the_numbers_of_a_publisher_are_counted():
    assert seen(7, 8, 11, 12, 20).total == 2 + 7


def test_what_was_sent_before_the_first_that_came_is_not_lost():
    assert seen(500, 501).total == 0


def test_a_publisher_that_starts_again_has_lost_nothing():
    assert seen(90, 91, 1, 2, 3).total == 0


def test_numbers_of_several_publishers_say_nothing():
    assert seen(90, 1, 91, 2, 92, alone=False).total == 0


def test_a_middleware_without_numbers_is_believed():
    losses = seen(None, None, 5, None, 9)
    assert losses.total == 0
    assert losses.tell() == ''


def test_many_are_told_once_and_few_are_not():
    assert seen(*range(1, 100), 102).tell() == ''
    losses = seen(1, 4, 5)
    assert '2 of 5 pictures were lost' in losses.tell()
    assert losses.tell() == ''
