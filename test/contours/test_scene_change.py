"""Cuts, bumps, covers, and lights: when a scene is another one, and what becomes of targets."""

import numpy as np
import pytest
from support.contour_pictures import follow
from support.contour_pictures import frame
from support.contour_pictures import known
from support.contour_pictures import picture
from support.contour_pictures import texture

from colortrack_ros.contours import ContourConfig
from colortrack_ros.contours import ContourTracker
from colortrack_ros.contours.foreground import SETTLED_SECONDS
from colortrack_ros.data import CONFIRMED

WALL = texture(3, 400, 700, contrast=25.0)
FIRST, FRAMES, RATE = 60, 150, 24.0
"""The picture from which on something is different, and how many there are."""


def place(k):
    """Column of one who comes in after half a second."""
    return 3.0 * k - 70


def seen(k, aside=(0, 0), wall=WALL):
    """Picture k of one who walks before a wall, as a camera that looks aside by (v, u) sees it."""
    rows, columns = (slice(50 + x, 50 + x + n) for x, n in zip(aside, (240, 320), strict=True))
    center = place(k) - aside[1], 120.0 - aside[0]
    return picture('person', center, 20.0, background=wall[rows, columns], seed=k)


def is_followed(tracks, u):
    """Whether one target that is measured is there, and at most one other coasts."""
    rows = tracks.rows[tracks.rows['state'] == CONFIRMED]
    return len(rows) == 1 and abs(rows['u'][0] - u) < 6 and known(tracks).sum() <= 2


def told_of(pictures, **settings):
    """What is told of pictures: tracks of each, and in which ones that it started afresh."""
    results = follow(pictures, ContourConfig(**settings))
    return results, [k for k, tracks in enumerate(results) if tracks.restarted]


@pytest.mark.slow
@pytest.mark.parametrize('aside', [(0, 6), (4, 30)], ids=['6 px', '30 px'])
def test_after_a_small_bump_the_background_goes_along_and_nobody_is_lost(aside):
    pictures = [seen(k, aside if k >= FIRST else (0, 0)) for k in range(FRAMES - 40)]
    results, told = told_of(pictures)
    assert not told
    ids = {int(i) for t in results[FIRST:] for i in t.rows['track_id'][known(t)]}
    assert len(ids) == 1
    for k in range(FIRST + 8, FRAMES - 40):
        assert is_followed(results[k], place(k) - aside[1])


@pytest.mark.slow
def test_after_a_bump_the_background_is_learned_anew_and_nothing_false_stands():
    aside = -40, 90
    results, told = told_of([seen(k, aside if k >= FIRST else (0, 0)) for k in range(FRAMES)])
    (when,) = told
    assert (when - FIRST) / RATE == pytest.approx(SETTLED_SECONDS, abs=0.1)
    assert not len(results[when].rows)
    for k in range(when + 20, FRAMES - 40):
        assert is_followed(results[k], place(k) - aside[1])


@pytest.mark.slow
def test_a_cut_ends_all_targets_but_those_that_somebody_named():
    other = texture(9, 400, 700, contrast=25.0)
    pictures = [seen(k, wall=other if k >= FIRST else WALL) for k in range(FRAMES - 30)]
    tracker, ids = ContourTracker(), []
    tracker.start([[200, 180, 40, 40]])
    for k, image in enumerate(pictures):
        image[180:220, 200:240] = 20
        tracks = tracker.update(frame(image, k))
        ids.append(tracks.rows['track_id'][known(tracks)].tolist())
        assert tracker.scene_changes == (k >= FIRST + round(SETTLED_SECONDS * RATE))
    assert all(1 in row for row in ids)
    assert len(ids[FIRST - 1]) == 2
    assert ids[FIRST + round(SETTLED_SECONDS * RATE)] == [1]


def half_light(image):
    return (image * np.linspace(0.5, 0.8, image.shape[1])).astype(np.uint8)


def with_a_door(image):
    """Half of the picture is covered by what stands there."""
    image = image.copy()
    image[:, 170:] = WALL[100:340, 400:550]
    return image


@pytest.mark.slow
@pytest.mark.parametrize('change', [half_light, with_a_door])
def test_other_light_and_what_is_put_before_half_of_the_scene_make_no_other_scene(change):
    pictures = [seen(k) for k in range(FRAMES)]
    assert not told_of(pictures[:FIRST] + [change(image) for image in pictures[FIRST:]])[1]


