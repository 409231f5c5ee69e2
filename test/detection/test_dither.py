"""Dithered pictures of few colors: things are found by any pixel of theirs."""

import cv2
import numpy as np
import pytest

from colortrack_ros.data import Frame
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection import dither
from colortrack_ros.detection import ReferenceColor
from colortrack_ros.detection.dither import color_shown
from colortrack_ros.detection.dither import is_dithered
from colortrack_ros.detection.lab import lab_from_rgb
from colortrack_ros.detection.lab import rgb_from_lab
from colortrack_ros.detection.smoothing import side_for
from colortrack_ros.scenes import open_scene
from colortrack_ros.scenes import SCENES

WALL, RED, BLUE, OLIVE = (176, 170, 160), (200, 28, 45), (6, 28, 115), (74, 90, 58)
RADIUS = 24


def ordered(size):
    """Thresholds of ordered dithering, (size, size) in -1/2..1/2 (Bayer 1973)."""
    matrix = np.zeros((1, 1))
    while len(matrix) < size:
        matrix = np.block([[4 * matrix, 4 * matrix + 2], [4 * matrix + 3, 4 * matrix + 1]])
    return (matrix + 0.5) / matrix.size - 0.5


def dithered(image, levels=(8, 8, 4)):
    """An RGB picture in so many levels of red, green, and blue."""
    height, width = image.shape[:2]
    threshold = np.tile(ordered(8), (height // 8 + 1, width // 8 + 1))[:height, :width, None]
    steps = np.array(levels) - 1
    level = np.rint(image / 255 * steps + threshold).clip(0, steps)
    return (level * 255 // steps).astype(np.uint8)


def film(color, count=12):
    """RGB pictures of a lit ball that moves in front of a wall, dithered."""
    for k in range(count):
        wall = np.full((200, 300, 3), WALL, float) * np.linspace(1, 0.85, 300)[:, None]
        ball = np.array(color) * np.linspace(1.1, 0.8, 200)[:, None, None]
        disc = np.zeros((200, 300), np.uint8)
        cv2.circle(disc, (60 + 9 * k, 100), RADIUS, 255, -1, cv2.LINE_AA)
        yield dithered(wall + (ball - wall) * disc[..., None] / 255)


def pixels_of(picture, fewest=20):
    """Palette colors of the middle of the ball, and how many pixels have each."""
    part = picture[85:115, 45:75].reshape(-1, 3)
    colors, number = np.unique(part, axis=0, return_counts=True)
    return colors[number >= fewest].tolist()


@pytest.mark.parametrize('color', [RED, BLUE, OLIVE])
def test_a_thing_is_found_by_any_pixel_of_its_checker(color):
    pictures = list(film(color))
    picked = [*pixels_of(pictures[0]), list(color)]
    assert len(picked) > 3
    for rgb in picked:
        detector = Detector(DetectorConfig(colors=(ReferenceColor.from_rgb('ball', rgb),)))
        for k, picture in enumerate(pictures):
            (row,) = detector.detect(Frame(picture, 'rgb8', stamp=40_000_000 * k)).rows
            assert np.hypot(row['u'] - 60 - 9 * k, row['v'] - 100) < 1.5
            assert abs(row['box_w'] - 2 * RADIUS) <= 5
            assert abs(row['box_h'] - 2 * RADIUS) <= 5


def test_a_palette_color_is_read_as_what_shows_it_and_is_nearest():
    rgb = next(film(RED))
    frame = Frame(np.ascontiguousarray(rgb[..., ::-1]))
    for picked in pixels_of(rgb):
        lab = color_shown(frame, ReferenceColor.from_rgb('ball', picked).lab)
        assert np.abs(rgb_from_lab(lab) - RED).max() < 30
    assert color_shown(frame, ReferenceColor.from_rgb('ball', (0, 255, 0)).lab) is None


def test_the_color_of_a_single_pixel_is_no_thing():
    frame = Frame(next(film(RED)).copy(), encoding='rgb8')
    frame.image[7, 7] = 0, 255, 0
    assert color_shown(frame, ReferenceColor.from_rgb('ball', (0, 255, 0)).lab) is None


def test_of_a_wall_that_shows_a_color_few_pixels_are_read(monkeypatch):
    read = []
    monkeypatch.setattr(dither, 'lab_from_rgb', lambda rgb: read.append(rgb) or lab_from_rgb(rgb))
    wall = dithered(np.full((480, 640, 3), WALL, float))
    picked = ReferenceColor.from_rgb('wall', wall[3, 3]).lab
    lab = color_shown(Frame(wall, 'rgb8'), picked)
    assert np.abs(rgb_from_lab(lab) - WALL).max() < 30
    assert len(read[-1]) == 4096


def test_a_color_that_a_dithered_film_did_not_show_is_itself_in_the_next_film():
    ball = 182, 72, 170
    wall = dithered(np.full((200, 300, 3), WALL, float))
    wall[::3, ::3] = ball  # what shows this color is gray, and fills the picture
    detector = Detector(DetectorConfig(colors=(ReferenceColor.from_rgb('ball', ball),)))
    assert not len(detector.detect(Frame(wall, 'rgb8')).rows)
    for k in range(1, 5):
        picture = np.full((200, 300, 3), WALL, np.uint8)
        cv2.circle(picture, (60 + 9 * k, 100), RADIUS, ball, -1, cv2.LINE_AA)
        (row,) = detector.detect(Frame(picture, 'rgb8', stamp=40_000_000 * k)).rows
        assert abs(row['u'] - 60 - 9 * k) < 1


@pytest.mark.parametrize('levels', [(8, 8, 4), (6, 6, 6), (2, 2, 2)])
def test_few_levels_in_a_checker_are_dithered(levels):
    gradient = np.add.outer(np.linspace(20, 150, 120), np.linspace(0, 90, 160))
    image = np.stack([gradient, 240 - gradient, 255 - gradient / 2], axis=-1)
    assert is_dithered(dithered(image, levels))
    assert not is_dithered(image.astype(np.uint8))


@pytest.mark.parametrize('shape', [(0, 0, 3), (1, 1, 3), (1, 2, 3), (5, 5, 3), (5, 5, 4), (50, 50)])
def test_what_is_even_or_too_small_is_not_dithered(shape):
    assert not is_dithered(np.full(shape, 36, np.uint8))


@pytest.mark.slow
@pytest.mark.parametrize('name', SCENES)
def test_no_scene_is_dithered(name):
    scene = open_scene(f'{name}?width=640&height=360')
    assert not any(is_dithered(scene.render(k)) for k in range(0, len(scene), len(scene) // 7))


def test_a_drawing_of_few_colors_is_not_dithered():
    image = np.full((240, 320, 3), 255, np.uint8)
    for k in range(6):
        cv2.circle(image, (30 + 50 * k, 120), 20, (0, 36 * k, 170), -1)
        cv2.putText(image, 'speed 12 m/s', (5, 20 + 30 * k), cv2.FONT_HERSHEY_SIMPLEX, 0.5, 0)
    assert not is_dithered(image)
    assert side_for(image) == 1


def test_a_user_who_wants_no_average_gets_the_pixels_themselves():
    picture = next(film(RED))
    color = ReferenceColor.from_rgb('ball', pixels_of(picture)[0])
    detector = Detector(DetectorConfig(colors=(color,), smoothing=1))
    detector.detect(Frame(picture, encoding='rgb8'))
    assert (picture[detector.mask > 0] == pixels_of(picture)[0]).all()
