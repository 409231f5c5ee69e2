"""What is learned of a target from what was looked at already."""

from dataclasses import replace

import numpy as np
import pytest
from support.window_pictures import frame
from support.window_pictures import texture

from colortrack_ros.data import COASTING
from colortrack_ros.data import CONFIRMED
from colortrack_ros.windows import appearance
from colortrack_ros.windows import matching
from colortrack_ros.windows import WindowConfig
from colortrack_ros.windows import WindowTracker
from colortrack_ros.windows.appearance import Appearance
from colortrack_ros.windows.correlation import CorrelationFilter
from colortrack_ros.windows.features import describe
from colortrack_ros.windows.matching import Matches
from colortrack_ros.windows.sighting import UNFOUND

CENTER, SIZE = np.array([160.0, 120.0]), np.array([31.0, 31.0])


def turned_picture(share):
    """A target whose look has turned by a share into another one, before a wall."""
    picture = 0.4 * texture(30, 240, 320) + 70
    picture[105:136, 145:176] = (1 - share) * texture(31, 31, 31) + share * texture(32, 31, 31)
    return frame(picture)


@pytest.mark.parametrize(('beside', 'looks'), [(2.0, 1), (12.0, 2)])
def test_a_target_near_the_middle_of_what_was_looked_at_is_not_looked_at_again(
    monkeypatch, beside, looks
):
    """A cell is 2.4 px wide here."""
    described, target = [], Appearance(turned_picture(0), CENTER, SIZE)
    monkeypatch.setattr(appearance, 'describe', lambda *x: described.append(1) or describe(*x))
    seen = target.look(turned_picture(0), np.add(CENTER, (beside, 0)))
    target.learn(turned_picture(0), seen.z, seen)
    assert len(described) == looks


def test_what_is_learned_beside_the_middle_is_found_where_it_was():
    target = Appearance(turned_picture(0), CENTER, SIZE)
    for k in range(60):
        picture = turned_picture(min(k / 40, 1))
        place = np.add(CENTER, (2.0, -2.0))
        seen = target.look(picture, place)
        place[:] = CENTER  # an array of the caller's
        target.learn(picture, CENTER, seen)
    seen = target.look(picture, CENTER)
    assert seen.z == pytest.approx(CENTER, abs=0.6)


@pytest.mark.parametrize('switch', ['appearance', 'drift_compensation'])
def test_an_appearance_that_is_switched_on_later_is_learned_from_then_on(switch):
    """Without it, what the target turns into is lost; with it from the start, 2.8 px off."""
    learning = WindowConfig(renewal=1.0)
    tracker = WindowTracker(replace(learning, **{switch: False}), targets=[145, 105, 31, 31])
    for k in range(60):
        if k == 5:
            tracker.configure(learning)
        rows = tracker.update(frame(turned_picture(min(k / 40, 1)).image, k)).rows
        assert (rows['track_id'].tolist(), rows['state'].tolist()) == ([1], [CONFIRMED])
        assert np.hypot(rows['u'][0] - 160, rows['v'][0] - 120) < 3


@pytest.mark.parametrize('found', [False, True])
def test_what_hardly_answered_for_a_time_is_seen_again_only_where_its_template_is_found(
    monkeypatch, found
):
    """Until then its filter has learned what it followed, and no new template shows that either."""
    now = {'distinct': True, 'found': True}
    monkeypatch.setattr(Appearance, 'likeness', lambda *_: 1.0)
    monkeypatch.setattr(Appearance, 'is_distinct', property(lambda _: now['distinct']))
    monkeypatch.setattr(Matches, 'are_valid', lambda own, *_: np.full(len(own.z), now['found']))
    tracker = WindowTracker(targets=[145, 105, 31, 31])
    states, templates = [], []
    for k in range(40):
        now.update(distinct=not 5 <= k < 20, found=k < 5 or (found and k >= 30))
        picture = turned_picture(min(max(k - 5, 0) / 10, 1))
        tracks = tracker.update(replace(picture, stamp=k * 33_000_000))
        states.append(int(tracks.rows['state'][0]))
        templates.append(tracker._tracks.records['template'][0])
    assert states[:5] == [CONFIRMED] * 5
    assert states[5:30] == [COASTING] * 25
    assert states[30:] == [CONFIRMED if found else COASTING] * 10
    assert all(each is templates[0] for each in templates[:30])


@pytest.mark.parametrize(('likeness', 'searches'), [(1.0, 5), (0.0, 10)])
def test_a_template_long_unfound_takes_turns_with_learning_while_the_target_is_seen(
    monkeypatch, likeness, searches
):
    """Until then, and while the target is lost, it is searched for in every frame."""
    searched, search = [], matching._search
    monkeypatch.setattr(Appearance, 'likeness', lambda *_: likeness)
    monkeypatch.setattr(Matches, 'are_valid', lambda own, *_: np.zeros(len(own.z), bool))
    monkeypatch.setattr(matching, '_search', lambda *x: searched.append(1) or search(*x))
    tracker = WindowTracker(targets=[145, 105, 31, 31])
    for k in range(UNFOUND + 1):
        tracker.update(frame(turned_picture(0).image, k))
    assert len(searched) == UNFOUND
    for k in range(UNFOUND + 1, UNFOUND + 11):
        tracker.update(frame(turned_picture(0).image, k))
    assert len(searched) == UNFOUND + searches


def test_nothing_is_learned_while_more_than_usual_responds_beside_the_target(monkeypatch):
    """Until that has become usual: who stands there will not cover it soon."""
    learned, look = [], texture(31, 61, 21)
    alone = 0.4 * texture(30, 240, 320) + 70
    alone[90:151, 150:171] = look
    beside = alone.copy()
    beside[90:151, 172:193] = look
    target = Appearance(frame(alone), CENTER, np.array([21.0, 61.0]))
    monkeypatch.setattr(CorrelationFilter, 'learn', lambda *_: learned.append(1))
    counts = []
    for picture in (*15 * [frame(alone)], *15 * [frame(beside)]):
        target.learn(picture, CENTER, target.look(picture, CENTER))
        counts.append(len(learned))
    assert counts[14] == 15
    assert counts[15:18] == 3 * [15]
    assert counts[-1] > 20
