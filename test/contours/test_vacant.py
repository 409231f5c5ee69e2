"""Contours of nothing are not told: on a place that something has left, or without foreground."""

import cv2
import numpy as np
import pytest
from support.contour_pictures import follow
from support.contour_pictures import known
from support.contour_pictures import picture
from support.contour_pictures import texture

from colortrack_ros.contours import ContourConfig
from colortrack_ros.contours.vacant import is_vacant

BOX = np.s_[60:160, 120:170]
ANGLES = np.linspace(0, 2 * np.pi, 40, endpoint=False)
OUTLINE = np.stack([144.5 + 28 * np.cos(ANGLES), 109.5 + 55 * np.sin(ANGLES)], axis=1)


def pictures(channels=3):
    """One with a thing, and one without it."""
    wall = texture(3, contrast=8.0).astype(np.uint8)
    thing = wall.copy()
    thing[BOX] = 45
    return (cv2.merge([each] * channels).reshape(240, 320, channels) for each in (thing, wall))


def differing(where=BOX):
    mask = np.zeros((240, 320), np.uint8)
    mask[where] = 255
    return mask


@pytest.mark.parametrize('channels', [1, 3])
def test_a_thing_has_its_edges_in_the_picture_and_a_place_left_in_the_background(channels):
    thing, wall = pictures(channels)
    assert not is_vacant(OUTLINE[None], differing(), thing, wall).any()
    assert is_vacant(OUTLINE[None], differing(), wall, thing).all()


def test_an_outline_with_next_to_no_foreground_shows_nothing():
    thing, wall = pictures()
    outlines = OUTLINE + np.array([0, 46, 90, -200, 1000])[:, None, None] * [1, 0]
    vacant = is_vacant(outlines, differing(), thing, wall)
    assert vacant.tolist() == [False, True, True, True, True]
    assert not is_vacant(outlines[1:2], differing(np.s_[60:160, 120:200]), thing, wall).any()
    assert is_vacant(np.zeros((0, 40, 2)), differing(), thing, wall).shape == (0,)


def test_many_outlines_are_judged_as_each_alone_with_as_many_filters(monkeypatch):
    """Few are cut out, of many, which cover more than there is, the whole picture is filtered."""
    thing, wall = pictures()
    random = np.random.default_rng(4)
    middles = random.uniform(-20, [340, 260], (40, 1, 2))
    size = random.uniform(0.1, 1.5, (40, 1, 1))
    outlines = size * (OUTLINE - OUTLINE.mean(axis=0)) + middles
    mask = differing() | (random.random((240, 320)) < 0.1)
    thing[:, 200:] = cv2.blur(thing[:, 200:], (9, 9))
    filtered = []
    blur = cv2.blur
    monkeypatch.setattr(cv2, 'blur', lambda image, *a: filtered.append(image) or blur(image, *a))
    together = is_vacant(outlines, mask, thing, wall)
    assert [image.shape for image in filtered] == [thing.shape] * 2
    alone = [is_vacant(each[None], mask, thing, wall)[0] for each in outlines]
    assert filtered[-1].size < thing.size
    assert together.tolist() == alone
    assert 5 < sum(alone) < 35


@pytest.mark.slow
@pytest.mark.parametrize(('contrast', 'speed'), [(8.0, 1.5), (8.0, 6.0), (25.0, -1.5), (25.0, 6.0)])
def test_where_somebody_stood_while_the_background_was_learned_nobody_is_told(contrast, speed):
    """A contour stayed there as he walked off, and was told for up to 43 pictures."""
    wall = texture(3, contrast=contrast)
    way = [160 + speed * max(k - 45, 0) for k in range(110)]
    shown = [
        picture('person', (u, 120.0), 24.0, background=wall, seed=k) for k, u in enumerate(way)
    ]
    results = follow(shown, ContourConfig())
    told = [(u, row['u']) for u, t in zip(way, results, strict=True) for row in t.rows[known(t)]]
    off = np.abs(np.diff(told)[:, 0])
    assert np.sum(off <= 30) >= 16  # he is followed for as long as he is in sight
    assert np.sum(off > 30) <= 3  # one picture, and two in which it coasts
