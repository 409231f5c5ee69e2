"""A color without a tolerance: how far it reaches is found in the pictures."""

import re

import cv2
import numpy as np
import pytest
from support.lit_balls import draw_lit_ball
from support.lit_balls import hues
from support.lit_balls import wheel
from support.paths import DATA
from support.sought import sought

from colortrack_ros.data import Frame
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection import ReferenceColor
from colortrack_ros.detection import shade_follower
from colortrack_ros.sources import open_source

RED, BROWN, WALL, GREEN = (200, 20, 60), (150, 100, 40), (190, 190, 180), (90, 140, 80)
ORANGE = (230, 120, 30)
NOISE = 3.0


def picture(*balls, seed=0, light=1.0, others=True):
    image = np.full((240, 320, 3), WALL[::-1], float)
    if others:
        image[150:, :160] = BROWN[::-1]
    for args in balls:
        draw_lit_ball(image, *args)
    image = light * image + np.random.default_rng(seed).normal(0, NOISE, image.shape)
    return np.clip(image, 0, 255).astype(np.uint8)


def test_a_shaded_thing_is_found_whole_and_what_is_like_it_is_not():
    found = sought(RED).detect(Frame(picture((80, 80, 25, RED), (230, 120, 25, RED)))).rows
    assert len(found) == 2
    assert sorted(found['u']) == pytest.approx([80, 230], abs=1.5)
    assert found['box_h'] == pytest.approx([48, 48], abs=4), 'the shaded side, too'


