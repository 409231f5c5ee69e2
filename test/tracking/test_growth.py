"""Objects that approach, recede or turn are where their centroids are, whatever their boxes do."""

from functools import cache

import numpy as np
import pytest

from colortrack_ros.data import DETECTION
from colortrack_ros.data import Detections
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig

RATE, NOISE = 30, 0.3
PICTURE = (1280, 720)
FIRST, MOST = 15, 90


def frames_of(growth, seed, first_size):
    """Return places, (K, 4, 2), and detections of four objects whose sides grow by a share a frame.

    They move straight until they are five times as large or as small, for MOST frames at most.

    :param growth: (2,) of width and height.
    """
    rng = np.random.default_rng(seed)
    count = min(MOST, int(np.log(5) / np.abs(growth).max()))
    scale = (1 + np.array(growth)) ** np.arange(count)[:, None]
    return seen_as(scale, rng, first_size)


def seen_as(scale, rng, first_size):
    """Return places and detections as frames_of() does, given the scale in each frame, (K, 2)."""
    count = len(scale)
    k, angle = np.arange(count)[:, None, None], rng.uniform(0, 2 * np.pi, 4)
    start = np.array([[250, 200], [950, 200], [250, 520], [950, 520]])
    place = start + k * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    size = first_size * rng.uniform(0.8, 1.25, (4, 1)) * scale[:, None]
    low, high = np.round(place - size / 2), np.round(place + size / 2)
    z = place + rng.normal(0, NOISE, place.shape)
    rows = np.zeros((count, 4), DETECTION)
    for names, values in (
        (('u', 'v'), z), (('box_u', 'box_v'), low + 0.5), (('box_w', 'box_h'), high - low)
    ):  # fmt: skip
        rows[names[0]], rows[names[1]] = values[..., 0], values[..., 1]
    rows['cov_uu'] = rows['cov_vv'] = NOISE**2
    return place, [Detections(r, round(i * 1e9 / RATE), '', PICTURE) for i, r in enumerate(rows)]


def squares(place, frames, **options):
    """Return squared errors of tracks 1 to 4 by frame and axis; fail if there are others."""
    tracker, found = Tracker(TrackerConfig(**options)), []
    for truth, message in zip(place, frames, strict=True):
        rows = tracker.update(message).rows
        found.append(np.square([rows['u'], rows['v']] - truth.T))
    assert rows['track_id'].tolist() == [1, 2, 3, 4]
    return found


def rms(found):
    """Return the root of the mean square once the tracks are there."""
    return np.sqrt(np.mean(found[FIRST:]))


@cache
def without_boxes(seed):
    """Squared errors where boxes are not used: objects of all sizes go the same ways there."""
    return squares(*frames_of((1e-9, 1e-9), seed, 40), use_boxes=False)


@pytest.mark.slow
@pytest.mark.parametrize(
    ('growth', 'first_size'),
    [
        ((0.005, 0.005), 40), ((0.01, 0.01), 40), ((0.02, 0.02), 40), ((0.03, 0.03), 40),
        ((0.01, 0.01), 100), ((0.03, 0.03), 60),
        ((-0.005, -0.005), 200), ((-0.01, -0.01), 120), ((-0.03, -0.03), 200),
        ((0.02, -0.02), 100), ((0.0, 0.01), 60), ((-0.02, 0.0), 100),
    ],
)  # fmt: skip
def test_boxes_that_grow_or_shrink_do_not_draw_tracks_aside(growth, first_size):
    """Three seeds: 0.99 to 1.05 of the error without boxes, whichever of eight they are."""
    with_boxes, without = [], []
    for seed in range(3):
        found = squares(*frames_of(growth, seed, first_size))
        with_boxes.append(rms(found))
        without.append(rms(without_boxes(seed)[: len(found)]))
    assert np.mean(with_boxes) <= 1.15 * np.mean(without)


@pytest.mark.slow
@pytest.mark.parametrize('aspect', [1.0, 1.6])
def test_what_approaches_and_recedes_by_turns_is_where_its_centroid_is(aspect):
    """Its growth changes from 0.8 to -0.8 a second within two seconds."""
    depth = np.exp(0.5 * np.sin(2 * np.pi * np.arange(180) / (4 * RATE)))[:, None]
    scene = seen_as(depth * [1.0, aspect], np.random.default_rng(0), 60)
    assert rms(squares(*scene)) <= 1.15 * rms(squares(*scene, use_boxes=False))


def test_a_blob_that_one_side_of_is_covered_has_not_shrunk():
    place, frames = frames_of((1e-9, 1e-9), 0, 60)
    tracker = Tracker()
    for k, message in enumerate(frames):
        covered = 3.0 * max(k - 40, 0)
        message.rows['box_w'] -= covered
        message.rows['u'] -= covered / 2
        rows = tracker.update(message).rows
        if covered == 24:
            break
    assert rows['u'] == pytest.approx(place[k, :, 0], abs=2)
