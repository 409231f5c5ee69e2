"""Every parameter of every node set to what it cannot be, in YAML and at run time."""

import itertools
import math

import numpy as np
import parameter_pages
import pytest
from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.msg import ParameterType
from rcl_interfaces.msg import ParameterValue
from rcl_interfaces.srv import GetParameters
from rcl_interfaces.srv import SetParameters
from rcl_interfaces.srv import SetParametersAtomically
from rclpy.parameter import Parameter
from rclpy.parameter import parameter_value_to_python
from sensor_msgs.msg import Image
from sensor_msgs.msg import PointCloud2
from support.all_nodes import NAMES
from support.all_nodes import start_nodes
from support.all_nodes import values_taken

from colortrack_ros.data import Frame
from colortrack_ros.messages import detections_of_cloud
from colortrack_ros.messages import image_of_frame
from colortrack_ros.parameters import Spec

FAULTS = ('type', 'low', 'high', 'nan')
"""One namespace for each: a file gives every parameter of a node there a value of this kind."""

TEXT = 'a text'


def bad(spec: Spec, fault: str) -> object:
    """A value that the parameter cannot have, or None where there is none of the kind."""
    many = isinstance(spec.default, list | tuple)
    kind = spec.type_name.removeprefix('list of ')
    value: object = None
    if fault == 'type':
        value = 7.5 if spec.int_is_text else 7 if kind in ('str', 'bool') else TEXT
    elif fault == 'nan' and kind == 'float':
        value = math.nan
    elif fault == 'low' and spec.choices:
        value = 'none of them'
    elif fault == 'low' and spec.name.endswith('_topic'):
        value = 'no topic'
    elif fault == 'low' and spec.limits:
        value = type(spec.limits[0])(spec.limits[0] - 1)
    elif fault == 'high' and spec.limits:
        value = type(spec.limits[1])(spec.limits[1] * 2)
    if kind == 'float' and isinstance(value, int):
        value = float(value)
    return [value] if many and value is not None else value


def rows(node: str) -> dict[str, Spec]:
    """The parameters of a node; those of a NAME for the one that its list has by default."""
    table = parameter_pages.NODES[node]
    each = table.groups.get('colors', {})
    if each and table.specs['colors'].optional:
        each = {}  # of a list without names there is none until somebody sets it
    return table.specs | {f'red.{name}': spec for name, spec in each.items()}


def faults(node: str, fault: str) -> dict[str, object]:
    found = {name: bad(spec, fault) for name, spec in rows(node).items()}
    return {name: value for name, value in found.items() if value is not None}


def of(reasons: str, name: str) -> str:
    """The line in which a parameter is refused."""
    return next((line for line in reasons.splitlines() if f' {name}: ' in f' {line}'), '')


def tells_all(reason: str, spec: Spec, value: object) -> bool:
    """Whether the reason names what was given and what was expected, in our words or in rclpy's."""
    one = value[0] if isinstance(value, list) else value
    ours = 'expected' in reason and spec.allowed_text[2:] in reason
    low, high = spec.limits or (None, None)
    theirs = all(t in reason for t in ('out of range', f'Min: {low}, Max: {high},'))
    return (ours or theirs) and any(text in reason for text in (str(one), repr(one)))


class Parameters:
    """What others do with the parameters of a node."""

    def __init__(self, ros, node: str) -> None:
        self._ros, self._node = ros, node

    def get(self, *names: str) -> list:
        request = GetParameters.Request(names=names)
        answer = self._ros.call(GetParameters, f'{self._node}/get_parameters', request)
        return [parameter_value_to_python(value) for value in answer.values]

    def set(self, values: dict[str, object]) -> list:
        parameters = [self._parameter(n, v) for n, v in values.items()]
        request = SetParameters.Request(parameters=parameters)
        return self._ros.call(SetParameters, f'{self._node}/set_parameters', request).results

    def set_together(self, values: dict[str, object]):
        parameters = [self._parameter(n, v) for n, v in values.items()]
        request = SetParametersAtomically.Request(parameters=parameters)
        name = f'{self._node}/set_parameters_atomically'
        return self._ros.call(SetParametersAtomically, name, request).result

    def _parameter(self, name: str, value: object):
        return Parameter(name, value=value).to_parameter_msg()


