from dataclasses import replace

import cv2
import numpy as np
import pytest
from support.cameras import encode

from colortrack_ros.data import ENCODINGS
from colortrack_ros.data import Frame
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection import ReferenceColor
from colortrack_ros.detection import survivors
from colortrack_ros.detection.regions import Region

RGBS = (200, 50, 40), (225, 80, 40), (60, 180, 60), (60, 60, 200)
"""The first two lie so close that pixels are within tolerance of both."""


def colors(count):
    return tuple(ReferenceColor.from_rgb(f'c{k}', rgb, 35.0) for k, rgb in enumerate(RGBS[:count]))


def clutter(random, height, width, count, specks=0.02, channels=3):
    """Discs, thin lines and single pixels of the colors, with noise; its rows are padded."""
    picture: np.ndarray = np.full((height, width + random.integers(0, 9), channels), 120, np.uint8)
    picture = picture[:, :width]
    for _ in range(6):
        bgr = tuple(RGBS[random.integers(count)][::-1]) + (0,) * (channels - 3)
        points = random.integers(0, [width, height], (3, 2)).tolist()
        drawn = picture.copy()
        cv2.circle(drawn, points[0], int(random.integers(1, 9)), bgr, int(random.choice([-1, 2])))
        cv2.line(drawn, points[1], points[2], bgr, int(random.integers(1, 4)))
        picture[...] = drawn
    picture[random.random((height, width)) < specks, :3] = RGBS[random.integers(count)][::-1]
    noise = random.normal(0, 4, (height, width, 3))
    picture[..., :3] = (picture[..., :3] + noise).clip(0, 255).astype(np.uint8)
    return picture


@pytest.fixture
def everywhere(monkeypatch):
    """Words are looked for in small pictures, too, however many there are; how often they were."""
    used = []
    label = survivors.Survivors.label

    def counted(*arguments):
        image = label(*arguments)
        used.append(image is not None)
        return image

    monkeypatch.setattr(survivors, 'WORTHWHILE_PIXELS', (0, 0))
    monkeypatch.setattr(survivors, 'LABELED_SHARE', 1.0)
    monkeypatch.setattr(survivors.Survivors, 'label', counted)
    return used


def both(config, frame, monkeypatch):
    """Rows and labels with words that are looked for, and with all pixels labeled."""
    found = []
    for fewest in ((0, 0), (1 << 40, 1 << 40)):
        monkeypatch.setattr(survivors, 'WORTHWHILE_PIXELS', fewest)
        detector = Detector(config)
        found.append((detector.detect(frame).rows, detector.labels))
    return found


@pytest.mark.slow
@pytest.mark.parametrize('erosion', [3, 5, 7])
@pytest.mark.parametrize('count', [1, 2, 4])
def test_what_outlasts_an_erosion_is_that_of_the_whole_picture(
    erosion, count, everywhere, monkeypatch
):
    random = np.random.default_rng(erosion * count)
    config = DetectorConfig(colors=colors(count), erosion_size=erosion, min_area=1)
    rows = 0
    for _ in range(30):
        height, width = random.integers(2 * erosion, 120), random.integers(8, 150)
        frame = Frame(clutter(random, height, width, count, random.choice([0, 0.02, 0.1])))
        (few, labels), (all_rows, all_labels) = both(config, frame, monkeypatch)
        np.testing.assert_array_equal(labels, all_labels)
        assert few.tobytes() == all_rows.tobytes()
        rows += len(few)
    assert rows > 30
    assert sum(everywhere) == 30


@pytest.mark.parametrize('encoding', [name for name in ENCODINGS if name != 'mono8'])
def test_any_encoding_will_do(encoding, everywhere, monkeypatch):
    random = np.random.default_rng(4)
    picture = clutter(random, 90, 130, 2, channels=ENCODINGS[encoding])
    if encoding.startswith('rgb'):
        picture[..., :3] = picture[..., 2::-1].copy()
    config = DetectorConfig(colors=colors(2), min_area=1)
    (few, _), (all_rows, _) = both(config, Frame(picture, encoding), monkeypatch)
    assert len(few)
    assert few.tobytes() == all_rows.tobytes()
    assert sum(everywhere) == 1


@pytest.mark.parametrize('view', ['[::-1]', '[:, ::-1]', '[..., ::-1]', '[::2, ::2]', '[::3]'])
def test_views_of_a_picture_are_read_as_their_copies_are(view, everywhere):
    picture = clutter(np.random.default_rng(4), 180, 260, 2)
    part = eval(f'picture{view}', {'picture': picture})
    config = DetectorConfig(colors=colors(2), min_area=1)
    rows, expected = (Detector(config).detect(Frame(x)).rows for x in (part, part.copy()))
    assert len(rows) or view == '[..., ::-1]'
    assert rows.tobytes() == expected.tobytes()
    assert everywhere[1]


@pytest.mark.parametrize('change', [
    {'closing_size': 3}, {'grow': 1.5}, {'moving_only': True}, {'erosion_size': 1},
    {'regions': (Region('all', ((0, 0), (999, 0), (999, 999))),)},
])  # fmt: skip
def test_all_is_labeled_where_something_else_reads_the_labels(change, everywhere):
    frame = Frame(clutter(np.random.default_rng(4), 90, 130, 1))
    config = DetectorConfig(colors=colors(1), min_area=1)
    Detector(config).detect(frame)
    assert everywhere == [True]
    Detector(replace(config, **change)).detect(frame)
    assert everywhere[1:]
    assert not any(everywhere[1:])


def test_where_colors_are_everywhere_it_is_not_tried_each_time(monkeypatch):
    monkeypatch.setattr(survivors, 'WORTHWHILE_PIXELS', (0, 0))
    tried = []
    near = survivors._words_near
    monkeypatch.setattr(survivors, '_words_near', lambda *a: tried.append(0) or near(*a))
    detector = Detector(DetectorConfig(colors=colors(1)))
    full: np.ndarray = np.full((60, 80, 3), RGBS[0][::-1], np.uint8)
    for k in range(3 * survivors.PICTURES_OF_PAUSE):
        (row,) = detector.detect(Frame(full, stamp=k)).rows
        assert row['area'] == 60 * 80
    assert len(tried) == 3


@pytest.mark.parametrize('encoding', ['bgr8', 'yuyv'])
def test_nothing_of_a_frame_is_left_in_the_memory_of_the_next(encoding, everywhere):
    random = np.random.default_rng(5)
    config = DetectorConfig(colors=colors(2), min_area=1)
    detector = Detector(config)
    memory = set()
    for _ in range(6):
        picture = clutter(random, 90, 130, 2)
        frame = encode(picture, encoding)
        fresh = Detector(config)
        detector.detect(frame), fresh.detect(frame)
        assert fresh.labels.any()
        np.testing.assert_array_equal(detector.labels, fresh.labels)
        memory.add(detector.labels.__array_interface__['data'])
    assert len(memory) == 1
