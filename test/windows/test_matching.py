import cv2
from hypothesis import given
from hypothesis import settings
from hypothesis import strategies as st
import numpy as np
import pytest
from support.window_pictures import frame
from support.window_pictures import texture

from colortrack_ros.data import ENCODINGS
from colortrack_ros.data import Frame
from colortrack_ros.windows import WindowConfig
from colortrack_ros.windows.costs import COSTS
from colortrack_ros.windows.crop import Crop
from colortrack_ros.windows.matching import match_templates
from colortrack_ros.windows.matching import refine
from colortrack_ros.windows.matching import reliability_map
from colortrack_ros.windows.matching import SUBPIXEL_SIGMA
from colortrack_ros.windows.template import COARSE_SIDE
from colortrack_ros.windows.template import Template


def look(picture, template, expected, half=20.0, usual=np.inf, **settings):
    """What is found for one template, around where it is expected."""
    return match_templates(
        frame(picture), [Template(template)], np.array([expected], float),
        np.array([[half, half]]), np.array([usual]), WindowConfig(**settings),
    )  # fmt: skip


def cut(picture, center, size=21):
    return Crop(picture, np.zeros(2, int)).window(np.array(center, float), (size, size))


@pytest.mark.parametrize('name', [n for n in COSTS if n != 'cc'])
@pytest.mark.parametrize('compensation', [False, True])
def test_every_cost_finds_the_place_with_a_fraction_of_a_pixel(name, compensation):
    picture = texture(1)
    shift = np.array([7.3, -4.6])
    moved = cv2.warpAffine(picture, np.array([[1, 0, 7.3], [0, 1, -4.6]]), (160, 120))
    found = look(
        moved, cut(picture, (80, 60)), (80, 60), cost=name, drift_compensation=compensation
    )
    assert np.abs(found.z - 80 - shift + [0, 20]).max() < (0.03 if compensation else 0.25)
    assert found.similarity[0] > 0.99


def test_nothing_is_found_where_no_window_of_the_region_is_inside_the_picture():
    picture = texture(2)
    for expected in [(-30, 60), (300, 60), (80, -31), (80, 500)]:
        found = look(picture, cut(picture, (80, 60)), expected)
        assert np.isnan(found.similarity[0])
        assert found.crops == [None]
        assert not found.are_valid(np.zeros(1), WindowConfig())[0]
    assert look(picture, texture(3, 201, 201), (80, 60)).crops == [None]


@settings(deadline=None, max_examples=50)
@given(
    u=st.floats(-0.49, 0.49), v=st.floats(-0.49, 0.49), a=st.floats(0.5, 5), b=st.floats(0.5, 5),
    twist=st.floats(-0.9, 0.9),
)  # fmt: skip
def test_refine_finds_the_minimum_and_the_covariance_of_a_paraboloid(u, v, a, b, twist):
    y, x = np.mgrid[-1:2, -1:2]

    def around(u, v, c):
        d = np.stack([x - u, y - v])
        return (0.01 + np.einsum('iyx,ij,jyx->yx', d, np.array([[a, c], [c, b]]), d) / 2)[None]

    shift, _ = refine(around(u, v, 0), np.array([100]))
    np.testing.assert_allclose(shift[0], [u, v], atol=1e-6)
    c = twist * np.sqrt(a * b)
    _, R = refine(around(0, 0, c), np.array([10_000]))
    expected = 2 * 0.01 / 10_000 * np.linalg.inv([[a, c], [c, b]])
    np.testing.assert_allclose(
        R[0] - SUBPIXEL_SIGMA**2 * np.eye(2), expected, rtol=0.03, atol=0.03 * expected.max()
    )


def test_the_covariance_is_that_of_many_noisy_matches():
    rng, clean = np.random.default_rng(5), texture(5)
    places, R = [], []
    for _ in range(150):
        one, other = (clean + rng.normal(0, 6, clean.shape).astype(np.float32) for _ in range(2))
        found = look(one, other[52:67, 72:87].copy(), (79, 59), half=5.0, drift_compensation=False)
        places.append(found.z[0])
        R.append(found.R[0])
    ratio = np.diag(np.cov(np.array(places).T)) / np.diag(np.mean(R, axis=0))
    assert (ratio > 0.5).all()
    assert (ratio < 2.0).all()


def test_a_match_along_an_edge_or_in_a_plain_place_is_not_valid():
    config = WindowConfig(min_similarity=0.0, max_deviation=0.3)
    edge = np.tile(60 + 120 / (1 + np.exp(-np.arange(-80.0, 80.0))), (120, 1))
    cases = [(edge, False), (np.full((120, 160), 100.0), False), (texture(6), True)]
    for picture, expected in cases:
        valid = []
        for seed in range(20):
            rng = np.random.default_rng(seed)
            one, other = (picture + rng.normal(0, 3, picture.shape) for _ in range(2))
            found = look(other, one[50:71, 70:91].astype(np.float32), (80, 60))
            valid.append(bool(found.are_valid(np.zeros(1), config)[0]))
        assert np.mean(valid) >= 0.9 if expected else np.mean(valid) <= 0.1