def test_every_bad_value_in_yaml_is_refused_with_a_reason(ros):
    unknown = {'warn_latncy': 1.0}
    kinds = [(fault, node) for fault in FAULTS for node in NAMES]
    taken, output = values_taken(ros, {f'/{f}/{n}': faults(n, f) | unknown for f, n in kinds})
    checked = 0
    for (fault, node), values in zip(kinds, taken, strict=True):
        log = '\n'.join(l for l in output.splitlines() if f'[{fault}.{node}]' in l)
        assert 'warn_latncy: no such parameter; the nearest is warn_latency' in log
        for (name, value), now in zip(faults(node, fault).items(), values[:-1], strict=True):
            spec = rows(node)[name]
            reason = of(log, name)
            assert tells_all(reason, spec, value), f'{fault} {node} {name} {value}: {log}'
            assert now == (None if spec.optional else spec.default), f'{node} {name}'
            checked += 1
    assert checked > 300
    assert 'Traceback' not in output


def test_every_bad_value_at_run_time_is_refused_with_a_reason(ros):
    process = start_nodes(ros, {f'/{node}': {} for node in NAMES})
    for node in NAMES:
        parameters = Parameters(ros, node)
        names = list(rows(node))
        before = parameters.get(*names)
        for fault in FAULTS:
            given = faults(node, fault)
            for (name, value), result in zip(given.items(), parameters.set(given), strict=True):
                spec = rows(node)[name]
                assert not result.successful, f'{node} {name} {value}'
                told = name in result.reason and (
                    spec.read_only or tells_all(result.reason, spec, value)
                )
                assert told, f'{node} {name} {value}: {result.reason}'
        unset = {name: None for name, spec in rows(node).items() if not spec.optional}
        unset = {name: None for name in unset if '.' not in name}
        for name, result in zip(unset, parameters.set(unset), strict=True):
            assert not result.successful, f'{node} {name}'
            assert name in result.reason
        assert parameters.get(*names) == before
        good = {'warn_silence': 3.0}
        for name, value in {'warn_latency': math.nan, 'queue_dept': 4}.items():
            for half in ({**good, name: value}, {name: value, **good}):
                result = parameters.set_together(half)
                assert not result.successful
                assert name in result.reason
        assert 'queue_dept: no such parameter; the nearest is queue_depth' in result.reason
        assert parameters.get(*names) == before
        assert parameters.set_together(good).successful
        assert parameters.get('warn_silence') == [3.0]
    assert process.stop() == 0, process.output
    assert 'Traceback' not in process.output


LISTS = {
    'detector': ('regions', ParameterType.PARAMETER_STRING_ARRAY),
    'window_tracker': ('targets', ParameterType.PARAMETER_DOUBLE_ARRAY),
}
"""By node, the list that may be empty, and its type."""


@pytest.mark.parametrize('way', ['in YAML', 'by -p'])
def test_an_empty_list_is_taken_on_start_and_when_the_command_line_sets_it(ros, way):
    """rcl knows no type of an empty list, and ``ros2 param set`` takes it for one of bools."""
    if way == 'in YAML':
        process = start_nodes(ros, {f'/{node}': {LISTS[node][0]: []} for node in LISTS})
    else:
        lists = [word for node, (name, _) in LISTS.items() for word in ('-p', f'{node}:{name}:=[]')]
        process = start_nodes(ros, {f'/{node}': {} for node in LISTS}, *lists)
    for node, (name, kind) in LISTS.items():
        request = GetParameters.Request(names=[name])
        taken = ros.call(GetParameters, f'{node}/get_parameters', request).values[0]
        assert (taken.type, parameter_value_to_python(taken)) == (kind, [])
    parameters = Parameters(ros, 'detector')
    corners = [0.0, 0.0, 9.0, 0.0, 9.0, 9.0]
    door = {'door.polygon': corners, 'regions': ['door']}
    assert parameters.set_together(door).successful
    assert parameters.get('regions') == [['door']]
    empty = ParameterValue(type=ParameterType.PARAMETER_BOOL_ARRAY)
    for node, (name, kind) in LISTS.items():
        request = SetParameters.Request(parameters=[ParameterMessage(name=name, value=empty)])
        (result,) = ros.call(SetParameters, f'{node}/set_parameters', request).results
        assert result.successful, result.reason
        request = GetParameters.Request(names=[name])
        taken = ros.call(GetParameters, f'{node}/get_parameters', request).values[0]
        assert (taken.type, parameter_value_to_python(taken)) == (kind, [])
    assert process.stop() == 0, process.output
    assert 'refused' not in process.output


