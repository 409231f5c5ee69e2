"""The files of params/: values, security policies, analyzers."""

from functools import partial
import re
from xml.etree import ElementTree

from parameter_pages import NODES
from parameter_pages import SETUPS
import pytest
from support.paths import ROOT
from support.pipeline import flat
import yaml

from colortrack_ros.node_kit.diagnostics import TASK
from colortrack_ros.parameters import build

PARAMS = sorted((ROOT / 'params').glob('*.yaml'))
OTHERS = {'analyzers', 'following_server', 'lifecycle_manager_following'}
"""Nodes of diagnostic_aggregator and Nav2 that files of params are for as well."""
BUILD = {name: partial(build, setup) for name, setup in SETUPS.items()}


@pytest.mark.parametrize('path', PARAMS, ids=lambda p: p.name)
def test_every_value_in_a_params_file_is_accepted(path):
    for node, content in yaml.safe_load(path.read_text()).items():
        name = node.removeprefix('/**/')
        if name in OTHERS:
            continue
        table = NODES[name]
        given = flat(content['ros__parameters'])
        values, refused = table.consistent(given, BUILD[name])
        assert refused == {}
        assert {k: values[k] for k in given} == given


def test_the_default_params_file_holds_the_defaults_and_the_scene():
    given = yaml.safe_load((ROOT / 'params' / 'colortrack.yaml').read_text())
    for node, content in given.items():
        table = NODES[node.removeprefix('/**/')]
        values = flat(content['ros__parameters'])
        changed = {k: v for k, v in values.items() if table.defaults(values)[k] != v}
        defaults = {k: v for k, v in values.items() if table.find(k).default == v}
        assert changed == {}
        assert set(values) - set(defaults) <= {'source', 'loop', 'red.rgb'}


OPTIONAL_TOPICS = {
    'window_tracker': {'detections'}, 'contour_tracker': {'detections'},
    'overlay': {'tracks/outlines'},
}  # fmt: skip
"""Topics without a default, under the name that the pages give them."""


@pytest.mark.parametrize('node', NODES)
def test_the_security_policy_gives_each_node_its_own_topics_and_no_others(node):
    enclaves = ElementTree.parse(ROOT / 'params' / 'sros2_policy.xml').iter('enclave')
    (own,) = [e for e in enclaves if e.get('path') == f'/colortrack/{node}']
    allowed = {topic.text for topic in own.iter('topic')}
    topics = {s.default for n, s in NODES[node].specs.items() if n.endswith('_topic') and s.default}
    if node == 'camera' or 'image_transport' in NODES[node].specs:
        topics.add('camera/image_raw/compressed')
    assert allowed == topics | OPTIONAL_TOPICS.get(node, set())


def test_the_security_policy_gives_the_pipeline_what_its_three_nodes_have():
    tree = ElementTree.parse(ROOT / 'params' / 'sros2_policy.xml')
    profiles = {
        enclave.get('path').rpartition('/')[2]: {
            profile.get('node'): ElementTree.tostring(profile).strip()
            for profile in enclave.iter('profile')
        }
        for enclave in tree.iter('enclave')
    }
    setup = (ROOT / 'setup.py').read_text().partition('EXECUTABLES')[2].partition('}')[0]
    executables = set(re.findall(r"'(\w+)': '(?:nodes|tools|replay|tuner)\.", setup))
    assert executables - {'evaluate', 'replay', 'tune'} == set(profiles)  # which send nothing
    names = ('camera', 'detector', 'tracker')
    assert profiles['pipeline'] == {name: profiles[name][name] for name in names}


def test_the_analyzers_find_the_status_of_every_node():
    content = yaml.safe_load((ROOT / 'params' / 'diagnostics.yaml').read_text())
    groups = content['analyzers']['ros__parameters']['color_tracking']['analyzers']
    texts = [text for group in groups.values() for text in group['contains']]
    for node in NODES:
        assert any(text in f'robot1/{node}: {TASK}' for text in texts), node
