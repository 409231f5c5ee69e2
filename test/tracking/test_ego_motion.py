"""A moving camera carries all tracks along."""

import numpy as np
import pytest
from support.silhouettes import FRAME
from support.silhouettes import points

from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig
from colortrack_ros.tracking.ego_motion import EgoMotion
from colortrack_ros.tracking.ego_motion import find_ego_motion


def crowd(rng, count):
    return rng.uniform(0, (640, 480), (count, 2))


def turned(x, degrees, zoom, shift):
    a = np.radians(degrees)
    A = zoom * np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])
    return (x - (320, 240)) @ A.T + (320, 240) + shift


@pytest.mark.parametrize('degrees', [0, 0.3, 20])
@pytest.mark.parametrize('zoom', [1, 1.02])
def test_a_motion_is_made_of_its_parts_in_time(degrees, zoom):
    origin = turned(np.zeros(2), degrees, zoom, (7, -3))
    A = np.stack([turned(e, degrees, zoom, (7, -3)) - origin for e in np.eye(2)], axis=1)
    whole = EgoMotion(A, origin)
    x = crowd(np.random.default_rng(0), 5)
    for share in (1 / 3, 0.5, 2.0):
        part = whole.during(share)
        rest = whole.during(1 - share)
        np.testing.assert_allclose(rest.of(part.of(x)), whole.of(x), atol=1e-6)
        np.testing.assert_allclose(part.way(part.of(x)), part.of(x) - x, atol=1e-9)


@pytest.mark.parametrize('seed', range(5))
@pytest.mark.parametrize('shift', [(0, 0), (3, 0), (-20, 8), (90, -90)])
def test_the_shift_that_most_share_is_found_though_some_go_their_own_way(seed, shift):
    rng = np.random.default_rng(seed)
    x = crowd(rng, 20)
    z = turned(x, 0, 1, shift) + rng.normal(0, 1, x.shape)
    z[:4] = crowd(rng, 4)
    motion = find_ego_motion(x, np.full_like(x, 2.0), rng.permutation(z[3:]))
    found = np.zeros(2) if motion is None else motion.shift + motion.A @ x.mean(0) - x.mean(0)
    np.testing.assert_allclose(found, shift, atol=2.0)


@pytest.mark.parametrize(('degrees', 'zoom'), [(1.0, 1.0), (0.0, 1.02), (-0.7, 0.99)])
def test_turn_and_zoom_are_found(degrees, zoom):
    rng = np.random.default_rng(0)
    x = crowd(rng, 20)
    z = turned(x, degrees, zoom, (5, 0)) + rng.normal(0, 0.3, x.shape)
    motion = find_ego_motion(x, np.full_like(x, 40.0), z)
    np.testing.assert_allclose(x @ motion.A.T + motion.shift, z, atol=1.5)


@pytest.mark.parametrize('seed', range(20))
def test_a_camera_that_stands_has_no_motion(seed):
    rng = np.random.default_rng(seed)
    x = crowd(rng, 10)
    z = x + rng.normal(0, 1, x.shape)
    assert find_ego_motion(x, np.full_like(x, 2.0), z) is None


@pytest.mark.parametrize('count', [0, 1, 2])
def test_of_one_or_two_nobody_can_tell_whose_motion_it_is(count):
    x = np.full((count, 2), 50.0) * np.arange(1, count + 1)[:, None]
    assert find_ego_motion(x, np.full_like(x, 2.0), x + 20) is None


@pytest.mark.parametrize('count', [5, 6, 24])
@pytest.mark.parametrize('spread', [0, 3, 40])
def test_detections_on_a_single_point_are_no_zoom_to_nothing(count, spread):
    rng = np.random.default_rng(0)
    tracker = Tracker(TrackerConfig(ego_motion='detections'))
    place = 200 + spread * rng.normal(size=(count, 2))
    for k in range(40):
        seen = place + rng.normal(0, 0.5, (count, 2))
        seen[:] = place.mean(axis=0) if k in (20, 30) else seen
        rows = tracker.update(points(seen, k * FRAME)).rows
        assert np.isfinite(rows['u']).all()
    np.testing.assert_allclose(rows['u'].mean(), place[:, 0].mean(), atol=10)


def ids(moves, ego_motion):
    """Return the last rows of six objects at rest in a jumping picture, one hidden meanwhile."""
    tracker = Tracker(TrackerConfig(ego_motion=ego_motion))
    place = np.array([(40 * k + 20, 60 + 17 * (k % 3)) for k in range(6)], float)
    for k, move in enumerate(moves):
        seen = place[:-1] if 20 <= k < 40 else place
        rows = tracker.update(points([tuple(p) for p in seen + move], k * FRAME)).rows
    return rows


