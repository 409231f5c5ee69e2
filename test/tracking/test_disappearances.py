"""Hidden objects are told from gone ones by what became of others."""

import numpy as np
import pytest
from support.silhouettes import FRAME
from support.silhouettes import points

from colortrack_ros.data import COASTING
from colortrack_ros.estimation.existence import HIDDEN_SHARE
from colortrack_ros.estimation.existence import predict_existence
from colortrack_ros.estimation.existence import update_existence
from colortrack_ros.estimation.existence import weigh_hidden
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig
from colortrack_ros.tracking.disappearances import Disappearances


def test_nothing_is_known_before_anything_has_disappeared():
    assert Disappearances(1.5).share(np.zeros((3, 2)), 9e5) == pytest.approx([HIDDEN_SHARE] * 3)


def test_a_cover_hides_and_the_open_does_not():
    learned, rng = Disappearances(1.5), np.random.default_rng(0)
    learned.learn(rng.normal((100, 100), 5, (10, 2)), np.full(10, 0.5), returned=True)
    learned.learn(rng.normal((500, 100), 5, (10, 2)), np.full(10, 1.5), returned=False)
    cover, open_air, elsewhere = learned.share(
        np.array([[100, 100], [500, 100], [300, 400.0]]), 9e5
    )
    assert cover > 0.9
    assert open_air < 0.1
    assert 0.3 < elsewhere < 0.7


def test_what_is_long_ago_is_forgotten():
    learned, place = Disappearances(1.5), np.full((200, 2), 50.0)
    learned.learn(place, np.full(200, 1.5), returned=False)
    learned.learn(place, np.full(200, 0.5), returned=True)
    assert learned.share(place[:1], 9e5) > 0.98


@pytest.mark.parametrize('dt', [0.03, 15.0, 60.0, 3600.0])
def test_chances_stay_chances_whatever_time_has_passed(dt):
    shares = np.array([0.0, 0.3, 1.0])
    visible, hidden = predict_existence(shares, 1 - shares, dt, 1.5)
    assert (visible >= 0).all()
    assert (hidden >= 0).all()
    assert (visible + hidden <= 1 + 1e-12).all()


@pytest.mark.parametrize('share', [0.02, 0.5, HIDDEN_SHARE, 0.99])
def test_weighed_by_the_share_existence_of_what_is_missed_goes_to_it(share):
    """It has just been missed often enough to be invisible, and could not have reappeared yet."""
    one = np.ones(1)
    visible, hidden = predict_existence(one, 0 * one, 1e-3, 1.5)
    visible, hidden = update_existence(visible, hidden, 1e-9 * one)
    visible, hidden = weigh_hidden(visible, hidden, share * one)
    assert visible + hidden == pytest.approx([share], abs=1e-3)
    assert (visible + hidden <= 1).all()


def shown(config, come_back):
    """Return for how many unseen frames the sixth is shown, after five did or did not return."""
    tracker, count = Tracker(config), 0
    for k in range(40 * 12):
        turn, t = divmod(k, 80)
        away = t >= 20 and (turn == 5 or not come_back or t < 35)
        detections = points([] if away else [(300, 200)], k * FRAME)
        rows = tracker.update(detections).rows
        count += turn == 5 and bool((rows['state'] == COASTING).any())
    return count


@pytest.mark.slow
def test_what_is_lost_where_others_came_back_is_shown_and_where_they_were_gone_is_not():
    assert shown(TrackerConfig(), come_back=True) >= 15
    assert shown(TrackerConfig(), come_back=False) <= 5


@pytest.mark.slow
def test_without_a_least_score_it_is_shown_for_its_whole_time():
    assert shown(TrackerConfig(min_score=0.0), come_back=False) >= 30


def test_a_track_that_is_not_published_any_more_comes_back_with_its_id():
    tracker = Tracker(TrackerConfig(min_score=0.9))
    for k in range(20):
        tracker.update(points([(300, 200)], k * FRAME))
    hidden = [len(tracker.update(points([], k * FRAME)).rows) for k in range(20, 40)]
    assert sum(hidden) < 5
    assert tracker.update(points([(300, 200)], 40 * FRAME)).rows['track_id'].tolist() == [1]


def least_score(seen):
    """Return the least score of eight objects after ten frames in which z[seen] is detected."""
    tracker, z = Tracker(TrackerConfig(min_score=0.0)), [(100 * i, 200) for i in range(8)]
    for k in range(30):
        tracker.update(points(z, k * FRAME))
    for k in range(30, 40):
        rows = tracker.update(points(z[seen], k * FRAME)).rows
    return rows['score'].min()


def test_to_be_missed_with_all_others_says_less_than_to_be_missed_alone():
    assert least_score(slice(0)) > 0.9 > least_score(slice(7))


def test_that_several_do_not_come_back_is_seen_long_before_their_time_is_over():
    """Eight of twelve are removed, one every second frame; ten frames later none is coasted."""
    tracker, z = Tracker(), [(100 * i + 50, 200) for i in range(12)]
    for k in range(55):
        left = z[min(max(k - 28, 0) // 2, 8) :]
        states = tracker.update(points(left, k * FRAME)).rows['state']
    assert len(states) == 4
    assert not (states == COASTING).any()


def test_that_one_does_not_come_back_does_not_tell_of_itself():
    learned, place = Disappearances(1.5), np.array([[300.0, 200.0]])
    alone = learned.share(place, 9e5, np.array([[0.1, 0.9]]))
    assert alone == pytest.approx([HIDDEN_SHARE])
    beside = learned.share(np.repeat(place, 2, axis=0), 9e5, np.array([[0.1, 0.9]] * 2))
    assert (beside < 0.5).all()


def test_the_longer_others_were_hidden_the_longer_what_is_lost_may_come_back():
    odds, one = [], np.ones(1)
    for time in (0.3, 3.0):
        learned = Disappearances(1.5)
        learned.learn(np.zeros((20, 2)), np.full(20, time), returned=True)
        odds.append(learned.return_odds(0.5 * one, 4 * one, 4 * one, 0.95, 1 / 30)[0])
    assert odds[1] > 2 * odds[0]


def test_who_has_been_given_up_and_comes_back_after_all_tells_of_the_others():
    learned, place = Disappearances(1.5), np.array([[100.0 * k, 200.0] for k in range(6)])
    learned.learn(place, np.full(6, 1.5), returned=False)
    before = learned.share_of_deleted(place[5:], 9e5)
    learned.rejoin(place[:5], np.full(5, 3.0), 1 / 30, in_time=False)
    assert before < 0.5 < learned.share_of_deleted(place[5:], 9e5)
