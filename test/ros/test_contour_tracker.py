from functools import cache

import cv2
from diagnostic_msgs.msg import DiagnosticArray
import numpy as np
from rcl_interfaces.msg import Parameter
from rcl_interfaces.msg import ParameterType
from rcl_interfaces.msg import ParameterValue
from rcl_interfaces.srv import SetParameters
from rclpy.serialization import serialize_message
from sensor_msgs.msg import CompressedImage
from sensor_msgs.msg import Image
from sensor_msgs.msg import PointCloud2
from std_srvs.srv import Trigger
from visualization_msgs.msg import Marker
from visualization_msgs.msg import MarkerArray

from colortrack_ros.data import CONFIRMED
from colortrack_ros.data import DETECTION
from colortrack_ros.data import Detections
from colortrack_ros.data import Frame
from colortrack_ros.messages import cloud_of_detections
from colortrack_ros.messages import compressed_of_frame
from colortrack_ros.messages import image_of_frame
from colortrack_ros.messages import outlines_of_serialized_cloud
from colortrack_ros.messages import tracks_of_cloud
from colortrack_ros.scenes import open_scene

START = 10**18
FAST = {'learn_seconds': 0.0, 'min_motion': 0.0}


@cache
def scene():
    return open_scene('silhouette?width=320&height=240&rate=25')


def frame(k: int, at: int | None = None) -> Frame:
    """Pictures of the silhouettes from their coming in on, the first three without them."""
    image = scene().render(0 if k < 3 else 60 + k)
    return Frame(image, 'bgr8', START + (k if at is None else at) * 40_000_000, 'cam')


def ready(ros, kind=Image, topic='camera/image_raw'):
    """The publisher of images, and the messages of tracks and markers, once the node is there."""
    publisher = ros.node.create_publisher(kind, topic, 10)
    tracks, markers = ros.listen(PointCloud2, 'tracks'), ros.listen(MarkerArray, 'tracks/markers')
    assert ros.spin(lambda: publisher.get_subscription_count() == 1), ros.outputs()
    assert ros.spin(lambda: ros.node.count_publishers('tracks/markers') == 1), ros.outputs()
    ros.settle()
    return publisher, tracks, markers


def send(ros, publisher, tracks, markers, frames, write=image_of_frame):
    for one in frames:
        count = len(tracks)
        publisher.publish(write(one))
        assert ros.spin(lambda count=count: len(tracks) == len(markers) == count + 1), ros.outputs()


def confirmed_near_the_truth(cloud, k: int) -> bool:
    rows, truth = tracks_of_cloud(cloud).rows, scene().truth(60 + k)
    far = np.hypot(rows['u'][:, None] - truth['u'], rows['v'][:, None] - truth['v'])
    return len(rows) == 2 and bool((far.min(axis=1) < 1).all() and (rows['state'] == 1).all())


def test_every_image_gives_one_message_of_tracks_one_of_outlines_and_one_of_markers(ros):
    ros.start('contour_tracker', **FAST)
    outlines = ros.listen(PointCloud2, 'tracks/outlines')
    topics = ready(ros)
    sent = [frame(k) for k in range(30)]
    send(ros, *topics, sent)
    _, tracks, markers = topics
    assert ros.spin(lambda: len(outlines) == len(sent)), ros.outputs()
    assert [m.header for m in outlines] == [m.header for m in tracks]
    _, points = outlines_of_serialized_cloud(serialize_message(outlines[-1]))
    rows = tracks_of_cloud(tracks[-1]).rows
    assert np.unique(points['track_id']).tolist() == rows['track_id'].tolist()
    own = points[points['track_id'] == rows['track_id'][0]]
    across = [np.ptp(own['u']), np.ptp(own['v'])]
    np.testing.assert_allclose(across, [rows['box_w'][0], rows['box_h'][0]], rtol=1e-4)
    assert [m.header for m in tracks] == [image_of_frame(f).header for f in sent]
    assert confirmed_near_the_truth(tracks[-1], 29)
    kinds = [m.ns for m in markers[-1].markers]
    assert kinds == ['ellipse', 'velocity', 'id', 'outline'] * 2
    outline = markers[-1].markers[3]
    assert (outline.type, outline.action) == (Marker.LINE_STRIP, Marker.ADD)
    assert outline.points[0] == outline.points[-1]
    row = tracks_of_cloud(tracks[-1]).rows[0]
    across = np.ptp([(p.x, p.y) for p in outline.points], axis=0) / 0.01
    np.testing.assert_allclose(across, [row['box_w'], row['box_h']], rtol=1e-4)


