"""The cost functions against the plain double loop."""

from hypothesis import given
from hypothesis import settings
from hypothesis import strategies as st
import numpy as np
import pytest

from colortrack_ros.windows.costs import COSTS
from colortrack_ros.windows.costs import distances


def quotient(a, b):
    return a / b if b > 0 else 0.0


def textbook(name, one, two):
    """Table 3.1 of two windows, with the parentheses that the table lacks."""
    one, two = one.astype(float), two.astype(float)
    gain = quotient(one.mean(), two.mean())
    z1, z2 = one - one.mean(), two - two.mean()
    return {
        'sad': lambda: np.abs(one - two).sum(),
        'ssd': lambda: ((one - two) ** 2).sum(),
        'zsad': lambda: np.abs(z1 - z2).sum(),
        'zssd': lambda: ((z1 - z2) ** 2).sum(),
        'lsad': lambda: np.abs(one - gain * two).sum(),
        'lssd': lambda: ((one - gain * two) ** 2).sum(),
        'cc': lambda: (one * two).sum(),
        'ncc': lambda: quotient((one * two).sum(), np.sqrt((one**2).sum() * (two**2).sum())),
        'zncc': lambda: quotient((z1 * z2).sum(), np.sqrt((z1**2).sum() * (z2**2).sum())),
    }[name.removesuffix('_frequency')]()


def double_loop(name, template, region):
    h, w = template.shape
    rows, columns = region.shape[0] - h + 1, region.shape[1] - w + 1
    result = np.zeros((rows, columns))
    for i in range(rows):
        for j in range(columns):
            result[i, j] = textbook(name, template, region[i : i + h, j : j + w])
    return result


@st.composite
def pictures(draw):
    """A template and a region, now and then black, plain or partly black."""
    h, w = (draw(st.sampled_from([1, 3, 5, 9])) for _ in range(2))
    rows, columns = draw(st.integers(h, h + 8)), draw(st.integers(w, w + 8))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    top = draw(st.sampled_from([1, 2, 256]))
    template = rng.integers(0, draw(st.sampled_from([1, 2, 256])), (h, w))
    region = rng.integers(0, top, (rows, columns))
    region[: draw(st.integers(0, rows))] *= draw(st.booleans())
    return template.astype(np.float32), region.astype(np.float32)


@pytest.mark.slow
@pytest.mark.parametrize('name', COSTS)
@settings(deadline=None, max_examples=50)
@given(pair=pictures())
def test_a_cost_is_that_of_the_double_loop_at_every_place(name, pair):
    template, region = pair
    expected = double_loop(name, template, region)
    scale = 1.0 if 'ncc' in name else max(expected.max(), (template**2).sum(), 1.0)
    np.testing.assert_allclose(
        COSTS[name].surface(template, region), expected, rtol=1e-5, atol=4e-6 * scale
    )


@pytest.mark.parametrize('name', COSTS)
def test_the_distance_is_least_and_zero_where_the_window_is_the_template(name):
    region = np.random.default_rng(3).integers(0, 256, (60, 70)).astype(np.float32)
    # cross-correlation without a norm is drawn to the light
    region[20:35, 30:51] = 255 - region[20:35, 30:51] / 8
    template = region[20:35, 30:51].copy()
    matrix = distances(name, template, region)
    assert np.unravel_index(matrix.argmin(), matrix.shape) == (20, 30)
    assert abs(matrix[20, 30]) < 1e-5 * np.abs(matrix).max() + 1e-5


@pytest.mark.parametrize('name', ['zsad', 'zssd', 'zncc'])
def test_the_zero_mean_costs_do_not_see_brightness_nor_the_local_ones_exposure(name):
    region = np.random.default_rng(4).integers(40, 200, (40, 40)).astype(np.float32)
    template = region[7:22, 9:24]
    surface = COSTS[name].surface
    np.testing.assert_allclose(
        surface(template + 30, region), surface(template, region), rtol=1e-4, atol=5.0
    )
    local = COSTS['lssd'].surface
    matrix = local(template / 2, region)
    assert np.unravel_index(matrix.argmin(), matrix.shape) == (7, 9)
    assert matrix.min() < 1e-4 * matrix.max()
