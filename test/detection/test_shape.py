import cv2
import numpy as np
import pytest

from colortrack_ros.data import Frame
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection import Region
from colortrack_ros.detection.blobs import find_blobs
from colortrack_ros.detection.label_image import LabelImage
from colortrack_ros.detection.shape import aspect
from colortrack_ros.detection.shape import circularity
from colortrack_ros.detection.shape import extent
from colortrack_ros.detection.shape import solidity

RED = (34, 58, 205)


def drawn(draw, shape=(200, 300)):
    """The blobs of a mask that is drawn on."""
    image = LabelImage.empty(*shape)
    mask = np.zeros(shape, np.uint8)
    draw(mask)
    image.pixels[...] = mask
    return find_blobs(image, 1, 10**9)


def disc(mask):
    cv2.circle(mask, (100, 90), 40, 1, -1)


def bar(mask):
    mask[90:100, 20:120] = 1


def cross(mask):
    mask[60:120, 85:95] = mask[85:95, 60:120] = 1


@pytest.mark.parametrize(
    ('measure', 'draw', 'expected'),
    [
        (aspect, disc, 1.0), (aspect, bar, 0.1), (aspect, cross, 1.0),
        (extent, disc, np.pi / 4), (extent, bar, 1.0), (extent, cross, 1100 / 3600),
        (circularity, disc, 1.0), (circularity, bar, 0.189), (circularity, cross, 0.525),
        (solidity, disc, 1.0), (solidity, bar, 1.0), (solidity, cross, 1100 / 2350),
    ],
)  # fmt: skip
def test_measures_of_known_shapes(measure, draw, expected):
    assert measure(drawn(draw)) == pytest.approx(expected, rel=0.03)


def test_measures_of_single_pixels_and_lines_are_in_their_range():
    def draw(mask):
        mask[10, 10] = mask[20, 10:50] = mask[30:70, 20] = 1
        mask[range(100, 140), range(100, 140)] = 1

    blobs = drawn(draw)
    assert len(blobs.area) == 4
    for measure in (aspect, extent, circularity, solidity):
        assert ((measure(blobs) > 0) & (measure(blobs) <= 1 + 1e-12)).all()


def test_taking_some_blobs_leaves_them_as_they_were():
    def draw(mask):
        disc(mask)
        mask[5, 5:15] = mask[150:160, 200:210] = mask[180:185, 20:60] = 1

    blobs = drawn(draw)
    some = blobs.take(np.array([True, False, True, False]))
    for name in ('label', 'area', 'mean', 'spread', 'box'):
        np.testing.assert_array_equal(getattr(some, name), getattr(blobs, name)[[0, 2]])
    np.testing.assert_allclose(extent(some), extent(blobs)[[0, 2]])
    np.testing.assert_allclose(solidity(some), solidity(blobs)[[0, 2]])


def found(**parameters):
    """Left edges of what is found of a disc, a bar and a cross of the reference color."""
    mask = np.zeros((200, 500), np.uint8)
    for draw, left in ((disc, 0), (bar, 150), (cross, 300)):
        draw(mask[:, left:])
    image = np.where(mask[..., None], np.uint8(RED), np.uint8(120))
    detector = Detector(DetectorConfig(**parameters))
    rows = detector.detect(Frame(image)).rows
    return sorted(['disc', 'bar', 'cross'][int(u) // 150 if u < 300 else 2] for u in rows['u'])


def test_without_demands_every_shape_is_found():
    assert found() == ['bar', 'cross', 'disc']


@pytest.mark.parametrize(
    ('parameters', 'expected'),
    [
        ({'min_aspect': 0.5}, ['cross', 'disc']),
        ({'min_extent': 0.5}, ['bar', 'disc']),
        ({'min_circularity': 0.9}, ['disc']),
        ({'min_solidity': 0.8}, ['bar', 'disc']),
        ({'min_solidity': 0.8, 'min_aspect': 0.5}, ['disc']),
    ],
)
def test_shapes_that_are_not_asked_for_are_dropped(parameters, expected):
    assert found(**parameters) == expected


LEFT = ((0, 0), (149, 0), (149, 199), (0, 199))
MIDDLE = ((150, 0), (299, 0), (299, 199), (150, 199))


@pytest.mark.parametrize(
    ('regions', 'expected'),
    [
        ([Region('a', LEFT)], ['disc']),
        ([Region('a', LEFT), Region('b', MIDDLE)], ['bar', 'disc']),
        ([Region('a', LEFT, ignore=True)], ['bar', 'cross']),
        ([Region('a', LEFT, ignore=True), Region('b', ((0, 0), (299, 0), (0, 900)))], ['bar']),
    ],
)
def test_only_the_regions_are_looked_in(regions, expected):
    assert found(regions=tuple(regions)) == expected


def test_a_picture_tells_where_not_to_look(tmp_path):
    mask = np.full((20, 50), 255, np.uint8)
    mask[:, :15] = 0
    cv2.imwrite(str(tmp_path / 'mask.png'), mask)
    assert found(mask=str(tmp_path / 'mask.png')) == ['bar', 'cross']


def test_a_mask_that_is_no_picture_is_refused_and_the_old_configuration_stays(tmp_path):
    detector = Detector(DetectorConfig())
    with pytest.raises(ValueError, match=r'mask: expected the path of a picture, got .*'):
        detector.configure(DetectorConfig(min_area=1000, mask=str(tmp_path / 'none.png')))
    image = np.full((40, 50, 3), 120, np.uint8)
    image[10:20, 20:30] = RED
    assert len(detector.detect(Frame(image)).rows) == 1


@pytest.mark.parametrize('polygon', [((0, 0), (1, 1)), ((0, 0), (1, 1), (float('nan'), 2)), ()])
def test_a_polygon_that_is_none_is_refused(polygon):
    with pytest.raises(ValueError, match=r'door\.polygon: expected .*, got '):
        Region('door', polygon)
