"""The launch files under the real ``ros2 launch``, where it is."""

import contextlib
import os
from pathlib import Path
import signal
import sys

from nav_msgs.msg import Odometry
import pytest
from rcl_interfaces.srv import GetParameters
from sensor_msgs.msg import Image
from sensor_msgs.msg import PointCloud2
from support.paths import ROOT
from support.ros_domain import executable

for module in ('launch_ros', 'launch_xml', 'ros2launch'):
    pytest.importorskip(module, reason='no ros2 launch here')

NODES = ('camera', 'detector', 'tracker', 'overlay', 'window_tracker', 'contour_tracker',
         'locator', 'follower', 'simulator')  # fmt: skip
SOURCE = 'scene:single?width=320&height=240'
SCENE = f'/**/camera:\n  ros__parameters:\n    source: {SOURCE}\n    loop: true\n'
ROS2 = 'import sys; from ros2cli.cli import main; sys.exit(main())'


@pytest.fixture
def launch(ros, tmp_path, monkeypatch):
    """Starts a launch file of the package, installed as ``ros2 launch`` expects it."""
    share, lib = tmp_path / 'share', tmp_path / 'lib' / 'colortrack_ros'
    index = share / 'ament_index' / 'resource_index' / 'packages'
    for folder in (share / 'colortrack_ros', index, lib):
        folder.mkdir(parents=True)
    (index / 'colortrack_ros').touch()
    for name in ('launch', 'params'):
        (share / 'colortrack_ros' / name).mkdir()
        for file in (ROOT / name).iterdir():
            (share / 'colortrack_ros' / name / file.name).symlink_to(file)
    for name in NODES:
        (lib / name).symlink_to(executable(name))
    paths = [str(tmp_path), os.environ.get('AMENT_PREFIX_PATH', sys.prefix)]
    monkeypatch.setenv('AMENT_PREFIX_PATH', os.pathsep.join(filter(None, paths)))
    monkeypatch.setenv('ROS_LOG_DIR', str(tmp_path / 'log'))

    def start(file, *arguments):
        command = [sys.executable, '-c', ROS2, 'launch', 'colortrack_ros', file, *arguments]
        return ros.start_command('launch', command)

    return start


def params(tmp_path):
    path = tmp_path / 'scene.yaml'
    path.write_text(SCENE)
    return f'params_file:={path}'


def names(ros):
    return set(ros.node.get_fully_qualified_node_names()) - {'/test'}


def pid_of(path):
    """Of a process that a launch file has started, by its executable."""
    for process in Path('/proc').glob('[0-9]*'):
        with contextlib.suppress(OSError):
            if str(path).encode() in (process / 'cmdline').read_bytes().split(b'\0'):
                return int(process.name)
    raise AssertionError(f'{path} does not run')


@pytest.mark.parametrize(
    'file', ['colortrack.launch.xml', 'with_driver.launch.py', 'world.launch.xml']
)
def test_every_argument_is_described(launch, file):
    process = launch(file, '--show-args')
    assert process.end() == 0, process.output
    blocks = process.output.partition('):\n')[2].split("\n    '")
    assert len(blocks) > 5
    for block in blocks[1:]:
        name, description, default = (line.strip() for line in block.strip().splitlines()[:3])
        assert len(description) > 20, name
        assert default.startswith('(default: ')


def test_the_default_shows_tracks_for_as_long_as_it_runs(ros, launch):
    process = launch('colortrack.launch.xml')
    tracks = ros.listen(PointCloud2, 'tracks')
    assert ros.spin(lambda: any(m.width for m in tracks)), process.output
    assert ros.spin(lambda: names(ros) == {'/camera', '/detector', '/tracker'}), names(ros)
    request = GetParameters.Request(names=['loop'])
    assert ros.call(GetParameters, 'camera/get_parameters', request).values[0].bool_value
    assert process.stop(signal.SIGINT) == 0, process.output


