"""The rules of the house that a machine can check."""

import ast
from collections import Counter
import functools
from graphlib import CycleError
from graphlib import TopologicalSorter
import json
from pathlib import Path
import subprocess
import sys

import pytest

PACKAGE = Path(__file__).parents[1] / 'colortrack_ros'
ROOMS_WITHOUT_ROS = (
    'batch',
    'bags',
    'sources',
    'scenes',
    'estimation',
    'detection',
    'tracking',
    'windows',
    'contours',
    'drawing',
    'flow',
    'chain',
    'parameters',
    'world',
    'simulation',
    'evaluation',
)
ALLOWED = {
    'given': set(),
    'data': {'given'},
    'columns': {'data'},
    'batch': {'files'},
    'stamps': set(),
    'encodings': {'data', 'stamps'},
    'parameters': set(),
    'files': set(),
    'signals': set(),
    'picture_files': {'files'},
    'ellipses': set(),
    'scenes': {'data'},
    'sources': {'data', 'encodings', 'files', 'parameters', 'picture_files', 'scenes'},
    'estimation': {'columns', 'data', 'parameters', 'stamps'},
    'detection': {'columns', 'data', 'encodings', 'parameters', 'picture_files'},
    'tracking': {'columns', 'data', 'estimation', 'parameters'},
    'windows': {'columns', 'data', 'encodings', 'estimation', 'parameters'},
    # new targets are found as the detector's method `background` does
    'contours': {'columns', 'data', 'detection', 'encodings', 'estimation', 'parameters'},
    'world': {'columns', 'data', 'estimation', 'parameters'},
    'simulation': {'data', 'parameters', 'world'},
    'drawing': {'data', 'ellipses', 'files'},
    'messages': {'data', 'ellipses', 'encodings', 'files', 'picture_files'},
    'bags': {'data', 'files'},
    'evaluation': {'data', 'ellipses', 'files', 'scenes'},
    'flow': {'data', 'parameters'},
}


FLOORS = (
    {'ellipses', 'files', 'given', 'parameters', 'signals', 'stamps'},
    {'data'},
    {'batch', 'columns', 'encodings', 'picture_files'},
    {'scenes', 'estimation', 'flow', 'messages', 'bags', 'drawing'},
    {'sources', 'detection', 'tracking', 'windows', 'world'},
    {'contours', 'chain', 'simulation', 'evaluation'},
    {'node_kit'},
    {'nodes'},
    {'replay'},
    {'tools'},
    {'tuner'},
    {'commands'},
)
"""The rooms, from the ground up: a file imports from its own room and from lower floors."""
FILES = sorted(PACKAGE.rglob('*.py'))


MAX_FILE, MAX_FUNCTION = 299, 39
"""Lines of a file and of a function that two screens and one screen hold."""


@functools.cache
def tree_of(file):
    """The syntax tree of a file."""
    return ast.parse(file.read_text())


@functools.cache
def file_of(module):
    """The file of a module of the package, None if there is no such module."""
    path = PACKAGE.parent.joinpath(*module.split('.'))
    candidates = (path / '__init__.py', path.with_suffix('.py'))
    return next((file for file in candidates if file.is_file()), None)


@functools.cache
def imported_by(file):
    """The files of the package that a file imports, anywhere in it."""
    return set(_imports_of(file))


def _imports_of(file):
    for node in ast.walk(tree_of(file)):
        if isinstance(node, ast.Import):
            modules = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f'{file}: {node.module}: imports are absolute'
            names = [f'{node.module}.{alias.name}' for alias in node.names]
            modules = [name if file_of(name) else node.module for name in names]
        else:
            continue
        for module in modules:
            if module.split('.')[0] == PACKAGE.name:
                yield file_of(module)


def room_of(file):
    return file.relative_to(PACKAGE).parts[0].removesuffix('.py')


@pytest.mark.slow
def test_no_files_import_each_other_in_a_circle():
    graph = {file: imported_by(file) for file in FILES}
    try:
        tuple(TopologicalSorter(graph).static_order())
    except CycleError as error:
        circle = ' -> '.join(str(file.relative_to(PACKAGE)) for file in reversed(error.args[1]))
        pytest.fail(f'imports in a circle: {circle}')


