"""replay knows from the odometry of a bag how the camera turned."""

import numpy as np
import pytest
from support.ball_before_camera import info
from support.ball_before_camera import odometry
from support.ball_before_camera import picture
from support.ball_before_camera import PLACE
from support.ball_before_camera import START
from support.recorded import of_topic
from support.recorded import write_bag

from colortrack_ros.bags import BagWriter
from colortrack_ros.messages import detections_of_cloud
from colortrack_ros.messages import tracks_of_cloud
from colortrack_ros.node_kit.camera_pose import CameraPoseConfig
from colortrack_ros.replay.main import main
from colortrack_ros.replay.viewpoints import RecordedViewpoints
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig
from colortrack_ros.world import CameraModel
from colortrack_ros.world import TransformError

FRAME = 40_000_000
YAWS = np.radians(70) * np.sin(np.arange(150) / 150 * 2 * np.pi)
"""To one side until the ball is out of the picture, back, and to the other, in 6 s."""
LENS = CameraModel.of(640, 480, info(0).k)
POSE = str([float(number) for number in PLACE])
ODOMETRY = ['-p', 'tracker:ego_motion:=odometry', '-p', f'tracker:camera_pose:={POSE}']


def seen(k):
    """The detections of a picture, none where the ball is beside it."""
    cloud, _ = picture(START + k * FRAME, 0.0, YAWS[k])
    detections = detections_of_cloud(cloud)
    pixels = np.stack([detections.rows['u'], detections.rows['v']], axis=1)
    if not LENS.contains(pixels).all() or abs(YAWS[k]) > 1.0:
        cloud.width, cloud.row_step, cloud.data = 0, 0, b''
    return cloud


