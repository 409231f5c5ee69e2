"""An object that is pushed after a long rest keeps its ID, and clutter attracts no track."""

import numpy as np
import pytest

from colortrack_ros.data import DETECTION
from colortrack_ros.data import Detections
from colortrack_ros.data import TENTATIVE
from colortrack_ros.ellipses import ELLIPSE_95
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig

SIZE = (640, 360)
AT_REST = np.array([[80.0, 200.0], [420.0, 80.0], [560.0, 195.0]])


def tracks_of(frames, rate, noise=1.0, seed=0, scale=1):
    """Return the rows of each frame of centers, (N, 2), of boxes 84x130 with some noise.

    :param scale: enlarges the picture and all in it.
    """
    rng, size = np.random.default_rng(seed), tuple(scale * side for side in SIZE)
    tracker, found = Tracker(TrackerConfig(image_size=size)), []
    for k, centers in enumerate(frames):
        rows = np.zeros(len(centers), DETECTION)
        rows['u'], rows['v'] = (centers + rng.normal(0, noise, centers.shape)).T
        rows['box_w'], rows['box_h'], rows['area'] = 84, 130, 7500
        rows['box_u'], rows['box_v'] = rows['u'] - 42, rows['v'] - 65
        rows['cov_uu'] = rows['cov_vv'] = (scale * noise) ** 2
        rows['area'] *= scale**2
        for name in ('u', 'v', 'box_u', 'box_v', 'box_w', 'box_h'):
            rows[name] *= scale
        live = tracker.update(Detections(rows, round(k / rate * 1e9))).rows
        live['u'], live['v'] = live['u'] / scale, live['v'] / scale
        found.append(live[live['state'] != TENTATIVE])
    return found


@pytest.mark.slow
@pytest.mark.parametrize('scale', [1, 2, 6])
@pytest.mark.parametrize('beside', [(420.0, 80.0), (200.0, 120.0)], ids=['alone', 'past another'])
@pytest.mark.parametrize(('rate', 'speed'), [(30, 900), (15, 900), (15, 600), (10, 600)])
def test_what_is_pushed_keeps_its_id(rate, speed, beside, scale):
    still = np.array([AT_REST[0], beside, AT_REST[2]])
    way = speed / rate * np.arange(round(0.1 * rate) + 3)
    pushed = np.array([[[u, 0.0], [0.0, 0.0], [0.0, 0.0]] for u in way])
    frames = [still] * 3 * rate + list(still + pushed)
    found = tracks_of(frames, rate, scale=scale)
    assert {tuple(rows['track_id']) for rows in found[-3:]} == {(1, 2, 3)}
    for rows, centers in zip(found[-3:], frames[-3:], strict=True):
        assert np.hypot(rows['u'] - centers[:, 0], rows['v'] - centers[:, 1]).max() < 8


@pytest.mark.parametrize('seed', range(2))
@pytest.mark.parametrize('leap', [(42.0, 0.0), (0.0, -65.0), (-30.0, 40.0)])
def test_what_leaps_by_half_its_size_just_before_it_is_hidden_is_expected_there(leap, seed):
    """As a figure that jumps up, or a hand that opens: seen once more, then hidden for 1/3 s."""
    there = AT_REST + np.array([(0.0, 0.0), leap, (0.0, 0.0)])
    found = tracks_of([AT_REST] * 90 + [there] + [there[::2]] * 10 + [there] * 5, 30, seed=seed)
    assert [sorted(rows['track_id']) for rows in found[-5:]] == [[1, 2, 3]] * 5
    for rows in found[91:101]:
        row = rows[rows['track_id'] == 2][0]
        e = np.array([row['u'], row['v']]) - there[1]
        assert e @ np.linalg.solve(row['covariance'][:2, :2], e) < ELLIPSE_95


@pytest.mark.slow
@pytest.mark.parametrize('seed', range(3))
def test_false_detections_draw_away_nobody_who_is_missed(seed):
    """As many false detections as true ones, and a fifth of the true ones missed."""
    rng = np.random.default_rng(seed)
    frames = []
    for _ in range(300):
        seen = AT_REST[rng.random(3) < 0.8]
        frames.append(np.concatenate([seen, rng.uniform((0, 0), SIZE, (rng.poisson(3), 2))]))
    found = tracks_of(frames, 30, seed=seed)
    off = 0
    for rows in found[60:]:
        away = np.hypot(*(np.stack([rows['u'], rows['v']], 1)[:, None] - AT_REST).T)
        off += int((away.min(axis=1) > 10).sum())
    assert off <= 0.01 * 3 * len(found[60:])
