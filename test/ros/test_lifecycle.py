"""A lifecycle manager, such as Nav2's, brings the nodes up, lets them rest, and takes them down."""

import signal

import cv2
from diagnostic_msgs.msg import DiagnosticArray
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from lifecycle_msgs.srv import GetState
import numpy as np
import pytest
from rcl_interfaces.msg import Parameter
from rcl_interfaces.msg import ParameterType
from rcl_interfaces.msg import ParameterValue
from rcl_interfaces.srv import SetParameters
from sensor_msgs.msg import Image
from sensor_msgs.msg import PointCloud2
from std_srvs.srv import SetBool
from visualization_msgs.msg import Marker
from visualization_msgs.msg import MarkerArray

from colortrack_ros.data import DETECTION
from colortrack_ros.data import Detections
from colortrack_ros.data import Frame
from colortrack_ros.messages import cloud_of_detections
from colortrack_ros.messages import image_of_frame
from colortrack_ros.messages import tracks_of_cloud

SOURCE = 'scene:single?width=320&height=240'
PICTURES = 'camera/image_raw'
CHAIN = ('tracker', 'detector', 'camera')
CONFIGURE, CLEAN_UP = Transition.TRANSITION_CONFIGURE, Transition.TRANSITION_CLEANUP
ACTIVATE, DEACTIVATE = Transition.TRANSITION_ACTIVATE, Transition.TRANSITION_DEACTIVATE


def change(ros, node, transition):
    request = ChangeState.Request(transition=Transition(id=transition))
    return ros.call(ChangeState, f'{node}/change_state', request).success


def state(ros, node):
    return ros.call(GetState, f'{node}/get_state', GetState.Request()).current_state.label


def start(ros, kind, **camera):
    """The three nodes, unconfigured, in one process or in three."""
    lines = [
        f'    {name}: {value}\n'
        for name, value in ({'source': SOURCE, 'loop': 'true'} | camera).items()
    ]
    path = ros.folder / 'managed.yaml'
    path.write_text(
        '/**:\n  ros__parameters:\n    autostart: false\n'
        '/camera:\n  ros__parameters:\n' + ''.join(lines)
    )
    names = ('pipeline',) if kind == 'pipeline' else CHAIN
    return [ros.start(name, '--params-file', str(path)) for name in names]


def last_messages(diagnostics):
    """What each node has said last, by its name."""
    return {status.name: status.message for array in diagnostics for status in array.status}


def all_rest(diagnostics):
    """Whether each node has said last that it is inactive."""
    return set(last_messages(diagnostics).values()) == {'inactive'}


@pytest.mark.parametrize('kind', ['pipeline', 'nodes'])
def test_the_chain_is_brought_up_rests_and_is_taken_down(ros, kind):
    processes = start(ros, kind)
    tracks, diagnostics = (
        ros.listen(PointCloud2, 'tracks'),
        ros.listen(DiagnosticArray, '/diagnostics'),
    )
    assert [state(ros, node) for node in CHAIN] == ['unconfigured'] * 3, ros.outputs()
    assert ros.node.count_publishers('tracks') == 0
    for _ in range(2):
        for node in CHAIN:
            assert change(ros, node, CONFIGURE), ros.outputs()
        assert [state(ros, node) for node in CHAIN] == ['inactive'] * 3
        assert ros.spin(lambda: all_rest(diagnostics)), (last_messages(diagnostics), ros.outputs())
        assert not tracks
        for node in CHAIN:
            assert change(ros, node, ACTIVATE), ros.outputs()
        assert ros.spin(lambda: any(message.width for message in tracks)), ros.outputs()
        diagnostics.clear()
        for node in CHAIN:
            assert change(ros, node, DEACTIVATE)
        assert ros.spin(lambda: ros.is_silent(tracks)), ros.outputs()
        for node in CHAIN:
            assert change(ros, node, CLEAN_UP), ros.outputs()
        assert ros.spin(lambda: ros.node.count_publishers('tracks') == 0), ros.outputs()
    assert [state(ros, node) for node in CHAIN] == ['unconfigured'] * 3
    for process in processes:
        assert process.stop(signal.SIGINT) == 0, process.output
        assert 'Traceback' not in process.output


def test_what_is_paused_stays_paused_when_it_is_activated_again(ros):
    start(ros, 'pipeline')
    tracks = ros.listen(PointCloud2, 'tracks')
    for transition in (CONFIGURE, ACTIVATE):
        for node in CHAIN:
            assert change(ros, node, transition), ros.outputs()
    assert ros.call(SetBool, 'detector/pause', SetBool.Request(data=True)).success
    assert change(ros, 'detector', DEACTIVATE)
    assert change(ros, 'detector', ACTIVATE)
    assert ros.spin(lambda: ros.is_silent(tracks)), ros.outputs()
    assert ros.call(SetBool, 'detector/pause', SetBool.Request(data=False)).success
    assert ros.spin(lambda: len(tracks) > 5), ros.outputs()


