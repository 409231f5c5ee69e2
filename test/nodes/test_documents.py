from functools import cache
from functools import partial
import re

from parameter_pages import NODES
from parameter_pages import PAGE
from parameter_pages import page
from parameter_pages import SETUPS
import pytest
from support.pages import blocks
from support.pages import FENCE
from support.pages import README
from support.paths import ROOT
from support.pipeline import flat
import yaml

from colortrack_ros.data import DETECTION
from colortrack_ros.data import LOCATION
from colortrack_ros.data import OUTLINE_POINT
from colortrack_ros.data import TRACK
from colortrack_ros.parameters import build
from colortrack_ros.replay.outputs import COLUMNS
from colortrack_ros.replay.setup import command_line

BUILD = {name: partial(build, setup) for name, setup in SETUPS.items()}

PAGES = [README, ROOT / 'CONTRIBUTING.md', *sorted((ROOT / 'doc').glob('*.md'))]

POINT_TYPES = {'f8': 'FLOAT64', 'f4': 'FLOAT32', 'u4': 'UINT32', 'u1': 'UINT8'}


def prose(path):
    """A page without its code blocks."""
    return FENCE.sub('', path.read_text())


def anchor(title):
    """The anchor of a heading, as GitHub and MyST make it."""
    return re.sub(r'[^\w\- ]', '', title.lower()).replace(' ', '-')


def by_page(*pages):
    return pytest.mark.parametrize('path', pages, ids=lambda p: p.name)


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


@pytest.mark.slow
@cache
def known() -> set[str]:
    """The parameters of all nodes."""
    return {name for table in NODES.values() for name in (*table.specs, *table.each)}


@cache
def words() -> set[str]:
    """All words of the code, of tests and benchmarks too, but for those of this file."""
    folders = ('colortrack_ros', 'test', 'benchmark', 'params', 'launch')
    files = [file for folder in folders for file in (ROOT / folder).rglob('*.*')]
    code = '\n'.join(
        file.read_text()
        for file in (*files, ROOT / 'setup.py', ROOT / 'package.xml')
        if file.suffix in ('.py', '.yaml', '.xml', '.xsd') and file.name != 'test_documents.py'
    )
    return set(re.findall(r'\w+', code)) | known() | set(COLUMNS)


@by_page(*PAGES)
def test_every_name_in_a_page_is_one_of_the_package(path):
    """snake_case words in backticks, and what is set by `name: value`."""
    for text in re.findall(r'`([^`\n]+)`', prose(path)):
        if setting := re.fullmatch(r'(\w+): \S+', text):
            assert setting[1] in known() | {'use_sim_time', 'ns'}, text
        if re.fullmatch(r'(?!my_)[a-z]+(_[a-z0-9]+)+', text):
            assert text in words(), text


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


@pytest.mark.parametrize('node', NODES)
def test_the_ranges_of_a_table_are_accepted_by_its_room(node):
    table = NODES[node]
    for name, spec in table.specs.items():
        assert spec.description.endswith('.')
        for bound in spec.limits or ():
            several = isinstance(spec.default, list | tuple)
            one = type(spec.default[0] if several else spec.default)(bound)
            value = [one] * len(spec.default) if several else one
            reasons = table.consistent({name: value}, BUILD[node])[1].values()
            # refused alone only for what another parameter says
            assert all('expected' in reason for reason in reasons), reasons
