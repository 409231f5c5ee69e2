import numpy as np
import pytest
from support.contour_pictures import corners_of
from support.contour_pictures import EMPTY
from support.contour_pictures import frame
from support.contour_pictures import overlap
from support.contour_pictures import picture
from support.contour_pictures import RATE

from colortrack_ros.contours import ContourConfig
from colortrack_ros.contours import ContourTracker
from colortrack_ros.contours.agreement import history
from colortrack_ros.contours.boxes import boxes
from colortrack_ros.contours.records import begin
from colortrack_ros.contours.records import CONTOUR_FIELDS
from colortrack_ros.contours.regions import OwnAreas
from colortrack_ros.data import COASTING
from colortrack_ros.data import CONFIRMED

QUICK = ContourConfig(learn_seconds=0.0)


def changes(widths, rate=RATE, height=90.0, shared=False):
    """Whether the width of a foreground is said to change, in each frame; None is without one."""
    records, said = np.zeros(1, CONTOUR_FIELDS), []
    records['seen_w'], records['seen_h'] = widths[0], height
    for width in widths:
        box = np.array([[10.0, 10.0, 10 + (width or np.nan), 10 + height]])
        first = np.array([-1 if width is None else 0])
        no = np.zeros((1, 4), bool)
        regions = OwnAreas(box, np.array([shared]), no, first, no[:, 0])
        said.append(bool(history(records, box, regions, 0, 1.0, 1 / rate).changing[0, 0]))
    return said


@pytest.mark.parametrize('rate', [10, 24, 60])
def test_a_foreground_that_goes_behind_a_cover_changes_until_it_has_come_out(rate):
    ramp = np.arange(40, 4, -40 / rate).tolist()
    half = len(ramp) // 2
    said = changes([40.0] * rate + ramp + [None] * rate + ramp[::-1] + [40.0] * 3 * rate, rate)
    assert not any(said[:rate])
    assert all(said[rate + half : rate + len(ramp)])
    out = 2 * rate + len(ramp)
    assert all(said[out : out + len(ramp)])
    assert not any(said[out + len(ramp) + rate :])


@pytest.mark.parametrize('rate', [10, 24, 60])
def test_a_foreground_that_trembles_or_grows_slowly_does_not_change(rate):
    noise = np.random.default_rng(3).normal(0, 1.5, 5 * rate)
    assert not any(changes([40.0, *(40 + noise)], rate))
    assert not any(changes((40 + 6 / rate * np.arange(5 * rate)).tolist(), rate))


def walking(k):
    return (40 + 2.5 * max(k - EMPTY, 0), 120.0), 26.0


def followed(count, spoil, at):
    """Tracks of each picture; the tracker is spoilt before one of them."""
    tracker, result = ContourTracker(QUICK), []
    for k in range(count):
        if k == at:
            spoil(tracker)
        place = walking(k) if k >= EMPTY else (None, 0)
        result.append(tracker.update(frame(picture('person', *place, seed=k), k)))
    return result


@pytest.mark.slow
@pytest.mark.parametrize('growth', [0.0, 0.05])
def test_a_contour_that_is_too_large_for_what_is_in_plain_sight_becomes_as_large(growth):
    def spoil(tracker):
        contours = tracker._tracks.filters
        center = contours.nodes.mean(axis=1, keepdims=True)
        contours.nodes[:] = center + 1.6 * (contours.nodes - center)
        contours.motion[:, 2] = growth

    results = followed(70, spoil, 45)
    for k in range(60, 70):
        (row,), (outline,) = results[k].rows, results[k].outlines
        assert row['track_id'] == 1
        truth = boxes(corners_of('person', *walking(k))[None])[0]
        np.testing.assert_allclose(boxes(outline[None])[0], truth, atol=8)
    assert overlap(outline, corners_of('person', *walking(69))) > 0.8


@pytest.mark.slow
def test_a_second_contour_of_one_thing_is_not_seen_and_ends():
    def spoil(tracker):
        tracks = tracker._tracks
        second = tracks.filters.take(np.arange(1))
        second.nodes += 2.0
        record = begin(tracks, second, tracker._spline, tracker._clock.now)
        record['state'], record['hits'] = CONFIRMED, 9
        record['moved'] = record['proven'] = record['single'] = True

    results = followed(90, spoil, 40)
    states = [dict(zip(t.rows['track_id'], t.rows['state'], strict=True)) for t in results]
    assert all(own.get(1) == CONFIRMED for own in states[40:])
    assert COASTING in {own.get(2) for own in states}
    assert not any(2 in own for own in states[40 + round(1.7 * RATE) :])


@pytest.mark.slow
def test_a_piece_of_somebody_is_not_told_whatever_its_speed():
    def spoil(tracker):
        tracks = tracker._tracks
        foot = tracks.filters.take(np.arange(1))
        center = foot.nodes.mean(axis=1, keepdims=True)
        foot.nodes[:] = center + [0.0, 18.0] + 0.25 * (foot.nodes - center)
        foot.motion[:, 1] = 3.0
        record = begin(tracks, foot, tracker._spline, tracker._clock.now)
        record['state'], record['hits'] = CONFIRMED, 9
        record['moved'] = record['proven'] = record['single'] = True

    results = followed(42, spoil, 40)
    assert [t.rows['track_id'].tolist() for t in results[39:]] == [[1]] * 3


@pytest.mark.slow
def test_what_walks_while_the_background_is_learned_leaves_no_ghost_with_the_defaults():
    tracker = ContourTracker(ContourConfig())
    for k in range(100):
        shown = tracker.update(frame(picture('person', *walking(k + EMPTY), seed=k), k)).rows
    assert len(shown) == 1
    assert abs(shown[0]['u'] - walking(99 + EMPTY)[0][0]) < 4