@pytest.mark.slow
@pytest.mark.parametrize(
    'cover',
    [np.zeros((240, 320), np.uint8), texture(7, contrast=30.0).astype(np.uint8)],
    ids=['black', 'hand'],
)
def test_what_covers_the_lens_for_a_second_is_no_background(cover):
    """It is given back as it was, and so is the target when it moves on."""
    pictures = [cover if FIRST <= k < FIRST + 24 else seen(k) for k in range(FRAMES - 40)]
    results, told = told_of(pictures)
    assert not told
    for k in range(FIRST + 24 + 12, FRAMES - 40):
        assert is_followed(results[k], place(k))


def test_black_pictures_while_the_background_is_learned_do_no_harm():
    black = [np.zeros((240, 320), np.uint8)] * 30
    assert len(follow([seen(k) for k in range(24)] + black, ContourConfig())) == 54


@pytest.mark.slow
def test_those_who_walk_on_a_plain_floor_from_the_first_picture_on_are_followed():
    """The only texture of the first picture is theirs: it is no background that has gone."""
    floor = np.full((240, 320), 215.0)

    def middles(k):
        way = 1.5 * k * np.resize([1, -1], 8)
        return np.stack([40.0 + 80 * (np.arange(8) % 4) + way, np.repeat([60.0, 180.0], 4)], axis=1)

    def shown(k):
        image = floor
        for middle in middles(k).tolist():
            image = picture('person', middle, 22.0, background=image, seed=k)
        return image

    def followed(k, tracks):
        rows, (u, v) = tracks.rows[known(tracks)], middles(k).T[..., None]
        inside = (np.abs(rows['box_u'] + rows['box_w'] / 2 - u) < rows['box_w'] / 2) & (
            np.abs(rows['box_v'] + rows['box_h'] / 2 - v) < rows['box_h'] / 2
        )
        return inside.any(axis=1).sum()

    results, told = told_of([shown(k) for k in range(70)])
    assert not told
    found = [followed(k, tracks) for k, tracks in enumerate(results)]
    assert max(found) >= 5
    assert min(found[found.index(max(found)) :]) >= 3  # those who meet are one area
    assert known(results[-1]).sum() <= found[-1] + 1


@pytest.mark.slow
def test_who_stood_before_a_plain_wall_from_the_first_picture_on_is_followed_when_leaving():
    """All texture of the background was theirs and went with them: for another scene, unseen."""
    wall = np.full((240, 320), 120.0)

    def shown(k):
        at = 70.0 + 3 * max(k - 50, 0), 120.0
        return picture('person', at, 32.0, background=wall, seed=k)

    results, told = told_of([shown(k) for k in range(110)])
    assert not told
    assert all(
        is_followed(tracks, 70.0 + 3 * (k - 50)) for k, tracks in enumerate(results[85:], 85)
    )


@pytest.mark.slow
def test_before_a_camera_that_moves_all_the_time_no_scene_stands_still():
    pictures = [seen(k, (0, round(40 * np.sin(k / 8)))) for k in range(FRAMES)]
    assert not told_of(pictures)[1]


@pytest.mark.slow
@pytest.mark.parametrize(('start', 'told'), [('background', True), ('targets', False)])
def test_a_camera_that_moves_for_long_is_told_until_it_stands_again(start, told):
    """Nothing is found meanwhile, where something would be looked for."""
    wide = texture(3, 400, 1000, contrast=25.0)
    tracker, troubles = ContourTracker(ContourConfig(start=start)), []
    for k in range(240):
        tracker.update(frame(seen(k, (0, min(4 * k, 600)), wide), k))
        troubles.append(bool(tracker.trouble))
    assert any(troubles[:150]) == told
    assert not any(troubles[:70]), 'a moment is nothing'
    assert not troubles[-1]


@pytest.mark.slow
def test_a_person_who_fills_the_picture_and_stops_is_a_target_still():
    """What is known is left out: it hides the background and is none."""

    def shown(k):
        radius = min(26.0 + k, 118.0)
        return picture('quadrilateral', (160.0, 120.0 + k % 2), radius, background=WALL[:240, :320])

    plain = [picture('person', None, 0, background=WALL[:240, :320], seed=k) for k in range(30)]
    assert not told_of(plain + [shown(k) for k in range(170)], min_motion=0.0)[1]
