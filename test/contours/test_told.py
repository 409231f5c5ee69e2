"""Targets that somebody names, with a background at rest and without any."""

import numpy as np
import pytest
from support.contour_pictures import corners_of
from support.contour_pictures import frame
from support.contour_pictures import overlap
from support.contour_pictures import picture
from support.contour_pictures import texture

from colortrack_ros.contours import ContourConfig
from colortrack_ros.contours import ContourTracker
from colortrack_ros.contours.told import begin_in
from colortrack_ros.data import CONFIRMED
from colortrack_ros.estimation.waiting_boxes import WaitingBoxes

RADIUS = 26.0
STILL, MOVING = (0.0, 0.0), (2.0, 0.5)
ALONE = ContourConfig(start='targets')


def box_of(shape, center, radius=RADIUS):
    low, high = (f(corners_of(shape, center, radius), axis=0) for f in (np.min, np.max))
    return [*low, *(high - low + 1)]


def place(k, speed):
    return np.array([80.0, 110.0]) + k * np.asarray(speed)


@pytest.mark.slow
@pytest.mark.parametrize(
    ('shape', 'speed', 'start'),
    [
        ('person', STILL, 'targets'), ('quadrilateral', MOVING, 'targets'),
        ('quadrilateral', STILL, 'background'), ('person', MOVING, 'background'),
        ('person', STILL, 'difference'), ('quadrilateral', MOVING, 'difference'),
    ],
)  # fmt: skip
def test_what_was_named_is_followed_from_the_first_picture_whether_it_moves_or_not(
    shape, speed, start
):
    tracker = ContourTracker(ContourConfig(start=start), box_of(shape, place(0, speed)))
    for k in range(50):
        tracks = tracker.update(frame(picture(shape, place(k, speed), RADIUS, seed=k), k))
        assert tracks.rows[0]['track_id'] == 1
        assert tracks.rows[0]['state'] == CONFIRMED
    least = 0.7 if shape == 'person' else 0.9  # from an ellipse no line finds the neck
    assert overlap(tracks.outlines[0], corners_of(shape, place(49, speed), RADIUS)) > least


def test_a_camera_that_moves_keeps_what_was_named():
    """A wall of texture moves through the picture, and the target otherwise."""
    wall = texture(3, 400, 700, contrast=10.0)
    tracker = ContourTracker(ALONE, box_of('quadrilateral', place(0, (1.5, 0.0))))
    for k in range(60):
        aside = 40 + round(30 * np.sin(k / 6)), 100 + 4 * k
        background = wall[aside[0] : aside[0] + 240, aside[1] : aside[1] + 320]
        center = place(k, (1.5, 0.0))
        image = picture('quadrilateral', center, RADIUS, background=background, seed=k)
        tracks = tracker.update(frame(image, k))
    assert tracks.rows['track_id'].tolist() == [1]
    assert overlap(tracks.outlines[0], corners_of('quadrilateral', center, RADIUS)) > 0.85


def test_what_is_offered_begins_once_and_what_is_named_begins_anew_after_a_restart():
    center = (80.0, 110.0)
    box, far = box_of('person', center), box_of('quadrilateral', (230.0, 120.0))
    tracker = ContourTracker(ALONE, box)
    for k in range(12):
        tracker.offer([box, far] if k % 3 == 0 else [])
        image = np.minimum(
            picture('person', center, RADIUS, seed=k),
            picture('quadrilateral', (230.0, 120.0), RADIUS, seed=k),
        )
        tracks = tracker.update(frame(image, k))
        assert tracks.rows['track_id'].tolist() == [1, 2], k
    tracker.reset()
    tracks = tracker.update(frame(image, 12))
    assert tracks.rows['track_id'].tolist() == [3]


def test_a_target_that_moves_is_known_to_be_the_one_that_is_named():
    """It has begun by itself; a box around it makes it no second one."""
    tracker = ContourTracker(ContourConfig(learn_seconds=0.0))
    for k in range(40):
        center = None if k < 6 else place(k - 6, (2.5, 0.3))
        if k == 25:
            tracker.start(box_of('person', center))
        tracks = tracker.update(frame(picture('person', center, RADIUS, seed=k), k))
    assert tracks.rows['track_id'].tolist() == [1]


@pytest.mark.parametrize(
    'box',
    [
        [500.0, 10.0, 20.0, 20.0], [10.0, 10.0, 1.0, 20.0], [10.0, 10.0, -5.0, 20.0],
        [np.nan, 10.0, 20.0, 20.0], [10.0, 10.0, np.inf, 20.0], [1e300, 1e300, 1e300, 1e300],
    ],
)  # fmt: skip
def test_a_box_of_nothing_is_refused_and_counted(box):
    tracker = ContourTracker(ALONE, box)
    with np.errstate(all='ignore'):
        assert len(tracker.update(frame(picture(None, None, 0.0))).rows) == 0
    assert tracker.waiting.refused == 1


def test_one_too_many_is_refused():
    waiting = WaitingBoxes([[10, 10, 30, 30], [60, 10, 30, 30], [110, 10, 30, 30]])
    new, _ = begin_in(waiting, np.zeros((0, 4)), (240, 320), 2)
    np.testing.assert_array_equal(new, [[10, 10, 39, 39], [60, 10, 89, 39]])
    assert waiting.refused == 1
    assert len(waiting) == 0
