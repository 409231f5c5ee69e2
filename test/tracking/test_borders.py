"""Where the picture ends if its size is not given."""

import numpy as np
import pytest

from colortrack_ros.data import DETECTION
from colortrack_ros.data import Detections
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig
from colortrack_ros.tracking.adaptation import Adaptation
from colortrack_ros.tracking.measurements import accept


def row_of(u, v, width, height, sigma=20.0):
    """Return a detection with this low corner and this standard deviation of the centroid [px]."""
    rows = np.zeros(1, DETECTION)
    rows['box_u'], rows['box_v'], rows['box_w'], rows['box_h'] = u, v, width, height
    rows['u'], rows['v'] = u + (width - 1) / 2, v + (height - 1) / 2
    rows['cov_uu'] = rows['cov_vv'] = sigma**2
    return rows


def cut(boxes, **options):
    """Return, by axis, whether the last of some boxes counts as cut; the size is unknown."""
    learned = Adaptation(1.5)
    for box in boxes:
        blobs = accept(row_of(*box, **options), TrackerConfig(), learned)
    return blobs.cut[0].tolist()


ENTERING = [(640 - width, 100, width, 30) for width in (4, 9, 14)]


def test_boxes_of_several_sizes_that_end_at_one_line_are_cut_there():
    assert cut(ENTERING) == [True, False]
    assert cut(ENTERING[:1]) == [False, False]


def test_a_box_that_stands_at_the_outermost_line_is_not_cut():
    assert cut([(610, 100, 30, 30)] * 9) == [False, False]


def test_a_box_beyond_a_line_ends_the_belief_in_it():
    assert cut([*ENTERING, (630, 100, 30, 30), ENTERING[0]]) == [False, False]


def test_pixels_are_counted_from_zero():
    assert cut([(0, 100, 30, 30)]) == [True, False]
    assert cut([(-9, 100, 30, 30), (0, 100, 30, 30)]) == [False, False]


def test_a_box_at_a_line_whose_center_is_well_known_is_whole():
    assert cut(ENTERING, sigma=0.5) == [False, False]


@pytest.mark.slow
@pytest.mark.parametrize('sigma', [5.0, 10.0])
def test_noise_of_a_quarter_of_the_box_is_smoothed_where_the_size_is_not_known(sigma):
    """Each detection has the noise it claims; half of it remains (0.9 if all count as cut)."""
    rng, tracker, squares = np.random.default_rng(0), Tracker(), []
    for k in range(150):
        x = 60.0 + 120 * np.arange(6)[:, None] * [0, 1] + [2.0 * k, 0]
        z = x + rng.normal(0, sigma, x.shape)
        rows = np.concatenate([row_of(*(at - 9.5), 20, 20, sigma) for at in z])
        tracks = tracker.update(Detections(rows, round(k * NANOSECONDS / 30))).rows
        at = np.stack([tracks['u'], tracks['v']], axis=1)
        if k >= 30:
            squares += list(((x[:, None] - at) ** 2).sum(axis=2).min(axis=1) / 2)
    assert np.sqrt(np.mean(squares)) < 0.6 * sigma