def test_of_candidates_alike_the_nearest_wins_unless_it_is_farther_than_usual():
    picture = np.full((120, 160), 100.0)
    patch = texture(7, 21, 21)
    picture[50:71, 60:81] = patch + 1  # nearer to (80, 60), by 10 px
    picture[50:71, 92:113] = patch  # the better one, by 22 px
    near = look(picture, patch, (80, 60), half=30, ambiguity=0.9, usual=15.0)
    # both are candidates: one gray level on 441 pixels against the rounding
    assert not near.alone[0]
    assert abs(near.z[0, 0] - 70) < 0.1
    assert (
        abs(look(picture, patch, (80, 60), half=30, ambiguity=0.9, usual=9.0).z[0, 0] - 102) < 0.1
    )
    assert abs(look(picture, patch, (80, 60), half=30, ambiguity=0.0).z[0, 0] - 102) < 0.1


@pytest.mark.parametrize('encoding', ['bgr8', 'rgb8', 'bgra8', 'rgba8', 'mono8'])
def test_every_encoding_is_searched(encoding):
    gray = texture(8).astype(np.uint8)
    channels = ENCODINGS[encoding]
    image = gray if channels == 1 else np.repeat(gray[..., None], channels, axis=2)
    found = match_templates(
        Frame(image, encoding), [Template(cut(texture(8), (90, 50)))], np.array([[85.0, 55.0]]),
        np.full((1, 2), 20.0), np.array([np.inf]), WindowConfig(),
    )  # fmt: skip
    np.testing.assert_allclose(found.z, [[90, 50]], atol=0.05)


def test_the_map_is_brightest_where_the_window_is_the_template():
    surface = np.array([[4.0, 2.0, 4.0], [2.0, 0.0, 2.0]])
    picture = reliability_map([(np.array([5, 3]), surface, 1)], (8, 12))
    assert picture.shape == (8, 12)
    np.testing.assert_array_equal(picture[3:5, 5:8], [[0, 127, 0], [127, 255, 127]])
    assert picture.sum() == 255 + 3 * 127
    coarse = reliability_map([(np.array([4, 2]), surface, 2)], (8, 12))
    np.testing.assert_array_equal(coarse[2:6:2, 4:10:2], picture[3:5, 5:8])
    assert coarse.sum() == 4 * picture.sum()
    assert not reliability_map([], (8, 12)).any()


@pytest.mark.parametrize('size', [(31, 31), (161, 151), (261, 201)])
@pytest.mark.parametrize(('aligned', 'exactly'), [(True, 0.05), (False, 0.1)])
def test_a_window_is_found_as_exactly_on_a_picture_that_is_smaller(size, aligned, exactly):
    around, errors, shares = texture(3, 480, 640, cell=6.0), [], []
    center = np.array([320.0, 240.0])
    template = Template.of(frame(around), center, *size)
    assert template.picture.size <= max(31 * 31, 4 * COARSE_SIDE**2)
    for k in range(12):
        shift = np.array([-7.0 + 1.13 * k, 6.0 - 0.87 * k])
        matrix = np.hstack([np.eye(2), shift[:, None]])
        picture = cv2.warpAffine(around, matrix, (640, 480), flags=cv2.INTER_CUBIC)
        picture += np.random.default_rng(k).normal(0, 2, picture.shape)
        found = match_templates(
            frame(picture), [template], center[None], np.full((1, 2), 20.0), np.array([np.inf]),
            WindowConfig(drift_compensation=aligned),
        )  # fmt: skip
        errors.append(found.z[0] - center - shift)
        shares.append(found.similarity[0])
        assert found.are_sharp(0.5).all()
    assert np.sqrt(np.square(errors).mean()) < exactly
    assert min(shares) > 0.9


@pytest.mark.parametrize('place', [(90.0, 90.0), (550.0, 390.0)])
def test_a_large_window_is_found_up_to_the_rim_of_the_picture(place):
    picture = texture(4, 480, 640, cell=6.0)
    template = Template.of(frame(picture), np.array(place), 161, 151)
    expected = np.add(place, (3.0, -3.0))[None]
    found = match_templates(
        frame(picture), [template], expected, np.full((1, 2), 3.0), np.array([np.inf]),
        WindowConfig(),
    )  # fmt: skip
    np.testing.assert_allclose(found.z[0], place, atol=0.5)
