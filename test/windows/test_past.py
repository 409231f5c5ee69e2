"""A window is not said to be on its target at a place that looked the same without it."""

import numpy as np
import pytest
from support.window_pictures import frame
from support.window_pictures import texture

from colortrack_ros.data import CONFIRMED
from colortrack_ros.data import Frame
from colortrack_ros.windows import WindowTracker
from colortrack_ros.windows.past import Past

HERE, THERE = np.array([100.0, 120.0, 30.0, 60.0]), np.array([200.0, 120.0, 30.0, 60.0])
RIGHT = np.array([1000.0, 0.0, 0.0, 0.0])
WALL, THING = 0.6 * texture(40, 240, 320) + 50, texture(41, 60, 30)


def shown(box=None, k=0, wall=WALL):
    """The wall, and the thing before it; four frames a second."""
    picture = wall.copy()
    if box is not None:
        left, top = (box[:2] - box[2:] / 2).astype(int)
        picture[top : top + 60, left : left + 30] = THING
    return frame(picture, k, rate=4.0)


def seen_at(box, looks=0):
    """Records of one target."""
    return {
        'track_id': np.array([1]), 'seen': box[None, :2], 'looks': np.array([looks]),
        'box_w': box[None, 2], 'box_h': box[None, 3],
    }  # fmt: skip


def past_of(boxes, looks=0):
    past = Past()
    for k, box in enumerate(boxes):
        past.keep(shown(box, k), seen_at(box, looks))
    return past


def test_a_place_that_showed_the_same_while_the_target_was_elsewhere_is_not_the_target():
    past = past_of([HERE, HERE])
    assert past.showed(shown(HERE, 2), 1, THERE)
    assert not past.showed(shown(THERE, 2), 1, THERE)
    assert not past.showed(shown(HERE, 2), 1, HERE)
    beside = HERE + 0.02 * RIGHT
    assert not past.showed(shown(HERE, 2), 1, beside)  # it was partly there
    assert not past.showed(shown(HERE, 2), 2, THERE)  # nobody knows where that one was


@pytest.mark.parametrize(('boxes', 'looks'), [([HERE], 0), ([HERE, THERE], 0), ([HERE] * 4, 1)])
def test_one_picture_or_a_target_that_was_lost_tells_nothing(boxes, looks):
    assert not past_of(boxes, looks).showed(shown(HERE, 4), 1, THERE)


def test_pictures_are_kept_four_times_a_second_and_for_some_seconds():
    past = Past()
    for k in range(5):
        past.keep(frame(WALL, k, rate=20.0), seen_at(HERE))
    assert not past.showed(shown(None, 2), 1, THERE)  # one alone
    past = past_of([HERE, HERE] + [THERE] * 16)
    assert not past.showed(shown(HERE, 18), 1, THERE)


def test_of_a_new_target_what_was_there_before_it_came_is_not_the_target():
    past = past_of([THERE, THERE])  # another one's
    past.begin(shown(HERE, 2), [7], HERE[None])
    assert past.showed(shown(None, 3), 7, HERE)
    assert not past.showed(shown(HERE, 3), 7, HERE)


def test_a_new_target_that_had_been_there_all_along_is_not_doubted():
    past = past_of([HERE, HERE])
    noise = np.random.default_rng(5).normal(0, 2, WALL.shape)
    past.begin(shown(HERE, 2), [7], HERE[None])
    assert not past.showed(shown(HERE, 3), 7, HERE)
    assert not past.showed(shown(HERE, 3, WALL + noise), 7, HERE)


def reached_for(left: int) -> np.ndarray:
    """The thing, and a hand that comes in from the left as far as that."""
    picture = WALL.copy()
    picture[90:150, 85:115] = THING
    picture[95:140, :left] = texture(43, 45, 320)[:, :left]
    return picture


def test_what_stood_there_is_not_its_own_background_after_a_hand_has_covered_it():
    past = past_of([HERE, HERE])
    past.begin(shown(k=2, wall=reached_for(97)), [7], HERE[None])
    assert not past.showed(shown(HERE, 3), 7, HERE)


@pytest.mark.slow
def test_a_target_that_stood_there_is_kept_after_a_hand_that_covered_it_has_gone():
    tracker = WindowTracker()
    for k in range(40):
        if k == 10:
            tracker.start([[85, 90, 30, 60]])
        left = (0, 97, max(97 - 5 * (k - 15), 0))[(k >= 10) + (k >= 15)]
        rows = tracker.update(frame(reached_for(left), k, rate=10.0)).rows
    assert rows['state'].tolist() == [CONFIRMED]
    np.testing.assert_allclose([rows['u'][0], rows['v'][0]], [99.5, 119.5], atol=2.0)


