"""Errors that last are part of what is published: no filter averages them."""

import cv2
import numpy as np
import pytest
from support.window_pictures import frame
from support.window_pictures import texture

from colortrack_ros.windows import WindowConfig
from colortrack_ros.windows import WindowTracker

CHI2 = 5.99
"""95 % of the squared errors of a middle, normalized by the covariance, are below."""

SIZE = 41
EXACT = WindowConfig(box_error=0.0)
"""First boxes are where the scene has its objects."""


def cloth(k, amplitude):
    """A patch that moves, stretched here and squeezed there by some pixels, and its middle."""
    picture = (0.25 * texture(20, 240, 320) + 90).astype(np.float32)
    u, v = 60 + round(1.5 * k), 110 + round(0.5 * k)
    wave, half = 2 * np.pi * k / 40, SIZE // 2
    y, x = np.mgrid[-half : half + 1, -half : half + 1].astype(np.float32)
    du = amplitude * np.sin(wave + y / 9) * np.cos(x / 13 + 0.7 * wave)
    dv = amplitude * np.sin(0.6 * wave + x / 8) * np.cos(y / 12 + 0.9 * wave)
    patch = cv2.remap(texture(21, 121, 121), x + 60 + du, y + 60 + dv, cv2.INTER_LINEAR)
    picture[v - half : v + half + 1, u - half : u + half + 1] = patch
    return picture, np.array([u, v], float)


def squared_errors(amplitude, config=EXACT, off=(0.0, 0.0), frames=80):
    """Of the middle, normalized by the covariance, and sigma [px], (K, 2).

    off: how far the first box is drawn beside the middle.
    """
    corner = cloth(0, amplitude)[1] - SIZE // 2 + off
    tracker, found = WindowTracker(config, [[*corner, SIZE, SIZE]]), []
    for k in range(frames):
        picture, middle = cloth(k, amplitude)
        (row,) = tracker.update(frame(picture, k)).rows
        e, P = np.array([row['u'], row['v']]) - middle, row['covariance'][:2, :2]
        found.append((e @ np.linalg.solve(P, e), np.sqrt(P.diagonal().max())))
    return np.array(found[1:])


@pytest.mark.slow
@pytest.mark.parametrize('amplitude', [2.0, 3.0, 5.0])
def test_the_middle_of_what_deforms_is_where_the_ellipse_says(amplitude):
    """By templates that are renewed again and again, and by its appearance."""
    found = squared_errors(amplitude)
    assert (found[:, 0] < CHI2).mean() > 0.85
    assert found[:, 0].mean() > 0.2  # not by ellipses as large as the picture


@pytest.mark.slow
def test_what_stays_as_it_is_is_known_exactly():
    assert squared_errors(0.0)[:, 1].max() < 0.1


@pytest.mark.slow
def test_the_middle_is_where_the_ellipse_says_when_boxes_are_drawn_by_hand():
    """Some 2 px beside the middle of 41 px, as those of two people are who label a picture."""
    offsets = np.random.default_rng(0).normal(0.0, 0.04 * SIZE, (25, 2))
    found = np.stack([squared_errors(0.0, WindowConfig(), off, 12) for off in offsets])
    assert 0.88 < (found[..., 0] < CHI2).mean() <= 1.0
    assert 0.5 < found[..., 0].mean() / 2 < 1.5  # and not by ellipses as large as the picture


def test_a_new_target_is_no_more_exact_than_its_box():
    tracker = WindowTracker(WindowConfig(), [[60, 50, SIZE, SIZE]])
    (row,) = tracker.update(frame(cloth(0, 0.0)[0], 0)).rows
    assert np.sqrt(row['covariance'][0, 0]) > 0.05 * SIZE


def test_a_window_without_a_pattern_has_a_covariance_all_the_same():
    """Without drift compensation it is followed still, with a correlation of 0."""
    config = WindowConfig(drift_compensation=False)
    picture, middle = cloth(0, 0.0)
    tracker = WindowTracker(config, [[*(middle - SIZE // 2), SIZE, SIZE]])
    flat = np.full_like(picture, 90.0)
    for k, shown in enumerate([picture, picture, flat, flat, flat]):
        rows = tracker.update(frame(shown, k)).rows
        assert np.isfinite(rows['covariance']).all()
