from dataclasses import replace
import tracemalloc

from hypothesis import assume
from hypothesis import given
from hypothesis import settings
from hypothesis import strategies as st
import numpy as np
import pytest
from support import pictures
from support import textbook

from colortrack_ros.data import ENCODINGS
from colortrack_ros.data import Frame
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection import ReferenceColor

RED = ReferenceColor.from_rgb('red', (220, 40, 30), 30.0)
CONFIG = DetectorConfig(colors=(RED,))


def scene(discs, shape=(120, 160), background=(110, 120, 115), color=(30, 40, 220)):
    """A bgr8 frame with discs (u, v, radius), not anti-aliased."""
    image = np.full((*shape, 3), background, np.uint8)
    v, u = np.indices(shape)
    for center_u, center_v, radius in discs:
        image[(u - center_u) ** 2 + (v - center_v) ** 2 <= radius**2] = color
    return Frame(image, stamp=7, frame_id='camera')


@pytest.mark.slow
@settings(deadline=None, max_examples=80)
@given(
    frame=pictures.frames(),
    colors=pictures.colors(),
    sizes=st.tuples(*[st.sampled_from([1, 3, 5])] * 3),
    limits=st.tuples(st.integers(1, 20), st.integers(20, 900)),
)
def test_detections_are_those_of_the_textbook(frame, colors, sizes, limits):
    assume(textbook.is_decided(frame, colors))
    closing, erosion, opening = sizes
    config = DetectorConfig(
        colors=colors,
        min_area=limits[0],
        max_area=limits[1],
        closing_size=closing,
        erosion_size=erosion,
        opening_size=opening,
    )
    detections = Detector(config).detect(frame)
    rows = detections.rows
    names = ('area', 'u', 'v', 'box_u', 'box_v', 'box_w', 'box_h', 'color')
    found = [tuple(float(row[name]) for name in names) for row in rows]
    expected = [tuple(map(float, row)) for row in textbook.detect(frame, config)]
    np.testing.assert_allclose(sorted(found), sorted(expected), atol=1e-9)
    assert (np.diff(rows['area']) <= 0).all()
    assert (detections.stamp, detections.frame_id) == (frame.stamp, 'camera')
    assert ((rows['score'] >= 0) & (rows['score'] <= 1)).all()
    determinant = rows['cov_uu'] * rows['cov_vv'] - rows['cov_uv'] ** 2
    assert ((rows['cov_uu'] > 0) & (determinant > 0)).all()


def test_a_disc_is_found_where_it_is():
    (row,) = Detector(CONFIG).detect(scene([(60, 50, 12)])).rows
    assert (row['u'], row['v']) == (60, 50)
    assert (row['box_u'], row['box_v'], row['box_w'], row['box_h']) == (50, 40, 21, 21)
    assert row['color'] == 0


@pytest.mark.parametrize('closing', [1, 9])
def test_groups_of_rows_with_nothing_between_are_eroded_as_the_whole_picture_is(closing):
    discs = [(30, 0, 9), (70, 2, 4), (20, 55, 6), (60, 63, 5), (9, 200, 7), (50, 299, 8)]
    frame = scene(discs, shape=(300, 90))
    config = DetectorConfig(colors=(RED,), erosion_size=5, closing_size=closing, min_area=1)
    rows = Detector(config).detect(frame).rows
    found = [tuple(float(row[k]) for k in ('u', 'v', 'area', 'box_v', 'box_h')) for row in rows]
    expected = [(u, v, area, top, high) for area, u, v, _, top, _, high, _ in (
        map(float, row) for row in textbook.detect(frame, config)
    )]  # fmt: skip
    np.testing.assert_allclose(sorted(found), sorted(expected))


def test_a_blob_of_exactly_the_reference_color_scores_one():
    detector = Detector(CONFIG)
    (exact,) = detector.detect(scene([(60, 50, 12)])).rows
    (other,) = detector.detect(scene([(60, 50, 12)], color=(40, 60, 200))).rows
    assert exact['score'] == pytest.approx(1, abs=1e-6)
    distance = np.linalg.norm(textbook.lab(np.array([200, 60, 40])) - RED.lab)
    assert other['score'] == pytest.approx(1 - distance / RED.tolerance)


def test_a_large_blob_is_known_better_than_a_small_one():
    small, large = (
        Detector(CONFIG).detect(scene([(80, 60, radius)])).rows[0] for radius in (5, 40)
    )
    assert large['cov_uu'] < small['cov_uu'] / 2


