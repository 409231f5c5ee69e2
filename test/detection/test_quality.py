"""Centroids and their covariances against the truth of the rendered scenes."""

from functools import cache

import numpy as np
import pytest

from colortrack_ros.data import Frame
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection import ReferenceColor
from colortrack_ros.detection import Region
from colortrack_ros.scenes import open_scene
from colortrack_ros.scenes.shapes import draw_ball

SCENES = ('single', 'enter_exit', 'five', 'crossing', 'occlusion')


@cache
def errors(spec, tolerances=(50.0,), step=12):
    """By tolerance, (N, 3) of whole balls: error in u, v [px], normalized squared error / 2."""
    scene = open_scene(spec)
    (color,) = scene.colors.items()
    detectors = [
        Detector(DetectorConfig(colors=(ReferenceColor.from_rgb(*color, tolerance),)))
        for tolerance in tolerances
    ]
    found = [[] for _ in tolerances]
    for k in range(0, len(scene), step):
        frame, truth = Frame(scene.render(k)), scene.truth(k)
        for detector, own in zip(detectors, found, strict=True):
            own += _errors(detector.detect(frame).rows, truth)
    return [np.array(own) for own in found]


def _errors(rows, truth):
    assert len(rows) <= len(truth), 'a false blob, or a ball in pieces'
    for ball in truth[truth['visible'] == 1]:
        error = np.array([rows['u'] - ball['u'], rows['v'] - ball['v']]).T
        nearest = np.linalg.norm(error, axis=1).argmin()
        row, error = rows[nearest], error[nearest]
        covariance = [[row['cov_uu'], row['cov_uv']], [row['cov_uv'], row['cov_vv']]]
        yield *error, error @ np.linalg.solve(covariance, error) / 2


@pytest.mark.slow
@pytest.mark.parametrize(('spec', 'limit'), [('single?noise=0', 0.15), ('single', 0.3)])
def test_centroids_are_better_than_a_pixel(spec, limit):
    error = errors(spec)[0][:, :2]
    assert np.sqrt((error**2).sum(axis=1).mean()) < limit


@pytest.mark.slow
@pytest.mark.parametrize(
    ('size', 'tolerances', 'step'),
    [
        ((320, 240), (50.0,), 12), ((640, 480), (50.0, 35.0), 12), ((1280, 720), (50.0, 35.0), 12),
        ((1920, 1080), (50.0, 35.0), 24), ((3840, 2160), (50.0,), 48),
    ],
)  # fmt: skip
def test_the_covariance_is_neither_bold_nor_shy(size, tolerances, step):
    specs = ['{}?width={}&height={}'.format(name, *size) for name in SCENES]
    for found in zip(*[errors(spec, tolerances, step) for spec in specs], strict=True):
        assert 0.8 < np.concatenate(found)[:, 2].mean() < 1.25


def test_a_blob_that_may_go_on_behind_what_was_dropped_is_known_badly():
    v, u = np.indices((120, 160))
    image = np.full((120, 160, 3), 110, np.uint8)
    image[np.hypot(u - 50, v - 60) < 20] = (34, 58, 205)
    pole = Region('pole', ((52, 0), (90, 0), (90, 119), (52, 119)), ignore=True)
    whole, cut, beside = (
        Detector(DetectorConfig(regions=regions)).detect(Frame(image)).rows[0]
        for regions in ((), (pole,), (Region('door', ((90, 0), (90, 99), (99, 99)), ignore=True),))
    )
    assert beside == whole
    assert cut['u'] < whole['u'] - 5
    assert (cut['u'] - whole['u']) ** 2 < 9 * cut['cov_uu']


@pytest.mark.parametrize('center', [12, 6, -8])
def test_a_ball_partly_out_of_the_picture_is_as_far_from_its_center_as_it_is_said(center):
    image = np.full((160, 240, 3), 110, np.uint8)
    v, u = np.indices(image.shape[:2])
    image[np.hypot(u - center, v - 80) < 24] = (34, 58, 205)
    (row,) = Detector(DetectorConfig()).detect(Frame(image)).rows
    assert 0.3 < (row['u'] - center) ** 2 / row['cov_uu'] < 2
    assert row['cov_vv'] < 0.1


@pytest.mark.slow
def test_a_ball_before_things_of_its_color_is_known_worse():
    """Three sigma where one is due: at 15 px a frame and a tight tolerance blur shifts it."""
    scene = open_scene('clutter?duration=6')
    colors = [ReferenceColor.from_rgb(*color, 25.0) for color in scene.colors.items()]
    config = DetectorConfig(
        colors=tuple(colors), moving_only=True, min_area=200, max_area=4000, min_aspect=0.3
    )
    detector, squared = Detector(config), []
    for k in range(len(scene)):
        frame = Frame(scene.render(k), stamp=round(k * NANOSECONDS / scene.rate))
        rows = detector.detect(frame).rows
        for ball in scene.truth(k):
            error = np.array([rows['u'] - ball['u'], rows['v'] - ball['v']])
            near = (rows['color'] == ball['color']) & (np.hypot(*error) < ball['radius'])
            sigma2 = rows['cov_uu'][near] + rows['cov_vv'][near]
            squared += (np.sum(error[:, near] ** 2, axis=0) / sigma2).tolist()
    assert np.mean(squared) < 5


def test_the_covariance_of_a_ball_that_leaves_the_picture_covers_its_hidden_part():
    scene, detector = open_scene('enter_exit'), Detector(DetectorConfig())
    squared = []
    for k in range(len(scene)):
        truth = scene.truth(k)
        cut = truth[(truth['visible'] > 0.2) & (truth['visible'] < 0.98)]
        for ball in cut:
            (row,) = detector.detect(Frame(scene.render(k))).rows
            squared.append((row['u'] - ball['u']) ** 2 / row['cov_uu'])
    assert len(squared) > 5
    assert 0.2 < np.mean(squared) < 1.25


def test_light_from_one_side_shifts_a_centroid_along_both_axes_together():
    image = np.full((160, 240, 3), (110, 105, 100), np.uint8)
    draw_ball(image, np.array([120.3, 80.2]), np.array([6.0, 3.0]), 24.0, np.array((34, 58, 205)))
    correlations = []
    for picture in (image, image[:, ::-1].copy()):
        (row,) = Detector(DetectorConfig()).detect(Frame(picture)).rows
        correlations.append(row['cov_uv'] / np.sqrt(row['cov_uu'] * row['cov_vv']))
    assert correlations[0] > 0.2  # the light is at the top left
    assert correlations[1] < -0.2
