"""Boxes of networks are whole, also where none overlap, and from the first frame on."""

import numpy as np
import pytest
from support.silhouettes import points

from colortrack_ros.data import CONFIRMED
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig

RATE = 25
SIZE = (640, 480)


def walkers(k, rng):
    """Centers and sizes of four people in a row, whose boxes jitter; none overlap [px]."""
    z = np.array([[100.0 + 120 * n + k, 240.0] for n in range(4)]) + rng.normal(0, 1, (4, 2))
    return z, np.array([50.0, 110.0]) * rng.lognormal(0, 0.3, (4, 2))


def measured_in_excess(seed):
    """Frames in which more tracks are measured than there are boxes, once somebody has left."""
    rng, tracker, count = np.random.default_rng(seed), Tracker(TrackerConfig(image_size=SIZE)), 0
    for k in range(100):
        z, size = walkers(k, rng)
        if k >= 70:  # the second has left, where the first one's box is much wider
            z, size = np.delete(z, 1, axis=0), np.delete(size, 1, axis=0)
            z[0, 0], size[0, 0] = 160 + k, 190
        tracks = tracker.update(points(z, round(k * 1e9 / RATE), size=size)).rows
        count += np.count_nonzero(tracks['state'] == CONFIRMED) > len(z)
    assert tracker._adaptation.finds_whole
    assert not tracker._adaptation.overlaps.are_resolved
    return count


@pytest.mark.slow
def test_who_is_missed_beside_a_larger_box_is_not_measured_in_it():
    """Of boxes that overlap many networks suppress all but the best, and so never show any."""
    assert sum(measured_in_excess(seed) for seed in range(6)) == 0


def frames_shown_on(change):
    """For how long the last of four that stand apart, found 20 times, is shown once it is gone.

    :param change: what is done to the rows of a network's detections.
    """
    rng, tracker, shown = np.random.default_rng(1), Tracker(TrackerConfig(image_size=SIZE)), 0
    for k in range(60):
        z = np.array([[100.0 + 120 * n, 240.0] for n in range(4 if k < 20 else 3)])
        size = np.array([50.3, 110.6]) * rng.lognormal(0, 0.02, z.shape)
        found = points(z + rng.normal(0, 1, z.shape), round(k * 1e9 / RATE), size=size)
        found.rows['score'] = rng.uniform(0.5, 0.99, len(z))
        change(found.rows)
        rows = tracker.update(found).rows
        shown += k >= 20 and len(rows) == 4
    return shown


def to_whole_pixels(rows):
    rows['box_w'], rows['box_h'] = np.rint(rows['box_w']), np.rint(rows['box_h'])


def to_certain_ones(rows):
    rows['score'] = 1


def to_measured_ones(rows):
    rows['cov_uu'] = rows['cov_vv'] = 1


def test_the_first_boxes_of_a_network_are_known_as_such():
    """None overlap and all are alike; what such a detector has lost is mostly gone."""
    assert 1 <= frames_shown_on(lambda rows: None) <= 4


@pytest.mark.parametrize('change', [to_whole_pixels, to_certain_ones, to_measured_ones])
def test_boxes_of_outlines_circles_and_blobs_are_not_taken_for_such(change):
    """What they have lost is mostly hidden."""
    assert frames_shown_on(change) > 10
