from dataclasses import replace
import itertools
from pathlib import Path

from hypothesis import given
from hypothesis import settings
from hypothesis import strategies as st
import numpy as np
import pytest
from support import pictures
from support import textbook
import yaml

from colortrack_ros.data import ENCODINGS
from colortrack_ros.data import Frame
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.detection import background_model
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection import ReferenceColor
from colortrack_ros.detection.background_model import _median_of_five
from colortrack_ros.detection.background_model import BackgroundModel
from colortrack_ros.detection.blobs import find_blobs
from colortrack_ros.detection.label_image import LabelImage

RATE = 25
PLAIN = {'closing_size': 1, 'erosion_size': 1, 'opening_size': 1}
ORDER = {'red': (0, 1, 2), 'green': (1, 0, 2), 'blue': (2, 0, 1)}


def channel_difference(frame, channel, threshold):
    """(8) to (12) of the document, indices from 0: area, u, v, box; or nothing."""
    wanted, one, other = (textbook.rgb(frame)[..., k].astype(int) for k in ORDER[channel])
    mask = wanted - one - other > threshold
    y, x = mask.sum(axis=1).argmax(), mask.sum(axis=0).argmax()
    v, u = np.indices(mask.shape)
    height, width = mask.shape
    v, u = np.nonzero(mask & (abs(v - y) <= 0.1 * height) & (abs(u - x) <= 0.1 * width))
    if not len(u):
        return None
    return len(u), u.mean(), v.mean(), u.min(), v.min(), np.ptp(u) + 1, np.ptp(v) + 1


@pytest.mark.slow
@settings(deadline=None, max_examples=60)
@given(
    frame=pictures.frames(),
    channel=st.sampled_from(['red', 'green', 'blue']),
    threshold=st.integers(0, 200),
)
def test_channel_difference_is_that_of_the_document(frame, channel, threshold):
    config = DetectorConfig(
        method='channel_difference',
        channel=channel,
        channel_threshold=threshold,
        largest_object='region',
        min_area=1,
        **PLAIN,
    )
    rows = Detector(config).detect(frame).rows
    expected = channel_difference(frame, channel, threshold)
    if expected is None:
        assert len(rows) == 0
        return
    (row,) = rows
    names = ('area', 'u', 'v', 'box_u', 'box_v', 'box_w', 'box_h')
    np.testing.assert_allclose([row[name] for name in names], expected)
    assert 0 < row['score'] <= 1


def red_rectangles(*boxes):
    """A gray picture (240, 320, 3) with plain red rectangles (left, top, width, height)."""
    image = np.full((240, 320, 3), 90, np.uint8)
    for left, top, width, height in boxes:
        image[top : top + height, left : left + width] = (20, 20, 250)
    return Frame(image)


@pytest.mark.parametrize(
    ('others', 'largest'),
    [
        ([(20, 20, 30, 30)], (140, 60, 40, 40)),
        ([(20, 200, 120, 10)], (200, 20, 20, 100)),
        ([(20, 200, 120, 12), (10, 10, 12, 120)], (150, 40, 90, 110)),
        ([(20, y, 20, 20) for y in (10, 40, 70)] + [(200, 10, 20, 20)], (120, 150, 30, 30)),
        ([(62, 60, 20, 60)], (90, 60, 60, 60)),
    ],
    ids=['smaller', 'peak_in_h_alone', 'larger_than_the_region', 'in_rows', 'right_beside'],
)
def test_channel_difference_finds_all_of_the_largest_object_whatever_else_is_there(others, largest):
    config = DetectorConfig(method='channel_difference', channel_threshold=100, **PLAIN)
    (row,) = Detector(config).detect(red_rectangles(*others, largest)).rows
    found = [row[name] for name in ('box_u', 'box_v', 'box_w', 'box_h')]
    np.testing.assert_array_equal(found, largest)
    assert row['area'] == largest[2] * largest[3]


@pytest.mark.parametrize(('level', 'score'), [(255, 1.0), (204, 0.8)])
def test_the_score_of_channel_difference_is_the_share_of_the_greatest_difference(level, score):
    picture = np.zeros((40, 40, 3), np.uint8)
    picture[10:30, 10:30, 2] = level
    detector = Detector(DetectorConfig(method='channel_difference', **PLAIN))
    (row,) = detector.detect(Frame(picture, 'bgr8')).rows
    assert row['score'] == pytest.approx(score, abs=1e-6)


