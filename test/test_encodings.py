import numpy as np
import pytest
from support import textbook
from support.cameras import encode

from colortrack_ros.data import ENCODINGS
from colortrack_ros.data import Frame
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection import pick_color
from colortrack_ros.detection import side_by_side
from colortrack_ros.encodings import check
from colortrack_ros.encodings import LAYOUTS
from colortrack_ros.encodings import plain
from colortrack_ros.encodings import size_of
from colortrack_ros.encodings import writable_bgr
from colortrack_ros.scenes import open_scene
from colortrack_ros.windows import WindowTracker

CONVERTED = [name for name in LAYOUTS if name not in ENCODINGS]
COLORED = [name for name in LAYOUTS if name != 'mono8']
RANGES = [(name, False) for name in CONVERTED] + [
    (n, True) for n in ('yuyv', 'uyvy', 'nv12', 'nv21')
]
SCENE = open_scene('five?width=320&height=240&noise=0')
PATCHES = np.array([[(20, 30, 200), (30, 170, 40)], [(200, 60, 30), (120, 130, 140)]], np.uint8)


@pytest.mark.parametrize(('encoding', 'full_range'), RANGES)
def test_plain_areas_of_color_come_back(encoding, full_range):
    bgr = PATCHES.repeat(8, 0).repeat(10, 1)
    frame = encode(bgr, encoding, full_range=full_range)
    back = plain(frame)
    assert size_of(frame) == back.image.shape[:2] == (16, 20)
    inner = np.s_[2:6, 2:8]  # where the neighbor's color has not been mixed in
    for down in (0, 8):
        for right in (0, 10):
            part = np.s_[down : down + 8, right : right + 10]
            difference = back.image[part][inner].astype(int) - bgr[part][inner]
            assert (
                np.abs(difference).max() <= 3
            )  # bytes of Y, U, V are coarser than those of R, G, B


def test_the_luma_of_full_range_is_not_taken_for_limited():
    frame = encode(np.full((2, 2, 3), 10, np.uint8), 'yuyv', full_range=True)
    assert plain(frame).image.mean() == pytest.approx(10, abs=1)
    assert plain(Frame(frame.image, 'yuyv')).image.max() == 0  # below black


@pytest.mark.parametrize('encoding', COLORED)
def test_balls_are_found_in_every_encoding_where_they_are(encoding):
    picture = SCENE.render(250)
    detector = Detector(DetectorConfig(erosion_size=1))
    expected = detector.detect(Frame(picture)).rows
    rows = detector.detect(encode(picture, encoding)).rows
    assert len(rows) == len(expected) >= 4
    for row in expected:
        away = np.hypot(rows['u'] - row['u'], rows['v'] - row['v'])
        assert away.min() < 0.5
        assert rows['area'][away.argmin()] == pytest.approx(row['area'], rel=0.12)


@pytest.mark.parametrize('encoding', COLORED)
def test_a_color_is_picked_in_every_encoding(encoding):
    frame = encode(SCENE.render(250), encoding)
    row = Detector(DetectorConfig()).detect(frame).rows[0]
    color = pick_color(frame, round(row['u']), round(row['v'])).color
    np.testing.assert_allclose(color.lab, textbook.lab(np.array([205.0, 58, 34])), atol=30)
    detector = Detector(DetectorConfig(colors=(color,)))
    assert side_by_side(frame, detector).shape == (240, 960, 3)


@pytest.fixture(scope='module')
def pictures():
    """Those of half a second."""
    return [SCENE.render(90 + k) for k in range(15)]


@pytest.mark.slow
@pytest.mark.parametrize('encoding', list(LAYOUTS))
def test_windows_follow_in_every_encoding(encoding, pictures):
    """Contours do in contours/test_tracker_input.py."""
    windows = WindowTracker()
    row = Detector(DetectorConfig()).detect(Frame(pictures[0])).rows[0]
    windows.start([[row[name] for name in ('box_u', 'box_v', 'box_w', 'box_h')]])
    for k, picture in enumerate(pictures):
        image = encode(picture, encoding).image
        tracks = windows.update(Frame(image, encoding, stamp=k * 10**9 // 30))
    assert len(tracks.rows) == 1
    assert tracks.rows['time_since_update'][0] == 0


@pytest.mark.parametrize('encoding', list(LAYOUTS))
def test_what_is_drawn_on_is_a_copy(encoding):
    frame = encode(PATCHES.repeat(2, 0).repeat(2, 1), encoding)
    before = frame.image.copy()
    picture = writable_bgr(frame)
    assert picture.shape == (4, 4, 3)
    picture[...] = 0
    np.testing.assert_array_equal(frame.image, before)


@pytest.mark.parametrize('encoding', list(LAYOUTS))
@pytest.mark.parametrize('size', [(0, 0), (0, 4), (4, 0), (2, 2), (2, 4), (4, 2)])
def test_small_and_empty_pictures_of_every_encoding_are_taken(encoding, size):
    frame = Frame(np.zeros(LAYOUTS[encoding].shape(*size), np.uint8), encoding)
    check(frame)
    assert size_of(frame) == size
    assert plain(frame).image.shape[:2] == size
    Detector(DetectorConfig()).detect(frame)


@pytest.mark.parametrize(
    ('shape', 'encoding', 'reason'),
    [
        ((4, 5, 2), 'yuyv', 'an even width for yuyv'),
        ((4, 4), 'uyvy', r'expected \(height, width, 2\)'),
        ((5, 4), 'nv12', '3/2 times an even height and an even width for nv12'),
        ((3, 5), 'nv21', '3/2 times an even height and an even width for nv21'),
        ((4, 4, 3), 'bayer_rggb8', r'expected \(height, width, 1\)'),
        ((4, 4), '32FC1', 'encoding: expected one of'),
    ],
)
def test_a_picture_that_does_not_fit_its_encoding_is_refused(shape, encoding, reason):
    with pytest.raises(ValueError, match=reason):
        check(Frame(np.zeros(shape, np.uint8), encoding))
