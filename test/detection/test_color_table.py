from hypothesis import assume
from hypothesis import given
from hypothesis import settings
import numpy as np
import pictures
import pytest
import textbook

from colortrack_ros.data import Frame
from colortrack_ros.detection import color_table
from colortrack_ros.detection import ReferenceColor
from colortrack_ros.detection.color_table import ColorTable

LUTS = sorted({False, color_table.HAS_16_BIT_LUT})


@pytest.mark.parametrize('has_lut', LUTS)
@settings(deadline=None, max_examples=60)
@given(frame=pictures.frames(), colors=pictures.colors())
def test_the_mask_is_that_of_the_float_computation(has_lut, frame, colors):
    assume(textbook.is_decided(frame, colors))
    table = ColorTable(colors)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(color_table, 'HAS_16_BIT_LUT', has_lut)
        labels = table.label(frame.image, frame.encoding).pixels
    np.testing.assert_array_equal(labels, textbook.labels(frame, colors))
    np.testing.assert_array_equal(
        table.label(frame.image, frame.encoding).pixels, labels, 'the second time, from memory'
    )


def test_all_colors_around_a_boundary_are_exact():
    red, green = np.meshgrid(np.arange(256), np.arange(256))
    image = np.stack([red, green, np.full_like(red, 90)], axis=-1).astype(np.uint8)
    frame = Frame(image, 'rgb8')
    colors = (
        ReferenceColor.from_rgb('a', (200, 60, 90), 40.0),
        ReferenceColor.from_rgb('b', (150, 90, 90), 30.0),
    )
    labels = ColorTable(colors).label(image, 'rgb8').pixels
    np.testing.assert_array_equal(labels, textbook.labels(frame, colors))
    assert set(np.unique(labels)) == {0, 1, 2}


def test_at_equal_distance_the_first_color_wins():
    lab = (50.0, 20.0, 20.0)
    colors = (ReferenceColor('a', lab, 200.0), ReferenceColor('b', lab, 200.0))
    image = np.full((2, 3, 3), 128, np.uint8)
    assert (ColorTable(colors).label(image, 'bgr8').pixels == 1).all()


def test_the_largest_number_of_colors():
    random = np.random.default_rng(0)
    colors = tuple(
        ReferenceColor.from_rgb(f'{k}', random.integers(0, 256, 3).tolist(), 5.0)
        for k in range(254)
    )
    image = random.integers(0, 256, (40, 50, 3), dtype=np.uint8)
    labels = ColorTable(colors).label(image, 'rgb8').pixels
    np.testing.assert_array_equal(labels, textbook.labels(Frame(image, 'rgb8'), colors))
    assert labels.max() == 254


@pytest.mark.parametrize('height', [1, 2, 3, 301])
def test_threads_and_strips_do_not_change_the_result(height):
    random = np.random.default_rng(5)
    image = random.integers(90, 160, (height, 1000, 3), dtype=np.uint8)
    colors = (ReferenceColor('gray', (50.0, 0.0, 0.0), 12.0),)
    expected = textbook.labels(Frame(image), colors)
    for threads in (1, 2, 3):
        labels = ColorTable(colors, threads).label(image, 'bgr8').pixels
        np.testing.assert_array_equal(labels, expected)
