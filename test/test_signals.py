"""What ends programs: signals of a terminal, or of somebody who is in a hurry."""

import os
from pathlib import Path
import signal
import subprocess
import sys

import pytest
from support.waiting import PATIENCE
from support.waiting import wait_until

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