def test_a_blob_cut_by_the_border_is_known_badly_in_that_direction():
    (left,) = Detector(CONFIG).detect(scene([(-3, 60, 20)])).rows
    (bottom,) = Detector(CONFIG).detect(scene([(80, 122, 20)])).rows
    assert np.sqrt(left['cov_uu']) > 5 > 0.5 > np.sqrt(left['cov_vv'])
    assert np.sqrt(bottom['cov_vv']) > 5 > 0.5 > np.sqrt(bottom['cov_uu'])


def test_colors_are_eroded_each_for_itself():
    image = np.full((9, 12, 3), (30, 40, 220), np.uint8)
    image[:, 6:] = (30, 220, 40)
    colors = (RED, ReferenceColor.from_rgb('green', (40, 220, 30), 30.0))
    detector = Detector(DetectorConfig(colors=colors, min_area=1))
    rows = detector.detect(Frame(image)).rows
    assert rows[['color', 'area', 'box_u', 'box_w']].tolist() == [(0, 45, 0, 5), (1, 45, 7, 5)]
    rows = detector.detect(Frame(np.ascontiguousarray(image.transpose(1, 0, 2)))).rows
    assert rows[['color', 'area', 'box_v', 'box_h']].tolist() == [(0, 45, 0, 5), (1, 45, 7, 5)]


def test_each_color_may_have_areas_of_its_own():
    image = np.full((40, 80, 3), (30, 40, 220), np.uint8)
    image[:, ::20] = image[:, 50:] = 128  # two of 760 px, one of 360
    image[10:14, 55:60] = (30, 220, 40)
    green = ReferenceColor.from_rgb('green', (40, 220, 30), 30.0)

    def areas(least=0, most=0, **config):
        colors = (replace(RED, min_area=least, max_area=most), green)
        detector = Detector(DetectorConfig(colors=colors, erosion_size=1, **config))
        return detector.detect(Frame(image)).rows['area'].tolist()

    assert areas(min_area=5) == [760, 760, 360, 20]
    assert areas(least=500, min_area=5) == [760, 760, 20]
    assert areas(least=2, most=500, min_area=30) == [360]
    assert areas(most=800, max_area=100, min_area=5) == [760, 760, 360, 20]


@pytest.mark.parametrize('encoding', ENCODINGS)
@pytest.mark.parametrize('shape', [(0, 0), (0, 5), (5, 0), (1, 1), (1, 9), (9, 1)])
def test_tiny_and_empty_pictures_give_detections(encoding, shape):
    image = np.full((*shape, ENCODINGS[encoding]), 255, np.uint8)
    white = ReferenceColor('white', (100.0, 0.0, 0.0), 5.0)
    config = DetectorConfig(colors=(white,), min_area=1)
    detections = Detector(config).detect(Frame(image, encoding, 3, 'camera'))
    assert detections.rows['area'].sum() == image[..., 0].size
    assert (detections.stamp, detections.frame_id) == (3, 'camera')


@pytest.mark.parametrize('encoding', ENCODINGS)
@pytest.mark.parametrize(
    'parameters',
    [
        {'moving_only': True},
        {'grow': 1.5},
        {'follow_light': 5.0},
        {'white_balance': 'gray_world'},
        {'split': True},
        {'min_solidity': 0.5, 'min_aspect': 0.1, 'min_extent': 0.1, 'min_circularity': 0.1},
        {'closing_size': 5, 'opening_size': 5},
        {'method': 'background'},
        {'method': 'background', 'background_model': 'mog2'},
        {'method': 'channel_difference'},
    ],
    ids=str,
)
def test_nothing_is_found_in_pictures_of_nothing_of_any_size(parameters, encoding):
    detector = Detector(DetectorConfig(**parameters))
    shapes = [(40, 50), (40, 50), (1, 1), (1, 9), (0, 5), (9, 1), (9, 1), (40, 50)]
    for k, shape in enumerate(shapes):
        image = np.full((*shape, ENCODINGS[encoding]), 100, np.uint8)
        assert len(detector.detect(Frame(image, encoding, k * 100_000_000)).rows) == 0


def test_a_picture_all_inside_is_one_blob():
    frame = Frame(np.full((30, 40, 3), (30, 40, 220), np.uint8))
    (row,) = Detector(CONFIG).detect(frame).rows
    assert (row['area'], row['u'], row['v']) == (1200, 19.5, 14.5)
    assert min(row['cov_uu'], row['cov_vv']) > 100


