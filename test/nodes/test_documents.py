import ast
from functools import partial
from pathlib import Path
import re
import shutil
import subprocess
import sys
from xml.etree import ElementTree

import cv2
import numpy as np
from parameter_pages import NODES
from parameter_pages import PAGE
from parameter_pages import page
from parameter_pages import SETUPS
import pytest
from support.paths import ROOT
from support.pipeline import flat
import yaml

from colortrack_ros.data import DETECTION
from colortrack_ros.data import LOCATION
from colortrack_ros.data import OUTLINE_POINT
from colortrack_ros.data import TRACK
from colortrack_ros.data import Tracks
from colortrack_ros.messages import cloud_of_tracks
from colortrack_ros.node_kit.diagnostics import TASK
from colortrack_ros.parameters import build
from colortrack_ros.replay.outputs import COLUMNS
from colortrack_ros.replay.setup import command_line
from colortrack_ros.scenes import open_scene

PARAMS = sorted((ROOT / 'params').glob('*.yaml'))
OTHERS = {'analyzers', 'following_server', 'lifecycle_manager_following'}
"""Nodes of diagnostic_aggregator and Nav2 that files of params are for as well."""
BUILD = {name: partial(build, setup) for name, setup in SETUPS.items()}

README = ROOT / 'README.md'
PAGES = [README, ROOT / 'CONTRIBUTING.md', *sorted((ROOT / 'doc').glob('*.md'))]
FENCE = re.compile(r'^( *)```(\w*)\n(.*?)^\1```$', re.MULTILINE | re.DOTALL)
POINT_TYPES = {'f8': 'FLOAT64', 'f4': 'FLOAT32', 'u4': 'UINT32', 'u1': 'UINT8'}


def blocks(path, language):
    """The code blocks of a page in a language."""
    found = FENCE.findall(path.read_text())
    return [text.replace('\n' + indent, '\n') for indent, kind, text in found if kind == language]


def prose(path):
    """A page without its code blocks."""
    return FENCE.sub('', path.read_text())


def anchor(title):
    """The anchor of a heading, as GitHub and MyST make it."""
    return re.sub(r'[^\w\- ]', '', title.lower()).replace(' ', '-')


def by_page(*pages):
    return pytest.mark.parametrize('path', pages, ids=lambda p: p.name)


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


def test_the_page_of_parameters_is_what_its_command_writes():
    assert PAGE.read_text() == page(), 'run `make docs`'


def test_the_readme_is_short():
    assert len(README.read_text().splitlines()) <= 150


@by_page(*PAGES)
def test_every_link_leads_somewhere(path):
    for target in re.findall(r'\]\(([^)\s]+)\)', prose(path)):
        if target.startswith('http'):
            continue
        name, _, title = target.partition('#')
        linked = (path.parent / name).resolve() if name else path
        assert linked.exists(), target
        assert linked.is_relative_to(ROOT), target
        headings = re.findall(r'^#+ (.*)$', linked.read_text() if title else '', re.MULTILINE)
        assert not title or title in [anchor(heading) for heading in headings], target


@by_page(ROOT / 'doc' / 'messages.md')
def test_the_page_of_messages_has_every_field_with_its_type_and_offset(path):
    sections = re.split(r'^## ', path.read_text(), flags=re.MULTILINE)
    for name, layout in (
        ('Detections', DETECTION),
        ('Tracks', TRACK),
        ('Outlines', OUTLINE_POINT),
        ('Locations', LOCATION),
    ):
        (section,) = (text for text in sections if text.startswith(f'{name}\n'))
        rows = re.findall(r'^\| `(\w+)` \| (.*?) \| (\d+) \|', section, re.MULTILINE)
        expected = []
        for field in layout.names:
            kind, offset = layout.fields[field][:2]
            several = f' × {kind.itemsize // kind.base.itemsize}' if kind.shape else ''
            expected.append((field, POINT_TYPES[kind.base.str[1:]] + several, str(offset)))
        assert rows == expected
        assert f'{layout.itemsize} bytes' in section