@pytest.mark.slow
@pytest.mark.parametrize('ego_motion', ['auto', 'detections'])
def test_tracks_keep_their_ids_and_hidden_ones_their_place_when_the_picture_jumps(ego_motion):
    """It jumps in every frame, by up to the distance between neighbors."""
    moves = np.random.default_rng(0).uniform(-20, 20, (60, 2))
    rows = ids(moves, ego_motion)
    assert rows['track_id'].tolist() == [1, 2, 3, 4, 5, 6]
    assert rows['hits'].tolist() == [60] * 5 + [40]
    assert np.abs(rows['u'] - (40 * np.arange(6) + 20 + moves[-1][0])).max() < 3
    assert ids(moves, 'none')['hits'].tolist() != [60] * 5 + [40]


def filmed(motions, ego_motion, count=10, seed=0):
    """Yield, by frame, the tracks of drifting objects as seen by a camera with these motions.

    :param motions: degrees, zoom and shift since the first frame.
    :return: rows of tracks, and positions and velocities in the picture, (count, 2).
    """
    rng, tracker = np.random.default_rng(seed), Tracker(TrackerConfig(ego_motion=ego_motion))
    at = rng.permutation([(100 + 120 * (k % 4), 60 + 120 * (k // 4)) for k in range(12)])[:count]
    v, last = rng.uniform(-20, 20, (count, 2)), None
    for k, motion in enumerate(motions):
        x = turned(at + v * k * FRAME / 1e9, *motion)
        z = x + rng.normal(0, 0.5, x.shape)
        rows = tracker.update(points(z, k * FRAME, 0.25)).rows
        yield rows, x, np.zeros_like(x) if last is None else (x - last) / (FRAME / 1e9)
        last = x


def rolling(frames=90):
    phase = np.sin(2 * np.pi * np.arange(frames) / 24)
    return [(20 * p, 1 + 0.2 * p, (0, 0)) for p in phase]


def panning(frames=90):
    """Return a pan of 20 px a frame that starts and stops twice a second."""
    steps = 20.0 * (np.arange(frames) // 12 % 2) * (1 - 2 * (np.arange(frames) // 24 % 2))
    return [(0, 1, (shift, 0)) for shift in np.cumsum(steps)]


@pytest.mark.parametrize('ego_motion', ['auto', 'detections'])
@pytest.mark.parametrize('motions', [rolling(), panning()])
def test_a_camera_that_pans_turns_and_zooms_costs_no_id(motions, ego_motion):
    names = set()
    for rows, x, _ in filmed(motions, ego_motion):
        names |= set(rows['track_id'].tolist())
        if len(rows) == len(x):
            at = np.stack([rows['u'], rows['v']], axis=1)
            assert np.abs(at[:, None] - x).max(axis=2).min(axis=1).max() < 6
    assert names == set(range(1, 11))


@pytest.mark.parametrize('ego_motion', ['auto', 'detections'])
@pytest.mark.parametrize('apart', [1, 1000, 1_000_000])
def test_pictures_of_a_zoom_that_are_stamped_right_after_each_other_cost_no_id(apart, ego_motion):
    """Some drivers stamp a picture just after the last one when their clock goes back."""
    rng, tracker, stamp = np.random.default_rng(0), Tracker(TrackerConfig(ego_motion=ego_motion)), 0
    crowd_of_20 = crowd(rng, 20)
    for k in range(60):
        stamp += apart if k % 20 == 15 else FRAME
        z = turned(crowd_of_20, 0, 1.01**k, (0, 0)) + rng.normal(0, 0.3, (20, 2))
        rows = tracker.update(points(z, stamp, 0.09)).rows
    assert rows['track_id'].tolist() == list(range(1, 21))


def shaking(size, frames=150):
    """Return shifts of a camera that a hand moves about for two seconds, drawn anew each frame."""
    shifts = np.random.default_rng(1).uniform(-0.5, 0.5, (frames, 2)) * size
    shifts[60:] = 0
    return [(0, 1, tuple(shift)) for shift in shifts]


@pytest.mark.slow
@pytest.mark.parametrize('ego_motion', ['auto', 'detections'])
@pytest.mark.parametrize(('size', 'count'), [(20.0, 10), (50.0, 10), (20.0, 6), (50.0, 6)])
def test_a_camera_that_shakes_costs_no_id_though_objects_are_missed(size, count, ego_motion):
    """Five or six objects are few: one that is missed leaves too few to find the motion by."""
    rng, tracker = np.random.default_rng(0), Tracker(TrackerConfig(ego_motion=ego_motion))
    at = np.array([(100 + 120 * (k % 4), 60 + 120 * (k // 4)) for k in range(count)], float)
    for k, motion in enumerate(shaking(size)):
        z = turned(at, *motion) + rng.normal(0, 0.5, at.shape)
        rows = tracker.update(points(z[rng.random(count) < 0.97], k * FRAME, 0.25)).rows
    assert rows['track_id'].tolist() == list(range(1, count + 1))


@pytest.mark.slow
def test_ellipses_hold_what_a_shaking_camera_shows():
    rng, tracker, inside = np.random.default_rng(7), Tracker(), []
    home = crowd(rng, 8)
    for k in range(60):
        true = home + rng.normal(0, 20, 2)
        detections = points(true + rng.normal(0, 1.5, true.shape), round(k * FRAME), 0.0)
        rows = tracker.update(detections).rows
        if k >= 20:
            place = np.stack([rows['u'], rows['v']], axis=1)
            away = place[:, None] - true
            error = away[np.arange(len(rows)), np.hypot(*away.T).argmin(axis=0)]
            P = rows['covariance'][:, :2, :2]
            inside.extend(np.einsum('ni,nij,nj->n', error, np.linalg.inv(P), error) < 5.99)
    assert 0.9 < np.mean(inside) < 0.99


@pytest.mark.parametrize('ego_motion', ['auto', 'detections'])
def test_a_camera_that_is_thrown_back_as_far_as_it_came_costs_no_id(ego_motion):
    """Had it gone on, it would be farther away than motions are searched for."""
    shifts = [(0, 0)] * 15 + [(-20, 70), (10, -40), (10, 0), (0, 0), (0, 0)]
    for rows, _, _ in filmed([(0, 1, shift) for shift in shifts], ego_motion):
        assert rows['track_id'].tolist() == list(range(1, 11))


def test_by_default_a_flock_that_turns_bit_by_bit_moves_no_camera():
    """Objects share slight motions by chance; taken for the camera's they would widen ellipses."""
    rows = {}
    for ego_motion in ('auto', 'none'):
        tracker, v, x = Tracker(TrackerConfig(ego_motion=ego_motion)), np.full((8, 2), 30.0), 0
        at, draw = (
            np.array([(100 + 90 * k, 200) for k in range(8)], float),
            np.random.default_rng(3),
        )
        for k in range(120):
            v = v + draw.normal(0, 3, (1, 2)) + draw.normal(0, 3, v.shape)
            x = x + v * FRAME / 1e9
            z = at + x + draw.normal(0, 0.5, at.shape)
            rows[ego_motion] = tracker.update(points(z, k * FRAME, 0.25)).rows
    assert rows['auto'].tobytes() == rows['none'].tobytes()


@pytest.mark.parametrize('seed', [4, 40])
def test_by_default_noise_of_more_than_is_stated_moves_no_camera(seed):
    """A turn, zoom and shift of it take six objects to within what was stated, now and then."""
    rows = {}
    for ego_motion in ('auto', 'none'):
        tracker, draw = Tracker(TrackerConfig(ego_motion=ego_motion)), np.random.default_rng(seed)
        at, v = crowd(draw, 6), draw.uniform(-100, 100, (6, 2))
        for k in range(40):
            z = at + v * k / 60 + draw.normal(0, 5, at.shape)
            rows[ego_motion] = tracker.update(points(z, k * FRAME // 2, 1.0)).rows
    assert rows['auto'].tobytes() == rows['none'].tobytes()


def test_published_velocities_are_those_in_the_picture():
    """They include the camera's motion."""
    inside = []
    for k, (rows, x, v) in enumerate(filmed(panning(), 'detections')):
        if k >= 24:
            at = np.stack([rows['u'], rows['v']], axis=1)
            mine = np.abs(at[:, None] - x).max(axis=2).argmin(axis=1)
            e = np.stack([rows['du'], rows['dv']], axis=1) - v[mine]
            P = rows['covariance'][:, 2:, 2:]
            inside += list((e * np.linalg.solve(P, e[..., None])[..., 0]).sum(axis=1) < 5.991)
    assert np.mean(inside) > 0.85


def test_what_the_camera_did_is_the_tracks_own_when_it_is_asked_for_no_more():
    """The option is switched off in the middle of a pan."""
    tracker = Tracker(TrackerConfig(ego_motion='detections'))
    place = np.array([(60 * k + 20, 60 + 17 * (k % 3)) for k in range(6)], float)
    for k in range(40):
        if k == 12:
            tracker.configure(TrackerConfig())
        shift = np.array([max(k - 10, 0) * 8.0, 0.0])
        rows = tracker.update(points(place + shift, k * FRAME)).rows
    assert rows['track_id'].tolist() == [1, 2, 3, 4, 5, 6]
    assert rows['du'] == pytest.approx(np.full(6, 8.0 * 24), rel=0.1)