@pytest.mark.slow
def test_imports_point_to_lower_floors():
    floor = {room: number for number, rooms in enumerate(FLOORS) for room in rooms}
    upwards = [
        f'{file.relative_to(PACKAGE)} imports {other.relative_to(PACKAGE)}'
        for file in FILES
        if room_of(file) != '__init__'
        for other in imported_by(file)
        if room_of(other) != room_of(file) and floor[room_of(other)] >= floor[room_of(file)]
    ]
    assert not upwards


def test_every_room_has_one_floor():
    rooms = sorted(room for rooms in FLOORS for room in rooms)
    assert rooms == sorted({room_of(file) for file in FILES} - {'__init__'})


def constants_of(file):
    for node in tree_of(file).body:
        for target in getattr(node, 'targets', [getattr(node, 'target', None)]):
            names = target.elts if isinstance(target, ast.Tuple) else [target]
            yield from (name.id for name in names if getattr(name, 'id', '').isupper())


@pytest.mark.slow
def test_files_and_functions_fit_on_the_screen():
    long = []
    folders = [PACKAGE, *(PACKAGE.parent / name for name in ('test', 'benchmark', 'doc'))]
    for file in [file for folder in folders for file in folder.rglob('*.py')]:
        text = file.read_text()
        name = str(file.relative_to(PACKAGE.parent))
        long += [name] if len(text.splitlines()) > MAX_FILE else []
        long += [
            f'{name}: {node.name}'
            for node in ast.walk(tree_of(file))
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
            if node.end_lineno - node.lineno + 1 > MAX_FUNCTION
        ]
    assert long == []


@pytest.mark.slow
def test_no_two_classes_have_one_name():
    names = Counter(
        node.name for file in FILES for node in tree_of(file).body if isinstance(node, ast.ClassDef)
    )
    assert [name for name, count in names.items() if count > 1] == []


@pytest.mark.slow
def test_no_two_constants_have_one_name():
    names = Counter(name for file in FILES for name in constants_of(file))
    assert [name for name, count in names.items() if count > 1] == []


def errors_of_imports(modules, missing):
    """Import modules without others: the error of each, None if there is none.

    One process imports all of them, and forgets the package before each: libraries take long.
    """
    code = (
        'import importlib, json, sys, traceback\n'
        f'sys.modules.update(dict.fromkeys({missing!r}))\n'
        'errors = {}\n'
        f'for module in {modules!r}:\n'
        f'    for name in [name for name in sys.modules if name.startswith({PACKAGE.name!r})]:\n'
        '        del sys.modules[name]\n'
        '    try:\n'
        f'        errors[module] = importlib.import_module("{PACKAGE.name}." + module) and None\n'
        '    except ImportError:\n'
        '        errors[module] = traceback.format_exc()\n'
        'print(json.dumps(errors))\n'
    )
    command = [sys.executable, '-c', code]
    done = subprocess.run(command, check=True, cwd=PACKAGE.parent, stdout=subprocess.PIPE)
    return json.loads(done.stdout)


@pytest.fixture(scope='module')
def errors_without_ros():
    return errors_of_imports(ROOMS_WITHOUT_ROS, ['rclpy', 'sensor_msgs', 'std_msgs'])


@pytest.mark.slow
@pytest.mark.parametrize('room', ROOMS_WITHOUT_ROS)
def test_a_room_imports_without_ros(room, errors_without_ros):
    assert errors_without_ros[room] is None


@pytest.mark.slow
def test_nodes_that_need_no_scipy_start_without_it():
    """It takes longer to import than all the rest."""
    nodes = [f'nodes.{n}' for n in ('camera', 'detector', 'follower', 'overlay', 'simulator')]
    assert errors_of_imports(nodes, ['scipy']) == dict.fromkeys(nodes)


@pytest.mark.parametrize('room', ALLOWED)
def test_arrows_point_one_way(room):
    files = [file for file in FILES if room_of(file) == room]
    used = {room_of(other) for file in files for other in imported_by(file)}
    assert used - {room} <= ALLOWED[room]
