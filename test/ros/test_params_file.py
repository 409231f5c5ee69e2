"""Files of parameters and assignments mean to replay what they mean to a node."""

import os
import subprocess
import sys
import threading

from parameter_pages import NODES
import pytest

from colortrack_ros.node_kit.runtime import StartError
from colortrack_ros.parameters.owners import is_owner
from colortrack_ros.parameters.owners import owners_in
from colortrack_ros.parameters.owners import untaken
from colortrack_ros.replay.command import replay
from colortrack_ros.replay.ros_arguments import AskedNode
from colortrack_ros.replay.ros_arguments import DISCOVERY
from colortrack_ros.replay.ros_arguments import namespaces_of
from colortrack_ros.replay.ros_arguments import ros_context
from colortrack_ros.replay.setup import parse
from colortrack_ros.replay.setup import read_setup

SCALARS = [
    '1e-6', '010', '08', '1:30', 'on', 'n', 'tRue', '~', 'null', '0x10', '2024-01-01', "'3'",
    '"on"', '[1, 2]', '[1e-3, 2.0]', '[on, off]', '1.', '.5', '-.5e3', '.inf', 'inf', '1_000',
    '+3', '0b11', '1e5', 'hello world', "''", '[a, b]', '-7', '0',
]  # fmt: skip

FILES = {
    'patterns': """
/**:
  ros__parameters:
    a: 1
    z: 1
/**/detector:
  ros__parameters:
    a: 2
detector:
  ros__parameters:
    a: 9
    c: 3
/ns/detector:
  ros__parameters:
    d: 3
/*/detector:
  ros__parameters:
    e: 3
ns:
  detector:
    ros__parameters:
      f: 3
      k:
        l: 2
/ns/*:
  ros__parameters:
    g: 1
/**/tracker:
  ros__parameters:
    h: 1
""",
    'the later one': """
detector:
  ros__parameters:
    a: 9
/**/detector:
  ros__parameters:
    a: 2
    b: 1
/**:
  ros__parameters:
    a: 1
    b: 2
""",
    'scalars': '/**:\n  ros__parameters:\n'
    + ''.join(f'    p{k}: {text}\n' for k, text in enumerate(SCALARS)),
}

OF_ANOTHER = """
detector:
  ros__parameters:
    min_area: 77
/r2/detector:
  ros__parameters:
    min_area: 78
"""

PROGRAM = """
import sys
import rclpy
from rclpy.node import Node
rclpy.init(args=['--ros-args', '--params-file', sys.argv[1]])
node = Node('detector', namespace=sys.argv[2])
print({name: given.value for name, given in node._parameter_overrides.items()})
"""


@pytest.mark.parametrize('name', FILES)
@pytest.mark.parametrize('namespace', ['', '/ns'])
def test_a_file_means_what_it_means_to_a_node(tmp_path, name, namespace):
    path = tmp_path / 'params.yaml'
    path.write_text(FILES[name])
    command = [sys.executable, '-c', PROGRAM, str(path), namespace]
    text = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    expected = eval(text, {'inf': float('inf')})
    with ros_context(['--params-file', str(path)]) as context:
        assert AskedNode('detector', namespace, context).given == expected


OWNERS = (
    '/**', '/*', 'detector', '/detector', '/**/detector', '/*/detector', '/ns/*', '/ns/**',
    '/ns/detector', '/ns/**/detector', '/*/b/detector', '/ns/tracker', '/n',
)  # fmt: skip


@pytest.mark.parametrize('owner', OWNERS)
def test_nodes_are_meant_by_the_rules_of_rcl(tmp_path, owner):
    path = tmp_path / 'params.yaml'
    path.write_text(f'{owner}:\n  ros__parameters:\n    a: 1\n')
    (read,) = owners_in(path.read_text())
    with ros_context(['--params-file', str(path)]) as context:
        for namespace in ('', '/ns', '/ns/b', '/other/b'):
            given = AskedNode('detector', namespace, context).given
            assert is_owner(read, f'{namespace}/detector') == (given == {'a': 1}), namespace


def test_a_file_for_another_namespace_is_told_by_the_node(ros, tmp_path):
    path = tmp_path / 'params.yaml'
    path.write_text('/**:\n  ros__parameters:\n    max_late: 0.1\n' + OF_ANOTHER)
    owners = owners_in(path.read_text())
    assert untaken(owners, '/detector') == untaken(owners, '/r/tracker') == ''
    node = ros.start('detector', '-r', '__ns:=/r', '--params-file', str(path))
    node.wait_for('has parameters for /detector, /r2/detector, but none by the name /r/detector')
    node.wait_for('under /**/detector they are for any namespace')


