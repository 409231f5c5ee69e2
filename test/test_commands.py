"""What the executables say and return when their program cannot run."""

import os
import signal
import subprocess
import sys
import types

import pytest

from colortrack_ros import commands


@pytest.fixture(autouse=True)
def untouched():
    """Ctrl-C is as in a new process, whatever other tests have left, and is so again."""
    last = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, last)


def test_ctrl_c_while_a_program_is_imported_ends_it_without_a_word():
    """A traceback of whatever was being imported."""
    code = (
        'import importlib, os, signal\n'
        'importlib.import_module = lambda _: os.kill(os.getpid(), signal.SIGINT)\n'
        'from colortrack_ros.commands import nodes; nodes.camera()'
    )
    done = subprocess.run([sys.executable, '-c', code], capture_output=True)
    assert (done.returncode, done.stderr) == (-signal.SIGINT, b'')


class Interrupted:
    @staticmethod
    def main():
        raise KeyboardInterrupt


def test_ctrl_c_ends_a_program_that_does_not_heed_it_with_the_status_of_a_shell(monkeypatch):
    monkeypatch.setattr(commands.importlib, 'import_module', lambda _: Interrupted)
    assert commands.tools.evaluate() == 130
    assert signal.getsignal(signal.SIGINT) == signal.default_int_handler


@pytest.mark.parametrize(
    ('room', 'program', 'name', 'extras'),
    [
        ('nodes', 'camera', 'camera', 'standalone'),
        ('replay', 'main', 'replay', 'standalone,replay'),
        ('tools', 'evaluate', 'evaluate', 'standalone,replay'),
        ('tuner', 'main', 'tuner', 'standalone,replay,tuner'),
    ],
)
def test_a_missing_package_is_told_in_a_line_with_all_that_its_program_needs(
    monkeypatch, capsys, room, program, name, extras
):
    """Tracebacks, or one package after the other."""
    monkeypatch.setitem(sys.modules, f'colortrack_ros.{room}.{program}', None)
    monkeypatch.setattr(commands, '__package__', 'another')
    assert getattr(getattr(commands, room), program)() == 1
    said = capsys.readouterr().err
    assert said.startswith(f'{name}: ')
    assert said.endswith(f"or in the folder of this package: pip install '.[{extras}]'\n")
    assert said.count('\n') == 1


@pytest.mark.parametrize(
    ('env', 'words', 'said'),
    [
        (
            {'LC_ALL': 'C', 'PYTHONUTF8': '0'},
            [b'b\xc3\xa4lle.png'],
            b'this locale is ascii: set LC_ALL=',
        ),
        ({'LC_ALL': 'C.UTF-8'}, [b'b\xff.png'], b'b\\xff.png: expected UTF-8; rename it\n'),
    ],
)
def test_arguments_that_ros_cannot_take_are_told_in_a_line(env, words, said):
    """Tracebacks of encoding."""
    command = [
        sys.executable,
        '-m',
        'colortrack_ros.commands',
        'tools.pick_color',
        *words,
        '3',
        '4',
    ]
    done = subprocess.run(command, env=os.environ | env, capture_output=True)
    assert done.returncode == 1
    assert done.stderr.startswith(b'pick_color: b')
    assert said in done.stderr
    assert done.stderr.count(b'\n') == 1


def test_what_a_terminal_cannot_show_does_not_end_a_program():
    """The demo's table has a sign that ASCII lacks."""
    code = (
        'import importlib, types\n'
        'program = types.SimpleNamespace(main=lambda: print("1 ± 2") or 0)\n'
        'importlib.import_module = lambda _: program\n'
        'from colortrack_ros.commands import tools; raise SystemExit(tools.demo())'
    )
    env = os.environ | {'PYTHONIOENCODING': 'ascii'}
    done = subprocess.run([sys.executable, '-c', code], env=env, capture_output=True)
    assert (done.returncode, done.stdout) == (0, b'1 ? 2\n')


@pytest.mark.parametrize('words', ['x' * 100_000, 'a line'])
@pytest.mark.parametrize(
    ('taker', 'status', 'said'),
    [('pipe', 141, ''), ('/dev/full', 1, 'evaluate: [Errno 28] No space left on device\n')],
)
def test_output_that_nobody_takes_ends_a_program_without_a_traceback(words, taker, status, said):
    """As of `evaluate tracks.csv | head -1`, whether it is written at once or at the end."""
    code = (
        'import importlib, types\n'
        f'program = types.SimpleNamespace(main=lambda: print({words!r}) or 0, __doc__="")\n'
        'importlib.import_module = lambda _: program\n'
        'from colortrack_ros.commands import tools; raise SystemExit(tools.evaluate())'
    )
    reading, writing = os.pipe()
    os.close(reading)
    with open(writing, 'w') if taker == 'pipe' else open(taker, 'w') as out:
        command = [sys.executable, '-c', code]
        done = subprocess.run(command, stdout=out, stderr=subprocess.PIPE, text=True)
    assert (done.returncode, done.stderr) == (status, said)


