"""A camera that sways, trembles, or was bumped by little: its background goes along."""

import cv2
import numpy as np
import pytest
from support.contour_pictures import follow
from support.contour_pictures import frame
from support.contour_pictures import known
from support.contour_pictures import noise
from support.contour_pictures import picture
from support.contour_pictures import texture

from colortrack_ros.contours import ContourConfig
from colortrack_ros.contours import ContourTracker
from colortrack_ros.contours.areas import Areas
from colortrack_ros.contours.background import StillBackground
from colortrack_ros.contours.steady import _is_more_alike
from colortrack_ros.contours.steady import LEAST_CORNERS
from colortrack_ros.contours.steady import Steady
from colortrack_ros.data import Frame
from colortrack_ros.detection.blobs import find_blobs
from colortrack_ros.detection.label_image import LabelImage
from colortrack_ros.detection.pixels import channels_of

WALL = texture(3, 400, 700, contrast=25.0)
NOBODY = np.zeros((0, 4))


def view(right=0, down=0, wall=WALL, k=0):
    """What a camera shows that has turned so far to the left and up [px]: the scene moves."""
    rows, columns = slice(60 - down, 300 - down), slice(60 - right, 380 - right)
    image = np.ascontiguousarray(wall[rows, columns].astype(np.uint8))
    return cv2.add(image, noise(k, image.shape), dtype=cv2.CV_8U)


class Known:
    """A background that is known, of the shape of its picture."""

    is_learning = False

    def __init__(self, gray):
        self.recent = gray[..., None]

    def knows(self, picture):
        return picture.shape == self.recent.shape


def shifts(pictures, known_boxes=NOBODY):
    """By how much a steadier says each picture is off."""
    steady, result = Steady(), []
    for k, image in enumerate(pictures):
        steady.steadied(Frame(image, 'mono8', k * 40_000_000), Known(pictures[0]), known_boxes)
        result.append(steady.shift.tolist())
    return result


@pytest.mark.parametrize('way', [(1, 0), (3, -4), (-20, 15)])
def test_a_picture_that_has_moved_is_moved_back(way):
    assert shifts([view(), view(*way, k=1)])[-1] == list(way)
    steady = Steady()
    background = Known(view() | 1)  # odd levels, and even ones in the pictures
    steady.steadied(Frame(view() & 254, 'mono8'), background, NOBODY)
    back = steady.steadied(Frame(view(*way, k=1) & 254, 'mono8', 1), background, NOBODY).image
    there = view(k=1) - back.astype(int)
    off = np.abs(way)
    out_of_sight = back % 2 == 1
    assert np.mean(out_of_sight) == pytest.approx(1 - np.prod(1 - off / [320, 240]), abs=0.01)
    assert np.abs(there[~out_of_sight]).mean() < 4  # noise of 2 levels in both


def test_a_camera_that_stands_still_leaves_its_pictures_as_they_are():
    steady = Steady()
    for k in range(30):
        frame = Frame(view(k=k), 'mono8', k * 40_000_000)
        assert steady.steadied(frame, Known(view()), NOBODY) is frame


def test_a_sway_of_less_than_a_pixel_is_left_and_a_slow_drift_is_followed():
    pictures = []
    for k in range(50):
        way = np.array([[1, 0, 0.2 * k], [0, 1, 0]])
        pictures.append(cv2.warpAffine(WALL, way, (700, 400))[60:300, 120:440].astype(np.uint8))
    right = np.array(shifts(pictures))[:, 0]
    assert not right[:3].any()
    assert np.abs(right - 0.2 * np.arange(50)).max() < 0.75
    assert (np.diff(right) >= 0).all(), 'it does not go back and forth'


def test_too_far_is_another_scene():
    assert shifts([view(), view(40, 0)])[-1] == [0, 0]


def test_one_thing_that_moves_is_not_the_camera():
    """Not even where it has all of the texture, and before a plain wall."""
    plain = np.full((400, 700), 120.0)

    def shown(k, wall):
        image = view(wall=wall, k=k).astype(float)
        image[50:190, 100 + 3 * k : 210 + 3 * k] = texture(9)[50:190, :110]
        return image.astype(np.uint8)

    for wall in (WALL, plain):
        assert not np.any(shifts([shown(k, wall) for k in range(12)]))


def test_what_is_off_by_so_much_that_nothing_is_in_sight_either_way_is_no_more_alike():
    image, bump = view(), np.array([0, 24])
    assert not _is_more_alike(image, image, np.array([0, -230]), bump)
    assert _is_more_alike(view(0, 24), image, bump, np.array([0, 0]))


def in_crowd(k, wall):
    """40 of 22x60 px, half of the picture, who all walk to the right at 2.5 px a picture."""
    image, random, people = wall.copy(), np.random.default_rng(0), texture(9)
    for i, (left, top) in enumerate(random.uniform((0, -30), (364, 210), (40, 2)).tolist()):
        left, top = round((left + 2.5 * k) % 364 - 22), round(top)
        person, right = people[4 * i : 4 * i + 60, 7 * i : 7 * i + 22] - 25 * (i % 5), left + 22
        part = image[max(top, 0) : top + 60, max(left, 0) : max(right, 0)]
        part[...] = person[max(-top, 0) :, max(-left, 0) :][: part.shape[0], : part.shape[1]]
    return cv2.add(image.astype(np.uint8), noise(k, image.shape), dtype=cv2.CV_8U)


