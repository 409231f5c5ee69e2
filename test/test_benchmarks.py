"""What the benchmarks need is in the environment that `make bench` makes for them."""

import ast
import re
import runpy
import sys

import setuptools
from support.paths import ROOT

CALLED = {
    'cv2': 'opencv-python-headless',
    'skimage': 'scikit-image',
    'supervision': 'trackers',
    'yaml': 'pyyaml',
}
"""Modules that are not called like what brings them."""

OF_ROS = re.compile('rclpy|.*_(msgs|interfaces)')


def imported(file):
    """The first names of all modules that a file imports, anywhere in it."""
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name.partition('.')[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield node.module.partition('.')[0]


def test_their_environment_has_what_they_import(monkeypatch):
    said = {}
    monkeypatch.chdir(ROOT)
    monkeypatch.setattr(setuptools, 'setup', said.update)
    runpy.run_path('setup.py')
    _, _, recipe = (ROOT / 'Makefile').read_text().partition('\n%/bench:')
    extras = re.search(r"-e '\.\[(.*)]'", recipe)[1].split(',')
    installed = [one for extra in extras for one in said['extras_require'][extra]]
    installed += (ROOT / 'benchmark/requirements.txt').read_text().splitlines()
    installed += re.findall(r'--no-deps (\S+)', recipe)
    there = {re.match(r'[\w-]*', one)[0].lower() for one in installed}
    files = list((ROOT / 'benchmark').rglob('*.py'))
    own = {file.stem for file in files} | {'colortrack_ros', 'support', 'worlds'}
    wanted = {name for file in files for name in imported(file)} - own - sys.stdlib_module_names
    assert {
        name for name in wanted if CALLED.get(name, name) not in there and not OF_ROS.match(name)
    } == set()


def test_each_answers_to_help():
    """Some ended in a traceback, and others began to measure."""
    files = {file.name: file.read_text() for file in (ROOT / 'benchmark').glob('*.py')}
    started = {name for name, text in files.items() if "__name__ == '__main__'" in text}
    assert {name for name, text in files.items() if 'sys.argv' in text} == set()
    assert {name for name in started if 'parse_args' not in files[name]} == set()
