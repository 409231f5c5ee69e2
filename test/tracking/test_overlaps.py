"""Boxes of complete objects overlap where the blobs of a threshold merge."""

import numpy as np
import pytest
from support.silhouettes import points

from colortrack_ros.data import COASTING
from colortrack_ros.data import CONFIRMED
from colortrack_ros.data import Detections
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig
from colortrack_ros.tracking.adaptation import Adaptation
from colortrack_ros.tracking.measurements import accept
from colortrack_ros.tracking.overlaps import Overlaps

RATE = 25


def corners(*boxes):
    """Return the corners, (M, 2, 2), of boxes with center and size (u, v, width, height) [px]."""
    box = np.array(boxes, float)
    return np.stack([box[:, :2] - box[:, 2:] / 2, box[:, :2] + box[:, 2:] / 2], axis=1)


def after(frames, box, color=(0, 0), merged=0):
    """Return whether objects count as resolved after some equal frames."""
    overlaps = Overlaps()
    for _ in range(frames):
        overlaps.look(corners(*box), np.array(color, np.uint32))
        overlaps.count_merged(merged)
    return overlaps.are_resolved


OVER = (100, 100, 40, 90), (110, 105, 44, 80)


def test_boxes_of_one_kind_over_each_other_are_those_of_resolved_objects():
    assert after(20, OVER)


@pytest.mark.parametrize(
    ('box', 'color'),
    [
        (((100, 100, 40, 90), (150, 100, 40, 90)), (0, 0)),
        (((100, 100, 40, 90), (105, 100, 10, 20)), (0, 0)),
        (OVER, (0, 1)),
    ],
    ids=['beside each other', 'a small one on a large one', 'a color on another'],
)
def test_other_boxes_are_not(box, color):
    assert not after(200, box, color)


def test_a_few_are_not_believed_where_many_merge():
    assert not after(200, OVER, merged=5)


def test_boxes_of_a_network_need_not_overlap():
    overlaps, found = Overlaps(), points([(100, 100), (400, 300)], size=(40.3, 90.6)).rows
    found['score'] = 0.8
    overlaps.see(found)
    assert overlaps.are_resolved


def test_blobs_that_follow_boxes_of_a_network_or_outnumber_them_are_blobs_again():
    """As if they were whole ever after, none was merged that touched."""
    boxes, blobs = (points([(100, 100), (400, 300)], size=(s, 90)) for s in (40.3, 40))
    boxes.rows['score'] = blobs.rows['score'] = 0.8
    blobs.rows['cov_uu'] = blobs.rows['cov_vv'] = 0.1
    learned, config = Adaptation(1.0), TrackerConfig()
    for found, resolved in ((boxes, True), (blobs, False)):
        for _ in range(20):
            accept(found.rows, config, learned)
        assert learned.overlaps.are_resolved is resolved
    for _ in range(20):
        accept(np.concatenate([boxes.rows[:1], blobs.rows]), config, learned)
    assert not learned.overlaps.are_resolved


@pytest.mark.parametrize('step', [10, 20])
def test_who_is_covered_is_not_measured_in_the_box_of_whoever_is_in_front(step):
    """A network finds no two that overlap; in front of somebody, who walks by has a larger box."""
    tracker = Tracker(TrackerConfig(image_size=(1920, 1080)))
    for k in range(90):
        far = np.array([[900.0, 500.0], [1200.0, 540.0], [1500.0, 580.0]])
        covered = np.abs(far[:, 0] - (200 + step * k)) <= 150
        near = (300.3, 690.2) if covered.any() else (250.4, 650.6)
        z = np.append(far[~covered], [[200 + step * k, 600 - 20 * covered.any()]], axis=0)
        size = [(46.3, 124.6)] * (len(z) - 1) + [near]
        inside = z[:, 0] < 1900
        found = points(z[inside], round(k * 1e9 / RATE), size=np.array(size)[inside])
        found.rows['score'] = 0.8
        rows = tracker.update(found).rows
        assert np.count_nonzero(rows['state'] == CONFIRMED) <= len(found.rows)


def walkers(noise, count=60):
    """Yield boxes of two rows of three that walk through each other; sizes jitter by a tenth."""
    rng = np.random.default_rng(5)
    for k in range(count):
        u = np.array([100 + 4 * k, 160 + 4 * k, 220 + 4 * k, 500 - 4 * k, 440 - 4 * k, 380 - 4 * k])
        size = np.array([40, 90]) * rng.lognormal(0, 0.1, (6, 2))
        v = np.array([200, 210, 205, 215, 208, 212])
        z = np.stack([u + rng.normal(0, noise, 6), rng.normal(v, noise)], axis=1)
        yield points(z, size=size).rows


def test_a_small_box_beside_a_person_is_one_of_its_own():
    tracker = Tracker(TrackerConfig(image_size=(640, 480)))
    for k, rows in enumerate(walkers(2.0)):
        if k > 30:  # a child walks beside the first
            child = rows[:1].copy()
            child['u'], child['v'] = 95 + 4 * k, 240
            child['box_w'], child['box_h'] = 12, 30
            child['box_u'], child['box_v'] = child['u'] - 6, child['v'] - 15
            rows = np.concatenate([rows, child])
        tracks = tracker.update(Detections(rows, round(k * 1e9 / RATE))).rows
    assert len(tracks[tracks['state'] != COASTING]) == 7