def test_a_reset_and_stamps_that_go_back_start_afresh_and_delete_all_markers(ros):
    node = ros.start('contour_tracker', **FAST)
    topics = ready(ros)
    _, tracks, markers = topics
    send(ros, *topics, [frame(k) for k in range(20)])
    assert confirmed_near_the_truth(tracks[-1], 19)
    assert ros.call(Trigger, 'contour_tracker/reset', Trigger.Request()).success
    send(ros, *topics, [frame(20)])
    assert tracks[-1].width == 0
    assert [m.action for m in markers[-1].markers] == [Marker.DELETEALL]
    send(ros, *topics, [frame(k, 21 + k) for k in range(20)])
    assert confirmed_near_the_truth(tracks[-1], 19)
    ros.spin(lambda: False, 1.2)  # such warnings come once a second
    send(ros, *topics, [frame(0)])
    assert [m.action for m in markers[-1].markers] == [Marker.DELETEALL]
    call = Trigger, 'contour_tracker/learn_background', Trigger.Request()
    assert ros.call(*call).success
    send(ros, *topics, [frame(k) for k in range(1, 3)])
    node.wait_for('a call of ~/reset')
    node.wait_for('the stamp went back by')


def test_a_camera_that_moves_is_told(ros):
    """No place shows the same twice, so there is no background."""
    node = ros.start('contour_tracker')
    rng = np.random.default_rng(1)
    shown = [
        Frame(rng.integers(0, 255, (48, 64, 3), np.uint8), 'bgr8', START + k * 200_000_000, 'cam')
        for k in range(20)
    ]
    send(ros, *ready(ros), shown)
    node.wait_for('nothing new is looked for: the camera moves')


def test_all_that_is_wrong_at_once_is_told(ros):
    """A camera that moves, and detections that never come."""
    reliable = {'qos_overrides./camera/image_raw.subscription.reliability': 'reliable'}
    detections = {'detections_topic': 'detections', 'max_lag': 60.0}
    node = ros.start('contour_tracker', **detections, **reliable)
    publisher, tracks, _ = ready(ros)
    diagnostics = ros.listen(DiagnosticArray, '/diagnostics')
    rng = np.random.default_rng(1)
    for k in range(30 + 150):  # as many wait, and as many on end are told
        picture = rng.integers(0, 255, (48, 64, 3), np.uint8)
        stamp = START + k * 200_000_000
        publisher.publish(image_of_frame(Frame(picture, 'bgr8', stamp, 'cam')))
        assert ros.spin(lambda k=k: len(tracks) >= k - 29), ros.outputs()
    told = 'nothing new is looked for: the camera moves', 'pictures wait in vain for detections'
    for one in told:
        node.wait_for(one)

    def last() -> str:
        return diagnostics[-1].status[0].message if diagnostics else ''

    assert ros.spin(lambda: all(one in last() for one in told)), last()


def test_compressed_images_and_late_ones_are_taken(ros):
    topic = 'camera/image_raw/compressed'
    parameters = {
        'image_transport': 'compressed',
        f'qos_overrides./{topic}.subscription.reliability': 'reliable',
        'image_queue_depth': 100,
        'max_lag': 60.0,
        'reorder_window': 2.0,  # also how long the next picture may take to come
    }
    node = ros.start('contour_tracker', **parameters, **FAST)
    publisher, tracks, _ = ready(ros, CompressedImage, topic)
    order = [0, 1, 2, *(k + (1, -1)[k % 2] for k in range(4, 24))]
    for message in [compressed_of_frame(frame(k), 95) for k in order]:
        publisher.publish(message)
    assert ros.spin(lambda: len(tracks) == len(order)), node.output
    stamps = [tracks_of_cloud(m).stamp for m in tracks]
    assert stamps == sorted(stamps)
    assert tracks[-1].width == 2


