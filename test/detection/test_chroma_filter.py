import numpy as np
import pytest
from support.cameras import encode

from colortrack_ros.data import Frame
from colortrack_ros.detection import chroma_filter
from colortrack_ros.detection import color_table
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection import ReferenceColor
from colortrack_ros.detection.chroma_filter import ChromaFilter
from colortrack_ros.detection.color_table import ColorTable
from colortrack_ros.encodings import bgr_at
from colortrack_ros.encodings import plain
from colortrack_ros.encodings import YUV420
from colortrack_ros.encodings import YUV422
from colortrack_ros.scenes import open_scene

LUTS = sorted({False, color_table.HAS_16_BIT_LUT})
ENCODINGS = [*YUV422, *YUV420]
RGB = ((205, 58, 34), (40, 160, 60), (20, 20, 20), (240, 240, 250), (190, 40, 180))
SCENE = open_scene('five?width=320&height=240')


def noise(encoding, height=24, width=40):
    """A picture of random bytes in an encoding, which also has colors that RGB has not."""
    shape = (height, width, 2) if encoding in YUV422 else (height * 3 // 2, width)
    return Frame(np.random.default_rng(0).integers(0, 256, shape, np.uint8), encoding)


@pytest.fixture(scope='module')
def every_color():
    """yuyv with each Y beside each U and V, and what it is when it is converted."""
    y, u, v = np.meshgrid(*[np.arange(256, dtype=np.uint8)] * 3, indexing='ij')
    frame = Frame(np.stack([y, u, y, v], axis=-1).reshape(4096, 8192, 2), 'yuyv')
    return frame, plain(frame).image


@pytest.mark.slow
@pytest.mark.parametrize('rgb', RGB)
def test_every_yuv_color_has_the_label_that_it_has_when_it_is_converted_first(
    rgb, every_color, monkeypatch
):
    monkeypatch.setattr(chroma_filter, 'CONVERTED_SHARE', 1)
    (frame, converted), table = every_color, ColorTable((ReferenceColor.from_rgb('c', rgb, 30.0),))
    image = ChromaFilter(table.touched).label(frame, lambda x: table.label(x, 'bgr8').pixels)
    expected = table.label(converted, 'bgr8').pixels
    np.testing.assert_array_equal(image.pixels, expected)
    assert expected.any()


@pytest.mark.parametrize('encoding', ENCODINGS)
def test_single_pixels_are_those_of_the_converted_picture(encoding):
    frame = noise(encoding)
    row, column = np.indices((24, 40))
    np.testing.assert_array_equal(bgr_at(frame, row, column), plain(frame).image)


@pytest.mark.parametrize('padding', [0, 6])
@pytest.mark.parametrize('has_lut', LUTS)
@pytest.mark.parametrize('encoding', ENCODINGS)
def test_detections_are_those_of_the_converted_picture_to_the_bit(
    encoding, has_lut, padding, monkeypatch
):
    monkeypatch.setattr(color_table, 'HAS_16_BIT_LUT', has_lut)
    colors = tuple(ReferenceColor.from_rgb(f'{rgb}', rgb, 30.0) for rgb in RGB[:2])
    config = DetectorConfig(colors=colors, erosion_size=1, min_area=5)
    for frame in (encode(SCENE.render(250), encoding), noise(encoding, 240, 320)):
        padded = np.full((frame.image.shape[0], 320 + padding, *frame.image.shape[2:]), 7, np.uint8)
        padded[:, :320] = frame.image
        detector, first = Detector(config), Detector(config)
        rows = detector.detect(Frame(padded[:, :320], encoding)).rows
        np.testing.assert_array_equal(rows, first.detect(plain(frame)).rows)
        np.testing.assert_array_equal(detector.labels, first.labels)
        assert len(rows)


@pytest.mark.parametrize('encoding', ENCODINGS)
def test_rows_may_end_anywhere_in_a_word(encoding, monkeypatch):
    monkeypatch.setattr(chroma_filter, 'CONVERTED_SHARE', 9)
    table = ColorTable((ReferenceColor.from_rgb('c', RGB[0], 40.0),))
    for width in range(16, 34, 2):
        frame = noise(encoding, 24, width)
        image = ChromaFilter(table.touched).label(frame, lambda x: table.label(x, 'bgr8').pixels)
        expected = table.label(plain(frame).image, 'bgr8').pixels
        np.testing.assert_array_equal(image.pixels, expected)
        assert not image.padded[:, width:].any()
        assert (np.diff(image.filled) > 0).all()
        assert expected.any()


def test_where_much_may_have_the_color_the_picture_is_converted_for_a_while():
    table = ColorTable((ReferenceColor.from_rgb('c', (128, 128, 128), 30.0),))
    asked = []
    chroma, gray = ChromaFilter(table.touched), Frame(np.full((16, 16, 2), 128, np.uint8), 'yuyv')
    for _ in range(chroma_filter.PICTURES_OF_PAUSE + 2):
        assert chroma.label(gray, asked.append) is None
    assert asked == []