@pytest.mark.parametrize(
    ('given', 'node', 'told'),
    [
        ('/**/detecter', '/detector', True),
        ('detector_node', '/r/detector', True),
        ('/**/window_tracer', '/window_tracker', True),
        ('detecter\n/**/detector', '/detector', False),
        ('/**', '/detector', False),
        ('/r2/tracker1', '/tracker2', False),
        ('tracker_2', '/tracker', False),
        ('/**/line_detector', '/detector', False),
        ('tracker', '/ball_tracker', True),
        *((kind, f'/{node}', False) for node in NODES for kind in NODES),
    ],
)
def test_a_name_that_is_nearly_the_nodes_is_told(given, node, told):
    owners = ['/' + name.lstrip('/') for name in given.split('\n')]
    assert ('is that misspelled?' in untaken(owners, node)) == told


def test_a_misspelled_name_is_told_by_node_and_replay(ros, tmp_path, capsys):
    path = tmp_path / 'params.yaml'
    path.write_text('/**/detecter:\n  ros__parameters:\n    min_area: 77\n')
    node = ros.start('detector', '--params-file', str(path))
    told = f'{path}: has parameters for /**/detecter, but none by the name '
    node.wait_for(f'{told}/detector: is that misspelled?')
    asked = ['scene:none', '--params-file', str(path)]
    assert replay(asked, threading.Event()) == 1
    assert f'{told}detector: is that misspelled?' in capsys.readouterr().err


def setup_of(*options):
    return read_setup(parse(['in', *options]), from_bag=False)


def test_an_assignment_is_for_all_nodes_or_for_one():
    setup = setup_of('-p', 'max_late:=1.5', '-p', 'tracker:reorder_window:=1e-1')
    intake = setup.detector.intake.order
    order = setup.tracker.order
    assert (intake.max_late, intake.reorder_window) == (1.5, 0.0)
    assert (order.max_late, order.reorder_window) == (1.5, 0.1)


def test_a_value_for_nodes_of_any_name_may_be_meant_for_another_kind(tmp_path):
    path = tmp_path / 'params.yaml'
    path.write_text('/**:\n  ros__parameters:\n    min_area: 77\n')
    assert setup_of('--params-file', str(path)).detector.config.min_area == 77
    with pytest.raises(StartError, match='min_area: no such parameter'):
        setup_of('--params-file', str(path), '-p', 'tracker:min_area:=78')


def test_the_command_line_overrides_the_files(tmp_path):
    path = tmp_path / 'params.yaml'
    path.write_text('detector:\n  ros__parameters:\n    min_area: 77\n')
    setup = setup_of('-p', 'detector:min_area:=78', '--params-file', str(path))
    assert setup.detector.config.min_area == 78


def test_namespaces_are_those_that_name_a_node(tmp_path):
    path = tmp_path / 'params.yaml'
    path.write_text(FILES['patterns'])
    assert namespaces_of([path], ['detector']) == {'/', '/ns'}
    assert namespaces_of([path], ['tracker']) == set()


def test_names_are_remapped_by_the_rules_of_ros():
    options = ['-r', '__ns:=/a/b', '-r', 'tracks:=~/all', '-r', 'tracker:detections:=/blobs']
    topics = setup_of(*options).topics
    assert topics == {
        'image': '/a/b/camera/image_raw',
        'detections': '/blobs',
        'tracks': '/a/b/tracker/all',
        'outlines': '',
        'camera_info': '/a/b/camera/camera_info',
        'markers': '/a/b/tracks/markers',
        'odometry': '',
    }


def test_odometry_is_a_topic_where_the_tracker_asks_for_it():
    asked = ['-p', 'tracker:ego_motion:=odometry', '-r', 'odom:=wheels']
    assert setup_of(*asked).topics['odometry'] == '/wheels'


def test_the_environment_is_left_as_it_was(monkeypatch):
    for before in ('SUBNET', None):
        if before is None:
            monkeypatch.delenv(DISCOVERY)
        else:
            monkeypatch.setenv(DISCOVERY, before)
        setup_of()
        with pytest.raises(StartError):
            setup_of('-p', 'a:=[')
        assert os.environ.get(DISCOVERY) == before


@pytest.mark.parametrize('text', ['', 'a', '- 1', 'a: 1', '/**:\n  ros__parameters: 3', '{', '\t'])
def test_what_is_no_file_of_parameters_is_refused_with_a_reason(tmp_path, text, capfd):
    path = tmp_path / 'params.yaml'
    path.write_text(text)
    with pytest.raises(StartError, match=r"params\.yaml'. Error: |params\.yaml: expected node"):
        setup_of('--params-file', str(path))
    assert capfd.readouterr().err == ''


@pytest.mark.parametrize('text', ['', 'a', ':=3', 'node::=3', 'a:=', 'a:=[', 'a:={b: 1}'])
def test_what_is_no_assignment_is_refused_with_a_reason(text):
    with pytest.raises(
        StartError, match=r"expected|a:=|Couldn't parse parameter override rule: '-p node::=3"
    ):
        setup_of('-p', text)
