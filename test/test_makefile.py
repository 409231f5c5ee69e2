"""What `make` says on machines that there are no wheels for."""

import os
import shutil
import subprocess
import sys

import pytest
from support.paths import ROOT

pytestmark = pytest.mark.skipif(shutil.which('make') is None, reason='there is no make')


def make(tmp_path, system, machine):
    """The exit status, and what `make demo` says on such a machine; nothing is installed."""
    uname = tmp_path / 'uname'
    uname.write_text(f'#!/bin/sh\n[ "$1" = -s ] && echo {system} || echo {machine}\n')
    uname.chmod(0o755)
    command = ['make', 'demo', f'VENV={tmp_path}/venv', f'PYTHON={sys.executable}']
    env = dict(os.environ, PATH=f'{tmp_path}{os.pathsep}{os.environ["PATH"]}', MAKEFLAGS='')
    done = subprocess.run(command, cwd=ROOT, env=env, capture_output=True, text=True)
    assert not (tmp_path / 'venv').exists()
    return done.returncode, [line for line in done.stderr.splitlines() if '***' not in line]


@pytest.mark.parametrize(
    ('system', 'machine'), [('Linux', 'aarch64'), ('Darwin', 'x86_64'), ('Darwin', 'arm64')]
)
def test_a_machine_without_wheels_is_told_in_one_line_what_to_do(tmp_path, system, machine):
    status, lines = make(tmp_path, system, machine)
    assert status != 0
    (line,) = lines
    assert f'here is {system} {machine}' in line
    assert 'use ROS 2 Jazzy from apt and colcon, or an x86-64 container' in line


@pytest.mark.parametrize('name', ["it's.mp4", '$HOME.mp4', 'a "b" `c`.mp4', '%d 100%.mp4'])
@pytest.mark.parametrize('target', ['demo', 'tuner'])
def test_names_of_files_arrive_as_they_are(tmp_path, target, name):
    python = tmp_path / 'bin' / ('python' if target == 'demo' else 'tuner')
    python.parent.mkdir()
    python.write_text('#!/bin/sh\nprintf "%s\\n" "$@"\n')
    python.chmod(0o755)
    (tmp_path / target).touch()
    command = ['make', '-s', '-o', str(tmp_path / target), target]
    given = [f'VENV={tmp_path}', f'SOURCE={name}', f'PARAMS={name}']
    env = dict(os.environ, MAKEFLAGS='')
    done = subprocess.run([*command, *given], cwd=ROOT, env=env, capture_output=True, text=True)
    words = [word.partition('=')[2] or word for word in done.stdout.splitlines()]
    assert words.count(name) == 2, done.stderr
