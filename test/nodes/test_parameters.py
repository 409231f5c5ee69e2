"""What holds for every parameter of every node."""

import re

from parameter_pages import NODES
import pytest

from colortrack_ros.node_kit.live_parameters import descriptor_of
from colortrack_ros.nodes.follower import FollowerSetup
from colortrack_ros.nodes.locator import LocatorSetup
from colortrack_ros.nodes.simulator import SimulatorSetup
from colortrack_ros.nodes.tracker import TrackerSetup
from colortrack_ros.parameters import build
from colortrack_ros.parameters import DOCUMENT
from colortrack_ros.parameters import EXPERT
from colortrack_ros.parameters import ParameterTable
from colortrack_ros.parameters import USER

PARAMETERS = {
    f'{node} {name}': spec
    for node, table in NODES.items()
    for name, spec in (table.specs | {f'NAME.{each}': s for each, s in table.each.items()}).items()
}


def test_no_node_is_forgotten():
    assert len(NODES) == 9
    assert len(PARAMETERS) > 150


@pytest.mark.parametrize('spec', PARAMETERS.values(), ids=PARAMETERS)
def test_a_parameter_is_described_in_sentences(spec):
    assert spec.description[0].isupper()
    assert spec.description.endswith('.')
    assert len(spec.description.split()) > 2
    assert '  ' not in spec.description


@pytest.mark.parametrize('spec', PARAMETERS.values(), ids=PARAMETERS)
def test_letters_and_numbers_of_the_documents_are_of_who_has_them(spec):
    """`the erosion (2.4)`, `the window (N)`: sigma_s stands in a formula beside it."""
    assert spec.audience == DOCUMENT or not re.search(
        r'\((\d\.\d+|[A-Z](_\w+)?|tau|sigma_w)\)', spec.description
    )


@pytest.mark.parametrize('spec', PARAMETERS.values(), ids=PARAMETERS)
def test_a_parameter_says_for_whom_it_is(spec):
    ends = {
        USER: '',
        EXPERT: ' For experts.',
        DOCUMENT: ' Only to reproduce a document.',
    }
    told = descriptor_of(spec).description
    assert told.startswith(spec.description)
    assert told.endswith(ends[spec.audience])
    assert ('For experts' in told) == (spec.audience == EXPERT)


@pytest.mark.parametrize('spec', PARAMETERS.values(), ids=PARAMETERS)
def test_a_default_and_both_ends_of_the_range_are_allowed(spec):
    if not spec.optional:
        assert spec.check(spec.name, spec.default) == spec.default
    for bound in spec.limits or ():
        one = spec.kind(bound)
        spec.check(spec.name, [one] * (spec.length or 1) if spec.many else one)
    if spec.limits:
        assert spec.limits[0] < spec.limits[1]


@pytest.mark.parametrize(
    ('name', 'value', 'reason'),
    [
        ('colors', [''], 'names that are not empty'),
        ('cameras', ['left', ''], 'names that are not empty'),
        ('cameras', ['a b'], 'the name of a topic'),
        ('cameras', ['left', 'left'], 'each name once'),
    ],
)
def test_names_that_cannot_be_one_are_refused_and_leave_the_default(name, value, reason):
    """An empty name ended the locator with a traceback."""
    table = ParameterTable.of(LocatorSetup)
    values, refused = table.consistent({name: value}, lambda every: build(LocatorSetup, every))
    assert reason in refused[name]
    assert values.get(name) != value
    for each in values:
        table.find(each)


IN_DEGREES = [0.1, 0.0, 0.5, 0.0, 15.0, 0.0]


@pytest.mark.parametrize(
    ('setup', 'given', 'refused'),
    [
        (LocatorSetup, {'camera_pose': IN_DEGREES}, 'camera_pose'),
        (TrackerSetup, {'camera_pose': IN_DEGREES}, 'camera_pose'),
        (SimulatorSetup, {'camera_pose': IN_DEGREES}, 'camera_pose'),
        (
            LocatorSetup, {'cameras': ['left'], 'left.camera_pose': IN_DEGREES},
            'left.camera_pose',
        ),
    ],
)  # fmt: skip
def test_angles_that_can_only_be_degrees_are_refused(setup, given, refused):
    """Of 15 rad, taken as 2.4, things would be behind the robot."""
    table = ParameterTable.of(setup)
    reasons = table.consistent(given, lambda every: build(setup, every))[1]
    assert list(reasons) == [refused]
    assert 'are these degrees?' in reasons[refused]


@pytest.mark.parametrize('frame', ['odom', 'base_footprint', 'optical'])
def test_a_target_has_no_frame_that_is_one_of_the_robot(frame):
    """As base_link it moved the robot to where the target is, for all that look it up in TF."""
    given = {'target_frame': frame, 'base_frame': 'base_footprint', 'camera_frame': 'optical'}
    assert locator_setup(given | {'pose_source': 'tf'}).hijacks == frame
    assert not locator_setup(given).hijacks
    assert not locator_setup(given | {'pose_source': 'tf', 'target_frame': 'target'}).hijacks


def locator_setup(given):
    return build(LocatorSetup, ParameterTable.of(LocatorSetup).defaults(given))


@pytest.mark.parametrize('setup', [LocatorSetup, FollowerSetup])
def test_an_id_is_selected_without_quotes_as_well(setup):
    """As ``ros2 param set /locator select 7`` gives it."""
    table = ParameterTable.of(setup)
    values, refused = table.consistent({'select': 7}, lambda every: build(setup, every))
    assert (values['select'], refused) == ('7', {})
