from nav_msgs.msg import Odometry
import numpy as np
from rcl_interfaces.msg import Parameter
from rcl_interfaces.msg import ParameterType
from rcl_interfaces.msg import ParameterValue
from rcl_interfaces.srv import SetParameters
from sensor_msgs.msg import CameraInfo
from sensor_msgs.msg import PointCloud2
from support.ball_before_camera import info
from support.ball_before_camera import odometry
from support.ball_before_camera import picture
from support.ball_before_camera import PLACE
from support.ball_before_camera import START
from visualization_msgs.msg import Marker
from visualization_msgs.msg import MarkerArray

from colortrack_ros.data import CONFIRMED
from colortrack_ros.data import DETECTION
from colortrack_ros.data import Detections
from colortrack_ros.messages import cloud_of_detections
from colortrack_ros.messages import tracks_of_cloud


def detections(k: int, points: list[tuple[float, float]]) -> PointCloud2:
    rows = np.zeros(len(points), DETECTION)
    for row, (u, v) in zip(rows, points, strict=True):
        row['u'], row['v'] = u, v
        row['cov_uu'] = row['cov_vv'] = 0.01
        row['area'], row['box_w'], row['box_h'] = 300.0, 20.0, 20.0
        row['box_u'], row['box_v'] = u - 9.5, v - 9.5
    return cloud_of_detections(Detections(rows, 10**18 + k * 40_000_000, 'cam'))


def test_every_detections_message_gives_one_of_tracks_and_one_of_markers(ros):
    ros.start('tracker')
    tracks, markers = ros.listen(PointCloud2, 'tracks'), ros.listen(MarkerArray, 'tracks/markers')
    publisher = ros.node.create_publisher(PointCloud2, 'detections', 10)
    assert ros.spin(lambda: publisher.get_subscription_count() == 1)
    assert ros.spin(lambda: ros.node.count_publishers('tracks/markers') == 1)
    ros.settle()
    sent = [detections(k, [(100 + 2.0 * k, 50)] if k < 10 else []) for k in range(60)]
    for k, message in enumerate(sent):
        publisher.publish(message)
        assert ros.spin(lambda k=k: len(tracks) == len(markers) == k + 1), ros.outputs()
    assert [m.header for m in tracks] == [m.header for m in sent]
    assert all(len(t.data) == t.width * 208 == t.row_step for t in tracks)
    first = tracks_of_cloud(tracks[9]).rows
    assert first['track_id'].tolist() == [1]
    assert first['state'].tolist() == [1]
    assert abs(first['u'][0] - 118) < 0.5
    assert tracks[-1].width == 0
    # another tracker, which was killed, may have left its markers
    assert [m.action for m in markers[0].markers] == [Marker.DELETEALL]
    kinds = {(m.ns, m.action) for array in markers[1:] for m in array.markers}
    assert {('ellipse', Marker.ADD), ('ellipse', Marker.DELETE)} < kinds
    assert {'ellipse', 'velocity', 'id'} == {ns for ns, _ in kinds}


def test_a_stamp_that_goes_back_starts_afresh_and_deletes_all_markers(ros):
    tracker = ros.start('tracker')
    markers = ros.listen(MarkerArray, 'tracks/markers')
    publisher = ros.node.create_publisher(PointCloud2, 'detections', 10)
    assert ros.spin(lambda: publisher.get_subscription_count() == 1)
    assert ros.spin(lambda: ros.node.count_publishers('tracks/markers') == 1)
    ros.settle()
    for count, k in enumerate([*range(10), 0]):
        publisher.publish(detections(k, [(100, 50)]))
        assert ros.spin(lambda count=count: len(markers) == count + 1)
    assert [m.action for m in markers[-1].markers] == [Marker.DELETEALL]
    assert tracker.output.count('started afresh') == 1


def set_parameter(ros, node: str, name: str, value: ParameterValue):
    request = SetParameters.Request(parameters=[Parameter(name=name, value=value)])
    return ros.call(SetParameters, f'{node}/set_parameters', request).results[0]


def test_bad_parameters_are_refused_with_a_reason(ros):
    tracker = ros.start('tracker', max_time_since_update=-3.0, max_tme_since_update=1.0)
    tracker.wait_for('max_time_since_update: expected 0..3600 s, got -3.0')
    tracker.wait_for(
        'max_tme_since_update: no such parameter; the nearest is max_time_since_update'
    )

    def double(value: float) -> ParameterValue:
        return ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=value)

    assert set_parameter(ros, 'tracker', 'max_time_since_update', double(2.5)).successful
    refused = set_parameter(ros, 'tracker', 'max_time_since_update', double(float('nan')))
    assert not refused.successful
    assert 'max_time_since_update' in refused.reason
    text = ParameterValue(type=ParameterType.PARAMETER_STRING, string_value='long')
    refused = set_parameter(ros, 'tracker', 'process_noise', text)
    assert not refused.successful
    assert "process_noise: expected float, 0..1e+06 px/s^2, got 'long'" in refused.reason
    whole = ParameterValue(type=ParameterType.PARAMETER_INTEGER, integer_value=3)
    assert set_parameter(ros, 'tracker', 'max_time_since_update', whole).successful


def test_a_ball_that_a_robot_turns_away_from_has_its_id_when_the_robot_turns_back(ros):
    """Odometry comes a little later than the picture; at the end it stops, which is told."""
    place = str([float(number) for number in PLACE])
    tracker = ros.start('tracker', ego_motion='odometry', camera_pose=place)
    tracks = ros.listen(PointCloud2, 'tracks')
    make = ros.node.create_publisher
    seen, driven, lens = (
        make(PointCloud2, 'detections', 10),
        make(Odometry, 'odom', 10),
        make(CameraInfo, 'camera/camera_info', 10),
    )
    assert ros.spin(lambda: seen.get_subscription_count() and driven.get_subscription_count())
    assert ros.spin(lambda: lens.get_subscription_count() == 2)
    assert ros.spin(lambda: ros.node.count_publishers('tracks') == 1)
    ros.settle()
    yaws = 0.08 * np.array([0] * 6 + list(range(15)) + list(range(15))[::-1] + [0] * 6)
    for k, yaw in enumerate(yaws):
        stamp = START + k * 40_000_000
        ball = picture(stamp, 0.0, yaw)[0] if abs(yaw) < 0.6 else detections(0, [])
        ball.header = info(stamp).header
        lens.publish(info(stamp))
        seen.publish(ball)
        driven.publish(odometry(stamp, 0.0, yaw=yaw))
        assert ros.spin(lambda k=k: len(tracks) == k + 1), ros.outputs()
    rows = np.concatenate([tracks_of_cloud(message).rows for message in tracks])
    assert set(rows['track_id'][rows['state'] == CONFIRMED]) == {1}
    assert any(m.width == 0 for m in tracks[12:30])
    assert 'viewpoint' not in tracker.output
    late = picture(stamp + 40_000_000, 0.0)[0]
    seen.publish(late)
    assert ros.spin(lambda: tracks[-1].header == late.header), ros.outputs()
    told = 'Lookup would require extrapolation into the future'
    tracker.wait_for(f'as if the camera stood still: {told}')
