from hypothesis import given
from hypothesis import strategies as st
import numpy as np
import pytest

from colortrack_ros.world import Pose
from colortrack_ros.world import PoseBuffer
from colortrack_ros.world import TransformError
from colortrack_ros.world.poses import OPTICAL
from colortrack_ros.world.poses import rotation_of

S = 1_000_000_000
angles = st.tuples(*[st.floats(-3.2, 3.2)] * 3)


def pose(x=0.0, yaw=0.0):
    return Pose.of_rpy((x, 0, 0), (0, 0, yaw))


def test_positive_pitch_looks_down_and_positive_yaw_to_the_left():
    forward = np.array([[1.0, 0, 0]])
    assert Pose.of_rpy((0, 0, 0), (0, 0.3, 0)).apply(forward)[0, 2] < 0
    assert Pose.of_rpy((0, 0, 0), (0, 0, 0.3)).apply(forward)[0, 1] > 0


def test_the_optical_axis_is_forward_of_the_camera_body_and_v_points_down():
    body = OPTICAL.apply(np.eye(3))
    assert body.tolist() == [[0, -1, 0], [0, 0, -1], [1, 0, 0]]


@given(angles)
def test_a_quaternion_gives_its_rotation_back(rpy):
    there = Pose.of_rpy((1, 2, 3), rpy)
    q = there.quaternion
    assert abs(q @ q - 1) < 1e-12
    assert q[3] >= 0
    np.testing.assert_allclose(rotation_of(q), there.R, atol=1e-9)
    np.testing.assert_allclose((there @ there.inverse()).R, np.eye(3), atol=1e-12)
    np.testing.assert_allclose((there @ there.inverse()).t, 0, atol=1e-12)


def test_a_frame_in_a_frame_is_where_its_points_are():
    a, b = Pose.of_rpy((1, 2, 0), (0.1, -0.2, 2)), Pose.of_rpy((0, 0.1, 1), (0, 0.5, -1))
    point = np.array([[0.3, -0.7, 2.0]])
    np.testing.assert_allclose((a @ b).apply(point), a.apply(b.apply(point)))


@pytest.mark.parametrize('xyzw', [(0, 0, 0, 0), (0, 0, 0, 2), (0, 0, 0, np.nan), [1e300] * 4])
def test_what_is_no_rotation_is_refused(xyzw):
    with pytest.raises(TransformError, match='length 1'):
        Pose.of_quaternion((0, 0, 0), xyzw)


@pytest.mark.parametrize('length', [0.9951, 1.002, 1.0049])
def test_a_quaternion_that_tf2_takes_is_taken_and_normalized(length):
    """Of odometry that rounds to two or three digits, or that has added up turns."""
    pose = Pose.of_quaternion((0, 0, 0), length * np.array([0, 0, np.sin(0.3), np.cos(0.3)]))
    np.testing.assert_allclose(pose.R, Pose.of_rpy((0, 0, 0), (0, 0, 0.6)).R, atol=1e-12)


@pytest.mark.parametrize('xyzw', [(0, 0, 0, 1.0051), (0, 0, 0, 0.9949)])
def test_a_quaternion_that_tf2_refuses_is_refused(xyzw):
    with pytest.raises(TransformError, match='length 1'):
        Pose.of_quaternion((0, 0, 0), xyzw)


@pytest.mark.parametrize('x', [1e300, -1e9, float('inf'), float('nan')])
def test_what_is_not_on_earth_is_refused(x):
    with pytest.raises(TransformError, match=r'below 1e\+08 m'):
        Pose.of_quaternion((0, x, 0), (0, 0, 0, 1))
    Pose.of_quaternion((5e5, 5.9e6, 400.0), (0, 0, 0, 1))  # UTM