def odometry_messages(**of):
    return [
        odometry(START + k * FRAME // 2, 0.0, yaw=np.interp(k / 2, np.arange(150), YAWS), **of)
        for k in range(299)
    ]


def recorded(path, **topics):
    messages = {
        '/camera/camera_info': [info(START + k * FRAME) for k in range(150)],
        '/odom': odometry_messages(),
        '/detections': [seen(k) for k in range(150)],
    }
    messages.update(topics)
    return write_bag(path, {name: some for name, some in messages.items() if some})


def ids(path):
    rows = [tracks_of_cloud(m.content).rows for m in of_topic(path, '/tracks')]
    return {int(name) for some in rows for name in some['track_id'][some['state'] == 1]}


def run(capfd, *arguments):
    status = main([str(argument) for argument in arguments])
    printed = capfd.readouterr()
    assert 'Traceback' not in printed.err
    return status, printed.out, printed.err


def test_a_ball_that_a_turn_takes_out_of_the_picture_comes_back_with_its_id(tmp_path, capfd):
    bag = recorded(tmp_path / 'bag')
    status, out, _ = run(capfd, bag, '--output', tmp_path / 'known', *ODOMETRY)
    assert status == 0
    assert 'warnings    0 pictures' in out
    assert ids(tmp_path / 'known') == {1}
    assert run(capfd, bag, '--output', tmp_path / 'unknown')[0] == 0
    assert len(ids(tmp_path / 'unknown')) > 1


def test_the_tracks_are_those_of_a_tracker_that_knows_the_same(tmp_path, capfd):
    bag = recorded(tmp_path / 'bag')
    run(capfd, bag, '--output', tmp_path / 'out', *ODOMETRY)
    config = CameraPoseConfig(camera_pose=PLACE)
    viewpoints = RecordedViewpoints(bag, config, '/camera/camera_info', '/odom')
    tracker = Tracker(TrackerConfig(ego_motion='odometry'))
    for message in of_topic(tmp_path / 'out', '/detections') or of_topic(bag, '/detections'):
        detections = detections_of_cloud(message.content)
        view = viewpoints.at(detections.stamp, message.log_time)
        yaw = np.arctan2(view.base.R[1, 0], view.base.R[0, 0])
        assert yaw == pytest.approx(YAWS[(detections.stamp - START) // FRAME], abs=1e-6)
        rows = tracker.update(
            type(detections)(detections.rows, detections.stamp, 'cam', (640, 480), view)
        ).rows
    last = tracks_of_cloud(of_topic(tmp_path / 'out', '/tracks')[-1].content).rows
    assert last.tobytes() == rows.tobytes()


@pytest.mark.parametrize(('delay', 'known'), [(300_000_000, True), (901_000_000, False)])
def test_odometry_that_was_recorded_late_is_waited_for_as_a_node_would(tmp_path, delay, known):
    messages = {'/camera/camera_info': [info(START)], '/odom': odometry_messages()}
    bag = write_bag(tmp_path / 'bag', messages, delay=delay)
    config = CameraPoseConfig(camera_pose=PLACE)
    viewpoints = RecordedViewpoints(bag, config, '/camera/camera_info', '/odom')
    stamp = START + 10 * FRAME
    if known:
        viewpoints.at(stamp, stamp)
    else:
        with pytest.raises(TransformError, match='no pose of'):
            viewpoints.at(stamp, stamp)
    viewpoints.close()


@pytest.mark.parametrize(
    ('topics', 'options', 'told'),
    [
        ({'/odom': None}, [], 'no topic /odom of nav_msgs/msg/Odometry there; there are: none'),
        ({}, ['-r', 'odom:=/wheels'], 'no topic /wheels of nav_msgs/msg/Odometry there'),
        ({'/camera/camera_info': None}, [], 'no topic /camera/camera_info of sensor_msgs'),
        ({'/camera/camera_info': [info(START, (0.0,) * 9)]}, [], 'has not been calibrated'),
        ({}, ['-p', 'tracker:pose_source:=tf'], 'expected odometry or fixed, got tf'),
    ],
)
def test_what_cannot_tell_where_the_camera_was_is_an_error_in_one_line(
    tmp_path, capfd, topics, options, told
):
    bag = recorded(tmp_path / 'bag', **topics)
    status, _, err = run(capfd, bag, '--output', tmp_path / 'out', *ODOMETRY, *options)
    assert status == 1
    assert told in err
    assert len(err.strip().splitlines()) == 1


def test_a_recording_without_odometry_is_no_place_to_ask_for_it(tmp_path, capfd):
    options = ['--output', tmp_path / 'out', *ODOMETRY]
    status, _, err = run(capfd, 'scene:five?duration=1', *options)
    assert status == 1
    assert 'scene:five?duration=1 is not a bag that has some' in err


def test_odometry_of_other_frames_is_told_and_tracks_go_on(tmp_path, capfd):
    bag = recorded(tmp_path / 'bag', **{'/odom': odometry_messages(child='base_footprint')})
    status, out, _ = run(capfd, bag, '--output', tmp_path / 'out', *ODOMETRY)
    assert status == 0
    assert 'warnings    150 pictures' in out
    assert "it is of 'base_footprint' in 'odom': expected base_frame 'base_link'" in out


def test_a_recording_that_loops_has_its_odometry_in_each_loop(tmp_path, capfd):
    recorded(tmp_path / 'once')
    once = {name: of_topic(tmp_path / 'once', name) for name in ('/detections', '/odom')}
    kinds = {'/odom': 'nav_msgs/msg/Odometry', '/detections': 'sensor_msgs/msg/PointCloud2'}
    kinds['/camera/camera_info'] = 'sensor_msgs/msg/CameraInfo'
    bag = BagWriter(tmp_path / 'loop', kinds, 'mcap')
    (lens, *_) = of_topic(tmp_path / 'once', '/camera/camera_info')
    bag.write('/camera/camera_info', START, lens.cdr)
    for loop in range(2):
        for name, messages in once.items():
            for message in messages:
                bag.write(name, message.log_time + loop * 151 * FRAME, message.cdr)
    bag.close()
    status, out, _ = run(capfd, tmp_path / 'loop', '--output', tmp_path / 'out', *ODOMETRY)
    assert status == 0
    assert 'warnings    0 pictures' in out


def test_odometry_that_jumps_is_told_and_moves_no_track(tmp_path, capfd):
    """As it does when it is reset, while the ball is in sight."""
    jump = [odometry(START + k * FRAME // 2, -3.0 * (k >= 20)) for k in range(299)]
    stands = [picture(START + k * FRAME, 0.0, 0.0)[0] for k in range(150)]
    bag = recorded(tmp_path / 'bag', **{'/odom': jump, '/detections': stands})
    status, out, _ = run(capfd, bag, '--output', tmp_path / 'out', *ODOMETRY)
    assert status == 0
    assert 'warnings    1 pictures' in out
    assert 'the robot has jumped by 3.00 m and 0 degrees in 0.040 s' in out
    assert ids(tmp_path / 'out') == {1}