def test_two_objects_with_a_peak_each_leave_the_region_of_the_document_empty():
    frame = red_rectangles((20, 200, 120, 10), (200, 20, 20, 100))
    config = DetectorConfig(method='channel_difference', largest_object='region', **PLAIN)
    assert len(Detector(config).detect(frame).rows) == 0


def test_the_parameters_after_the_document_find_the_larger_of_two_objects_with_a_peak_each():
    path = Path(__file__).parents[2] / 'params' / 'red_object.yaml'
    declared = yaml.safe_load(path.read_text())['/**/detector']['ros__parameters']
    (row,) = (
        Detector(DetectorConfig(**declared))
        .detect(red_rectangles((20, 200, 130, 16), (200, 20, 20, 100)))
        .rows
    )
    assert [row[name] for name in ('box_u', 'box_v', 'box_w', 'box_h')] == [20, 200, 130, 16]


def film(path, light=lambda k: 1.0, encoding='bgr8', shape=(120, 160)):
    """Frames of a noisy gray wall, with a bright disc of radius 8 on the path (None: away)."""
    random = np.random.default_rng(0)
    channels = ENCODINGS[encoding]
    wall = random.integers(70, 110, (*shape, channels)).astype(float)
    v, u = np.indices(shape)
    for k, position in enumerate(path):
        image = wall * light(k) + random.normal(0, 2, wall.shape)
        if position is not None:
            disc = (u - position[0]) ** 2 + (v - position[1]) ** 2 <= 8**2
            image[disc] = 180 * light(k)
        stamp = k * NANOSECONDS // RATE
        yield Frame(np.clip(image, 0, 255).astype(np.uint8), encoding, stamp)


def moving(config, frames):
    """Number of blobs and distance to the path in each frame."""
    detector = Detector(config)
    return [detector.detect(frame).rows for frame in frames]


@pytest.mark.slow
@pytest.mark.parametrize(
    ('model', 'encoding'),
    [
        *itertools.product(['median'], ENCODINGS),
        *itertools.product(['mog2', 'knn'], ['mono8', 'bgra8']),
    ],
)
def test_background_finds_what_moves_in_every_encoding(model, encoding):
    """Models of OpenCV are given one channel or three, as the median is."""
    path = [None] * 30 + [(20 + 2 * k, 60) for k in range(50)]
    config = DetectorConfig(method='background', background_model=model, opening_size=3)
    found = moving(config, film(path, encoding=encoding))
    assert not any(len(rows) for rows in found[5:30])
    for (u, v), rows in zip(path[31:], found[31:], strict=True):
        assert len(rows) == 1
        assert np.hypot(rows['u'][0] - u, rows['v'][0] - v) < 2


@pytest.mark.slow
def test_background_keeps_an_object_that_rests_and_forgets_where_it_was_at_first():
    path = [(40, 60)] * 2 + [(40 + 2 * k, 60) for k in range(40)] + [(118, 60)] * 150
    config = DetectorConfig(method='background', opening_size=3)
    found = moving(config, film(path))
    assert all(len(rows) == 1 for rows in found[60:])
    assert all(abs(rows['u'][0] - 118) < 1 for rows in found[60:])


def test_background_does_not_see_a_light_that_is_switched():
    config = DetectorConfig(method='background', opening_size=3)
    found = moving(config, film([None] * 60, light=lambda k: 1.0 if k < 30 else 0.55))
    assert sum(map(len, found)) == 0


def test_background_is_learned_again_on_request_and_after_a_change_of_size():
    config = DetectorConfig(method='background', learn_seconds=0.2)
    detector = Detector(config)
    frames = list(film([None] * 10 + [(60, 60)] * 20))
    counts = [len(detector.detect(frame).rows) for frame in frames]
    assert counts[-1] == 1
    detector.learn_background()
    assert sum(len(detector.detect(frame).rows) for frame in frames[-5:]) == 0
    smaller = [replace(frame, image=frame.image[:80]) for frame in frames[-5:]]
    assert sum(len(detector.detect(frame).rows) for frame in smaller) == 0


@pytest.mark.slow
def test_what_moves_of_a_color_may_rest_and_a_light_may_be_switched():
    path = [None] * 30 + [(20 + 2 * k, 60) for k in range(40)] + [(98, 60)] * 130
    color = ReferenceColor('white', (75.0, 0.0, 0.0), 30.0)
    config = DetectorConfig(colors=(color,), moving_only=True)
    found = moving(config, film(path, light=lambda k: 1.0 if k < 120 else 0.8))
    assert not any(len(rows) for rows in found[:30])
    for (u, v), rows in zip(path[31:], found[31:], strict=True):
        assert len(rows) == 1
        assert np.hypot(rows['u'][0] - u, rows['v'][0] - v) < 1


