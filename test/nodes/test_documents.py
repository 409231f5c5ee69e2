from dataclasses import fields
from xml.etree import ElementTree

import pytest
from support import readme_tables
from support.paths import ROOT
from support.pipeline import flat
import yaml

from colortrack_ros.contours import ContourConfig
from colortrack_ros.data import DETECTION
from colortrack_ros.data import TRACK
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.nodes import camera_parameters
from colortrack_ros.nodes import contour_tracker_parameters
from colortrack_ros.nodes import detector_parameters
from colortrack_ros.nodes import tracker_parameters
from colortrack_ros.nodes import window_tracker_parameters
from colortrack_ros.tracking import TrackerConfig
from colortrack_ros.windows import WindowConfig

PARAMS = sorted((ROOT / 'params').glob('*.yaml'))
BUILD = {
    'camera': camera_parameters.build,
    'detector': detector_parameters.build,
    'tracker': tracker_parameters.build,
    'overlay': dict,
    'window_tracker': window_tracker_parameters.build,
    'contour_tracker': contour_tracker_parameters.build,
}


@pytest.mark.parametrize('path', PARAMS, ids=lambda p: p.name)
def test_every_value_in_a_params_file_is_accepted(path):
    for node, content in yaml.safe_load(path.read_text()).items():
        name = node.removeprefix('/**/')
        table = readme_tables.NODES[name]
        given = flat(content['ros__parameters'])
        values, refused = table.consistent(given, BUILD[name])
        assert refused == {}
        assert {k: values[k] for k in given} == given


def test_the_default_params_file_holds_the_defaults_and_the_scene():
    given = yaml.safe_load((ROOT / 'params' / 'colortrack.yaml').read_text())
    for node, content in given.items():
        table = readme_tables.NODES[node.removeprefix('/**/')]
        values = flat(content['ros__parameters'])
        changed = {k: v for k, v in values.items() if table.defaults(values)[k] != v}
        defaults = {k: v for k, v in values.items() if table.find(k).default == v}
        assert changed == {}
        assert set(values) - set(defaults) <= {'source', 'red.rgb'}


def test_the_tables_in_the_readme_are_those_of_the_nodes():
    text = readme_tables.README.read_text()
    for node in readme_tables.NODES:
        assert text.count(f'<!-- parameters of {node} -->') == 2
    assert readme_tables.written(text) == text, 'run `make docs`'


def test_the_readme_names_every_field_of_the_messages():
    text = readme_tables.README.read_text()
    assert [n for n in (*DETECTION.names, *TRACK.names) if f'`{n}`' not in text] == []


def test_every_setting_of_a_room_is_a_parameter():
    names = {field.name for field in fields(TrackerConfig)}
    assert names <= set(tracker_parameters.TABLE.specs)
    names = {field.name for field in fields(DetectorConfig)}
    assert names <= set(detector_parameters.TABLE.specs)
    names = {field.name for field in fields(WindowConfig)}
    assert names <= set(window_tracker_parameters.TABLE.specs)
    names = {field.name for field in fields(ContourConfig)}
    assert names <= set(contour_tracker_parameters.TABLE.specs)


@pytest.mark.parametrize(
    'node', ['detector', 'tracker', 'camera', 'window_tracker', 'contour_tracker']
)
def test_the_ranges_of_a_table_are_accepted_by_its_room(node):
    table = readme_tables.NODES[node]
    for name, spec in table.specs.items():
        assert spec.description.endswith('.')
        for bound in (spec.minimum, spec.maximum):
            if bound is None:
                continue
            several = isinstance(spec.default, list | tuple)
            one = type(spec.default[0] if several else spec.default)(bound)
            value = [one] * len(spec.default) if several else one
            reasons = table.consistent({name: value}, BUILD[node])[1].values()
            # refused alone only for what another parameter says
            assert all('expected' in reason for reason in reasons), reasons


@pytest.mark.parametrize('node', readme_tables.NODES)
def test_the_security_policy_gives_each_node_its_own_topics_and_no_others(node):
    enclaves = ElementTree.parse(ROOT / 'params' / 'sros2_policy.xml').iter('enclave')
    (own,) = [e for e in enclaves if e.get('path') == f'/colortrack/{node}']
    allowed = {topic.text for topic in own.iter('topic')}
    topics = {
        s.default
        for n, s in readme_tables.NODES[node].specs.items()
        if n.endswith('_topic') and s.default
    }
    if node == 'camera' or 'image_transport' in readme_tables.NODES[node].specs:
        topics.add('camera/image_raw/compressed')
    assert allowed == topics
