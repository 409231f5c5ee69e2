"""Things that the erosion leaves nothing of are found where the picture shows that they are none
of its noise.
"""

import cv2
import numpy as np
import pytest
from support.sought import sought

from colortrack_ros.data import Frame
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection import ReferenceColor
from colortrack_ros.detection import small_things
from colortrack_ros.detection.small_things import Specks

RED, WALL, RATE = (200, 40, 35), 130.0, 5
FROM = 2 * RATE + 3
"""Picture from which on a small thing is found: 2 s, and what 8 of them take at this rate."""


def picture(*places, seed=0):
    """Red discs of 13 px, 4 px wide, before a noisy wall, as a camera sees them."""
    image = np.full((120, 160, 3), WALL)
    for u, v in places:
        cv2.circle(image, (round(u), round(v)), 2, RED, cv2.FILLED)
    image = cv2.GaussianBlur(image, (0, 0), 0.7)
    image += np.random.default_rng(seed).normal(0, 2, image.shape)
    return image.clip(0, 255).astype(np.uint8)


def rows_of(detector, pictures):
    """The detections in each picture."""
    stamped = (Frame(image, 'rgb8', k * NANOSECONDS // RATE) for k, image in enumerate(pictures))
    return [detector.detect(frame).rows for frame in stamped]


def way(k):
    """Where a ball is that goes to the right."""
    return 20 + 4 * k, 60 + k


def test_one_small_ball_is_found_and_nothing_else():
    found = rows_of(sought(RED), (picture(way(k), seed=k) for k in range(25)))
    assert not any(len(rows) for rows in found[: 2 * RATE])
    for k, rows in enumerate(found[FROM:], FROM):
        (row,) = rows
        assert [row['u'], row['v']] == pytest.approx(way(k), abs=1)


def test_a_small_ball_is_found_by_its_name():
    detector = Detector(DetectorConfig(colors=(ReferenceColor.from_preset('it', 'red'),)))
    found = rows_of(detector, (picture(way(k), seed=k) for k in range(25)))
    assert [len(rows) for rows in found[FROM:]] == [1] * (25 - FROM)
    assert detector.trouble == ''


def test_a_ball_of_7_px_of_which_the_erosion_leaves_enough_now_and_then_is_found_in_every_picture():
    """The pictures in which it was found as usual kept it from being found in the others."""

    def shown(k):
        u, v = 20.3 + 4.3 * k, 60.2 + 1.4 * k
        image = np.full((480, 640, 3), WALL)
        cv2.circle(image, (round(4 * u), round(4 * v)), 14, RED, cv2.FILLED)
        image = cv2.resize(image, (160, 120), interpolation=cv2.INTER_AREA)
        image = cv2.GaussianBlur(image, (0, 0), 0.7)
        image += np.random.default_rng(k).normal(0, 2, image.shape)
        return image.clip(0, 255).astype(np.uint8)

    found = [len(rows) for rows in rows_of(sought(RED), map(shown, range(25)))]
    assert 0 < sum(found[:FROM]) < FROM / 2
    assert found[FROM:] == [1] * (25 - FROM)


def test_its_box_is_its_own_and_its_area_what_an_erosion_leaves_of_it():
    """So that the locator, which adds what the erosion takes, knows how large it is."""
    *_, (row,) = rows_of(sought(RED), (picture((80, 60), seed=k) for k in range(20)))
    assert 3 <= row['box_w'] <= 5
    assert np.sqrt(4 * row['area'] / np.pi) + 2.55 == pytest.approx(4.1, abs=0.5)


def test_specks_that_flicker_are_noise():
    rng = np.random.default_rng(0)
    places = [rng.uniform([10, 10], [150, 110], (3, 2)) for _ in range(40)]
    found = rows_of(sought(RED), (picture(*each, seed=k) for k, each in enumerate(places)))
    assert not any(len(rows) for rows in found)


def test_many_specks_are_a_texture():
    places = [(u, v) for u in range(15, 150, 30) for v in range(15, 110, 30)]
    found = rows_of(sought(RED), (picture(*places, seed=k) for k in range(25)))
    assert not any(len(rows) for rows in found)


def test_lines_are_no_small_things():
    image = picture()
    image[20:22, 40:60] = RED
    assert not any(len(rows) for rows in rows_of(sought(RED), [image] * 25))


def test_a_speck_beside_a_thing_is_none_until_the_thing_has_been_gone_for_long():
    images = [picture((120, 60), (40, 60), seed=k) for k in range(36)]
    for image in images[:8]:
        cv2.circle(image, (120, 60), 12, RED, cv2.FILLED)
    found = rows_of(sought(RED), images)
    assert {len(rows) for rows in found[:8]} == {1}
    assert {len(rows) for rows in found[8 : 8 + 3 * RATE]} == {0}
    assert len(found[-1]) == 2


@pytest.mark.parametrize('given', [{'min_area': 21}, {'closing_size': 3}, {'moving_only': True}])
def test_who_asks_for_other_blobs_gets_no_small_things(given):
    config = DetectorConfig(colors=(ReferenceColor.from_rgb('it', RED, 0.0),), **given)
    found = rows_of(Detector(config), (picture(way(k), seed=k) for k in range(25)))
    assert not any(len(rows) for rows in found)


def test_a_small_thing_in_an_ignored_region_is_not_found(tmp_path):
    mask = np.full((120, 160), 255, np.uint8)
    mask[:, :80] = 0
    cv2.imwrite(str(tmp_path / 'mask.png'), mask)
    config = DetectorConfig(
        colors=(ReferenceColor.from_rgb('it', RED, 0.0),), mask=str(tmp_path / 'mask.png')
    )
    found = rows_of(Detector(config), (picture((40, 60), (120, 60), seed=k) for k in range(20)))
    assert found[-1]['u'] == pytest.approx([120], abs=1)


def test_a_speck_that_comes_back_less_often_than_not_is_forgotten():
    specks, here = Specks.of(np.zeros((0, 2)), 0), np.array([[10.0, 10.0]])
    for k in range(30):
        seen = here if k % 3 == 0 else here[:0]
        assert not specks.update(seen, 20.0, k * NANOSECONDS // 10).any()
    assert len(specks) <= 1


def test_a_small_ball_is_found_when_the_stamps_start_again():
    """As in a recording that is played in a loop, at the end of which the ball has just come."""
    detector = sought(RED)
    rows_of(detector, (picture(*[(80, 60)] * (k >= 38), seed=k) for k in range(40)))
    found = rows_of(detector, (picture((80, 60), seed=k) for k in range(25)))
    assert [len(rows) for rows in found[FROM:]] == [1] * (25 - FROM)


@pytest.mark.parametrize('given', [{}, {'erosion_size': 1, 'min_area': 1}, {'min_area': 21}])
def test_a_wall_of_the_color_is_no_thing_and_is_told(given):
    """It is not found, as it fills the picture, and whatever is not small is not found either."""
    detector = Detector(DetectorConfig(colors=(ReferenceColor.from_rgb('it', RED, 0.0),), **given))
    image = picture()
    image[:, :140] = RED
    assert not any(len(rows) for rows in rows_of(detector, [image] * 13))
    assert 'fills more than' in detector.trouble


def test_a_texture_of_the_color_is_not_looked_at_in_each_picture(monkeypatch):
    """Looking at thousands of specks takes longer than all else."""
    looks, find_blobs = [], small_things.find_blobs
    monkeypatch.setattr(
        small_things, 'find_blobs', lambda image, least: looks.append(1) or find_blobs(image, least)
    )
    image = picture()
    image[::6, ::6] = RED
    assert not any(len(rows) for rows in rows_of(sought(RED), [image] * 6 * RATE))
    assert 1 < len(looks) < 8


def test_without_an_erosion_a_small_ball_is_found_at_once():
    color = ReferenceColor.from_rgb('it', RED, 0.0)
    detector = Detector(DetectorConfig(colors=(color,), erosion_size=1, min_area=5))
    found = rows_of(detector, (picture(way(k), seed=k) for k in range(5)))
    assert [len(rows) for rows in found] == [1] * 5
