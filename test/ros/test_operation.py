"""What an operator does and sees: pausing, resetting, diagnostics, late messages."""

from diagnostic_msgs.msg import DiagnosticArray
from diagnostic_msgs.msg import DiagnosticStatus
import numpy as np
from rclpy.qos import DurabilityPolicy
from rclpy.qos import qos_profile_sensor_data
from rclpy.qos import QoSProfile
from sensor_msgs.msg import CameraInfo
from sensor_msgs.msg import Image
from sensor_msgs.msg import PointCloud2
from std_srvs.srv import SetBool
from std_srvs.srv import Trigger
from visualization_msgs.msg import Marker
from visualization_msgs.msg import MarkerArray

from colortrack_ros.data import DETECTION
from colortrack_ros.data import Detections
from colortrack_ros.data import Frame
from colortrack_ros.messages import cloud_of_detections
from colortrack_ros.messages import frame_of_image
from colortrack_ros.messages import image_of_frame
from colortrack_ros.messages import stamp_of
from colortrack_ros.messages import tracks_of_cloud
from colortrack_ros.nodes.detector import DetectorNode

LOOP = {'source': 'scene:single?width=320&height=240', 'loop': 'true'}
START = 1_700_000_000 * 10**9
STEP = 40_000_000


def detections(k: int) -> PointCloud2:
    rows = np.zeros(1, DETECTION)
    rows['u'], rows['v'], rows['area'] = 100 + k, 50, 300
    return cloud_of_detections(Detections(rows, START + k * STEP, 'cam'))