@pytest.mark.parametrize('size', [(10, 20), (14, 30), (70, 40)])
def test_a_person_who_is_missed_is_not_taken_for_a_box_of_another_size(size):
    tracker = Tracker(TrackerConfig(image_size=(640, 480)))
    for k, rows in enumerate(walkers(2.0, count=21)):
        if k == 20:  # the first one is missed, and something else found 38 px away
            rows[:1] = points([(180, 238)], size=size).rows
        tracks = tracker.update(Detections(rows, round(k * 1e9 / RATE))).rows
    assert tracks['track_id'].tolist()[:6] == [1, 2, 3, 4, 5, 6]
    assert np.count_nonzero(tracks['state'] == COASTING) == 1


@pytest.mark.parametrize('seed', range(3))
def test_centers_of_boxes_are_good_whose_sizes_are_not(seed):
    """For moments some boxes show half a person or one and a half, about the same center."""
    rng, tracker = np.random.default_rng(seed), Tracker(TrackerConfig(image_size=(640, 480)))
    off, variance, shown = [], [], np.ones((2, 2))
    for k in range(100):
        truth = np.array([[60.0 + 5 * k, 120.0], [580.0 - 5 * k, 360.0]])
        shown = np.where(rng.random((2, 2)) < 1 / 6, rng.choice([1, 0.55, 1.8], (2, 2)), shown)
        z = truth + rng.normal(0, 2, (2, 2))
        size = np.array([[60], [130]]) * rng.lognormal(0, 0.1, (2, 2)) * shown
        tracks = tracker.update(points(z, round(k * 1e9 / RATE), size=size.T)).rows
        if k > 40:
            off.append(np.stack([tracks['u'], tracks['v']], axis=1) - truth)
            variance.append(tracks['covariance'][:, [0, 1], [0, 1]])
    assert np.sqrt(np.mean(np.square(off))) < 2.5
    assert np.sqrt(np.mean(variance)) < 2.5


def test_a_box_a_fifth_larger_that_is_off_is_still_that_of_the_person():
    """Boxes of networks hardly change for a long time, and then by a step."""
    rng, tracker = np.random.default_rng(5), Tracker(TrackerConfig(image_size=(640, 480)))
    for k in range(41):
        u = [100 + 4 * k, 120 + 4 * k, 300 + 2 * k, 325 + 2 * k, 500, 520]
        z = np.stack([u, [200, 206, 300, 306, 100, 106]], axis=1) + rng.normal(0, 1, (6, 2))
        size = np.array([40, 90]) * rng.lognormal(0, 0.01, (6, 2))
        if k == 40:
            size[0] *= 1.22
            z[0, 1] += 30
        tracks = tracker.update(Detections(points(z, size=size).rows, round(k * 1e9 / RATE))).rows
    assert len(tracks) == 6
    assert not (tracks['state'] == COASTING).any()


def boxes_of(*found):
    """Detections of a network: (u, v, score) each, of 40x90 px and a little."""
    detections = points([(u, v) for u, v, _ in found], size=(40.3, 90.6))
    detections.rows['score'] = [score for *_, score in found]
    return detections


def ids_of(frames, **options):
    """IDs that are published in each of some frames at RATE."""
    tracker = Tracker(TrackerConfig(image_size=(640, 480), **options))
    published = []
    for k, frame in enumerate(frames):
        tracks = tracker.update(Detections(frame.rows, (k + 1) * 10**9 // RATE)).rows
        published.append(tracks['track_id'][tracks['state'] == CONFIRMED].tolist())
    return published


def test_weak_boxes_of_a_network_start_no_track_but_go_on_with_one():
    frames = [
        boxes_of((100 + k, 200, 0.9 if k < 20 else 0.2), (500, 100 + k, 0.2)) for k in range(60)
    ]
    assert ids_of(frames)[-1] == [1]
    assert ids_of(frames, start_score=0.0)[-1] == [1, 2]


def test_a_weak_box_is_for_whom_no_sure_one_is_for_however_well_it_fits():
    """Beside somebody the network finds him once more, nearer to where he is expected."""
    rng, tracker = np.random.default_rng(3), Tracker(TrackerConfig(image_size=(640, 480)))
    for k in range(90):
        u, aside = 100 + 2 * k, rng.normal(0, 4)
        lone = k > 20 and k % 9 == 0  # and then the only one that there is
        one = (u, 200, 0.2) if lone else (u + aside, 200, 0.9)
        frame = boxes_of(one, *[(u, 201, 0.2)] * (k > 20 and not lone))
        frame.rows['box_w'][1:] += 0.5
        tracks = tracker.update(Detections(frame.rows, (k + 1) * 10**9 // RATE)).rows
        tracks = tracks[tracks['state'] == CONFIRMED]
        if k > 5:
            assert tracks['track_id'].tolist() == [1]
            assert tracks['box_w'] == frame.rows['box_w'][0]


@pytest.mark.parametrize('score', [0.2, 0.35, 7.0])
def test_a_network_that_is_never_surer_starts_tracks(score):
    frames = [boxes_of((100 + k, 200, score), (500, 100, 0.15)) for k in range(10)]
    assert 1 in ids_of(frames)[-1]


@pytest.mark.slow
def test_a_network_that_was_sure_once_starts_tracks_again():
    """A single box of 0.99 kept all of 0.35 and less from ever being seen."""
    frames = [
        boxes_of((100 + k, 200, 0.35 if k else 0.99), (500, 100 + k, 0.35)) for k in range(160)
    ]
    found = ids_of(frames)
    assert found[100] == [1]
    assert found[-1] == [1, 2]


def test_blobs_of_any_score_start_tracks():
    frames = [points([(100.37 + k, 200.21)], size=(40, 90)) for k in range(10)]
    for frame in frames:
        frame.rows['score'] = 0.1
    frames[0].rows['score'] = 1.0
    assert ids_of(frames)[-1] == [1]
