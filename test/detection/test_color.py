"""What the color method adds for real rooms."""

from dataclasses import replace
from functools import cache

from hypothesis import assume
from hypothesis import given
from hypothesis import settings
from hypothesis import strategies as st
import numpy as np
import pytest
from scipy import ndimage
from support import pictures
from support import textbook

from colortrack_ros.data import ENCODINGS
from colortrack_ros.data import Frame
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection import ReferenceColor
from colortrack_ros.scenes import open_scene

PLAIN = {'erosion_size': 1, 'min_area': 1}


def colors_of(scene, tolerance):
    return tuple(ReferenceColor.from_rgb(*color, tolerance) for color in scene.colors.items())


def played(scene, config, step=1):
    """Truth and detections of every step-th frame, with stamps as the camera gives them."""
    detector = Detector(config)
    for k in range(0, len(scene), step):
        frame = Frame(scene.render(k), stamp=round(k * NANOSECONDS / scene.rate))
        yield scene.truth(k), detector.detect(frame).rows


def compare(scene, config, step=1, visible=0.5):
    """Share of the balls found, false blobs a frame, and RMSE of those found [px]."""
    sought, hits, false, errors, frames = 0, 0, 0, [], 0
    for truth, rows in played(scene, config, step):
        frames += 1
        is_false = np.ones(len(rows), bool)
        for ball in truth:
            distance = np.hypot(rows['u'] - ball['u'], rows['v'] - ball['v'])
            distance[rows['color'] != ball['color']] = np.inf
            is_false &= distance > 1.5 * ball['radius']
            if ball['visible'] >= visible:
                sought += 1
                nearest = distance.min(initial=np.inf)
                hits += nearest < ball['radius']
                errors += [nearest] if nearest < ball['radius'] else []
        false += is_false.sum()
    return hits / sought, false / frames, np.sqrt(np.mean(np.square(errors)))


@pytest.mark.slow
@settings(deadline=None, max_examples=60)
@given(frame=pictures.frames(), colors=pictures.colors(1), grow=st.floats(1.05, 3))
def test_a_tight_tolerance_starts_a_blob_and_a_looser_one_grows_it(frame, colors, grow):
    (color,) = colors
    axes = tuple(min(grow * axis, 200.0) for axis in color.axes)
    loose = replace(color, tolerance=min(grow * color.tolerance, 200.0), tolerance_lab=axes)
    assume(textbook.is_decided(frame, (color,)) and textbook.is_decided(frame, (loose,)))
    components, _ = ndimage.label(textbook.labels(frame, (loose,)), textbook.EIGHT)
    started = np.unique(components[textbook.labels(frame, (color,)) == 1])
    expected = sorted(row for row in textbook.blobs(np.isin(components, started[started > 0])))
    rows = Detector(DetectorConfig(colors=colors, grow=grow, **PLAIN)).detect(frame).rows
    names = ('area', 'u', 'v', 'box_u', 'box_v', 'box_w', 'box_h')
    found = sorted(tuple(float(row[name]) for name in names) for row in rows)
    np.testing.assert_allclose(found, [tuple(map(float, row)) for row in expected], atol=1e-9)


def test_what_erosion_takes_away_starts_no_blob():
    image = np.full((40, 60, 3), 110, np.uint8)
    image[5:25, 5:25] = image[5:25, 35:55] = 140
    image[10:16, 10:16] = image[10, 40] = 200
    color = ReferenceColor.from_rgb('light', (200, 200, 200), 15.0)
    (row,) = Detector(DetectorConfig(colors=(color,), grow=2.0)).detect(Frame(image)).rows
    assert (row['box_u'], row['area']) == (6, 18 * 18)


@cache
def in_falling_light(**parameters):
    """As compare tells."""
    scene = open_scene('light')
    return compare(scene, DetectorConfig(colors=colors_of(scene, 25.0), **parameters), step=5)


@pytest.mark.slow
@pytest.mark.parametrize(
    'parameters', [{'white_balance': 'gray_world'}, {'follow_light': 60.0}], ids=str
)
def test_balls_are_found_while_the_light_falls_to_a_third_and_turns_yellow(parameters):
    recall, _, _ = in_falling_light()
    assert recall < 0.7
    recall, false, rmse = in_falling_light(**parameters)
    assert recall == 1
    assert false == 0
    assert rmse < 1


@pytest.mark.slow
def test_a_color_does_not_follow_farther_than_its_bound():
    assert in_falling_light(follow_light=5.0)[0] < 0.9


@pytest.mark.parametrize('encoding', ENCODINGS)
def test_gray_world_works_in_every_encoding(encoding):
    bright = np.full((60, 80, ENCODINGS[encoding]), 100, np.uint8)
    bright[20:40, 30:50] = 200
    color = ReferenceColor.from_rgb('light', (200, 200, 200), 8.0)
    detector = Detector(DetectorConfig(colors=(color,), white_balance='gray_world'))
    areas = [
        detector.detect(Frame((bright * gain).astype(np.uint8), encoding)).rows['area'].tolist()
        for gain in (1.0, 0.8, 0.6)
    ]
    assert areas == [[324.0]] * 3


@pytest.mark.slow
def test_in_a_room_full_of_its_colors_a_ball_is_not_found_by_color_alone():
    """By what moves it is: test_rooms_tracked."""
    scene = open_scene('clutter')
    config = DetectorConfig(colors=colors_of(scene, 25.0), min_area=200, max_area=4000)
    _, false, _ = compare(scene, config, step=50)
    assert false > 2


@pytest.mark.parametrize('encoding', ENCODINGS)
def test_clutter_that_stands_still_is_dropped_in_every_encoding(encoding):
    channels = ENCODINGS[encoding]
    color = ReferenceColor.from_rgb('gray', (200, 200, 200), 20.0)
    detector = Detector(DetectorConfig(colors=(color,), moving_only=True))
    for k in range(30):
        wide = np.full((60, 90, channels), 90, np.uint8)
        wide[:, 60:75] = 190
        wide[20:32, 2 * k : 2 * k + 12] = 210
        rows = detector.detect(Frame(wide[:, :80], encoding, k * NANOSECONDS // 10)).rows
        if k > 5:
            assert rows['u'].tolist() == [2 * k + 5.5]


@pytest.mark.slow
@pytest.mark.parametrize('tolerance', [0.0, 50.0])
def test_a_ball_that_is_smeared_is_one_blob_with_its_centroid_in_the_middle_of_the_smear(tolerance):
    color = ReferenceColor.from_rgb('red', (205, 58, 34), tolerance)
    recall, false, rmse = compare(
        open_scene('fast'), DetectorConfig(colors=(color,)), step=2, visible=1.0
    )
    assert recall == 1
    assert false == 0
    assert rmse < 0.5