@by_page(*PAGES)
def test_every_name_in_a_page_is_one_of_the_package(path):
    """snake_case words in backticks, and what is set by `name: value`."""
    known = {name for table in NODES.values() for name in (*table.specs, *table.each)}
    code = '\n'.join(
        file.read_text()
        for file in ROOT.rglob('*.*')
        if file.suffix in ('.py', '.yaml', '.xml', '.xsd')
        and file.relative_to(ROOT).parts[0]
        in ('colortrack_ros', 'test', 'benchmark', 'params', 'launch', 'setup.py', 'package.xml')
        and file.name != 'test_documents.py'
    )
    words = set(re.findall(r'\w+', code)) | known | set(COLUMNS)
    for text in re.findall(r'`([^`\n]+)`', prose(path)):
        if setting := re.fullmatch(r'(\w+): \S+', text):
            assert setting[1] in known | {'use_sim_time', 'ns'}, text
        if re.fullmatch(r'(?!my_)[a-z]+(_[a-z0-9]+)+', text):
            assert text in words, text


@by_page(*PAGES)
def test_every_parameter_in_yaml_is_accepted(path):
    for text in blocks(path, 'yaml'):
        for node, content in yaml.safe_load(text).items():
            name = node.removeprefix('/**/')
            given = {
                key: value
                for key, value in flat(content['ros__parameters']).items()
                if key != 'use_sim_time' and not key.startswith('qos_overrides')
            }
            assert NODES[name].consistent(given, BUILD[name])[1] == {}


@by_page(*PAGES)
def test_shell_commands_name_what_there_is(path):
    makefile = (ROOT / 'Makefile').read_text()
    setup = (ROOT / 'setup.py').read_text()
    replay = command_line().format_help()
    inline = re.findall(r'`([^`]+)`', prose(path))
    for line in [*'\n'.join(blocks(path, 'sh') + blocks(path, 'console')).splitlines(), *inline]:
        for target in re.findall(r'\bmake ([a-z][\w./-]*)', line):
            assert re.search(rf'^(\S+ )*{re.escape(target)}( \S+)*:', makefile, re.MULTILINE), line
        for name in re.findall(r'ros2 run colortrack_ros (\w+)', line):
            assert f"'{name}':" in setup, line
        for file in re.findall(
            r'(?<![\w/~])(?:python )?((?:test|benchmark|params|doc|colortrack_ros)/\S+\.\w+)', line
        ):
            assert (ROOT / file).exists(), line
        if re.match(r'(\$ )?(ros2 run colortrack_ros )?replay ', line):
            for option in re.findall(r' (--[a-z-]+)', line):
                assert option in replay or option == '--ros-args', line


def test_the_page_of_the_architecture_names_every_room_and_no_other():
    page = ROOT / 'doc' / 'architecture.md'
    rooms = {p.parent.name for p in (ROOT / 'colortrack_ros').glob('*/__init__.py')} | {
        path.name for path in (ROOT / 'colortrack_ros').glob('[!_]*.py')
    }
    assert set(re.findall(r'^\| `([\w.]+)` \|', page.read_text(), re.MULTILINE)) == rooms
    steps = re.findall(r'^\d+\. `(\w+\.?\w*)`', page.read_text(), re.MULTILINE)
    assert len(steps) == 10
    assert [s for s in steps if not (ROOT / 'colortrack_ros' / 'tracking' / s).exists()] == []
    drawn = re.findall(r'class="name".*?>(.*?)<', (page.parent / 'architecture.svg').read_text())
    assert {name for names in drawn for name in names.split(', ')} <= rooms | {'data'}