@pytest.mark.slow
def test_a_crowd_that_walks_one_way_from_the_first_picture_on_is_not_the_camera():
    """Its corners were those of the first picture, and the background went along with it."""
    steady, background, wall = Steady(), StillBackground(), WALL[60:300, 60:380]
    nothing = find_blobs(LabelImage(np.zeros((240, 320), np.uint8), 1), 1)
    for k in range(72):
        shown = steady.steadied(frame(in_crowd(k, wall), k), background, NOBODY)
        background.follow(channels_of(shown), shown.stamp, nothing, 1.5)
        assert not steady.shift.any()
    off = np.abs(background.recent[..., 0].astype(float) - wall)
    assert np.mean(off < 15) > 0.8  # half of it is covered in each picture


def test_known_targets_do_not_tell_and_pictures_without_corners_change_nothing():
    pictures = [view(), view(6, 0, k=1)]
    everywhere = np.array([[-20.0, -20, 340, 260]])
    assert shifts(pictures, everywhere)[-1] == [0, 0]
    assert shifts([np.full((240, 320), 90, np.uint8)] * 3)[-1] == [0, 0]
    for shape in ((5, 4), (30, 5000), (5000, 30)):
        assert shifts([np.zeros(shape, np.uint8)] * 2)[-1] == [0, 0]
    assert LEAST_CORNERS > 4


def test_areas_go_along_and_are_cut_where_the_picture_ends_or_what_was_learned():
    steady = Steady()
    steady.shift = np.array([5, -3])
    mask = np.ones((10, 10), np.uint8)
    masks = np.empty(2, object)
    masks[:] = [mask, mask]
    box = np.array([[20.0, 30, 29, 39], [305, 3, 314, 12]])
    center = box[:, :2] + 4.5
    size, no = np.full(2, 100.0), np.zeros(2, bool)
    own_cut = np.array([[True, False, False, False], [False] * 4])
    areas = Areas(box, center, size, no, own_cut, masks)
    moved = steady.along(areas, np.zeros((240, 320, 1), np.uint8))
    np.testing.assert_array_equal(moved.box, box + np.tile(steady.shift, 2))
    np.testing.assert_array_equal(steady.back(moved.box), box)
    np.testing.assert_array_equal(moved.center, center + steady.shift)
    assert moved.cut.tolist() == [own_cut[0].tolist(), [False, True, True, False]]


def sway(k):
    """A pole in the wind [px]: 8 px to each side in 3 s."""
    return round(8 * np.sin(2 * np.pi * k / 72)), round(3 * np.sin(2 * np.pi * k / 50))


def walker(k, right, down):
    """One who comes in from the left after a second and walks through the scene."""
    center = 3.0 * k - 100 + right, 120.0 + down
    return picture('person', center, 24.0, background=view(right, down).astype(float), seed=k)


@pytest.mark.slow
@pytest.mark.parametrize('way', [sway, lambda k: (k // 6, 0), lambda k: (7 * (k > 60), 0)])
def test_who_walks_before_a_camera_that_sways_drifts_or_was_bumped_is_followed(way):
    """Before, what the sway uncovered was told, or nothing was looked for."""
    results = follow([walker(k, *way(k)) for k in range(125)], ContourConfig())
    assert not any(tracks.restarted for tracks in results)
    ids = set()
    for k, tracks in enumerate(results[65:], 65):
        (row,) = tracks.rows[known(tracks)]
        right, down = way(k)
        assert np.hypot(row['u'] - (3.0 * k - 100 + right), row['v'] - (120.0 + down)) < 6
        ids.add(int(row['track_id']))
    assert len(ids) == 1


@pytest.mark.slow
def test_who_comes_in_beside_what_was_learned_is_taken_whole_as_soon_as_that_shows_it():
    """The contour was that of the part in sight for a third of a second."""
    results = follow([walker(k, 30 * (k > 20), 0) for k in range(44)], ContourConfig())
    (row,) = results[-1].rows[known(results[-1])]
    assert abs(row['u'] - (3.0 * 43 - 100 + 30)) < 1


@pytest.mark.slow
@pytest.mark.parametrize('other', ['start', 'size'])
def test_pictures_that_are_not_steadied_stay_where_they_are(other):
    """Boxes were moved along nevertheless, and those beyond the border ended the update."""
    tracker = ContourTracker(ContourConfig())
    for k in range(100):
        tracker.update(frame(walker(k, 12 * (k > 40), 0), k))
    if other == 'start':
        tracker.configure(ContourConfig(start='difference'))
    for k in range(100, 142):
        shown = walker(k, 12, 0)
        tracks = tracker.update(frame(shown if other == 'start' else shown[100:110].copy(), k))
        for row in tracks.rows[known(tracks)] if other == 'start' else ():
            assert abs(row['u'] - (3.0 * k - 100 + 12)) < 2
