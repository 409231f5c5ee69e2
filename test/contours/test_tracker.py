from dataclasses import replace

import numpy as np
import pytest
from support.contour_pictures import corners_of
from support.contour_pictures import EMPTY
from support.contour_pictures import errors
from support.contour_pictures import follow
from support.contour_pictures import frame
from support.contour_pictures import known
from support.contour_pictures import only
from support.contour_pictures import overlap
from support.contour_pictures import picture
from support.contour_pictures import pictures
from support.contour_pictures import QUICK
from support.contour_pictures import SHAPES
from support.contour_pictures import straight
from support.contour_pictures import texture

from colortrack_ros.contours import ContourTracker
from colortrack_ros.data import COASTING
from colortrack_ros.data import CONFIRMED
from colortrack_ros.data import TRACK


@pytest.mark.slow
@pytest.mark.parametrize(
    ('shape', 'width', 'level'),
    [
        ('person', 30, 45),
        ('quadrilateral', 30, 120),
        ('person', 80, 120),
        ('quadrilateral', 80, 45),
    ],
)
def test_a_target_behind_a_cover_comes_back_with_its_shape(shape, width, level):
    cover = (slice(None), slice(150, 150 + width)), level
    results = follow(pictures(shape, 110, cover=cover), QUICK)
    assert {i for t in results for i in t.rows['track_id'][known(t)].tolist()} <= {1, 2}
    assert results[-1].rows['track_id'].tolist() == [1]
    seen = errors(shape, [only(1, tracks) for tracks in results], straight)
    states = np.concatenate([tracks.rows['state'] for tracks in results])
    assert COASTING in states or width == 30
    assert seen[:, 1].max() < 5.0
    assert seen[-8:, 1].max() < 0.7
    assert seen[-8:, 2].min() > 0.92


@pytest.mark.slow
def test_a_target_that_was_growing_keeps_its_size_while_it_is_hidden():
    def place(k):
        return (40 + 2.5 * max(k - EMPTY, 0), 120.0), 20 + 0.3 * max(k - EMPTY, 0)

    cover = (slice(None), slice(150, 240)), 120
    results = follow(
        pictures('quadrilateral', 75, place, cover=cover), replace(QUICK, min_score=0.0)
    )
    rows = np.concatenate([tracks.rows for tracks in results])
    hidden = np.flatnonzero(rows['state'] == COASTING)
    assert len(hidden) > 5
    np.testing.assert_allclose(rows['area'][hidden[1:]], rows['area'][hidden[0]], rtol=1e-4)
    assert rows['area'][hidden[0]] > 1.5 * rows['area'][0]


@pytest.mark.slow
@pytest.mark.parametrize(('shape', 'speed'), [('person', 4), ('quadrilateral', 1)])
def test_once_a_target_is_known_the_background_may_move(shape, speed):
    wide = texture(3, 240, 320 + 4 * 110)
    shown = []
    for k, at in enumerate(max(0, k - 20) * speed for k in range(100)):
        place = straight(k) if k >= EMPTY else (None, 0)
        shown.append(picture(shape, *place, background=wide[:, at : at + 320], seed=k))
    results = follow(shown, QUICK)
    seen = errors(shape, results, straight)
    assert len(seen) > 80
    assert seen[:, 1].max() < 1.0
    assert seen[:, 2].min() > 0.92


def turning(k):
    return (100.0 + 0.5 * max(k - EMPTY, 0), 120.0), 30.0, np.tan(0.45 * (1 - np.cos(0.04 * k)))


@pytest.mark.slow
@pytest.mark.parametrize('shape', SHAPES)
def test_what_turns_is_followed_with_rotation(shape):
    shown = pictures(shape, 100, turning)
    seen = errors(shape, follow(shown, replace(QUICK, rotation=True)), turning)
    assert seen[:, 1].max() < 1.0
    assert seen[:, 2].min() > 0.9
    without = follow(shown, QUICK)
    still = [overlap(t.outlines[0], corners_of(shape, *turning(k)))
             for k, t in enumerate(without) if len(t.rows) == 1]  # fmt: skip
    assert min(still) < 0.8


@pytest.mark.slow
def test_targets_of_a_robot_that_slows_down_and_turns_round_are_kept():
    def place(k):
        return (160 + 90 * np.sin(0.06 * k), 120.0), 26.0

    results = follow(pictures('quadrilateral', 140, place), QUICK)
    seen = errors('quadrilateral', results, place)
    assert {int(i) for tracks in results for i in tracks.rows['track_id']} == {1}
    assert seen[5:, 1].max() < 0.6


def test_a_track_has_the_fields_of_its_message():
    tracker = ContourTracker(QUICK)
    for k, image in enumerate(pictures('quadrilateral', 30)):
        tracks = tracker.update(replace(frame(image, k), frame_id='eye'))
    row = tracks.rows[0]
    assert tracks.rows.dtype == TRACK
    assert (tracks.stamp, tracks.frame_id) == (frame(image, 29).stamp, 'eye')
    assert tracks.outlines.shape == (1, 48, 2)
    center, radius = straight(29)
    assert (row['track_id'], row['state'], row['color']) == (1, CONFIRMED, 0)
    np.testing.assert_allclose([row['u'], row['v']], center, atol=0.3)
    np.testing.assert_allclose([row['du'], row['dv']], [60, 7.2], atol=3)
    assert row['area'] == pytest.approx(np.pi * radius**2, rel=0.04)
    box = np.ptp(corners_of('quadrilateral', center, radius), axis=0)
    np.testing.assert_allclose([row['box_w'], row['box_h']], box, atol=4)
    assert row['age'] == pytest.approx((row['hits'] - 1) / 24, abs=1e-5)
    assert row['time_since_update'] == 0
    assert 0.9 < row['score'] <= 1
    assert (np.linalg.eigvalsh(row['covariance']) > 0).all()