def test_between_two_poses_it_moves_and_turns_evenly_the_short_way():
    start, end = pose(0, 3.0), pose(2, -3.0)  # 0.283 rad through pi
    quarter = start.between(end, 0.25)
    assert quarter.t[0] == pytest.approx(0.5)
    yaw = np.arctan2(quarter.R[1, 0], quarter.R[0, 0])
    assert yaw == pytest.approx(3.0 + 0.25 * (2 * np.pi - 6))


def buffer(*stamps):
    buffer = PoseBuffer('odom', 'base_link')
    for stamp in stamps:
        buffer.add(round(stamp * S), pose(stamp))
    return buffer


def test_a_pose_between_two_stamps_is_interpolated_whatever_their_order_of_arrival():
    assert buffer(1.0, 1.4, 1.2).at(round(1.3 * S)).t[0] == pytest.approx(1.3)
    assert buffer(1.0).at(S).t[0] == 1.0


def swinging(*stamps):
    """Speeds up and turns ever faster, 2 m/s^2 and 2 rad/s^2."""
    buffer = PoseBuffer('odom', 'base_link')
    for t in stamps:
        buffer.add(round(t * S), pose(t * t, t * t))
    return buffer


def test_between_poses_that_are_far_apart_the_way_bends_as_it_did_before():
    """Odometry at 5 Hz: the chord is off by 1 cm and 0.6 degrees."""
    for at in (0.25, 0.3, 0.37):
        found = swinging(0, 0.2, 0.4).at(round(at * S))
        assert found.t[0] == pytest.approx(at * at, abs=1e-9)
        assert np.arctan2(found.R[1, 0], found.R[0, 0]) == pytest.approx(at * at, abs=1e-6)


def test_between_the_first_poses_near_ones_and_jumps_the_way_is_straight():
    assert swinging(0.2, 0.4).at(round(0.3 * S)).t[0] == pytest.approx(0.1)
    assert swinging(0.2, 0.24, 0.28).at(round(0.26 * S)).t[0] == pytest.approx(0.068)
    jumps = buffer(0.2, 0.4)
    jumps.add(round(0.6 * S), pose(5.4))
    assert jumps.at(round(0.5 * S)).t[0] == pytest.approx(2.9)


def test_beyond_the_poses_it_refuses_with_the_words_of_tf2_and_says_whether_waiting_helps():
    one = buffer(1.0, 2.0)
    with pytest.raises(TransformError, match=r'into the future.*2\.500000.*2\.000000') as error:
        one.at(round(2.5 * S))
    assert error.value.later
    with pytest.raises(TransformError, match=r'into the past.*0\.500000.*1\.000000') as error:
        one.at(round(0.5 * S))
    assert not error.value.later
    assert '[base_link] to frame [odom]' in str(error.value)
    with pytest.raises(TransformError, match='has come yet') as error:
        buffer().at(S)
    assert error.value.later


def test_poses_are_kept_for_ten_seconds_and_older_ones_refused():
    one = buffer(*np.arange(0.0, 25.0, 0.5))
    assert len(one) == 21
    assert not one.add(14 * S, pose())
    with pytest.raises(TransformError, match='into the past'):
        one.at(14 * S)


def test_a_pose_of_a_run_that_starts_again_is_not_mixed_with_those_of_the_last():
    one = buffer(1.0, 2.0)
    assert one.add(round(1.6 * S), pose(1.6))  # late
    assert not one.add(round(1.4 * S), pose(0.0))
    assert one.at(round(1.5 * S)).t[0] == pytest.approx(1.5)


def test_a_second_pose_of_a_stamp_takes_the_place_of_the_first():
    one = buffer(1.0, 2.0)
    one.add(2 * S, pose(7.0))
    assert len(one) == 2
    assert one.at(2 * S).t[0] == 7.0


def test_a_cleared_buffer_knows_nothing():
    one = buffer(1.0, 2.0)
    one.clear()
    assert len(one) == 0
    with pytest.raises(TransformError, match='has come yet'):
        one.latest()
