"""What the sizes of blobs reveal about the object they belong to, and what they do not."""

import numpy as np
import pytest

from colortrack_ros.data import DETECTION
from colortrack_ros.data import Detections
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig
from colortrack_ros.tracking.adaptation import Adaptation
from colortrack_ros.tracking.measurements import accept
from colortrack_ros.tracking.sizes import OTHER_SIZE
from colortrack_ros.tracking.sizes import Sizes

RATE = 30


def blobs(*boxes):
    """Return detections of boxes with center and size (u, v, width, height) [px]."""
    rows = np.zeros(len(boxes), DETECTION)
    for row, (u, v, width, height) in zip(rows, boxes, strict=True):
        row['u'], row['v'], row['box_w'], row['box_h'] = u, v, width, height
        row['box_u'], row['box_v'] = u - width / 2 + 0.5, v - height / 2 + 0.5
        row['cov_uu'] = row['cov_vv'] = 0.1
        row['area'] = width * height
    return rows


def play(frames):
    """Return the tracker after some frames, and the rows of the last."""
    tracker = Tracker()
    for k, rows in enumerate(frames):
        tracks = tracker.update(Detections(rows, round(k * 1e9 / RATE)))
    return tracker, tracks.rows


@pytest.mark.parametrize('alike', [0.0, 0.1, 0.7])
@pytest.mark.parametrize('off', [(0.0, 0.0), (1.0, -2.0), (60.0, 0.0)])
def test_a_size_is_as_likely_as_the_density_of_its_errors_over_that_of_others(alike, off):
    """Errors are normal but for one in 50; others are alike, or evenly 0 to 2 times as large."""
    sizes, size = Sizes(), np.array([[20.0, 60.0]])
    sizes.alike = alike
    slack, (excess,) = sizes.slack(size)[0], np.array([off])
    own = np.exp(-((excess / slack) ** 2).sum() / 2) / (2 * np.pi * slack.prod())
    others = alike / (2 * np.pi * slack.prod()) + 1 / (4 * size.prod())
    expected = np.log(OTHER_SIZE + (1 - OTHER_SIZE) * own / others)
    assert sizes.log_fit(size, size + off)[0] == pytest.approx(expected)


def test_what_has_long_stood_still_and_jumps_is_known_by_its_size():
    stood = [blobs((300, 200, 70, 110))] * 60
    _, rows = play([*stood, blobs((333, 200, 70, 110))])
    assert rows['track_id'].tolist() == [1]
    assert rows['time_since_update'][0] == 0


@pytest.mark.parametrize('speed', [0.0, 2.0])
def test_an_object_that_was_whole_does_not_take_the_size_of_what_it_merges_with(speed):
    alone = [blobs((300 + speed * k, 200, 70, 110)) for k in range(60)]
    u = 300 + speed * 60
    _, rows = play([*alone, blobs((u + 20, 220, 110, 150)), blobs((u + speed, 200, 70, 110))])
    assert rows['u'][0] == pytest.approx(u + speed, abs=3)
    tracker, _ = play([*alone, blobs((u + 20, 220, 110, 150))])
    size = tracker._tracks.records['extent'][0].sum(axis=0)
    assert size == pytest.approx([70, 110], abs=6)


def test_objects_that_are_found_again_after_a_gap_tell_nothing_of_jitter():
    """When a look is due, no object was measured in the previous frame, which used to fail."""
    tracker, rows = Tracker(), blobs((100, 100, 20, 20))
    for k in range(12):
        seen = rows if k in (0, 1, 3, 4, 6, 8, 10) else rows[:0]
        tracks = tracker.update(Detections(seen, k * 33_000_000, 'camera')).rows
    assert len(tracks) == 1


def test_an_object_that_comes_into_view_has_the_size_that_is_in_view():
    frames = [blobs((4 * k / 2, 200, 4 * k, 60)) for k in range(1, 20)]
    tracker, _ = play(frames)
    size = tracker._tracks.records['extent'][0].sum(axis=0)
    assert size == pytest.approx([76, 60], abs=6)


@pytest.mark.parametrize(
    ('corner', 'cut'),
    [
        ((0, 100), [True, False]), ((2, 100), [False, False]), ((100, 450), [False, True]),
        ((610, 100), [True, False]), ((608, 100), [False, False]), ((0, 0), [True, True]),
    ],
)  # fmt: skip
@pytest.mark.parametrize('sigma', [0.2, 20.0])
def test_a_blob_at_the_border_is_cut_and_one_that_is_covered_is_not(corner, cut, sigma):
    rows = np.zeros(1, DETECTION)
    rows['box_u'], rows['box_v'], rows['box_w'], rows['box_h'] = *corner, 30, 30
    rows['u'], rows['v'] = rows['box_u'] + 14.5, rows['box_v'] + 14.5
    rows['cov_uu'] = rows['cov_vv'] = sigma**2
    learned = Adaptation(1.5)
    learned.know_size((640, 480))
    assert accept(rows, TrackerConfig(), learned).cut.tolist() == [cut]