def test_targets_and_detections_start_contours_in_the_picture_that_they_are_of(ros):
    person, other = (scene().outlines(63)[i] for i in (1, 2))
    named = [*person.min(axis=0), *np.ptp(person, axis=0)]
    ros.start(
        'contour_tracker', start='targets', detections_topic='detections',
        targets='[' + ', '.join(f'{x:.1f}' for x in named) + ']',
    )  # fmt: skip
    topics = ready(ros)
    detected = ros.node.create_publisher(PointCloud2, 'detections', 10)
    assert ros.spin(lambda: detected.get_subscription_count() == 1), ros.outputs()
    ros.settle()
    for k in range(3, 12):
        rows = np.zeros(int(k % 4 == 3), DETECTION)
        for row in rows:
            row['box_u'], row['box_v'] = other.min(axis=0)
            row['box_w'], row['box_h'] = np.ptp(other, axis=0)
        detected.publish(cloud_of_detections(Detections(rows, frame(k).stamp, 'cam')))
        send(ros, *topics, [frame(k)])
        found = tracks_of_cloud(topics[1][-1]).rows
        assert found['track_id'].tolist() == [1, 2]
    truth = scene().truth(60 + k)
    np.testing.assert_allclose([found['u'], found['v']], [truth['u'], truth['v']], atol=8.0)


def test_bad_images_and_parameters_are_refused_and_the_node_goes_on(ros):
    node = ros.start(
        'contour_tracker', opening_size=4, points=3, mask='[1.0, 2.0]', no_edge='-1.0', **FAST
    )
    node.wait_for('opening_size: expected an odd number of px, got 4')
    node.wait_for('points: expected 6..64')
    node.wait_for('mask: expected 3 to 15 weights, odd in number, of sum 0')
    node.wait_for('no_edge: expected 0..255')
    topics = ready(ros)
    publisher, tracks, _ = topics
    bad = image_of_frame(frame(0))
    bad.step = 7
    publisher.publish(bad)
    node.wait_for('Refused: image step 7')
    tiny = [np.zeros((h, w, 3), np.uint8) for h, w in ((1, 1), (0, 0), (3, 2000))]
    send(ros, *topics, [Frame(t, 'bgr8', START - 3 + k, 'cam') for k, t in enumerate(tiny)])

    def set_value(name, **value):
        parameter = Parameter(name=name, value=ParameterValue(**value))
        request = SetParameters.Request(parameters=[parameter])
        return ros.call(SetParameters, 'contour_tracker/set_parameters', request).results[0]

    kind = ParameterType.PARAMETER_DOUBLE
    refused = set_value('edge_variance', type=kind, double_value=0.0)
    assert not refused.successful
    assert 'edge_variance' in refused.reason
    assert set_value('edge_variance', type=kind, double_value=0.2).successful
    send(ros, *topics, [frame(k) for k in range(20)])
    assert set_value('points', type=ParameterType.PARAMETER_INTEGER, integer_value=16).successful
    send(ros, *topics, [frame(k) for k in range(20, 30)])
    assert tracks[-1].width == 2


def test_the_overlay_draws_the_outlines_of_the_picture(ros):
    ros.start('contour_tracker', marker_scale=0.5, **FAST)
    ros.start('overlay', outlines_topic='tracks/outlines')
    pictures = ros.listen(Image, 'overlay/image_raw')
    topics = ready_for_two(ros)
    send(ros, *topics, [frame(k) for k in range(20)])
    last = topics[1][-1].header
    assert ros.spin(lambda: pictures and pictures[-1].header == last), f'{len(pictures)} pictures'
    last = np.frombuffer(pictures[-1].data, np.uint8).reshape(240, 320, 3)
    drawn = (np.abs(last.astype(int) - frame(19).image).max(axis=2) > 40).astype(np.uint8)
    assert tracks_of_cloud(topics[1][-1]).rows['state'].tolist() == [CONFIRMED] * 2
    for corners in scene().outlines(79).values():
        ring = np.zeros((240, 320), np.uint8)
        cv2.polylines(ring, [np.rint(corners).astype(np.int32)], True, 1, 1)
        near = cv2.dilate(drawn, np.ones((7, 7), np.uint8))
        assert near[ring > 0].mean() > 0.85


def ready_for_two(ros):
    publisher = ros.node.create_publisher(Image, 'camera/image_raw', 10)
    tracks, markers = ros.listen(PointCloud2, 'tracks'), ros.listen(MarkerArray, 'tracks/markers')
    assert ros.spin(lambda: publisher.get_subscription_count() == 2), ros.outputs()
    assert ros.spin(lambda: ros.node.count_publishers('overlay/image_raw') == 1), ros.outputs()
    assert ros.spin(lambda: ros.node.count_subscribers('tracks/outlines') == 1), ros.outputs()
    ros.settle()
    return publisher, tracks, markers