def test_size_and_encoding_may_change_from_frame_to_frame():
    detector = Detector(CONFIG)
    for shape in ((60, 80), (200, 100), (60, 80)):
        frame = scene([(40, 30, 10)], shape)
        assert len(detector.detect(frame).rows) == 1
        mono = Frame(np.ascontiguousarray(frame.image[..., 0]), 'mono8')
        assert len(detector.detect(mono).rows) == 0


def test_a_padded_picture_is_not_copied_nor_changed():
    wide = scene([(40, 30, 10)], (60, 100)).image
    before = wide.copy()
    narrow = np.ascontiguousarray(wide[:, :80])
    detector = Detector(CONFIG)
    padded, plain = detector.detect(Frame(wide[:, :80])), detector.detect(Frame(narrow))
    np.testing.assert_array_equal(padded.rows, plain.rows)
    np.testing.assert_array_equal(wide, before)


def test_padded_rows_of_a_large_picture_take_no_more_memory():
    wide = scene([(400, 300, 40), (900, 200, 30)], (720, 1296)).image
    padded = wide[:, :1280]

    def most_memory(image):
        detector = Detector(CONFIG)
        for _ in range(2):  # memory is reused from the second picture on
            tracemalloc.start()
            assert len(detector.detect(Frame(image)).rows) == 2
            _, most = tracemalloc.get_traced_memory()
            tracemalloc.stop()
        return most

    assert most_memory(padded) < most_memory(padded.copy()) + wide.nbytes / 100


def test_a_configuration_counts_from_the_next_frame_on():
    detector = Detector(CONFIG)
    frame = scene([(40, 30, 10)])
    detector.configure(replace(CONFIG, min_area=1000))
    assert len(detector.detect(frame).rows) == 0
    gray = ReferenceColor.from_rgb('gray', (115, 120, 110), 25.0)
    detector.configure(replace(CONFIG, colors=(gray,)))
    assert detector.detect(frame).rows['area'] > 10_000


@pytest.mark.parametrize(
    ('image', 'encoding', 'said'),
    [
        (np.zeros((4, 5, 3), np.uint8), 'yuv422', 'encoding'),
        (np.zeros((4, 5, 3), np.uint8), 'bgra8', 'image.shape'),
        (np.zeros((4, 5), np.uint8), 'bgr8', 'image.shape'),
        (np.zeros((4, 5, 3), np.uint16), 'bgr8', 'image.dtype'),
    ],
)
def test_a_picture_that_contradicts_its_encoding_is_refused(image, encoding, said):
    with pytest.raises(ValueError, match=said):
        Detector(CONFIG).detect(Frame(image, encoding))


@pytest.mark.parametrize('erosion', [1, 3, 7])
def test_the_box_of_a_color_whose_end_is_found_is_that_of_the_thing(erosion):
    v, u = np.indices((120, 160))
    image = np.full((120, 160, 3), 110, np.uint8)
    image[(abs(u - 60) <= 20) & (abs(v - 50) <= 15)] = (34, 58, 205)
    image[(u >= 130) & (abs(v - 90) <= 10)] = (34, 58, 205)
    names = ['box_u', 'box_v', 'box_w', 'box_h']
    for tolerance, less in ((0.0, 0), (25.0, erosion // 2)):
        colors = (ReferenceColor.from_rgb('red', (205, 58, 34), tolerance),)
        rows = (
            Detector(DetectorConfig(colors=colors, erosion_size=erosion)).detect(Frame(image)).rows
        )
        large, small = rows[names].tolist()
        assert large == (40 + less, 35 + less, 41 - 2 * less, 31 - 2 * less)
        assert small == (130 + less, 80 + less, 30 - less, 21 - 2 * less)


@pytest.mark.parametrize(
    ('config', 'told'),
    [
        (DetectorConfig(colors=(ReferenceColor.from_rgb('red', (205, 58, 34), 30.0),)), True),
        (DetectorConfig(colors=(ReferenceColor.from_rgb('black', (20, 20, 20), 30.0),)), False),
        (DetectorConfig(method='channel_difference'), True),
        (DetectorConfig(method='background'), False),
    ],
)
def test_gray_pictures_in_which_nothing_can_be_found_are_told(config, told):
    """As of a driver whose image_rect is gray: nothing was found, without a word."""
    detector = Detector(config)
    assert detector.trouble == ''
    detector.detect(Frame(np.full((40, 60), 130, np.uint8), 'mono8'))
    assert ('the pictures are gray' in detector.trouble) == told
    detector.detect(Frame(np.full((40, 60, 3), 130, np.uint8), 'bgr8', 33_000_000))
    assert detector.trouble == ''