def test_the_python_of_the_readme_tracks_a_video(tmp_path, monkeypatch, capsys):
    """Its ball.mp4 is a scene of one ball, in the color that the README names."""
    scene = open_scene('single?width=320&height=240&duration=1')
    codec = cv2.VideoWriter.fourcc(*'mp4v')
    video = cv2.VideoWriter(str(tmp_path / 'ball.mp4'), codec, 24.0, (320, 240))
    for k in range(len(scene)):
        video.write(scene.render(k))
    video.release()
    monkeypatch.chdir(tmp_path)
    (code,) = blocks(README, 'python')
    exec(code, {})
    _stamp, track, u, v = capsys.readouterr().out.splitlines()[-1].split()
    truth = scene.truth(len(scene) - 1)[0]
    assert int(track) == 1
    assert abs(float(u) - truth['u']) < 3
    assert abs(float(v) - truth['v']) < 3


def test_the_python_that_reads_tracks_reads_a_message(capsys):
    (code,) = blocks(ROOT / 'doc' / 'messages.md', 'python')
    tree = ast.parse(code)
    tree.body = [
        node
        for node in tree.body
        if isinstance(node, ast.Import | ast.ImportFrom | ast.FunctionDef)
    ]
    scope = {}
    exec(compile(tree, 'messages.md', 'exec'), scope)
    rows = np.zeros(2, TRACK)
    rows['track_id'], rows['state'] = [3, 4], [1, 0]
    scope['tracks_of'](cloud_of_tracks(Tracks(rows)))
    assert capsys.readouterr().out == '[3] [0.] [0.] (1, 4, 4)\n'


TRY = """
import numpy as np
from colortrack_ros.data import Frame
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.sources import open_source
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig

lamp = np.zeros((12, 60, 80, 3), np.uint8)
for k, picture in enumerate(lamp):
    picture[20:30, 10 + 3 * k : 20 + 3 * k] = 250
np.save('lamp.npy', lamp)
video = open_source('lamp.npy', rate=10.0)
detector = Detector(DetectorConfig(method='brightness', least_brightness=245))
tracker = Tracker(TrackerConfig(motion_model='damped_velocity', associator='greedy'))
while (frame := video.read()) is not None:
    rows = tracker.update(detector.detect(frame)).rows
(row,) = rows
assert row['track_id'] == 1 and row['hits'] == 12, row
assert abs(row['u'] - 47.5) < 0.5 and abs(row['v'] - 24.5) < 0.5, row
assert 20 < row['du'] < 35, row
"""


def insert(path, line, anchor):
    """A line after the first one that the pattern matches."""
    text = path.read_text()
    end = re.search(anchor, text, re.MULTILINE).end()
    path.write_text(f'{text[:end]}\n{line}{text[end:]}')


@pytest.mark.slow
def test_each_way_to_extend_the_package_is_one_file_and_one_line(tmp_path):
    shutil.copytree(ROOT / 'colortrack_ros', tmp_path / 'colortrack_ros')
    page = ROOT / 'doc' / 'extending.md'
    lines = re.findall(r'^The line: `(.*?)` in `(\w+)`', page.read_text(), re.MULTILINE)
    for code, (line, table) in zip(blocks(page, 'python'), lines, strict=True):
        file, text = code.removeprefix('# ').split('\n', 1)
        (tmp_path / file).write_text(text)
        module = file.removesuffix('.py').replace('/', '.')
        name = line.rpartition(' ')[2]
        found = name if f'class {name}' in text else f'associate as {name}'
        init = tmp_path / file.replace(Path(file).name, '__init__.py')
        insert(init, f'from {module} import {found}', r'^from colortrack_ros.*$')
        insert(init, f'    {line},', rf'^{table}\b.*[{{(]')
    config = tmp_path / 'colortrack_ros' / 'detection' / 'config.py'
    where = 'colortrack_ros.detection.methods.brightness'
    insert(config, f'from {where} import BrightnessConfig', r'^from colortrack_ros.*$')
    insert(config, '    BrightnessConfig,', r'^class DetectorConfig\($')
    done = subprocess.run(
        [sys.executable, '-c', TRY], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize('node', NODES)
def test_the_ranges_of_a_table_are_accepted_by_its_room(node):
    table = NODES[node]
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
