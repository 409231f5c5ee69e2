"""The linters of ROS, where they are installed; why they leave out what they do is said here."""

import shutil

import pytest
from support.paths import ROOT

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


def test_ament_xmllint_passes():
    main = pytest.importorskip('ament_xmllint.main', reason='no ament_xmllint here')
    if not shutil.which('xmllint'):
        pytest.skip('no xmllint here')
    files = ['package.xml', *(f'params/{file.name}' for file in (ROOT / 'params').glob('*.xml'))]
    assert main.main(argv=[str(ROOT / file) for file in files]) == 0
