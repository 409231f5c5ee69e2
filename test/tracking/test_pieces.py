"""A blob that breaks into pieces is one object, at the center of all of them."""

import numpy as np
import pytest
from support.silhouettes import FRAME
from support.silhouettes import points

from colortrack_ros.tracking import Tracker

WHOLE = (160.0, 200.0, 219.0, 239.0)
"""left, top, right, bottom [px]"""


def of_boxes(boxes, k, color=0):
    """Return the detections of a frame, one in the middle of each box."""
    box = np.asarray(boxes, float)
    detections = points((box[:, :2] + box[:, 2:]) / 2, k * FRAME, 1.0)
    rows = detections.rows
    rows['box_u'], rows['box_v'] = box[:, :2].T
    rows['box_w'], rows['box_h'] = (box[:, 2:] - box[:, :2] + 1).T
    rows['area'], rows['color'] = rows['box_w'] * rows['box_h'], color
    return detections


def after(pieces, color=0):
    """Return the tracks after 24 frames of the whole and 6 of the pieces."""
    tracker = Tracker()
    for k in range(24):
        tracker.update(of_boxes([WHOLE], k))
    for k in range(24, 30):
        rows = tracker.update(of_boxes(pieces, k, color)).rows
    return rows


@pytest.mark.parametrize('step', [1, -1], ids=['left first', 'right first'])
@pytest.mark.parametrize('widths', [(40, 12), (26, 26), (12, 40), (18, 16, 18)])
def test_pieces_side_by_side_are_one_object_in_the_middle_of_them(widths, step):
    gap = (60 - sum(widths)) / (len(widths) - 1)
    left = 160 + np.concatenate([[0], np.cumsum(widths[:-1])]) + gap * np.arange(len(widths))
    pieces = [(u, 200, u + width - 1, 239) for u, width in zip(left, widths, strict=True)]
    rows = after(pieces[::step])
    assert rows['track_id'].tolist() == [1]
    assert (rows['u'][0], rows['v'][0]) == pytest.approx((189.5, 219.5), abs=0.5)
    assert (rows['box_w'][0], rows['box_h'][0]) == pytest.approx((60, 40), abs=1)
    assert rows['area'][0] == 40 * sum(widths)
    assert rows['covariance'][0, 0, 0] < 2


@pytest.mark.parametrize('aside', [(0, 60), (60, 0)])
def test_what_does_not_fit_into_the_object_is_no_piece_of_it(aside):
    other = np.array([200, 200, 219, 239]) + np.tile(aside, 2)
    rows = after([(160, 200, 195, 239), other])
    assert len(rows) == 2


def test_what_has_another_color_is_no_piece():
    rows = after([(160, 200, 195, 239), (200, 200, 219, 239)], color=[0, 1])
    assert sorted(rows['color'].tolist()) == [0, 1]


@pytest.mark.parametrize(('frames', 'left'), [(4, 1), (60, 2)])
def test_what_was_seen_briefly_inside_an_object_is_not_still_in_it_when_it_has_grown(frames, left):
    tracker = Tracker()
    part, piece, whole = (480, 285, 519, 324), (500, 300, 533, 311), (475, 285, 533, 331)
    for k in range(24):
        tracker.update(of_boxes([part], k))
    for k in range(24, 24 + frames):
        rows = tracker.update(of_boxes([part, piece], k)).rows
    assert len(rows) == 2
    for k in range(24 + frames, 40 + frames):
        rows = tracker.update(of_boxes([whole], k)).rows
    assert len(rows) == left
