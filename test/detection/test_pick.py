import cv2
import numpy as np
import pytest
from support.lit_balls import draw_lit_ball

from colortrack_ros.data import ENCODINGS
from colortrack_ros.data import Frame
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection import pick
from colortrack_ros.detection import pick_color
from colortrack_ros.detection import side_by_side
from colortrack_ros.detection.lab import lab_from_rgb
from colortrack_ros.detection.own_color import own_color_at
from colortrack_ros.scenes import open_scene


@pytest.fixture(scope='module')
def clutter():
    scene = open_scene('clutter')
    return Frame(scene.render(60)), scene.truth(60)


def test_the_color_picked_from_a_shaded_ball_finds_that_ball(clutter):
    frame, truth = clutter
    for ball in truth:
        picked = pick_color(frame, int(ball['u']) + 4, int(ball['v']) - 3, name='ball')
        assert picked.color.name == 'ball'
        assert picked.area == pytest.approx(np.pi * (ball['radius'] - 1) ** 2, rel=0.25)
        config = DetectorConfig(colors=(picked.color,), **picked.limits)
        rows = Detector(config).detect(frame).rows
        distance = np.hypot(rows['u'] - ball['u'], rows['v'] - ball['v'])
        assert distance.min() < 1
        assert len(rows) <= 6, 'the furniture of this color, but no noise'


RED, WALL = (200, 20, 60), (190, 190, 180)


def picture(*balls, light=1.0, seed=0):
    image = np.full((240, 320, 3), WALL[::-1], float)
    for ball in balls:
        draw_lit_ball(image, *ball, RED)
    image = light * image + np.random.default_rng(seed).normal(0, 3, image.shape)
    return np.clip(image, 0, 255).astype(np.uint8)