def test_colors_set_at_run_time_count_from_the_next_frame_on_and_half_a_set_changes_nothing(ros):
    detector = ros.start('detector')
    answers = ros.listen(PointCloud2, 'detections')
    publisher = ros.node.create_publisher(Image, 'camera/image_raw', 10)
    assert ros.spin(lambda: publisher.get_subscription_count() == 1), ros.outputs()
    assert ros.spin(lambda: ros.node.count_publishers('detections') == 1), ros.outputs()
    ros.settle()
    parameters = Parameters(ros, 'detector')
    stamps = itertools.count(10**18, 40_000_000)
    picture = np.zeros((60, 80, 3), np.uint8)
    picture[10:30, 10:30] = 40, 200, 40
    picture[35:50, 40:60] = 200, 40, 40

    def found() -> list[tuple[int, int]]:
        """Color and area of what is detected in the next frame."""
        answers.clear()
        publisher.publish(image_of_frame(Frame(picture, 'bgr8', next(stamps))))
        assert ros.spin(lambda: len(answers) == 1), ros.outputs()
        rows = detections_of_cloud(answers[0]).rows
        return [(int(row['color']), int(row['area'])) for row in rows]

    assert found() == []
    green = {'colors': ['green'], 'green.rgb': [40, 200, 40], 'erosion_size': 1}
    assert parameters.set_together(green).successful
    assert found() == [(0, 400)]
    half = {'min_area': 1000, 'green.tolerance': 5.0, 'colors': ['green', 'sky']}
    result = parameters.set_together(half)
    assert (result.successful, 'sky' in result.reason) == (False, True)
    assert found() == [(0, 400)]
    assert parameters.get('min_area', 'colors') == [20, ['green']]
    results = parameters.set({'sky.lab': [32.0, 59.0, -84.0], 'colors': ['green', 'sky'], 'x': 1})
    assert [r.successful for r in results] == [True, True, False]
    assert parameters.set({'sky.tolerance': 40.0})[0].successful
    assert found() == [(0, 400), (1, 300)]
    assert parameters.set({'sky.lab': None})[0].successful is False  # it is in use
    assert found() == [(0, 400), (1, 300)]
    assert detector.stop() == 0


def test_with_strict_a_node_ends_when_a_value_is_refused_on_start(ros):
    process = ros.start('tracker', strict='true', confirm_hits=-1)
    assert process.end() == 1
    assert 'Parameter refused: confirm_hits: expected' in process.output
    assert 'strict: 1 refused on start, as said above; correct that' in process.output
    assert 'Traceback' not in process.output


@pytest.mark.parametrize(
    ('given', 'reason'),
    [
        ({'use_sim_time': 'maybe'}, "'use_sim_time' to 'maybe' of type 'STRING'"),
        ({'image_topic': 'same', 'detections_topic': 'same'}, 'topic same as Image: '),
    ],
)
def test_what_rclpy_refuses_ends_a_node_with_its_reason_in_one_line(ros, given, reason):
    process = ros.start('detector', **given)
    assert process.end() == 1
    assert 'Traceback' not in process.output
    (line,) = (line for line in process.output.splitlines() if 'FATAL' in line)
    assert reason in line
