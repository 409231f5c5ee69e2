from colortrack_ros.flow.completion import Completion
from colortrack_ros.flow.completion import MOST_INCOMPLETE


class Post:
    """Items are complete once their number is known; a clock of its own."""

    def __init__(self):
        self.now, self.known, self.out = 0.0, 0, []
        self.waiting = Completion(
            self.complete, lambda item, context: self.out.append((item, context)), 0.5,
            lambda: self.now,
        )  # fmt: skip

    def complete(self, item, over):
        if item <= self.known:
            return f'{item} complete'
        return f'{item} alone' if over else None


def test_items_wait_until_they_are_complete_and_keep_their_order():
    post = Post()
    for item in (2, 1, 3):
        post.waiting.put(item, f'of {item}')
    assert post.out == []
    post.known = 2
    post.waiting.look()
    assert post.out == [('2 complete', 'of 2'), ('1 complete', 'of 1')]


def test_an_item_goes_on_alone_when_it_has_waited_too_long():
    post = Post()
    post.waiting.put(1)
    post.now = 0.4
    post.waiting.put(2)
    post.now = 0.6
    post.waiting.look()
    assert post.out == [('1 alone', None)]


def test_a_clock_that_has_gone_back_holds_nobody_up():
    post = Post()
    post.now = 10.0
    post.waiting.put(1)
    post.now = 1.0
    post.waiting.look()
    assert post.out == [('1 alone', None)]


def test_where_time_stands_still_no_more_wait_than_there_is_room_for():
    post = Post()
    for item in range(1, MOST_INCOMPLETE + 11):
        post.waiting.put(item)
    assert len(post.out) == 10


def test_when_nothing_more_comes_all_go_on():
    post = Post()
    for item in (1, 2):
        post.waiting.put(item)
    post.waiting.flush()
    assert [item for item, _ in post.out] == ['1 alone', '2 alone']