@pytest.mark.slow
def test_what_is_found_is_no_background_even_if_it_is_too_large_to_be_detected():
    path = [None] * 30 + [(60, 60)] * 150
    config = DetectorConfig(method='background', opening_size=3, max_area=100)
    detector = Detector(config)
    for frame in film(path):
        assert len(detector.detect(frame).rows) == 0
    assert np.count_nonzero(detector.mask) > 150


@pytest.mark.slow
@pytest.mark.parametrize('present', [8, 40])
def test_what_something_that_was_there_from_the_beginning_has_hidden_is_not_found(present):
    """A red ball leaves its place on a red rug: the rug is not new."""
    random = np.random.default_rng(0)
    room = np.full((120, 200, 3), 110, np.uint8)
    room[60:110, 30:170] = (60, 70, 190)
    v, u = np.indices(room.shape[:2])
    color = ReferenceColor.from_rgb('red', (200, 60, 45), 40.0)
    detector, counts = Detector(DetectorConfig(colors=(color,), moving_only=True)), []
    for k in range(100):
        image = room + random.normal(0, 2, room.shape)
        image[np.hypot(u - 60 - 8 * max(k - present, 0), v - 85) < 12] = (20, 40, 230)
        frame = Frame(np.clip(image, 0, 255).astype(np.uint8), stamp=k * NANOSECONDS // RATE)
        counts.append(len(detector.detect(frame).rows))
    assert max(counts[present : present + 10]) > 0, 'the ball itself'
    assert max(counts[present + 45 :]) == 0


def test_the_mask_is_that_of_the_last_frame():
    image = np.full((40, 50, 3), 90, np.uint8)
    image[10:20, 20:30] = (34, 58, 205)
    detector = Detector(DetectorConfig())
    assert detector.mask.shape == (0, 0)
    detector.detect(Frame(image))
    expected = np.zeros((40, 50), np.uint8)
    expected[11:19, 21:29] = 255
    np.testing.assert_array_equal(detector.mask, expected)


def test_the_median_of_five_is_the_median():
    samples = np.random.default_rng(0).integers(0, 256, (5, 40, 50, 3), dtype=np.uint8)
    np.testing.assert_array_equal(_median_of_five(*samples), np.median(samples, axis=0))


def test_what_was_there_before_a_long_rest_is_still_background():
    """The recent background takes it in, the lasting one keeps what is behind it."""
    wall, nothing = np.full((40, 50, 3), 100, np.uint8), LabelImage(np.zeros((1, 8), np.uint8), 1)
    rested = wall.copy()
    rested[10:20, 10:20] = 200
    model = BackgroundModel()
    for k in range(160):
        picture = wall if k < 40 else rested
        model.follow(picture, k * NANOSECONDS // 10, find_blobs(nothing, 1), 1.0)
    assert model.difference(wall).max() < 30  # twelve seconds' worth
    assert model.difference(rested).max() < 8
    assert np.abs(wall.astype(int) - model.recent).max() > 90


@pytest.mark.parametrize('channels', [1, 3])
@pytest.mark.parametrize('threshold', [0.0, 8.0, 8.4, 84.0, 250.0])
def test_all_pixels_and_single_ones_are_compared_with_the_background_alike(
    channels, threshold, monkeypatch
):
    random = np.random.default_rng(3)
    before = random.integers(0, 256, (40, 50, channels), dtype=np.uint8)
    change = random.choice([0, 8, 9, 20, 90, 255], (40, 50, 1)) + random.integers(
        -3, 4, before.shape
    )
    picture = (before + change).clip(0, 255).astype(np.uint8)
    model = BackgroundModel()
    model.follow(before, 0, find_blobs(LabelImage(np.zeros((1, 8), np.uint8), 1), 1), 1.0)
    expected = np.abs(picture.astype(int) - before).sum(axis=2) > threshold * channels
    for share in (0.0, 1.0):
        monkeypatch.setattr(background_model, 'DENSE_SHARE', share)
        image = LabelImage.empty(40, 50)
        image.pixels[...] = labels = random.integers(0, 5, (40, 50))
        model.clear_still(picture, image, threshold)
        np.testing.assert_array_equal(image.pixels, np.where(expected, labels, 0))
