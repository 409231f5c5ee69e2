from dataclasses import replace

import numpy as np
import pytest
from support.contour_pictures import EMPTY
from support.contour_pictures import errors
from support.contour_pictures import follow
from support.contour_pictures import frame
from support.contour_pictures import known
from support.contour_pictures import picture
from support.contour_pictures import pictures
from support.contour_pictures import QUICK
from support.contour_pictures import straight

from colortrack_ros.contours import ContourConfig
from colortrack_ros.contours import ContourTracker
from colortrack_ros.data import COASTING
from colortrack_ros.data import CONFIRMED
from colortrack_ros.data import TENTATIVE


@pytest.mark.parametrize(('speed', 'within'), [(2.5, 10), (1.0, 20)])
def test_a_target_is_tentative_until_it_has_moved(speed, within):
    def place(k):
        return straight(k, speed=(speed, 0.0))

    results = follow(pictures('quadrilateral', 40, place), QUICK)
    states = [int(tracks.rows['state'][0]) for tracks in results if len(tracks.rows)]
    assert states == sorted(states)
    first = states.index(CONFIRMED)
    assert 3 <= first <= within
    assert first * speed == pytest.approx(0.3 * 52, abs=2 * speed + 4)


@pytest.mark.slow
def test_what_trembles_in_its_place_is_never_confirmed():
    def place(k):
        return (160.0 + 3 * (-1) ** k, 120 + 3 * (-1) ** (k // 2)), 20 + 2 * (k % 2)

    results = follow(pictures('quadrilateral', 120, place), QUICK)
    assert not any(known(tracks).any() for tracks in results)


def test_without_min_motion_a_third_measurement_confirms():
    results = follow(pictures('quadrilateral', 20), replace(QUICK, min_motion=0.0))
    states = [int(tracks.rows['state'][0]) for tracks in results if len(tracks.rows)]
    assert states[:4] == [TENTATIVE, TENTATIVE, CONFIRMED, CONFIRMED]


@pytest.mark.parametrize('radius', [9.0, 18.0])
def test_what_is_small_has_to_be_there_for_longer(radius):
    def place(k):
        return straight(k, speed=(3.0, 0.0), radius=radius)

    results = follow(pictures('quadrilateral', 40, place), QUICK)
    live = [tracks for tracks in results if len(tracks.rows)]
    first = [known(tracks).any() for tracks in live].index(True)
    (row,) = live[first].rows
    assert row['age'] == pytest.approx(np.sqrt(QUICK.min_area / row['area']), abs=0.06)


@pytest.mark.slow
def test_what_moved_before_it_was_there_for_long_is_confirmed_though_it_stands():
    def place(k):
        return (100.0 + 3 * min(k - EMPTY, 6), 120.0), 9.0

    results = follow(pictures('quadrilateral', 60, place), QUICK)
    (row,) = results[-1].rows
    assert row['state'] == CONFIRMED


@pytest.mark.slow
def test_what_was_put_somewhere_is_never_confirmed():
    results = follow(pictures('quadrilateral', 120, lambda k: ((160.0, 120.0), 20.0)), QUICK)
    assert not any(known(tracks).any() for tracks in results)


def test_a_tentative_target_that_is_not_seen_again_is_dropped_at_once():
    shown = pictures('quadrilateral', 20)
    first = [len(tracks.rows) for tracks in follow(shown, QUICK)].index(1)
    empty = pictures('quadrilateral', EMPTY)
    results = follow(shown[: first + 1] + empty, QUICK)
    assert [len(tracks.rows) for tracks in results[first:]] == [1] + [0] * len(empty)


def test_frame_differencing_starts_targets_as_well():
    config = ContourConfig(start='difference', start_interval=0.8)

    def place(k):  # there from the beginning
        return (40.0 + 3 * k, 60.0), 16.0

    shown = [picture('quadrilateral', *place(k), seed=k) for k in range(60)]
    results = follow(shown, config)
    (row,) = results[-1].rows
    assert np.hypot(row['u'] - place(59)[0][0], row['v'] - place(59)[0][1]) < 0.5


@pytest.mark.slow
def test_what_was_there_from_the_beginning_leaves_no_ghost():
    def place(k):
        return (60 + 3.0 * k, 120.0), 26.0

    shown = [picture('quadrilateral', *place(k), seed=k) for k in range(70)]
    results = follow(shown, ContourConfig())
    rows = results[-1].rows
    assert len(rows) == 1
    assert abs(rows['u'][0] - place(69)[0][0]) < 0.5


@pytest.mark.slow
def test_what_moves_is_tentative_while_the_background_is_learned():
    tracker, shown = ContourTracker(ContourConfig()), pictures('quadrilateral', 60)
    results = [tracker.update(frame(image, k)) for k, image in enumerate(shown)]
    learned = round(1.5 * 24)
    assert not any(known(tracks).any() for tracks in results[:learned])
    assert all(known(tracks).any() for tracks in results[learned:])
    tracker.learn_background()
    assert known(tracker.update(frame(shown[-1], 60))).any()


@pytest.mark.slow
def test_a_target_that_is_gone_coasts_and_is_given_up_in_time():
    shown = pictures('quadrilateral', 30) + pictures('quadrilateral', EMPTY)[:1] * 30
    config = replace(QUICK, max_time_since_update=0.5)
    for least, count in ((0.0, 12), (0.5, 2)):
        results = follow(shown, replace(config, min_score=least))
        states = [tracks.rows['state'].tolist() for tracks in results[30:]]
        assert states == [[COASTING]] * count + [[]] * (30 - count)


@pytest.mark.slow
def test_what_is_gone_where_the_background_has_edges_is_given_up_all_the_same():
    wall = np.full((240, 320), 215.0)
    wall[90:150, 100:160] = 120
    shown = pictures('quadrilateral', 46, background=wall)
    shown += [picture('quadrilateral', None, 0.0, background=wall, seed=k) for k in range(60)]
    results = follow(shown, QUICK)
    assert known(results[40]).any()
    assert not len(results[-1].rows)


@pytest.mark.slow
def test_a_target_ends_when_it_leaves_the_picture_and_ids_go_on():
    def place(k):
        return (300 - 5.0 * ((k * 1.0 - EMPTY) % 64), 120.0), 20.0

    results = follow(pictures('quadrilateral', 2 * 64 + 50, place), QUICK)
    ids = [tracks.rows['track_id'][known(tracks)].tolist() for tracks in results]
    assert max(map(len, ids)) == 1
    seen = [i for own in ids for i in own]
    assert (len(set(seen)), seen) == (3, sorted(seen))


@pytest.mark.slow
def test_a_target_starts_while_it_comes_in_and_is_followed_to_the_border():
    def place(k):
        return (-30 + 4.0 * (k - EMPTY), 120.0), 26.0

    results = follow(pictures('quadrilateral', 110, place), QUICK)
    seen = errors('quadrilateral', results, place)
    first, last = (place(int(k))[0][0] for k in seen[[0, -1], 0])
    assert first < 26
    assert last > 320 - 26
    inside = [one for one in seen if 40 < place(int(one[0]))[0][0] < 280]
    assert max(one[1] for one in inside) < 1.0
    assert {i for t in results for i in t.rows['track_id'][known(t)].tolist()} == {1}


def test_what_crosses_the_picture_in_half_a_second_is_followed():
    def place(k):
        return (-30 + 30.0 * (k - EMPTY), 120.0), 26.0

    results = follow(pictures('quadrilateral', 20, place), QUICK)
    seen = errors('quadrilateral', results, place)
    assert len(seen) >= 6
    assert seen[:, 2].mean() > 0.5
