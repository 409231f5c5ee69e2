import numpy as np
import pytest

from colortrack_ros.scenes import detections_of
from colortrack_ros.scenes import open_scene


def paths(scene):
    """(K, N) truth of a scene, NaN where an object is not in it."""
    count = max(max(scene.truth(k)['id'], default=0) for k in range(len(scene)))
    table = np.zeros((len(scene), count), scene.truth(0).dtype)
    table['u'] = table['visible'] = np.nan
    for k in range(len(scene)):
        rows = scene.truth(k)
        table[k, rows['id'] - 1] = rows
    return table


def distance(path, i, j):
    return np.hypot(path['u'][:, i] - path['u'][:, j], path['v'][:, i] - path['v'][:, j])


def speed(path):
    return np.hypot(np.diff(path['u'], axis=0), np.diff(path['v'], axis=0))


def runs(flags):
    """Lengths of the runs of True that end within the flags."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(int)))
    return np.diff(edges)[::2]


def test_the_pairs_of_collision_touch_for_ten_frames_and_nothing_else_does():
    path = paths(open_scene('collision'))
    reach = 2 * path['radius'].max()
    for i in range(8):
        for j in range(i):
            near = runs(distance(path, i, j) < reach)
            if i == j + 1 and i % 2:
                assert len(near) == 1
                assert near[0] in (10, 11)
            else:
                assert len(near) == 0


def test_touching_objects_of_collision_are_one_blob_around_both():
    scene = open_scene('collision')
    path = paths(scene)
    for i, j in ((0, 1), (2, 3), (4, 5), (6, 7)):
        k = int(np.nanargmin(distance(path, i, j)))
        pair = scene.truth(k)
        pair = pair[np.isin(pair['id'], (i + 1, j + 1))]
        blobs = detections_of(scene, k).rows
        mid = pair['u'].mean(), pair['v'].mean()
        blob = blobs[np.argmin(np.hypot(blobs['u'] - mid[0], blobs['v'] - mid[1]))]
        assert (blob['u'], blob['v']) == pytest.approx(mid, abs=1)
        shown = np.sum(np.pi * pair['radius'] ** 2 * pair['visible'])
        assert blob['area'] == pytest.approx(shown, rel=0.01)
        assert blob['box_w'] == pytest.approx(np.ptp(pair['u']) + 2 * pair['radius'][0], abs=2)
        assert blob['box_h'] == pytest.approx(np.ptp(pair['v']) + 2 * pair['radius'][0], abs=2)


@pytest.mark.slow
def test_swarm_has_fifty_objects_that_never_leave():
    path = paths(open_scene('swarm'))
    assert path.shape == (500, 50)
    radius = path['radius'].max()
    assert (path['u'] > radius).all()
    assert (path['u'] < 1279 - radius).all()
    assert (path['v'] > radius).all()
    assert (path['v'] < 719 - radius).all()
    assert 1 < np.median(speed(path)) < 5
    assert np.quantile(speed(path), 0.98) < 6
    meetings = sum(
        len(runs(distance(path, i, j) < 2 * radius)) for i in range(50) for j in range(i)
    )
    assert meetings > 50


@pytest.mark.slow
def test_blackout_moves_four_to_twelve_pixels_a_frame():
    pace = speed(paths(open_scene('blackout')))
    assert pace.shape == (499, 20)
    assert np.quantile(pace, 0.1) > 4
    assert np.quantile(pace, 0.9) < 12


@pytest.mark.slow
def test_juggled_balls_fall_freely_and_are_hidden_in_the_hands():
    path = paths(open_scene('juggle'))
    assert path.shape == (500, 5)
    assert not np.isnan(path['u'][10:]).any()
    gravity = 8 * 0.64 * 720 / 24**2
    acceleration = np.diff(path['v'], n=2, axis=0)
    flying = path['visible'][1:-1] == 1
    assert np.mean(np.isclose(acceleration[flying], gravity)) > 0.8
    hidden = np.concatenate([runs(path['visible'][10:, i] == 0)[1:-1] for i in range(5)])
    assert 7 <= hidden.min() <= hidden.max() <= 12
    assert len(hidden) > 5 * 10
    assert 25 < np.nanmedian(speed(path)) < 45


def test_objects_of_turns_come_out_where_straight_motion_does_not_lead():
    path = paths(open_scene('turns'))
    misses = []
    for i in range(5):
        hidden = path['visible'][:, i] == 0
        starts = np.flatnonzero(hidden[1:] & ~hidden[:-1])
        for k, length in zip(starts, runs(hidden), strict=True):
            assert 9 <= length <= 20
            u, v = path['u'][:, i], path['v'][:, i]
            ahead = length + 1
            straight = u[k] + ahead * (u[k] - u[k - 1]), v[k] + ahead * (v[k] - v[k - 1])
            misses.append(np.hypot(straight[0] - u[k + ahead], straight[1] - v[k + ahead]))
    assert len(misses) == 6
    assert min(misses) > 80
    assert (path['visible'][:, 5][~np.isnan(path['u'][:, 5])] > 0).all()


@pytest.mark.slow
def test_objects_of_flicker_change_brightness_and_break_up():
    scene = open_scene('flicker?noise=0')
    broken, red = 0, []
    for k in range(len(scene)):
        truth = scene.truth(k)
        shown = truth[truth['visible'] > 0]
        broken += len(detections_of(scene, k).rows) - len(shown)
        whole = truth[(truth['id'] == 1) & (truth['visible'] == 1)]
        if len(whole):
            red.append(scene.render(k)[int(whole['v'][0]), int(whole['u'][0]), 2])
    assert broken / (5 * 3) == pytest.approx(9, abs=1.5)
    assert max(red) > 1.6 * min(red)


@pytest.mark.slow
def test_of_the_objects_of_vanish_some_end_inside_the_picture_and_others_come_back():
    path = paths(open_scene('vanish'))
    hidden = [runs(path['visible'][:, i] == 0) for i in range(11)]
    away = [max(one, default=0) / 24 for one in hidden]
    assert sum(0.3 < one < 0.5 for one in away) == 3
    assert sum(2.9 < one < 4.0 for one in away) == 2
    last = [np.flatnonzero(path['visible'][:, i] > 0)[-1] for i in range(11)]
    inside = [30 < path['u'][k, i] < 1250 and k < 490 for i, k in enumerate(last)]
    assert sum(inside) == 6


@pytest.mark.parametrize('rate', [24, 25, 30])
def test_a_lamp_that_comes_on_is_no_smear_over_millions_of_pixels(rate):
    scene = open_scene(f'vanish?width=160&height=90&rate={rate}')
    for k in range(int(11.9 * rate), int(12.1 * rate) + 1):
        assert scene.render(k).shape == (90, 160, 3)
