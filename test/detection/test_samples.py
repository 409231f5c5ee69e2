"""Colors taught by examples: what is it, and what is not."""

from dataclasses import replace

import numpy as np
import pytest

from colortrack_ros.data import Frame
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.detection import color_table
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection.color_table import ColorTable
from colortrack_ros.detection.lab import lab_from_rgb
from colortrack_ros.detection.reference import reference_color_of
from colortrack_ros.detection.reference import ReferenceColor
from colortrack_ros.detection.reference import ReferenceColorConfig

ORANGE, YELLOW, SHADE, WALL = (230, 120, 30), (220, 190, 40), (90, 40, 10), (180, 180, 170)


def taught(samples, others=(), tolerance=0.0):
    config = ReferenceColorConfig(
        samples=tuple(map(float, np.ravel(samples))),
        others=tuple(map(float, np.ravel(others))),
        tolerance=tolerance,
    )
    return reference_color_of('ball', config)


def squares(*colors):
    """Squares of 40 px beside each other on a wall."""
    image = np.full((120, 60 * len(colors) + 20, 3), WALL[::-1], float)
    for k, color in enumerate(colors):
        image[40:80, 60 * k + 20 : 60 * k + 60] = color[::-1]
    noise = np.random.default_rng(0).normal(0, 2, image.shape)
    return Frame(np.clip(image + noise, 0, 255).astype(np.uint8))


def columns(frame, color):
    rows = Detector(DetectorConfig(colors=(color,))).detect(frame).rows
    return sorted((rows['u'] // 60).astype(int).tolist())


def test_each_sample_is_it():
    frame = squares(ORANGE, YELLOW, SHADE)
    assert columns(frame, taught([ORANGE, SHADE])) == [0, 2]
    assert columns(frame, taught([ORANGE, SHADE], tolerance=15.0)) == [0, 2]


def test_what_is_nearer_to_an_example_of_something_else_is_not_it():
    frame = squares(ORANGE, YELLOW)
    assert columns(frame, taught([ORANGE], tolerance=90.0)) != [0]
    assert columns(frame, taught([ORANGE], [YELLOW, WALL], tolerance=90.0)) == [0]


@pytest.mark.slow
def test_the_table_says_what_the_distances_to_the_samples_say():
    color = taught([ORANGE, SHADE], [YELLOW, (200, 90, 60)], tolerance=40.0)
    rgb = np.random.default_rng(1).integers(0, 256, (400, 500, 3), np.uint8)
    lab = lab_from_rgb(rgb)

    def nearest(shades):
        return np.min([np.linalg.norm(lab - shade, axis=-1) for shade in shades], axis=0)

    mine, other = nearest((color.lab, *color.samples)), nearest(color.others)
    labels = ColorTable((color,)).label(rgb, 'rgb8').pixels
    assert 0 < labels.mean() < 1
    assert (labels == ((mine < 40) & (mine < other))).all()
    inside = labels == 1
    closeness = ColorTable((color,)).closeness(rgb[inside], labels[inside])
    assert closeness == pytest.approx(1 - mine[inside] / 40)


@pytest.mark.parametrize('key', ['samples', 'others'])
def test_half_a_color_is_refused(key):
    config = ReferenceColorConfig(lab=(50.0, 10.0, 10.0), **{key: (1.0, 2.0, 3.0, 4.0)})
    with pytest.raises(ValueError, match=rf'ball\.{key}: expected r, g, b of each color.*got 4'):
        reference_color_of('ball', config)


@pytest.mark.parametrize('key', ['samples', 'others'])
def test_so_many_samples_that_a_node_would_stand_still_are_refused(key):
    config = ReferenceColorConfig(lab=(50.0, 10.0, 10.0), **{key: (9.0, 90.0, 9.0) * 257})
    with pytest.raises(ValueError, match=rf'ball\.{key}: expected at most 256 colors, got 257'):
        reference_color_of('ball', config)


@pytest.mark.slow
@pytest.mark.parametrize('has_lut', sorted({False, color_table.HAS_16_BIT_LUT}))
def test_the_table_of_everything_else_says_what_the_distances_say(has_lut, monkeypatch):
    monkeypatch.setattr(color_table, 'HAS_16_BIT_LUT', has_lut)
    ground = replace(taught([WALL, SHADE], [(150, 150, 90)], tolerance=30.0), inverted=True)
    ball = taught([ORANGE], tolerance=35.0)
    rgb = np.random.default_rng(1).integers(0, 256, (400, 500, 3), np.uint8)
    lab = lab_from_rgb(rgb)

    def nearest(shades):
        return np.min([np.linalg.norm(lab - shade, axis=-1) for shade in shades], axis=0)

    mine, other = nearest((ground.lab, *ground.samples)), nearest(ground.others)
    expected = np.where((mine < 30) & (mine < other), 0, 1)
    np.testing.assert_array_equal(ColorTable((ground,)).label(rgb, 'rgb8').pixels, expected)
    expected[nearest([ball.lab]) < 35] = 2
    np.testing.assert_array_equal(ColorTable((ground, ball)).label(rgb, 'rgb8').pixels, expected)


@pytest.mark.parametrize('tolerance', [0.0, 25.0])
def test_everything_that_is_not_the_color_of_the_ground_is_found(tolerance):
    ground = replace(taught([WALL], tolerance=tolerance), inverted=True)
    assert columns(squares(ORANGE, YELLOW, WALL, SHADE), ground) == [0, 1, 3]


@pytest.mark.parametrize('lab', [(50.0, 60.0, 40.0), (75.0, 0.0, 0.0)])
def test_where_the_ground_is_not_in_the_picture_or_is_all_of_it_nothing_is_found(lab):
    detector = Detector(DetectorConfig(colors=(ReferenceColor('ground', lab, 0.0, inverted=True),)))
    for k in range(4):
        empty = Frame(np.full((120, 160, 3), 183, np.uint8), stamp=k * NANOSECONDS)
        assert len(detector.detect(empty).rows) == 0


def test_the_uneven_light_of_a_ground_is_no_thing_before_there_is_one():
    v, u = np.indices((240, 320))
    light = 85 - 160 * ((u / 320 - 0.4) ** 2 + (v / 240 - 0.5) ** 2)
    noise = np.random.default_rng(0).normal(0, 2, (3, 240, 320, 3))
    empty, entering, there = np.repeat(light[..., None], 3, axis=2) + noise
    entering[40:200, :20] = there[40:200, 100:150] = 200
    ground = ReferenceColor.from_rgb('ground', (80, 80, 80), 0.0)
    detector = Detector(DetectorConfig(colors=(replace(ground, inverted=True),)))
    found = [
        detector.detect(
            Frame(np.clip(picture, 0, 255).astype(np.uint8), stamp=k * NANOSECONDS)
        ).rows
        for k, picture in enumerate((empty, empty, entering, there))
    ]
    assert [len(rows) for rows in found[:2]] == [0, 0]
    (last,) = found[-1]
    assert last['u'] == pytest.approx(124.5, abs=1)
