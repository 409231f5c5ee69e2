import cv2
from hypothesis import assume
from hypothesis import given
from hypothesis import HealthCheck
from hypothesis import settings
from hypothesis import strategies as st
import numpy as np
import pytest

from colortrack_ros.contours import ContourConfig
from colortrack_ros.contours.lines import find_edges
from colortrack_ros.contours.lines import sampled

UNKNOWN = np.full((1, 4, 2), np.nan)
POINTS = np.array([[[80.0, 40.0], [80.0, 50.0], [80.0, 60.0], [80.0, 70.0]]])
RIGHT = np.tile([1.0, 0.0], (1, 4, 1))
SIGMA = np.full((1, 4), 3.0)


def textbook(line, config, sigma, usual):
    """The best edge of a line of samples from inside to outside, one after the other.

    :return: its offset from the middle, or None; it is of the full sample at first.
    """
    middle, mask = len(line) // 2, np.array(config.mask) / (np.abs(config.mask).sum() / 2)
    k = len(mask) // 2
    contrast = {j: abs(float(mask @ line[j - k : j + k + 1])) for j in range(k, len(line) - k)}
    best, most = None, config.no_edge
    half = config.line_length // 2
    for j in range(middle - half, middle + half + 1):
        here, most_beside = contrast[j], max(contrast[j - 1], contrast[j + 1])
        assume(min(abs(here - most_beside), abs(here - config.min_contrast)) > 1e-3)  # no ties
        if here < config.min_contrast or here < contrast[j - 1] or here <= contrast[j + 1]:
            continue
        score = here * np.exp(-0.5 * ((j - middle) / sigma) ** 2)
        for side, known, deviation in (
            (line[j - 6 : j - 1].mean(), usual[0], config.inside_deviation),
            (line[j + 2 : j + 7].mean(), usual[1], config.outside_deviation),
        ):
            if deviation > 0 and not np.isnan(known):
                score *= np.exp(-0.5 * ((side - known) / deviation) ** 2)
        assume(abs(score - most) > 1e-4)
        if score > most:
            best, most = j, score
    if best is None:
        return None
    a, b, c = contrast[best - 1], contrast[best], contrast[best + 1]
    return best - middle + np.clip((c - a) / (2 * (2 * b - a - c)), -0.5, 0.5)


@pytest.mark.slow
@given(
    st.integers(0, 10_000), st.sampled_from([8, 15, 30]), st.floats(1, 8), st.floats(0, 30),
    st.sampled_from([(-1.2, -2.0, 0.0, 2.0, 1.2), (-1.0, 0.0, 1.0), (-1, -1, -1, 0, 1, 1, 1)]),
)  # fmt: skip
@settings(max_examples=80, deadline=None, suppress_health_check=[HealthCheck.filter_too_much])
def test_the_edge_is_that_of_the_textbook(seed, length, sigma, no_edge, mask):
    rng = np.random.default_rng(seed)
    config = ContourConfig(line_length=length, no_edge=no_edge, mask=mask)
    image = cv2.GaussianBlur(rng.integers(0, 256, (100, 160)).astype(np.uint8), (0, 0), 2.0)
    usual = rng.uniform(100, 150, (1, 4, 2))
    usual[0, rng.random(4) < 0.5] = np.nan
    edges = find_edges(image, POINTS, RIGHT, np.full((1, 4), sigma), usual, config)
    lines = sampled(image, POINTS[0], RIGHT[0], 30).astype(float)
    for i, line in enumerate(lines):
        wanted = textbook(line, config, sigma, usual[0, i])
        assert edges.found[0, i] == (wanted is not None)
        assert edges.offset[0, i] == pytest.approx(wanted or 0.0, abs=1e-3)


def step(place, low=40, high=200, width=160):
    """A picture of two levels with its edge at u = place, anti-aliased."""
    cover = np.clip(np.arange(width) - place + 0.5, 0, 1)
    return np.tile(np.rint(low + (high - low) * cover).astype(np.uint8), (100, 1))


