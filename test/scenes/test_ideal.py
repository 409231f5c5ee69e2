import numpy as np
import pytest

from colortrack_ros.data import DETECTION
from colortrack_ros.scenes import BLACKOUT
from colortrack_ros.scenes import detections_of
from colortrack_ros.scenes import open_scene


@pytest.fixture(scope='module')
def five():
    return open_scene('five?duration=14')


@pytest.fixture(scope='module')
def blackout():
    return open_scene('blackout?duration=10')


def test_a_perfect_detector_sees_each_visible_object_where_it_is(five):
    for k in range(0, len(five), 20):
        truth = five.truth(k)
        truth = truth[truth['visible'] == 1]
        detections = detections_of(five, k)
        assert detections.rows.dtype == DETECTION
        assert detections.stamp == round(k * 1e9 / 24)
        for row in truth:
            apart = np.hypot(detections.rows['u'] - row['u'], detections.rows['v'] - row['v'])
            nearest = detections.rows[np.argmin(apart)]
            assert apart.min() < 0.3
            assert nearest['area'] == pytest.approx(np.pi * row['radius'] ** 2, rel=0.02)
            assert nearest['box_w'] == pytest.approx(2 * row['radius'], abs=1.1)
            assert nearest['box_u'] == pytest.approx(row['u'] - row['radius'], abs=1.1)


@pytest.mark.slow
def test_a_hidden_object_is_not_detected():
    scene = open_scene('occlusion?duration=9')
    seen = hidden = 0
    for k in range(len(scene)):
        visible = scene.truth(k)['visible']
        hidden += np.sum(visible == 0)
        seen += np.sum(visible > 0.02)
        assert np.sum(visible > 0.02) <= len(detections_of(scene, k).rows) <= np.sum(visible > 0)
    assert hidden > 20
    assert seen > 200


def test_largest_area_comes_first(blackout):
    area = detections_of(blackout, 5, clutter=1.5).rows['area']
    assert (np.diff(area) <= 0).all()


def test_the_same_arguments_give_the_same_detections_in_any_order(blackout):
    first = detections_of(blackout, 30, **BLACKOUT)
    detections_of(blackout, 31, **BLACKOUT)
    np.testing.assert_array_equal(first.rows, detections_of(blackout, 30, **BLACKOUT).rows)
    other = detections_of(blackout, 30, **BLACKOUT, seed=1)
    assert len(other.rows) != len(first.rows) or (other.rows['u'] != first.rows['u']).any()


@pytest.mark.slow
def test_share_of_detections_and_clutter_and_noise_are_as_asked(blackout):
    frames = range(0, len(blackout), 2)
    perfect = [detections_of(blackout, k).rows for k in frames]
    count = sum(map(len, perfect))
    missed = sum(len(detections_of(blackout, k, detected=0.85).rows) for k in frames)
    false = sum(len(detections_of(blackout, k, clutter=0.2).rows) for k in frames)
    assert missed / count == pytest.approx(0.85, abs=0.03)
    assert false / count == pytest.approx(1.2, abs=0.03)
    shifts = []
    for k, rows in zip(frames, perfect, strict=True):
        noisy = detections_of(blackout, k, noise=2.0).rows
        assert noisy['cov_uu'] == pytest.approx(4, abs=0.02)
        shifts.append([noisy['u'] - rows['u'], noisy['box_v'] - rows['box_v']])
    shifts = np.concatenate(shifts, axis=1)
    np.testing.assert_allclose(shifts.std(axis=1), 2.0, rtol=0.05)
    np.testing.assert_allclose(shifts.mean(axis=1), 0.0, atol=0.15)
    assert abs(np.corrcoef(shifts)[0, 1]) < 0.05


@pytest.mark.slow
def test_gaps_leave_an_object_out_for_so_many_frames_on_end():
    scene = open_scene('single?width=320&height=180')
    missed = np.array([len(detections_of(scene, k, gap=10).rows) == 0 for k in range(480)])
    for block in missed.reshape(8, 60):
        assert block.sum() == 10
        assert np.ptp(np.flatnonzero(block)) == 9
    assert len({int(np.argmax(block)) for block in missed.reshape(8, 60)}) > 3