def frame_numbers(messages) -> list[int]:
    return [(stamp_of(m.header) - START) // STEP for m in messages]


def status_of(ros, messages: list, node: str, level: bytes, text: str) -> DiagnosticStatus:
    def found() -> list[DiagnosticStatus]:
        return [
            status
            for array in messages
            for status in array.status
            if (status.name, status.level) == (f'{node[1:]}: messages', level)
            and text in status.message
        ]

    assert ros.spin(lambda: len(found()) > 0), f'{text}: {messages[-3:]} {ros.outputs()}'
    return found()[-1]


def fed_tracker(ros, **parameters):
    """A tracker, its tracks, and a publisher of detections."""
    tracker = ros.start('tracker', max_lag=60.0, **parameters)
    tracks = ros.listen(PointCloud2, 'tracks')
    publisher = ros.node.create_publisher(PointCloud2, 'detections', 100)
    assert ros.spin(lambda: publisher.get_subscription_count() == 1), ros.outputs()
    ros.settle()
    return tracker, tracks, publisher


def test_a_late_detections_message_is_dropped_and_counted(ros):
    diagnostics = ros.listen(DiagnosticArray, '/diagnostics')
    tracker, tracks, publisher = fed_tracker(ros)
    for k in (0, 1, 2, 4, 3, 5):
        publisher.publish(detections(k))
    assert ros.spin(lambda: len(tracks) == 5), ros.outputs()
    assert frame_numbers(tracks) == [0, 1, 2, 4, 5]
    tracker.wait_for('0.040 s older than the newest')
    status = status_of(ros, diagnostics, '/tracker', DiagnosticStatus.WARN, '1 refused')
    assert {v.key: v.value for v in status.values}['refused'] == '1'


def test_within_the_window_a_late_message_is_put_in_its_place(ros):
    _, tracks, publisher = fed_tracker(ros, reorder_window=2.0)
    last = 60  # its stamp says that the window of all others has passed
    for k in (0, 1, 2, 4, 3, 5, 7, 6, 8, last):
        publisher.publish(detections(k))
    assert ros.spin(lambda: len(tracks) == 10), ros.outputs()
    assert frame_numbers(tracks) == [*range(9), last]
    assert tracks_of_cloud(tracks[8]).rows['track_id'].tolist() == [1]


def test_a_loop_resets_once_with_one_line_and_a_deleteall(ros):
    markers = ros.listen(MarkerArray, 'tracks/markers')
    tracker, tracks, publisher = fed_tracker(ros)
    for k in (*range(100, 130), *range(20)):
        publisher.publish(detections(k))
    assert ros.spin(lambda: len(tracks) == len(markers) == 50), ros.outputs()
    actions = [marker.action for array in markers[1:] for marker in array.markers]
    assert actions.count(Marker.DELETEALL) == 1
    assert tracker.output.count('started afresh') == 1
    ids = [tracks_of_cloud(message).rows['track_id'].tolist() for message in tracks]
    assert ids == [[1]] * 30 + [[2]] * 20


def test_a_late_image_is_dropped_and_counted(ros):
    reliable = {'qos_overrides./camera/image_raw.subscription.reliability': 'reliable'}
    detector = ros.start('detector', max_lag=60.0, image_queue_depth=10, **reliable)
    answers = ros.listen(PointCloud2, 'detections')
    publisher = ros.node.create_publisher(Image, 'camera/image_raw', 100)
    assert ros.spin(lambda: publisher.get_subscription_count() == 1), ros.outputs()
    ros.settle()
    pixels = np.zeros((4, 5, 3), np.uint8)
    for k in (0, 1, 3, 2, 4):
        publisher.publish(image_of_frame(Frame(pixels, 'bgr8', START + k * STEP)))
    assert ros.spin(lambda: len(answers) == 4), ros.outputs()
    assert frame_numbers(answers) == [0, 1, 3, 4]
    detector.wait_for('older than the newest')


def test_reset_drops_the_tracks_and_the_markers(ros):
    markers = ros.listen(MarkerArray, 'tracks/markers')
    _, tracks, publisher = fed_tracker(ros)
    for k in range(10):
        publisher.publish(detections(k))
    assert ros.spin(lambda: len(tracks) == 10), ros.outputs()
    assert ros.call(Trigger, 'tracker/reset', Trigger.Request()).success
    publisher.publish(detections(10))
    assert ros.spin(lambda: len(tracks) == len(markers) == 11), ros.outputs()
    assert [m.action for m in markers[-1].markers] == [Marker.DELETEALL]
    assert tracks_of_cloud(tracks[-1]).rows['track_id'].tolist() == [2]


def test_camera_and_detector_pause(ros):
    for name in ('camera', 'detector'):
        ros.start(name, **(LOOP if name == 'camera' else {}))
    infos, answers = (
        ros.listen(CameraInfo, 'camera/camera_info'),
        ros.listen(PointCloud2, 'detections'),
    )
    assert ros.spin(lambda: len(answers) > 5), ros.outputs()
    for name, messages in (('detector', answers), ('camera', infos)):
        assert ros.call(SetBool, f'{name}/pause', SetBool.Request(data=True)).message == 'paused'
        assert ros.spin(lambda m=messages: ros.is_silent(m)), name
        assert ros.call(SetBool, f'{name}/pause', SetBool.Request(data=False)).success
        assert ros.spin(lambda m=messages: len(m) > 5), ros.outputs()


def test_compressed_images_are_taken(ros):
    ros.start('camera', **LOOP)
    ros.start('detector', image_transport='compressed')
    answers = ros.listen(PointCloud2, 'detections')
    assert ros.spin(lambda: len(answers) > 5), ros.outputs()
    assert answers[-1].width == 1


def test_the_mask_is_published_and_the_background_learned_anew(ros):
    ros.start('camera', **LOOP)
    ros.start('detector')
    masks = ros.listen(Image, 'detector/mask')
    assert ros.spin(lambda: len(masks) > 3), ros.outputs()
    mask = frame_of_image(masks[-1])
    assert (mask.encoding, mask.image.shape) == ('mono8', (240, 320))
    assert 100 < np.count_nonzero(mask.image) < 5000
    request = Trigger.Request()
    assert ros.call(Trigger, 'detector/learn_background', request).success


def test_no_mask_is_published_while_nobody_looks(ros, monkeypatch):
    node = DetectorNode(subscribe=False, context=ros.node.context)
    node.start()
    sent = []
    monkeypatch.setattr(node._debug_publisher, 'publish', sent.append)
    frame = Frame(np.zeros((20, 30, 3), np.uint8))
    node.stage.put(frame)
    node.stage.settle()
    assert not sent
    ros.listen(Image, 'detector/mask')
    assert ros.spin(lambda: node._debug_publisher.get_subscription_count() > 0), ros.outputs()
    node.stage.put(frame)
    node.stage.settle()
    assert len(sent) == 1
    node.close()
    node.destroy_node()


def test_diagnostics_tell_what_is_wrong(ros):
    diagnostics = ros.listen(DiagnosticArray, '/diagnostics')
    ros.start('camera', **LOOP)
    ros.start('detector', warn_latency=0.0)
    ros.start('tracker', detections_topic='nobody', warn_silence=0.5, error_silence=8.0)
    camera = status_of(ros, diagnostics, '/camera', DiagnosticStatus.OK, 'working')
    assert camera.hardware_id.startswith('scene:single')
    status_of(ros, diagnostics, '/detector', DiagnosticStatus.WARN, 'from stamp to output')
    status_of(ros, diagnostics, '/tracker', DiagnosticStatus.WARN, 'nothing has come in')
    status_of(ros, diagnostics, '/tracker', DiagnosticStatus.ERROR, 'nothing has come in')


def test_a_color_that_is_out_of_view_is_no_error(ros):
    diagnostics = ros.listen(DiagnosticArray, '/diagnostics')
    ros.start('camera', **LOOP)
    ros.start('detector', **{'colors': '[red, away]', 'away.rgb': '[20.0, 250.0, 250.0]'})
    status_of(ros, diagnostics, '/detector', DiagnosticStatus.WARN, 'away has not been seen yet')
    assert not any(s.level == DiagnosticStatus.ERROR for m in diagnostics for s in m.status)


def test_stamps_that_nobody_fills_in_are_told(ros):
    """No track was ever confirmed, and nobody said why."""
    diagnostics = ros.listen(DiagnosticArray, '/diagnostics')
    tracker, tracks, publisher = fed_tracker(ros)
    for _ in range(12):
        publisher.publish(cloud_of_detections(Detections(np.zeros(1, DETECTION), 0)))
    text = 'the stamps stand still at 0.000 s'
    status_of(ros, diagnostics, '/tracker', DiagnosticStatus.WARN, text)
    assert tracker.output.count(text) == 1
    assert len(tracks) == 12


def test_rivals_are_warned_of(ros):
    diagnostics = ros.listen(DiagnosticArray, '/diagnostics')
    ros.start('tracker', warn_silence=60.0)
    status_of(ros, diagnostics, '/tracker', DiagnosticStatus.OK, 'working')
    other = ros.start('tracker', '-r', '__node:=other', warn_silence=60.0)
    text = 'others publish on /tracks as well'
    for node in ('/tracker', '/other'):
        status_of(ros, diagnostics, node, DiagnosticStatus.WARN, text)
    assert other.stop() == 0
    ros.start('tracker', warn_silence=60.0)
    status_of(
        ros, diagnostics, '/tracker', DiagnosticStatus.WARN, 'several nodes are called /tracker'
    )


def test_two_cameras_on_one_topic_are_warned_of(ros):
    diagnostics = ros.listen(DiagnosticArray, '/diagnostics')
    detector = ros.start('detector', warn_silence=60.0)
    ros.node.create_publisher(Image, 'camera/image_raw', 10)
    status_of(ros, diagnostics, '/detector', DiagnosticStatus.OK, 'working')
    ros.start('camera', **LOOP)
    text = '/camera and /test publish on /camera/image_raw, and their messages take turns'
    status_of(ros, diagnostics, '/detector', DiagnosticStatus.WARN, text)
    assert detector.output.count(text) == 1


def test_no_subscriber_is_incompatible(ros):
    for name in ('camera', 'detector', 'tracker', 'overlay'):
        ros.start(name, **(LOOP if name == 'camera' else {}))
    topics = {
        'camera/image_raw': Image,
        'camera/camera_info': CameraInfo,
        'detections': PointCloud2,
        'tracks': PointCloud2,
        'tracks/markers': MarkerArray,
        'overlay/image_raw': Image,
    }
    heard = {}
    for name, kind in topics.items():
        for qos in (qos_profile_sensor_data, 10):  # as Foxglove and as RViz and `ros2 topic echo`
            messages = heard.setdefault((name, str(qos)), [])
            ros.node.create_subscription(kind, name, messages.append, qos)
    assert ros.spin(lambda: all(heard.values())), [k for k, v in heard.items() if not v]


def test_qos_that_does_not_match_is_told_and_odometry_of_any_is_taken(ros):
    """Nothing came in, in silence but for a line of rclpy, such as the odometry of a Create 3."""
    diagnostics = ros.listen(DiagnosticArray, '/diagnostics')
    ros.node.create_publisher(PointCloud2, 'detections', qos_profile_sensor_data)
    kept = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    ros.node.create_subscription(MarkerArray, 'poses', lambda _: None, kept)
    ros.start('tracker')
    text = 'tracker gets nothing from test on /detections: best effort publisher and reliable'
    status_of(ros, diagnostics, '/tracker', DiagnosticStatus.WARN, text)
    ros.start(
        'tracker',
        '-r',
        '__node:=other',
        detections_topic='x',
        tracks_topic='t',
        markers_topic='poses',
    )
    text = 'test gets nothing from other on /poses: volatile publisher'
    status_of(ros, diagnostics, '/other', DiagnosticStatus.WARN, text)
    ros.start('follower')
    assert ros.spin(lambda: ros.node.count_subscribers('odom') == 1), ros.outputs()
    (odometry,) = ros.node.get_subscriptions_info_by_topic('odom')
    assert odometry.qos_profile.reliability.name == 'BEST_EFFORT'


def test_qos_and_depth_are_parameters(ros):
    ros.start(
        'camera', '-p', 'qos_overrides./camera/image_raw.publisher.reliability:=best_effort', **LOOP
    )
    ros.start(
        'detector',
        '-p',
        'qos_overrides./detections.publisher.durability:=transient_local',
        queue_depth=3,
    )
    assert ros.spin(lambda: ros.node.count_publishers('detections') == 1), ros.outputs()
    assert ros.spin(lambda: ros.node.count_publishers('camera/image_raw') == 1), ros.outputs()
    (camera,) = ros.node.get_publishers_info_by_topic('camera/image_raw')
    assert camera.qos_profile.reliability.name == 'BEST_EFFORT'
    (detector,) = ros.node.get_publishers_info_by_topic('detections')
    assert detector.qos_profile.durability.name == 'TRANSIENT_LOCAL'