@pytest.mark.slow
def test_what_one_click_gives_keeps_a_ball_that_goes_away_into_the_shade():
    picked = pick_color(Frame(picture((80, 80, 25))), 80, 80)
    detector = Detector(DetectorConfig(colors=(picked.color,), **picked.limits))
    for k in range(60):
        image = picture((80 + 2 * k, 80, 25 - k / 4), light=1 - k / 120, seed=k)
        rows = detector.detect(Frame(image, stamp=k * NANOSECONDS // 10)).rows
        assert rows['u'] == pytest.approx([80 + 2 * k], abs=2)
        assert rows['box_h'] == pytest.approx([2 * (25 - k / 4)], rel=0.2)


def test_a_thing_that_the_detector_takes_for_a_speck_has_what_one_click_knows_of_it():
    frame = Frame(picture((200, 120, 80), (40, 40, 8)))
    picked = pick_color(frame, 40, 40)
    rows = Detector(DetectorConfig(colors=(picked.color,), **picked.limits)).detect(frame).rows
    assert sorted(rows['u']) == pytest.approx([40, 200], abs=2)
    assert picked.area == pytest.approx(np.pi * 7**2, rel=0.5)


def test_what_is_clicked_is_found_beside_a_larger_thing_that_its_color_runs_into():
    """A brown ball beside a board: where the color ends, only the board is left."""
    image = np.full((240, 320, 3), (88, 97, 100), float)
    image[100:220, 150:290] = 70, 100, 120
    draw_lit_ball(image, 60, 60, 13, (110, 72, 42))
    image += np.random.default_rng(0).normal(0, 3, image.shape)
    frame = Frame(np.clip(image, 0, 255).astype(np.uint8))
    picked = pick_color(frame, 57, 58)
    rows = Detector(DetectorConfig(colors=(picked.color,), **picked.limits)).detect(frame).rows
    assert rows['u'] == pytest.approx([60], abs=1)


def test_a_fixed_color_has_the_tolerance_and_the_least_area_of_its_picture():
    """Who clicks on one picture wants the mask of that one, also where the thing has just come."""
    picked = pick_color(Frame(picture((80, 80, 25))), 80, 80, fixed=True)
    assert picked.color.tolerance_lab is not None
    assert picked.limits == {'min_area': picked.area // 4}


def test_a_thing_that_is_too_far_away_to_be_found_yet_is_picked_by_its_color_alone():
    picked = pick_color(Frame(picture((40, 40, 3))), 40, 40)
    assert picked.color.is_sought
    assert picked.limits == {}


def test_what_else_is_set_for_the_detector_does_not_hide_what_is_clicked():
    config = DetectorConfig(moving_only=True, min_area=5000, min_aspect=0.99)
    picked = pick_color(Frame(picture((80, 80, 25))), 80, 80, config=config)
    assert picked.color.is_sought
    assert picked.limits == {}
    assert picked.area == pytest.approx(np.pi * 24**2, rel=0.1)


def test_in_a_picture_of_one_color_that_color_is_picked():
    frame = Frame(np.full((20, 30, 3), (34, 58, 205), np.uint8))
    picked = pick_color(frame, 0, 19)
    assert picked.color.lab == pytest.approx((47.1, 56.5, 47.1), abs=0.1)
    assert picked.area == 600


def test_what_has_neither_a_gap_nor_a_blob_is_segmented_once(monkeypatch):
    segment, seen = pick._stable_region, []
    monkeypatch.setattr(pick, '_stable_region', lambda *a: seen.append(a) or segment(*a))
    image = np.random.default_rng(0).integers(0, 255, (40, 40, 3), np.uint8)
    assert pick_color(Frame(image), 20, 20).area == segment(*seen[0]).sum()
    assert len(seen) == 1


CLOTH, FLOOR = (150, 40, 65), (255, 250, 236)


def overexposed_ball(u, v, radius=16):
    """A yellow ball on a red cloth; what it mirrors is as white as the floor beside the cloth."""
    image = np.full((240, 320, 3), CLOTH[::-1], float)
    image[:, 260:] = FLOOR[::-1]
    column, row = np.meshgrid(np.arange(320) - u, np.arange(240) - v)
    away = np.hypot(column, row)[..., None] / radius
    own = np.clip((away - 0.5) / 0.2, 0, 1)
    ball = own * (40, 200, 255) + (1 - own) * FLOOR[::-1]
    image = np.where(away < 1, ball, image)
    image += np.random.default_rng(0).normal(0, 2, image.shape)
    return Frame(np.clip(image, 0, 255).astype(np.uint8))


@pytest.mark.parametrize('fixed', [False, True])
@pytest.mark.parametrize('click', [(8, 0), (0, -7), (-6, 6)])
def test_a_click_on_the_highlight_of_a_ball_picks_the_color_of_its_rim(click, fixed):
    frame = overexposed_ball(100, 120)
    picked = pick_color(frame, 100 + click[0], 120 + click[1], fixed=fixed)
    rows = Detector(DetectorConfig(colors=(picked.color,), **picked.limits)).detect(frame).rows
    assert rows['box_u'] + rows['box_w'] / 2 == pytest.approx([100], abs=1)
    assert rows['box_w'] == pytest.approx([31 - 2 * (not picked.color.is_sought)], abs=1)


def test_a_click_beside_a_ball_of_its_hue_does_not_pick_the_ball():
    image = np.full((240, 320, 3), (170, 225, 255), np.uint8)
    cv2.circle(image, (100, 120), 20, (0, 200, 255), -1)
    picked = pick_color(Frame(cv2.blur(image, (3, 3))), 100, 97)
    assert picked.color.lab[2] < 40


@pytest.mark.parametrize('rgb', [(205, 58, 34), (34, 205, 58), (13, 17, 99), (255, 255, 0)])
def test_a_climb_ends_where_all_is_of_one_color(rgb):
    picture = np.full((41, 67, 3), rgb, np.uint8)
    lab = tuple(lab_from_rgb(picture[0, 0]).tolist())
    for u, v in ((0, 0), (66, 40), (31, 20)):
        assert own_color_at(picture, u, v, lab) == (u, v)


@pytest.mark.parametrize('turn', range(4))
def test_a_climb_begins_at_any_border(turn):
    rgb = np.full((20, 60, 3), 255, np.uint8)
    rgb[..., 1:] = np.linspace(200, 0, 60)[None, :, None]
    place = np.zeros((20, 60), bool)
    place[10, 0] = True
    turned, ((v, u),) = np.rot90(rgb, turn), np.argwhere(np.rot90(place, turn)).tolist()
    lab = tuple(lab_from_rgb(turned[v, u]).tolist())
    ended = own_color_at(np.ascontiguousarray(turned), u, v, lab)
    assert turned[ended[::-1]][1] < 10


def test_gray_has_no_color_of_its_own_elsewhere():
    rgb = np.full((20, 30, 3), 128, np.uint8)
    rgb[:, 15:] = 255, 0, 0
    assert own_color_at(rgb, 13, 10, (54.0, 0.0, 0.0)) == (13, 10)


@pytest.mark.parametrize('pixel', [(-1, 0), (30, 0), (0, 20)])
def test_a_pixel_outside_of_the_picture_is_refused(pixel):
    with pytest.raises(ValueError, match=r'pixel: expected u, v in the picture of 30 x 20 px, got'):
        pick_color(Frame(np.zeros((20, 30, 3), np.uint8)), *pixel)


@pytest.mark.parametrize('encoding', ENCODINGS)
def test_picture_mask_and_blobs_are_shown_side_by_side(encoding):
    frame = Frame(np.zeros((20, 30, ENCODINGS[encoding]), np.uint8), encoding)
    assert side_by_side(frame, Detector(DetectorConfig())).shape == (20, 90, 3)