def test_a_color_that_is_not_yet_in_the_picture_finds_nothing_until_it_comes():
    detector = sought(RED)
    for k in range(10):
        frame = Frame(picture(seed=k), stamp=k * NANOSECONDS // 30)
        assert len(detector.detect(frame).rows) == 0
    frame = Frame(picture((200, 80, 25, RED), seed=11), stamp=NANOSECONDS)
    assert len(detector.detect(frame).rows) == 1


@pytest.mark.slow
def test_a_color_is_kept_while_the_light_falls_to_half():
    detector = sought(RED)
    for k in range(90):
        image = picture((100 + k, 80, 25, RED), seed=k, light=1 - 0.5 * k / 89)
        rows = detector.detect(Frame(image, stamp=k * NANOSECONDS // 15)).rows
        assert len(rows) == 1, k
        assert rows['box_h'][0] > 40, k


def test_sparkles_and_the_pieces_of_a_thing_are_no_things():
    image = picture((80, 80, 30, RED), (80, 120, 6, RED, 1.0), (250, 60, 5, RED, 1.0))
    assert len(sought(RED).detect(Frame(image)).rows) == 1


def test_a_third_of_a_thing_right_beside_it_is_a_piece_of_it():
    image = picture((80, 80, 30, RED), (72, 130, 12, RED, 1.0), (88, 130, 12, RED, 1.0))
    (row,) = sought(RED).detect(Frame(image)).rows
    assert row['v'] == pytest.approx(80, abs=2)


def test_a_ball_right_beside_one_that_is_nearer_is_a_ball():
    """It is round and whole, which nothing is that a stripe or a finger cuts off."""
    image = picture((80, 80, 30, RED), (80, 130, 16, RED, 1.0))
    assert sorted(sought(RED).detect(Frame(image)).rows['v'].round()) == [80, 130]


@pytest.mark.parametrize('rgb', [RED, GREEN, (230, 120, 30)])
@pytest.mark.parametrize('radius', [6, 8])
def test_a_far_ball_is_found_to_its_outline_though_that_is_much_of_it(rgb, radius):
    image = np.full((240, 320, 3), WALL[::-1], np.float32)
    cv2.circle(image, (200, 80), radius, rgb[::-1], cv2.FILLED)
    image = cv2.GaussianBlur(image, (0, 0), 1.0)
    detector = sought(rgb)
    for k in range(8):
        noise = np.random.default_rng(k).normal(0, NOISE, image.shape)
        frame = Frame(np.clip(image + noise, 0, 255).astype(np.uint8), stamp=k * NANOSECONDS // 8)
        (row,) = detector.detect(frame).rows
        assert [row['u'], row['v']] == pytest.approx([200, 80], abs=0.5)
        assert row['area'] > 0.6 * np.pi * (radius - 1) ** 2, 'the erosion takes a pixel'


def lit_ball(rgb):
    """A matt ball of radius 25 at (120, 100), lit from the upper left."""
    image = np.full((240, 320, 3), WALL[::-1], float)
    y, x = np.mgrid[:240, :320]
    normal = np.stack([(x - 120) / 25, (y - 100) / 25], axis=-1)
    depth = np.sqrt(np.maximum(1 - (normal**2).sum(axis=-1), 0))
    toward = normal @ [-0.7, -0.5] + 0.5 * depth
    shade = 0.35 + 0.65 * np.clip(toward, 0, 1)
    inside = np.hypot(x - 120, y - 100) < 25
    image[inside] = (shade[..., None] * np.array(rgb[::-1]))[inside]
    return cv2.GaussianBlur(image, (0, 0), 0.8)


def test_the_shaded_side_of_a_thing_is_found_where_its_light_side_is():
    image = lit_ball(ORANGE)
    image[20:220, 240:300] = 0.75 * np.array(ORANGE[::-1])
    detector, noise = sought(ORANGE), np.random.default_rng(0)
    for k in range(12):
        noisy = image + noise.normal(0, NOISE, image.shape)
        frame = Frame(np.clip(noisy, 0, 255).astype(np.uint8), stamp=k * NANOSECONDS // 4)
        _, row = detector.detect(frame).rows
    assert [row['u'], row['v']] == pytest.approx([120, 100], abs=1)
    assert row['area'] > 1700, 'more than its light side'


@pytest.mark.slow
@pytest.mark.parametrize(('count', 'least'), [(8, 0.6), (10, 0.8)])
def test_among_balls_of_many_hues_the_color_of_one_pixel_finds_its_ball_alone(count, least):
    image, places = wheel(hues(count).round(), least)
    frame = Frame(image)
    for u, v in places:
        for picked in (v - 14, v, v + 14):
            (row,) = sought(tuple(image[picked, u][::-1].tolist())).detect(frame).rows
            assert [row['u'], row['v']] == pytest.approx([u, v], abs=2)
            assert row['area'] > 0.8 * np.pi * 28**2


def test_what_is_printed_in_a_frame_is_a_piece_of_it_and_what_is_beside_one_is_not():
    image = picture()
    cv2.rectangle(image, (60, 40), (120, 100), RED[::-1], 5)
    cv2.rectangle(image, (75, 55), (105, 85), RED[::-1], cv2.FILLED)
    cv2.ellipse(image, (230, 80), (50, 50), 0, 0, 90, RED[::-1], 9)
    cv2.rectangle(image, (235, 85), (252, 102), RED[::-1], cv2.FILLED)
    rows = sought(RED).detect(Frame(image)).rows
    places = sorted(zip(rows['u'].round(), rows['v'].round(), strict=True))
    assert len(places) == 3
    assert places[0] == pytest.approx((90, 70), abs=2)
    assert places[1] == pytest.approx((243, 93), abs=2)


def test_a_smaller_thing_elsewhere_is_a_thing():
    image = picture((80, 80, 30, RED), (250, 60, 9, RED, 1.0))
    assert len(sought(RED).detect(Frame(image)).rows) == 2


def test_blobs_of_a_color_with_a_tolerance_may_have_any_area():
    colors = (ReferenceColor.from_rgb('green', GREEN, 20.0), ReferenceColor.from_rgb('red', RED, 0))
    detector = Detector(DetectorConfig(colors=colors))
    image = picture((80, 80, 30, GREEN, 1.0), (80, 120, 6, GREEN, 1.0), (230, 100, 20, RED))
    assert detector.detect(Frame(image)).rows['color'].tolist() == [0, 1, 0]


@pytest.mark.parametrize(('encoding', 'order'), [('rgb8', [2, 1, 0]), ('bgra8', [0, 1, 2, 0])])
def test_the_order_of_the_channels_makes_no_difference(encoding, order):
    image = picture((80, 80, 25, RED))
    expected = sought(RED).detect(Frame(image)).rows
    rows = sought(RED).detect(Frame(np.ascontiguousarray(image[..., order]), encoding)).rows
    assert (rows == expected).all()


def test_the_same_pictures_give_the_same_detections_again():
    frames = [Frame(picture((99 + k, 80, 25, RED), seed=k), stamp=k << 26) for k in range(12)]
    one, other = sought(RED), sought(RED)
    for frame in frames:
        assert one.detect(frame).rows.tobytes() == other.detect(frame).rows.tobytes()


@pytest.mark.parametrize(
    ('image', 'stamps'),
    [
        (np.zeros((1, 1, 3), np.uint8), [0]),
        (np.full((9, 9, 3), (60, 20, 200), np.uint8), [5, 0, 1 << 62]),
    ],
)
def test_pictures_that_tell_nothing_and_stamps_that_jump_do_no_harm(image, stamps):
    detector = sought(RED)
    for stamp in stamps:
        assert len(detector.detect(Frame(image, stamp=stamp)).rows) == 0


def test_what_keeps_a_color_from_being_found_is_told():
    nothing, full = sought(RED), sought(WALL)
    assert nothing.trouble == ''
    for k in range(4):
        for detector in (nothing, full):
            detector.detect(Frame(picture(seed=k), stamp=k * NANOSECONDS))
    assert nothing.trouble.startswith('c0 has not been seen yet')
    assert nothing.trouble.endswith('with pick_color, or set c0.preset, such as red')
    assert 'c0 fills more than 25% of the picture: set c0.tolerance' in full.trouble
    nothing.detect(Frame(picture((80, 80, 25, RED)), stamp=4 * NANOSECONDS))
    assert nothing.trouble == ''


def test_the_color_that_is_nearest_to_one_that_is_not_there_is_told_and_finds_the_thing():
    image = picture((80, 80, 25, RED))
    guessed = sought((255, 60, 120))
    for k in range(4):
        assert len(guessed.detect(Frame(image, stamp=k * NANOSECONDS)).rows) == 0
    told = re.search(r'in view, (\d+),(\d+),(\d+) is nearest', guessed.trouble)
    (found,) = sought(tuple(map(int, told.groups()))).detect(Frame(image)).rows
    assert (found['u'], found['v']) == pytest.approx((80, 80), abs=1.5)


def test_a_color_that_runs_into_others_is_told():
    image = np.zeros((200, 256, 3), np.uint8)
    image[..., 2], image[..., 1] = np.arange(256), np.arange(200)[:, None]
    detector = sought((150, 100, 0))
    detector.detect(Frame(image))
    assert 'c0 runs into other colors' in detector.trouble


def test_specks_are_told():
    image = picture((80, 80, 30, RED))
    for k in range(30):
        draw_lit_ball(image, 10 + 10 * k, 200, 4, RED, 1.0)
    detector = Detector(
        DetectorConfig(colors=(ReferenceColor.from_rgb('red', RED, 0.0),), min_area=5)
    )
    assert len(detector.detect(Frame(image)).rows) == 1
    assert 'specks of the colors in one picture' in detector.trouble


REAL = {
    'cups': ((200, 20, 60), 30 * [3]),
    'caps': ((0, 19, 121), 20 * [2] + 10 * [3]),
    'box': ((224, 162, 65), 30 * [1]),
    'greenball': ((71, 85, 57), 9 * [0] + 21 * [1]),
}
"""The color of a pixel of each thing, and how many things there are in each frame."""


@pytest.mark.slow
@pytest.mark.skipif(not DATA.is_dir(), reason=f'no videos at {DATA}; set COLORTRACK_DATA')
@pytest.mark.parametrize('name', REAL)
def test_in_the_first_second_of_a_real_video_the_things_are_found_and_nothing_else(name):
    rgb, numbers = REAL[name]
    detector, source = sought(rgb), open_source(str(DATA / 'real' / f'{name}.mp4'))
    found = [len(detector.detect(source.read()).rows) for _ in numbers]
    source.close()
    assert np.mean(np.array(found) == numbers) >= 0.9, found


@pytest.mark.slow
def test_a_small_thing_is_found_again_soon_after_a_large_one_of_its_color_has_left():
    detector, found = sought(RED), []
    for k in range(150):
        image = picture((60, 60, 6, RED, 1.0), others=False, seed=k)
        if 10 <= k < 40:
            draw_lit_ball(image, 210, 130, 60, RED, 1.0)
        found.append(len(detector.detect(Frame(image, stamp=k * NANOSECONDS // 30)).rows))
    assert set(found[:10]) == set(found[40 + 90 :]) == {1}, 'three seconds later'


@pytest.mark.parametrize('share', [0.2, 0.9])
def test_a_thing_is_found_whole_by_its_dark_and_by_its_light_side(share):
    detector = sought(tuple(share * x for x in ORANGE))
    for k in range(8):
        image = picture(seed=k, others=False)
        draw_lit_ball(image, 160, 120, 40, ORANGE, least=0.15)
        (row,) = detector.detect(Frame(image, stamp=k * NANOSECONDS // 4)).rows
    assert row['box_h'] > 0.9 * 80


@pytest.mark.slow
def test_shades_beyond_are_seldom_looked_for_also_while_another_color_is_not_there(monkeypatch):
    """A color that is not in sight is looked for in every picture."""
    searches = []
    search = shade_follower.shades_beyond
    monkeypatch.setattr(
        shade_follower, 'shades_beyond', lambda *a: (searches.append(1), search(*a))[1]
    )
    detector = sought(ORANGE, (20, 60, 250))
    for k in range(120):
        image = picture(seed=k, others=False)
        draw_lit_ball(image, 160, 120, 40, ORANGE, least=0.15)
        detector.detect(Frame(image, stamp=k * NANOSECONDS // 30))
    assert 5 <= len(searches) <= 8, 'four times in the first second, then once in each'


def test_a_color_whose_pixels_are_too_few_on_end_is_told():
    thin = sought(RED)
    color = ReferenceColor.from_rgb('c0', RED)
    still = Detector(DetectorConfig(colors=(color,), moving_only=True))
    for k in range(13):
        image = picture(others=False)
        image[40:200, 100:102] = RED[::-1]
        frame = Frame(image, stamp=k * NANOSECONDS // 4)
        assert len(thin.detect(frame).rows) == 0
        still.detect(frame)
        assert (thin.trouble == '') == (k <= 8), 'said after 2 s'
    assert thin.trouble.startswith('c0 is there, but in pieces that are too small: pick another')
    assert still.trouble == ''
    image[60:90, 150:180] = RED[::-1]
    thin.detect(Frame(image, stamp=4 * NANOSECONDS))
    assert thin.trouble == ''
