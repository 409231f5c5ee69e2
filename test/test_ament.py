"""The linters of ROS, where they are installed; why they leave out what they do is said here."""

import ast
from pathlib import Path
import shutil
import subprocess
import sys
from xml.etree import ElementTree

import pytest
from support.paths import ROOT

PACKAGE = 'colortrack_ros'

PATHS = [str(ROOT / name) for name in ('colortrack_ros', 'launch', 'setup.py')]

UNLIKE = ('D205', 'D213', 'D400', 'D401', 'D402', 'D403', 'D415')
"""Summaries begin on the first line, may run over two, and say what is, not what to do; ruff.toml
checks the rest of their form."""


def test_ament_flake8_passes():
    main = pytest.importorskip('ament_flake8.main', reason='no ament_flake8 here')
    status, errors = main.main_with_errors(argv=['--config', str(ROOT / 'setup.cfg'), *PATHS])
    assert status == 0, '\n'.join(errors)


def test_ament_pep257_passes():
    main = pytest.importorskip('ament_pep257.main', reason='no ament_pep257 here')
    assert main.main(argv=['--add-ignore', *UNLIKE, '--', *PATHS]) == 0


XML = [str(path) for path in (ROOT / 'package.xml', *sorted(ROOT.glob('[lp]a*/*.xml')))]


def test_all_files_of_xml_are_well_formed():
    assert {Path(path).parent.name for path in XML} == {ROOT.name, 'launch', 'params'}
    for path in XML:
        ElementTree.parse(path)
    if shutil.which('xmllint'):
        done = subprocess.run(
            ['xmllint', '--nonet', '--noout', *XML], capture_output=True, text=True, check=False
        )
        assert (done.returncode, done.stderr) == (0, '')


def test_ament_xmllint_passes(capfd: pytest.CaptureFixture[str]):
    main = pytest.importorskip('ament_xmllint.main', reason='no ament_xmllint here')
    if not shutil.which('xmllint'):
        pytest.skip('no xmllint here')
    status, printed = main.main(argv=XML), capfd.readouterr()
    if 'Failed to locate the main schema' in printed.err:
        pytest.skip('no network, from which xmllint loads the schema of package.xml')
    assert status == 0, printed


def test_package_xml_names_each_package_once_in_the_order_of_its_schema():
    """That of http://download.ros.org/schema/package_format3.xsd, which xmllint loads itself."""
    package = ElementTree.parse(ROOT / 'package.xml').getroot()
    tags = [child.tag for child in package]
    order = ['name', 'version', 'description', 'maintainer', 'license', 'url', 'depend',
             'exec_depend', 'test_depend', 'export']  # fmt: skip
    assert list(dict.fromkeys(tags)) == order
    assert tags == sorted(tags, key=order.index)
    keys = [child.text for child in package if child.tag.endswith('depend')]
    assert len(keys) == len(set(keys))


@pytest.mark.slow
def test_an_installed_package_tells_type_checkers_that_it_is_typed(tmp_path):
    """PEP 561: without the marker, mypy ignores all types of an installed package."""
    where = ['--build-base', str(tmp_path / 'build'), '--build-lib', str(tmp_path / 'lib')]
    command = [sys.executable, 'setup.py', '-q', 'egg_info', '-e', str(tmp_path), 'build', *where]
    subprocess.run(command, cwd=ROOT, capture_output=True, check=True)
    assert (tmp_path / 'lib' / PACKAGE / 'py.typed').is_file()
    assert (tmp_path / 'lib' / PACKAGE / 'tuner' / 'page' / 'app.js').is_file()


IMPORTED = {'cv2': 'python3-opencv', 'yaml': 'python3-yaml'}
"""Modules whose rosdep keys are not ``python3-`` and their name."""

OPTIONAL = {'rosbags', 'apsw', 'distributed', 'vision_msgs', 'colortrack_ros'}
"""What is used where it is there: a robot has none of it but, perhaps, vision_msgs."""


@pytest.mark.slow
def test_package_xml_has_a_key_for_whatever_is_imported():
    trees = [ast.parse(file.read_text()) for file in sorted((ROOT / PACKAGE).rglob('*.py'))]
    trees += [ast.parse(file.read_text()) for file in (ROOT / 'launch').glob('*.py')]
    nodes = [node for tree in trees for node in ast.walk(tree)]
    names = {node.module for node in nodes if isinstance(node, ast.ImportFrom) and node.module}
    names |= {alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names}
    modules = {name.partition('.')[0] for name in names} - sys.stdlib_module_names - OPTIONAL
    package = ElementTree.parse(ROOT / 'package.xml').getroot()
    keys = {child.text for child in package if child.tag in ('depend', 'exec_depend')}
    keys |= {'tf2_ros'} if 'tf2_ros_py' in keys else set()  # the package of that name
    missing = {m for m in modules if m not in keys and IMPORTED.get(m, f'python3-{m}') not in keys}
    assert missing == set()
