"""Targets that change their look, their size, or their place all at once."""

from types import SimpleNamespace

import cv2
import numpy as np
import pytest
from support.window_pictures import frame
from support.window_pictures import texture

from colortrack_ros.data import COASTING
from colortrack_ros.data import CONFIRMED
from colortrack_ros.data import Frame
from colortrack_ros.windows import WindowConfig
from colortrack_ros.windows import WindowTracker
from colortrack_ros.windows.appearance import Appearance
from colortrack_ros.windows.appearance import LEARNED
from colortrack_ros.windows.appearance import NEARBY
from colortrack_ros.windows.matching import Matches
from colortrack_ros.windows.one_place import crowded_out
from colortrack_ros.windows.scale import ScaleFilter
from colortrack_ros.windows.template import Template

WALL = 0.4 * texture(30, 240, 320) + 70


def shown(patch, center, wall=WALL):
    """The wall with a patch of odd sides on it."""
    picture = wall.astype(np.float32).copy()
    (h, w), (u, v) = patch.shape, center
    picture[v - h // 2 : v + h // 2 + 1, u - w // 2 : u + w // 2 + 1] = patch
    return picture


def around(center, size=31):
    return [center[0] - size // 2, center[1] - size // 2, size, size]


def test_a_target_that_turns_into_another_look_is_kept_with_its_id():
    """Half a turn of its look in 40 frames: no window is like the first in the end."""
    one, other = texture(31, 31, 31), texture(32, 31, 31)
    tracker = WindowTracker(targets=around((60, 60)))
    for k in range(50):
        share = np.clip((k - 5) / 40, 0, 1)
        center = (60 + 3 * k, 60 + k)
        picture = shown((1 - share) * one + share * other, center)
        (row,) = tracker.update(frame(picture, k)).rows
    assert (row['track_id'], row['state']) == (1, CONFIRMED)
    assert np.hypot(row['u'] - center[0], row['v'] - center[1]) < 3


@pytest.mark.slow
def test_the_box_grows_and_shrinks_with_the_target():
    look = texture(33, 31, 31)
    for last in (47, 21):
        tracker = WindowTracker(targets=around((120, 120)))
        for k in range(60):
            side = round(np.interp(k, [5, 50], [31, last])) // 2 * 2 + 1
            picture = shown(cv2.resize(look, (side, side)), (120, 120))
            (row,) = tracker.update(frame(picture, k)).rows
        assert row['box_w'] == pytest.approx(last, rel=0.2)
        assert row['area'] == pytest.approx(row['box_w'] * row['box_h'], rel=1e-5)


def test_a_target_that_is_beside_its_place_after_a_cut_is_found_again():
    look = texture(34, 31, 31)
    tracker = WindowTracker(targets=around((60, 60)))
    states = []
    for k in range(45):
        place = (60, 60) if k < 15 else (110, 90)
        picture = WALL if 15 <= k < 20 else shown(look, place)
        (row,) = tracker.update(frame(picture, k)).rows
        states.append(row['state'])
    assert states[15:20] == [COASTING] * 5
    assert (row['track_id'], row['state']) == (1, CONFIRMED)
    assert np.hypot(row['u'] - 110, row['v'] - 90) < 2


def test_nothing_is_no_target():
    """Once it is gone, no part of the wall is taken for it."""
    tracker = WindowTracker(targets=around((60, 60)))
    look = texture(35, 31, 31)
    for k in range(15):
        tracker.update(frame(shown(look, (60 + 2 * k, 60)), k))
    for k in range(15, 60):
        rows = tracker.update(frame(WALL, k)).rows
        assert not (rows['state'] == CONFIRMED).any()
    assert not len(rows)


def test_a_velocity_that_the_matches_do_not_agree_on_is_not_coasted_by():
    look = texture(36, 31, 31)
    tracker = WindowTracker(targets=around((120, 120)))
    for k in range(15):
        center = (120 + 8 * (k % 2), 120)
        (row,) = tracker.update(frame(shown(look, center), k)).rows
    for k in range(15, 25):
        (row,) = tracker.update(frame(WALL, k)).rows
    assert np.hypot(row['u'] - center[0], row['v'] - center[1]) < 20


@pytest.mark.parametrize('encoding', ['bgr8', 'rgba8', 'mono8'])
def test_every_encoding_is_learned(encoding):
    tracker = WindowTracker(WindowConfig(min_similarity=1.0), around((60, 60)))
    for k in range(10):
        gray = np.clip(shown(texture(37, 31, 31), (60 + 3 * k, 60)), 0, 255).astype(np.uint8)
        image = {'bgr8': 3, 'rgba8': 4, 'mono8': 0}[encoding]
        image = np.repeat(gray[..., None], image, axis=2) if image else gray
        (row,) = tracker.update(Frame(image, encoding, k * 33_333_333)).rows
    assert row['state'] == CONFIRMED
    assert abs(row['u'] - 87) < 2


@pytest.mark.parametrize(
    ('seen', 'state'),
    [
        ([(0.0, 3), (0.6, 60)], COASTING),  # longer than max_time_since_update
        ([(0.0, 3), (0.95, 60)], CONFIRMED),
        ([(0.0, 15), (0.6, 15), (0.95, 10)], CONFIRMED),
        ([(0.0, 20), (0.6, 30), (0.95, 10)], COASTING),
    ],
)
def test_what_was_lost_is_followed_in_doubt_but_is_said_to_be_seen_only_for_sure(
    monkeypatch, seen, state
):
    """One in 30 other places is as like as 0.6: it is not the target by that alone.

    After max_time_since_update any place that is like it may be the best of many.
    """
    tracker = WindowTracker(targets=around((100, 100)))
    look, beside = texture(35, 31, 31), 0.4 * texture(36, 240, 320) + 70
    for k in range(30):
        rows = tracker.update(frame(shown(look, (100, 100)), k)).rows
    assert rows['state'] == CONFIRMED
    for value, frames in seen:
        monkeypatch.setattr(Appearance, 'likeness', lambda *_, value=value: value)
        for _ in range(frames):
            k += 1
            rows = tracker.update(frame(beside, k)).rows
    assert rows['state'].tolist() == [state]


@pytest.mark.parametrize(('share', 'states'), [(0.5, {COASTING}), (0.1, {CONFIRMED})])
def test_what_its_own_filter_hardly_answers_to_is_followed_but_not_said_to_be_seen(share, states):
    """A box on water: nothing in it stays, and the filter learns anew in each frame."""
    tracker, told = WindowTracker(targets=[[144, 104, 33, 33]]), []
    wall = 0.4 * texture(32, 240, 320) + 70
    for k in range(36):
        water = texture(1050 + k, 240, 320)
        rows = tracker.update(frame((1 - share) * wall + share * water, k)).rows
        told += rows['state'].tolist()
    assert set(told[-10:]) == states


def test_a_size_that_has_changed_by_a_quarter_since_the_last_look_is_found_at_once():
    look = texture(38, 93, 93, 4.0)
    for side in (25, 39):
        first = frame(shown(cv2.resize(look, (31, 31), interpolation=cv2.INTER_AREA), (160, 120)))
        sizes = ScaleFilter(first, np.array([160.0, 120.0]), np.array([31.0, 31.0]))
        then = cv2.resize(look, (side, side), interpolation=cv2.INTER_AREA)
        sizes.update(frame(shown(then, (160, 120))), np.array([160.0, 120.0]))
        assert 31 * sizes.scale == pytest.approx(side, rel=0.1)


def test_a_size_that_stays_is_the_same_to_the_bit():
    look, sizes = texture(39, 31, 31), None
    for k in range(20):
        noise = np.random.default_rng(k).normal(0, 2, WALL.shape)
        picture = frame(shown(look, (160, 120)) + noise)
        if sizes is None:
            sizes = ScaleFilter(picture, np.array([160.0, 120.0]), np.array([31.0, 31.0]))
        sizes.update(picture, np.array([160.0, 120.0]))
    assert sizes.scale == 1


@pytest.mark.parametrize(('covered', 'learned'), [(False, True), (True, False)])
def test_what_is_hardly_like_the_target_is_learned_only_where_its_template_is_found(
    monkeypatch, covered, learned
):
    """A target that deforms would be less and less like what was learned of it at first."""
    tracker, lessons = WindowTracker(targets=around((100, 100))), []
    look = texture(35, 31, 31)
    for k in range(30):
        tracker.update(frame(shown(look, (100, 100)), k))
    monkeypatch.setattr(Appearance, 'likeness', lambda *_: (NEARBY + LEARNED) / 2)
    monkeypatch.setattr(Appearance, 'learn', lambda *_: lessons.append(1))
    other = texture(36, 31, 31) if covered else look
    for k in range(30, 40):
        rows = tracker.update(frame(shown(other, (100, 100)), k)).rows
        assert rows['state'] == CONFIRMED
    assert bool(lessons) == learned


def test_what_is_as_like_at_another_place_is_not_said_to_be_the_target_at_once(monkeypatch):
    """Nor if it is found in the very frame in which the target is gone."""
    tracker = WindowTracker(targets=around((100, 100)))
    look = texture(35, 31, 31)
    for k in range(30):
        rows = tracker.update(frame(shown(look, (100, 100)), k)).rows
    assert rows['state'] == CONFIRMED
    answers = iter([0.0] + 60 * [0.6])  # at the expected place, and then wherever it looks
    monkeypatch.setattr(Appearance, 'likeness', lambda *_: next(answers))
    beside = 0.4 * texture(36, 240, 320) + 70
    for k in range(30, 40):
        rows = tracker.update(frame(beside, k)).rows
        assert rows['state'].tolist() == [COASTING]


@pytest.mark.parametrize(('found', 'share'), [(True, 0.5), (False, 1.0)])
def test_while_its_template_is_found_a_target_is_looked_at_in_every_other_frame(
    monkeypatch, found, share
):
    tracker, looks, look = WindowTracker(targets=around((100, 100))), [], Appearance.look
    picture = shown(texture(35, 31, 31), (100, 100))
    for k in range(10):
        tracker.update(frame(picture, k))
    monkeypatch.setattr(Appearance, 'look', lambda *given: looks.append(1) or look(*given))
    monkeypatch.setattr(Matches, 'are_valid', lambda own, *_: np.full(len(own.z), found))
    for k in range(10, 30):
        (row,) = tracker.update(frame(picture, k)).rows
        assert row['state'] == CONFIRMED
    assert len(looks) == 20 * share


@pytest.mark.parametrize('seed', [33, 35])
def test_what_was_seen_beside_a_target_and_then_covers_it_is_not_taken_for_it(seed):
    """Its look is more than half that of the target, and it goes on when it has covered it."""
    look, other = texture(seed, 31, 31), texture(seed + 100, 31, 31)
    tracker = WindowTracker(WindowConfig(min_similarity=1.0), around((160, 120)))
    for k in range(80):
        picture = shown(0.55 * look + 0.45 * other, (280 - 3 * k, 120), shown(look, (160, 120)))
        for row in tracker.update(frame(picture, k)).rows:
            away = np.hypot(row['u'] - 160, row['v'] - 120)
            assert away < 31 or row['state'] != CONFIRMED


@pytest.mark.slow
@pytest.mark.parametrize('share', [0.7, 1.0])
def test_a_window_does_not_go_over_to_another_target_that_crosses_before_its_own(share):
    """Both look much alike, as walkers do, and none is like its template."""
    look, other = texture(33, 31, 31), texture(133, 31, 31)
    boxes = [around((160, 120)), around((280, 120))]
    tracker = WindowTracker(WindowConfig(min_similarity=1.0), boxes)
    for k in range(80):
        place = {1: 160, 2: 280 - 3 * k}
        picture = shown(
            share * look + (1 - share) * other, (place[2], 120), shown(look, (160, 120))
        )
        rows = tracker.update(frame(picture, k)).rows
        for row in rows[rows['state'] == CONFIRMED]:
            assert abs(row['u'] - place[row['track_id']]) < 31
    assert rows['state'].tolist() == [CONFIRMED, CONFIRMED]


def test_two_windows_that_are_started_on_one_thing_stay_both():
    """A detector may have drawn two boxes: none of them tells which is the better one."""
    look = texture(33, 31, 31)
    boxes = [around((100, 120)), np.add(around((100, 120)), [5, 0, 0, 0])]
    tracker = WindowTracker(WindowConfig(min_similarity=1.0), boxes)
    for k in range(20):
        rows = tracker.update(frame(shown(look, (100 + 2 * k, 120)), k)).rows
        assert rows['state'].tolist() == [CONFIRMED, CONFIRMED]


@pytest.mark.parametrize('wait', [0, 1])
def test_a_window_whose_template_is_found_without_being_alike_may_be_crowded_out(monkeypatch, wait):
    """At a least similarity of 0; in every other frame it is not looked for besides."""
    aligned = Template.align

    def align(template, crop, position):
        alike = template.picture.shape == (31, 31)
        return aligned(template, crop, position) if alike else (position, 0.0, -1.0)

    monkeypatch.setattr(Template, 'align', align)
    boxes = [around((160, 120)), around((220, 120), 29)]
    tracker = WindowTracker(WindowConfig(min_similarity=0.0, max_drop=1.0), boxes)
    for k in range(20):
        u = 220 - 5 * min(max(k - wait - 2, 0), 11)
        picture = shown(texture(35, 29, 29), (u, 120), shown(texture(33, 31, 31), (160, 120)))
        rows = tracker.update(frame(picture, k)).rows
    assert rows['track_id'].tolist() == [1, 2]


@pytest.mark.parametrize(('looks', 'out'), [([0, 0], [0]), ([0, 7], []), ([7, 7], [0])])
def test_what_was_lost_crowds_out_nobody_who_was_seen_until_now(looks, out):
    """The second one is more like itself at the place of both."""
    likeness = [SimpleNamespace(likeness=lambda _, own=own: own) for own in (0.7, 0.9)]
    records = {
        'track_id': np.array([1, 2]), 'looks': np.array(looks), 'appearance': likeness,
        'box_w': np.full(2, 20.0), 'box_h': np.full(2, 40.0), 'company': [{1}, {2}],
    }  # fmt: skip
    matches = SimpleNamespace(z=np.full((2, 2), 50.0), similarity=np.zeros(2))
    assert crowded_out(records, matches, np.ones(2, bool), {0: None, 1: None}) == out