@pytest.mark.parametrize('place', [70.0, 76.3, 80.0, 83.75, 88.5])
def test_an_edge_is_found_to_a_fraction_of_a_pixel(place):
    config = ContourConfig(line_length=30, sigma=6.0)
    edges = find_edges(step(place), POINTS, RIGHT, SIGMA * 2, UNKNOWN, config)
    assert edges.found.all()
    np.testing.assert_allclose(edges.offset, place - 80, atol=0.1)
    np.testing.assert_allclose(edges.sides, np.tile([40, 200], (1, 4, 1)), atol=1)


def test_a_line_across_no_edge_has_none():
    flat = np.full((100, 160), 90, np.uint8)
    edges = find_edges(flat, POINTS, RIGHT, SIGMA, UNKNOWN, ContourConfig())
    assert not edges.found.any()
    far = find_edges(step(94), POINTS, RIGHT, SIGMA, UNKNOWN, ContourConfig(no_edge=2.0))
    assert not far.found.any()
    believed = find_edges(step(94), POINTS, RIGHT, SIGMA, UNKNOWN, ContourConfig(no_edge=0.0))
    assert believed.found.all()


def test_an_edge_beside_which_other_things_are_is_none():
    usual = np.tile([40.0, 200.0], (1, 4, 1))
    usual[0, 1, 0], usual[0, 2, 1] = 140.0, 20.0
    edges = find_edges(step(80), POINTS, RIGHT, SIGMA, usual, ContourConfig())
    assert edges.found.tolist() == [[True, False, False, True]]
    any_will_do = ContourConfig(inside_deviation=0.0, outside_deviation=0.0)
    assert find_edges(step(80), POINTS, RIGHT, SIGMA, usual, any_will_do).found.all()


def test_the_nearer_of_two_equal_edges_is_taken_and_a_much_stronger_one_farther_away():
    image = step(77, 40, 120)
    image[:, 85:] = 200
    near = find_edges(image, POINTS, RIGHT, SIGMA, UNKNOWN, ContourConfig())
    np.testing.assert_allclose(near.offset, -3, atol=0.3)
    image = step(77, 40, 60)
    image[:, 84:] = 220
    strong = find_edges(image, POINTS, RIGHT, SIGMA, UNKNOWN, ContourConfig())
    np.testing.assert_allclose(strong.offset, 3.5, atol=0.3)


@pytest.mark.parametrize('kind', ['bgr8', 'bgra8', 'strided'])
def test_intensity_is_the_greatest_channel_whatever_the_encoding(kind):
    gray = step(80)
    image = np.stack([gray // 2, gray, gray // 3], axis=2)
    if kind == 'bgra8':
        image = np.dstack([image, np.full_like(gray, 255)])
    if kind == 'strided':
        image = np.concatenate([image, image], axis=1)[:, :160]
    one = sampled(gray, POINTS[0], RIGHT[0], 20)
    assert (sampled(image, POINTS[0], RIGHT[0], 20) == one).all()


@pytest.mark.parametrize(
    'points', [POINTS - 1000, POINTS + np.array([80, 0]), POINTS * 1e30, POINTS * 0]
)
def test_lines_that_leave_the_picture_find_nothing_there(points):
    edges = find_edges(step(80), points, RIGHT, SIGMA, UNKNOWN, ContourConfig())
    assert not edges.found.any()
    assert np.isfinite(edges.offset).all()


@pytest.mark.parametrize('shape', [(0, 0), (1, 1), (0, 5, 3), (2, 3, 4)])
def test_tiny_pictures_do_no_harm(shape):
    edges = find_edges(np.zeros(shape, np.uint8), POINTS, RIGHT, SIGMA, UNKNOWN, ContourConfig())
    assert not edges.found.any()
    none = find_edges(step(80), POINTS[:0], RIGHT[:0], SIGMA[:0], UNKNOWN[:0], ContourConfig())
    assert none.found.shape == (0, 4)
