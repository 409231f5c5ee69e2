"""Colors with a known number of objects."""

import numpy as np
import pytest
from support.silhouettes import FRAME
from support.silhouettes import points

from colortrack_ros.data import TENTATIVE
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig

SIZE = (640, 480)


def tracker_of(*population, **options):
    return Tracker(TrackerConfig(population=population, image_size=SIZE, **options))


def play(tracker, z, frames, begin=0, color=0, every=1):
    """Show z, (N, 2), in every k-th of some frames; return the rows of the last one."""
    for k in range(begin, begin + frames, every):
        rows = tracker.update(points(z, k * FRAME, 0.5, color)).rows
    return rows


def test_the_ids_are_one_to_n_and_what_has_none_yet_is_not_published():
    tracker, z = tracker_of(3), [(100, 100), (300, 200), (500, 300)]
    for k in range(10):
        rows = tracker.update(points(z, k * FRAME, 0.5)).rows
        assert rows['track_id'].tolist() == ([1, 2, 3] if k >= 2 else [])
        assert (rows['state'] != TENTATIVE).all()


def test_the_next_color_goes_on_from_there_and_others_take_what_follows():
    tracker = tracker_of(2, 0, 1)
    colors = np.array([0, 0, 1, 2, 7])
    z = [(100 * (i + 1), 50 * (i + 1)) for i in range(5)]
    rows = play(tracker, z, 10, color=colors)
    ids = {color: sorted(rows['track_id'][rows['color'] == color].tolist()) for color in colors}
    assert ids[0] == [1, 2]
    assert ids[2] == [3]
    assert len(ids[1] + ids[7]) == 2
    assert min(ids[1] + ids[7]) > 3


def test_one_too_many_has_no_id_and_takes_none_away():
    tracker, z = tracker_of(2), [(100, 100), (300, 200)]
    play(tracker, z, 20)
    rows = play(tracker, [*z, (500, 300)], 60, begin=20)
    assert rows['track_id'].tolist() == [1, 2]
    assert rows['u'] == pytest.approx([100, 300], abs=1)


@pytest.mark.slow
@pytest.mark.parametrize('max_hidden', [0.0, 6.0])
def test_the_only_one_comes_back_anywhere_after_any_time_as_itself(max_hidden):
    tracker = tracker_of(1, max_hidden=max_hidden)
    play(tracker, [(100, 100)], 20)
    play(tracker, [], 2000, begin=20, every=5)
    assert play(tracker, [(600, 20)], 10, begin=2020)['track_id'].tolist() == [1]


def test_one_that_has_left_the_picture_comes_back_as_itself():
    tracker = tracker_of(1)
    for k in range(200):
        u = 560 + 5.0 * k if k < 17 else 640 - 3.0 * (k - 150)
        seen = k < 16 or k > 150
        rows = tracker.update(points([(u, 200)] if seen else [], k * FRAME, 0.5)).rows
    assert rows['track_id'].tolist() == [1]


def test_of_two_that_are_away_the_likelier_comes_back():
    tracker, z = tracker_of(2), [(100, 100), (500, 400)]
    play(tracker, z, 20)
    play(tracker, [], 60, begin=20)
    assert play(tracker, [(510, 390)], 10, begin=80)['track_id'].tolist() == [2]
    assert play(tracker, [(510, 390), (110, 90)], 10, begin=90)['track_id'].tolist() == [1, 2]


def test_a_false_one_gives_its_id_back_to_the_true():
    tracker, z = tracker_of(1), [(500, 400)]
    play(tracker, [(100, 100)], 5)
    rows = play(tracker, z, 60, begin=5)
    assert rows['track_id'].tolist() == [1]
    assert rows['u'] == pytest.approx([500], abs=1)


def test_after_a_reset_and_another_population_the_ids_are_one_to_n_again():
    tracker, z = tracker_of(2), [(100, 100), (300, 200), (500, 300)]
    play(tracker, z[:2], 20)
    tracker.reset('test')
    assert play(tracker, z[:2], 10, begin=20)['track_id'].tolist() == [1, 2]
    tracker.configure(TrackerConfig(population=(3,)))
    tracks = tracker.update(points(z, 30 * FRAME, 0.5))
    assert 'population changed' in tracks.restarted
    assert play(tracker, z, 10, begin=31)['track_id'].tolist() == [1, 2, 3]


def test_a_population_below_zero_is_refused():
    with pytest.raises(ValueError, match='population'):
        TrackerConfig(population=(-1,))