@pytest.mark.parametrize('taker', ['/dev/null', '/dev/full'])
def test_help_that_cannot_be_written_is_an_error(taker):
    """argparse exits by itself, with the text still to be written: status 120 and a traceback."""
    code = (
        'import argparse, importlib, types\n'
        'main = lambda: argparse.ArgumentParser().parse_args(["--help"])\n'
        'importlib.import_module = lambda _: types.SimpleNamespace(main=main, __doc__="")\n'
        'from colortrack_ros.commands import tools; raise SystemExit(tools.evaluate())'
    )
    env = {name: value for name, value in os.environ.items() if name != 'PYTHONUNBUFFERED'}
    with open(taker, 'w') as out:
        command = [sys.executable, '-c', code]
        done = subprocess.run(command, env=env, stdout=out, stderr=subprocess.PIPE, text=True)
    full = (1, 'evaluate: [Errno 28] No space left on device\n')
    assert (done.returncode, done.stderr) == (full if taker == '/dev/full' else (0, ''))


def test_a_pipe_of_the_program_itself_that_breaks_is_shown_as_a_fault(monkeypatch):
    def fail():
        raise BrokenPipeError('of a codec')

    program = types.SimpleNamespace(main=fail, __doc__='')
    monkeypatch.setattr(commands.importlib, 'import_module', lambda _: program)
    with pytest.raises(BrokenPipeError, match='of a codec'):
        commands.run('tools.evaluate')


@pytest.mark.parametrize('words', [['-p', 'rate:=3.0'], ['--rosargs'], ['ball.mp4']])
def test_a_node_refuses_arguments_that_are_not_of_ros(monkeypatch, capsys, words):
    """They were ignored: the camera opened device 0 in place of what was asked for."""
    monkeypatch.setattr('colortrack_ros.nodes.camera.main', lambda: pytest.fail('it runs'))
    monkeypatch.setattr(sys, 'argv', ['camera', *words, '--ros-args', '-p', 'loop:=true'])
    assert commands.nodes.camera() == 2
    said = capsys.readouterr().err
    assert said.startswith('The camera node: publishes pictures')
    assert f'camera: got {words[0]!r}; expected camera --ros-args -p NAME:=VALUE' in said


@pytest.mark.slow
@pytest.mark.parametrize(
    ('words', 'said'),
    [
        (['--params-file', 'none.yaml'], 'No such file or directory: none.yaml'),
        (['--params-file', 'pipe'], 'expected a file, got a folder, a pipe, a socket or a device'),
        (['--params-file', 'flat.yaml'], 'Cannot have a value before ros__parameters at line 2'),
        (['--log-level', 'loud'], "Couldn't parse log level: '--log-level loud'"),
    ],
)
def test_ros_arguments_that_cannot_be_read_end_a_node_with_the_reason_in_a_line(
    tmp_path, words, said
):
    (tmp_path / 'flat.yaml').write_text('tracker:\n  max_hidden: 3.0\n')
    os.mkfifo(tmp_path / 'pipe')
    command = [sys.executable, '-m', 'colortrack_ros.commands', 'nodes.tracker', '--ros-args']
    done = subprocess.run(
        [*command, *words], cwd=tmp_path, stderr=subprocess.PIPE, text=True, timeout=60
    )
    assert done.returncode == 1
    assert 'Traceback' not in done.stderr
    assert done.stderr.splitlines()[-1].startswith('colortrack_ros: bad ROS arguments: ')
    assert said in done.stderr


def test_a_node_tells_what_it_does(monkeypatch, capsys):
    monkeypatch.setattr('colortrack_ros.nodes.camera.main', lambda: pytest.fail('it runs'))
    monkeypatch.setattr(sys, 'argv', ['camera', '--help'])
    assert commands.nodes.camera() == 0
    assert 'The camera node: publishes pictures' in capsys.readouterr().out


def test_a_node_takes_ros_arguments_alone(monkeypatch):
    monkeypatch.setattr('colortrack_ros.nodes.camera.main', lambda: 7)
    monkeypatch.setattr(sys, 'argv', ['camera', '--ros-args', '-r', 'a:=b', '--', '--ros-args'])
    assert commands.nodes.camera() == 7