def test_a_transition_that_there_is_not_is_refused_and_ends_nothing(ros):
    (process,) = [ros.start('tracker', autostart='false')]
    for transition in (ACTIVATE, DEACTIVATE, CLEAN_UP, 77, 255):
        assert not change(ros, 'tracker', transition)
        assert state(ros, 'tracker') == 'unconfigured'
    assert change(ros, 'tracker', CONFIGURE)
    assert not change(ros, 'tracker', CONFIGURE)
    assert state(ros, 'tracker') == 'inactive'
    assert change(ros, 'tracker', Transition.TRANSITION_INACTIVE_SHUTDOWN)
    assert state(ros, 'tracker') == 'finalized'
    assert process.stop() == 0, process.output
    assert 'Traceback' not in process.output


def test_a_node_that_cannot_be_configured_says_why_and_stays(ros, tmp_path):
    folder = tmp_path / 'pictures'
    process = ros.start('camera', autostart='false', source=folder / '*.png')
    assert not change(ros, 'camera', CONFIGURE)
    assert state(ros, 'camera') == 'unconfigured'
    process.wait_for('Not configured: ')
    folder.mkdir()
    cv2.imwrite(str(folder / 'one.png'), np.zeros((48, 64, 3), np.uint8))
    pictures = ros.listen(Image, 'camera/image_raw')
    assert change(ros, 'camera', CONFIGURE), process.output
    assert ros.spin(lambda: ros.node.count_publishers('camera/image_raw') == 1)
    ros.settle()
    assert change(ros, 'camera', ACTIVATE)
    assert ros.spin(lambda: len(pictures) == 1), process.output


def test_what_is_set_before_a_node_is_configured_holds_then(ros):
    process = ros.start('camera', autostart='false', source=SOURCE)
    value = ParameterValue(type=ParameterType.PARAMETER_STRING, string_value='left_eye')
    request = SetParameters.Request(parameters=[Parameter(name='frame_id', value=value)])
    assert ros.call(SetParameters, 'camera/set_parameters', request).results[0].successful
    pictures = ros.listen(Image, 'camera/image_raw')
    assert change(ros, 'camera', CONFIGURE)
    assert change(ros, 'camera', ACTIVATE)
    assert ros.spin(lambda: bool(pictures)), process.output
    assert pictures[0].header.frame_id == 'left_eye'


@pytest.mark.parametrize(
    'name',
    ['overlay', 'locator', 'window_tracker', 'contour_tracker', 'follower', 'simulator'],
)
def test_the_other_nodes_are_brought_up_and_taken_down_twice(ros, name):
    process = ros.start(name, autostart='false')
    for _ in range(2):
        for transition in (CONFIGURE, ACTIVATE, DEACTIVATE, ACTIVATE, DEACTIVATE, CLEAN_UP):
            assert change(ros, name, transition), process.output
    assert change(ros, name, CONFIGURE)
    assert process.stop() == 0, process.output
    assert 'Traceback' not in process.output


@pytest.mark.parametrize('name', ['tracker', 'window_tracker', 'contour_tracker'])
def test_no_id_comes_back_when_a_node_is_configured_again(ros, name):
    """Others know the tracks and markers of before: a locator, RViz."""
    image = np.random.default_rng(0).integers(0, 255, (120, 160, 3), np.uint8)
    rows = np.zeros(1, DETECTION)
    rows['u'] = rows['v'] = rows['area'] = 50.0
    options = {'targets': '[40.0, 40.0, 40.0, 40.0]'} if name != 'tracker' else {}
    ros.start(name, autostart='false', **options)
    topic, kind = ('detections', PointCloud2) if name == 'tracker' else (PICTURES, Image)
    publisher = ros.node.create_publisher(kind, topic, 10)
    tracks, markers = ros.listen(PointCloud2, 'tracks'), ros.listen(MarkerArray, 'tracks/markers')
    for k in range(2):
        for transition in (CONFIGURE, ACTIVATE):
            assert change(ros, name, transition), ros.outputs()
        assert ros.spin(lambda: publisher.get_subscription_count() == 1), ros.outputs()
        assert ros.spin(lambda: ros.node.count_publishers('tracks/markers') == 1), ros.outputs()
        ros.settle()
        stamp = 10**18 + k * 40_000_000
        publisher.publish(
            cloud_of_detections(Detections(rows, stamp))
            if name == 'tracker'
            else image_of_frame(Frame(image, stamp=stamp))
        )
        assert ros.spin(lambda k=k: len(tracks) == len(markers) == k + 1), ros.outputs()
        assert tracks_of_cloud(tracks[k]).rows['track_id'].tolist() == [k + 1]
        for transition in (DEACTIVATE, CLEAN_UP):
            assert change(ros, name, transition), ros.outputs()
        assert ros.spin(lambda: publisher.get_subscription_count() == 0), ros.outputs()
    assert markers[1].markers[0].action == Marker.DELETEALL