def test_a_place_is_compared_with_the_past_once(monkeypatch):
    """Where the template is found and the target is seen."""
    asked, showed = [], Past.showed
    monkeypatch.setattr(Past, 'showed', lambda *given: asked.append(1) or showed(*given))
    tracker = WindowTracker(targets=[[85, 90, 30, 60]])
    for k in range(8):
        assert len(tracker.update(shown(HERE, k)).rows) == 1
        assert len(asked) == k


@pytest.mark.parametrize('box', [HERE * (1, 1, 0.1, 0.1), HERE + RIGHT, HERE * 20])
def test_places_that_cannot_be_compared_tell_nothing(box):
    past = past_of([THERE, THERE, THERE])
    past.begin(shown(THERE, 3), [7], box[None])
    assert not past.showed(shown(THERE, 3), 7, box)
    assert not past.showed(shown(THERE, 3), 1, box)


def test_pictures_of_another_size_and_without_texture_tell_nothing():
    past = past_of([HERE, HERE])
    large = Frame(np.repeat(shown(HERE).image, 2, axis=0), 'mono8', 10**9)
    past.begin(large, [7], THERE[None])
    assert not past.showed(large, 1, THERE)
    past = Past()
    for k in range(3):
        past.keep(frame(0 * WALL, k, rate=4.0), seen_at(HERE))
    assert not past.showed(frame(0 * WALL, 4, rate=4.0), 1, THERE)


@pytest.mark.slow
@pytest.mark.parametrize('encoding', ['mono8', 'rgb8'])
def test_a_window_does_not_stay_on_what_a_target_came_out_from_behind(encoding):
    """Its first box shows mostly a pillar, on which the window stayed for as long as it stood."""
    pillar = WALL.copy()
    pillar[60:180, 90:113] = texture(42, 120, 23)
    tracker, on_nothing = WindowTracker(), []
    for k in range(64):
        left = max(85 - 60 + 2 * k, 0) if k < 30 else 85 + 3 * (k - 30)
        picture = pillar.copy()
        picture[90:150, left : left + 30] = THING
        if k <= 34:
            picture[60:180, 90:113] = pillar[60:180, 90:113]
        if k == 30:
            tracker.start([[85, 90, 30, 60]])
        gray = np.clip(np.rint(picture), 0, 255).astype(np.uint8)
        image = gray if encoding == 'mono8' else np.repeat(gray[..., None], 3, axis=2)
        rows = tracker.update(Frame(image, encoding, round(k * 1e9 / 10))).rows
        if k > 44:
            off = [abs(float(r['u']) - left - 14.5) > 30 for r in rows if r['state'] == CONFIRMED]
            on_nothing.append(any(off))
    assert sum(on_nothing) <= 2


def test_things_that_look_alike_and_pass_in_a_row_are_not_taken_for_what_stands_there():
    """Bottles on a conveyor, 64 px apart, at 97 px/s: each has been where the last one is."""
    belt = np.tile(np.concatenate([THING, np.full((60, 34), 90, np.float32)], axis=1), (1, 10))
    past = Past()
    for k in range(16):
        left = round(97 * k / 4)
        picture = WALL.copy()
        picture[90:150] = np.roll(belt, left, axis=1)[:, :320]
        past.keep(frame(picture, k, rate=4.0), seen_at(HERE))
    doubted, picture = [], WALL.copy()
    for left in range(64):
        picture[90:150] = np.roll(belt, left, axis=1)[:, :320]
        place = np.array([192.0 + left + 15, 120.0, 30.0, 60.0])
        doubted.append(past.showed(frame(picture, 16, rate=4.0), 1, place))
    assert sum(doubted) == 0


@pytest.mark.slow
@pytest.mark.parametrize('behind', [0, 4])
def test_things_that_look_alike_and_move_on_by_one_place_are_not_doubted(behind):
    """Parts on a belt that stops: each comes to stand where the one before it stood."""
    tracker, on_target = WindowTracker(), 0
    for k in range(48):
        steps, rest = divmod(k, 16)
        moved = round(64 * (steps + max(rest - 10, 0) / 6))
        picture = WALL.copy()
        for left in range(45 - 64 * behind + moved, 290, 64):
            if left >= 0:
                picture[90:150, left : left + 30] = THING
        if k == 3:
            tracker.start([[45, 90, 30, 60]])
        rows = tracker.update(frame(picture, k, rate=10.0)).rows
        on_target += any(r['state'] == CONFIRMED and abs(r['u'] - 60 - moved) < 5 for r in rows)
    assert on_target >= 43
