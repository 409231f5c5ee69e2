from hypothesis import given
from hypothesis import settings
from hypothesis import strategies as st
import numpy as np
import pytest

from colortrack_ros.scenes.shapes import draw_ball
from colortrack_ros.scenes.shapes import draw_rectangle

RED = np.array([34, 58, 205], np.float32)


def coverage(draw):
    """What a thing hides: 1 where black and white grounds give the same picture."""
    black, white = np.zeros((120, 160, 3), np.uint8), np.full((120, 160, 3), 255, np.uint8)
    draw(black)
    draw(white)
    return 1 - (white.astype(float) - black).mean(axis=2) / 255


def moments(weight):
    v, u = np.mgrid[: weight.shape[0], : weight.shape[1]]
    total = weight.sum()
    return total, (weight * u).sum() / total, (weight * v).sum() / total


centers = st.tuples(st.floats(60, 100), st.floats(50, 70))
smears = st.tuples(st.floats(-12, 12), st.floats(-12, 12))


@pytest.mark.slow
@settings(max_examples=60, deadline=None)
@given(center=centers, smear=smears, radius=st.floats(3, 35))
def test_a_ball_covers_a_disc_around_its_center_however_it_moves(center, smear, radius):
    center, smear = np.array(center), np.array(smear)
    area, u, v = moments(coverage(lambda image: draw_ball(image, center, smear, radius, RED)))
    assert area == pytest.approx(np.pi * radius**2, rel=0.03)
    assert (u, v) == pytest.approx(tuple(center), abs=0.05)


@settings(max_examples=60, deadline=None)
@given(center=centers, smear=smears, half=st.tuples(st.floats(2, 30), st.floats(2, 30)))
def test_a_rectangle_covers_its_area_around_its_center(center, smear, half):
    center, smear, half = np.array(center), np.array(smear), np.array(half)
    area, u, v = moments(coverage(lambda image: draw_rectangle(image, center, smear, half, RED)))
    assert area == pytest.approx(4 * half[0] * half[1], rel=0.01)
    # Half a pixel's worth counts at the pixel's center, up to a quarter pixel off.
    assert (u, v) == pytest.approx(tuple(center), abs=0.125 / (2 * half.min()) + 0.01)


@settings(max_examples=60, deadline=None)
@given(
    center=st.tuples(st.floats(-300, 500), st.floats(-300, 500)),
    smear=smears,
    radius=st.floats(0.5, 300),
)
def test_a_thing_may_be_outside_or_larger_than_the_picture(center, smear, radius):
    image = np.full((20, 31, 3), 100, np.uint8)
    center, smear = np.array(center), np.array(smear)
    draw_ball(image, center, smear, radius, RED)
    draw_rectangle(image, center, smear, np.array([radius, radius]), RED)
    outside = (np.abs(center - [15, 10]) - np.abs(smear) - radius > [17, 12]).any()
    assert not outside or (image == 100).all()


def test_motion_smears_a_small_ball_over_its_way():
    center, radius = np.array([80.0, 60.0]), 3.0
    still = coverage(lambda image: draw_ball(image, center, np.zeros(2), radius, RED))
    fast = coverage(lambda image: draw_ball(image, center, np.array([20.0, 0.0]), radius, RED))
    assert np.count_nonzero(still.any(axis=0)) <= 9
    assert 24 <= np.count_nonzero(fast.any(axis=0)) <= 29
    assert fast.max() < 0.4
    assert fast[60, 72:88].std() < 0.02