def test_a_driver_of_ones_own_a_namespace_and_a_node_that_dies(ros, launch, tmp_path):
    ros.start('camera', '-r', '__ns:=/front', source=SOURCE, loop='true')
    process = launch(
        'colortrack.launch.xml', 'camera:=false', 'image_topic:=/front/camera/image_raw',
        'camera_info_topic:=/front/camera/camera_info', 'namespace:=robot1', 'overlay:=true',
        'respawn:=true', 'log_level:=warn', params(tmp_path),
    )  # fmt: skip
    tracks = ros.listen(PointCloud2, 'robot1/tracks')
    pictures = ros.listen(Image, 'robot1/overlay/image_raw')
    assert ros.spin(lambda: any(m.width for m in tracks) and bool(pictures)), process.output
    ours = {f'/robot1/{name}' for name in ('detector', 'tracker', 'overlay')}
    assert ros.spin(lambda: names(ros) == {'/front/camera', *ours}), names(ros)
    assert 'takes /front/camera/image_raw' not in process.output  # an INFO line
    os.kill(pid_of(tmp_path / 'lib' / 'colortrack_ros' / 'detector'), signal.SIGKILL)
    process.wait_for('process has died')
    ros.spin(lambda: False, 0.5)
    tracks.clear()
    assert ros.spin(lambda: len(tracks) > 3), process.output


@pytest.mark.parametrize('tracker', ['window', 'contour'])
def test_another_tracker_without_colors_in_simulated_time(ros, launch, tmp_path, tracker):
    process = launch(
        'colortrack.launch.xml', f'tracker:={tracker}', 'detector:=false', 'use_sim_time:=true',
        params(tmp_path),
    )  # fmt: skip
    node = f'/{tracker}_tracker'
    assert ros.spin(lambda: names(ros) == {'/camera', node}), process.output
    request = GetParameters.Request(names=['use_sim_time'])
    assert ros.call(GetParameters, f'{node}/get_parameters', request).values[0].bool_value


def test_the_example_with_a_driver_tracks_what_it_publishes(ros, launch, tmp_path):
    process = launch(
        'with_driver.launch.py',
        params(tmp_path).replace('params_file', 'driver_params'),
        'namespace:=front',
    )
    tracks = ros.listen(PointCloud2, 'front/tracks')
    assert ros.spin(lambda: any(m.width for m in tracks)), process.output
    ours = {f'/front/{name}' for name in ('camera', 'detector', 'tracker')}
    assert ros.spin(lambda: names(ros) == ours), names(ros)


def test_a_robot_of_ones_own_with_its_topics_in_simulated_time(ros, launch):
    process = launch(
        'world.launch.xml', 'simulator:=false', 'image_topic:=/front/image_raw',
        'camera_info_topic:=/front/camera_info', 'odometry_topic:=/wheels/odom',
        'use_sim_time:=true', 'namespace:=robot1',
    )  # fmt: skip
    ours = {f'/robot1/{name}' for name in ('detector', 'tracker', 'locator', 'follower')}
    assert ros.spin(lambda: names(ros) == ours), process.output
    # detector and tracker take the size of the pictures, the latter also the lens
    takers = {'/front/image_raw': 1, '/front/camera_info': 4, '/wheels/odom': 3}
    assert ros.spin(
        lambda: all(ros.node.count_subscribers(topic) == n for topic, n in takers.items())
    ), {topic: ros.node.count_subscribers(topic) for topic in takers}
    request = GetParameters.Request(names=['use_sim_time'])
    assert ros.call(GetParameters, 'robot1/follower/get_parameters', request).values[0].bool_value


def test_the_frames_of_one_of_several_robots_have_its_prefix(ros, launch):
    process = launch('world.launch.xml', 'namespace:=r1', 'frame_prefix:=r1/')
    frames = {
        'simulator': ['fixed_frame', 'base_frame', 'frame_id'],
        'tracker': ['fixed_frame', 'base_frame'],
        'locator': ['fixed_frame', 'base_frame', 'target_frame'],
        'follower': ['fixed_frame', 'base_frame'],
    }
    assert ros.spin(lambda: len(names(ros)) == 5), process.output
    for node, parameters in frames.items():
        request = GetParameters.Request(names=parameters)
        values = ros.call(GetParameters, f'r1/{node}/get_parameters', request).values
        assert all(value.string_value.startswith('r1/') for value in values), node
    odometry = ros.listen(Odometry, 'r1/odom')
    locations = ros.listen(PointCloud2, 'r1/locations')
    assert ros.spin(lambda: odometry and any(m.width for m in locations)), process.output
    assert odometry[-1].header.frame_id == locations[-1].header.frame_id == 'r1/odom'
