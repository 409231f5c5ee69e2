import subprocess
import sys

import pytest

from colortrack_ros.replay.params_file import namespaces_of
from colortrack_ros.replay.params_file import read_assignment
from colortrack_ros.replay.params_file import read_params_file

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
    node = f'{namespace}/detector'
    assert {g.name: g.value for g in read_params_file(path) if g.is_for(node)} == expected


def test_an_assignment_is_for_all_nodes_or_for_one():
    (everywhere, one) = map(read_assignment, ('min_area:=30', 'tracker:max_dt:=1e-1'))
    assert everywhere[1:] == ('min_area', 30)
    assert everywhere.is_for('/detector')
    assert everywhere.is_for('/a/b/tracker')
    assert one[1:] == ('max_dt', 0.1)
    assert one.is_for('/tracker')
    assert not one.is_for('/detector')


def test_namespaces_are_those_that_name_a_node(tmp_path):
    path = tmp_path / 'params.yaml'
    path.write_text(FILES['patterns'])
    given = read_params_file(path)
    assert namespaces_of(given, ['detector']) == {'/', '/ns'}
    assert namespaces_of(given, ['tracker']) == set()


@pytest.mark.parametrize('text', ['', 'a', '- 1', 'a: 1', '/**:\n  ros__parameters: 3', '{', '\t'])
def test_what_is_no_file_of_parameters_is_refused_with_a_reason(tmp_path, text):
    path = tmp_path / 'params.yaml'
    path.write_text(text)
    with pytest.raises(ValueError, match=r'params\.yaml: not a file of parameters'):
        read_params_file(path)


@pytest.mark.parametrize('text', ['', 'a', ':=3', 'node::=3', 'a:=', 'a:=[', 'a:={b: 1}'])
def test_what_is_no_assignment_is_refused_with_a_reason(text):
    with pytest.raises(ValueError, match=r'expected|a:='):
        read_assignment(text)
