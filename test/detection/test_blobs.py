from hypothesis import given
from hypothesis import settings
from hypothesis import strategies as st
import numpy as np
from support import textbook

from colortrack_ros.detection.blobs import find_blobs
from colortrack_ros.detection.blobs import sample_pixels
from colortrack_ros.detection.label_image import LabelImage


def image_of(labels):
    image = LabelImage.empty(*labels.shape)
    image.pixels[...] = labels
    return image


@settings(deadline=None, max_examples=150)
@given(
    seed=st.integers(0, 2**32 - 1),
    shape=st.tuples(st.integers(1, 30), st.integers(1, 30)),
    share=st.floats(0, 1),
    count=st.integers(1, 3),
)
def test_components_and_moments_are_those_of_the_textbook(seed, shape, share, count):
    random = np.random.default_rng(seed)
    labels = random.integers(1, count + 1, shape) * (random.random(shape) < share)
    blobs = find_blobs(image_of(labels), 2, 200)
    expected = [
        (label, *row)
        for label in range(1, count + 1)
        for row in textbook.blobs(labels == label, 2, 200)
    ]
    found = np.column_stack([blobs.label, blobs.area, blobs.mean, blobs.box])
    assert sorted(map(tuple, found.round(9))) == sorted(
        tuple(np.round(row, 9).tolist()) for row in expected
    )
    assert (np.diff(blobs.area) <= 0).all()


def test_the_spread_is_the_covariance_of_the_pixels():
    random = np.random.default_rng(3)
    labels = random.random((40, 50)) < 0.6
    blobs = find_blobs(image_of(labels), 400, 10_000)
    assert len(blobs.area) == 1
    components, _ = textbook.ndimage.label(labels, textbook.EIGHT)
    v, u = np.nonzero(components == np.bincount(components.ravel())[1:].argmax() + 1)
    np.testing.assert_allclose(blobs.spread[0], np.cov(u, v, bias=True))


def test_blobs_of_equal_area_come_in_raster_order():
    labels = np.zeros((9, 9), np.uint8)
    labels[0, 5:7] = labels[4, 0:2] = labels[8, 3:5] = labels[0, 1:3] = 1
    assert find_blobs(image_of(labels), 1, 9).box[:, :2].tolist() == [
        [1, 0],
        [5, 0],
        [0, 4],
        [3, 8],
    ]


def test_pixels_are_connected_over_corners_but_not_over_the_border():
    labels = np.array([[1, 0, 0, 1], [0, 1, 0, 0], [0, 0, 0, 1], [1, 0, 0, 0]])
    assert find_blobs(image_of(labels), 1, 9).area.tolist() == [2, 1, 1, 1]


@settings(deadline=None, max_examples=50)
@given(seed=st.integers(0, 2**32 - 1), most=st.integers(1, 30))
def test_sampled_pixels_are_different_pixels_of_their_blob(seed, most):
    random = np.random.default_rng(seed)
    labels = random.random((20, 20)) < 0.4
    blobs = find_blobs(image_of(labels), 1, 400)
    blob, position = sample_pixels(blobs, most)
    components, _ = textbook.ndimage.label(labels, textbook.EIGHT)
    component = components[np.divmod(position, 24)]
    assert len(set(position.tolist())) == len(position)
    assert (component > 0).all()
    for k, area in enumerate(blobs.area):
        assert len(set(component[blob == k].tolist())) == 1
        assert np.count_nonzero(blob == k) == min(area, most)
