"""What ends programs: signals of a terminal, or of somebody who is in a hurry."""

import os
from pathlib import Path
import signal
import subprocess
import sys

import pytest
from support.waiting import PATIENCE
from support.waiting import wait_until

from colortrack_ros import commands
from colortrack_ros.signals import ending_signals

SCENE = 'scene:single?width=64&height=48&duration=20'
COMMANDS = {
    'replay': ['replay.main', SCENE, SCENE.replace('single', 'five'), '--output', '{}'],
    'tune': ['tools.tune', SCENE, '--trials', '100'],
}


def test_what_nohup_has_started_outlives_its_terminal(monkeypatch):
    assert ending_signals() == (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    monkeypatch.setattr(signal, 'getsignal', lambda _: signal.SIG_IGN)
    assert ending_signals() == (signal.SIGINT, signal.SIGTERM)


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


def descendants(pid: int) -> list[int]:
    """Processes that one has started, and those that these have."""
    try:
        text = Path(f'/proc/{pid}/task/{pid}/children').read_text()
    except OSError:
        return []
    own = [int(child) for child in text.split()]
    return own + [one for child in own for one in descendants(child)]


@pytest.mark.slow
def test_a_command_that_is_killed_leaves_no_process_behind(tmp_path):
    started = {}
    for name, (module, *words) in COMMANDS.items():
        code = f'import sys; from colortrack_ros.{module} import main; sys.exit(main())'
        # with a session of its own, as none of them hears of the end by the terminal then
        started[name] = subprocess.Popen(
            [sys.executable, '-c', code, *words],
            cwd=tmp_path,
            start_new_session=True,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
    for name, process in started.items():
        # resource tracker, fork server, and who works
        wait_until(lambda p=process: len(descendants(p.pid)) >= 3, PATIENCE, lambda n=name: n)
        helpers = descendants(process.pid)
        os.kill(process.pid, signal.SIGKILL)
        process.wait()
        wait_until(lambda h=helpers: not any(Path(f'/proc/{p}').exists() for p in h))
