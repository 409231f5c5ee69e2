"""The demo, whose nodes are processes: nobody waits for the dead, none is left behind."""

import argparse
import contextlib
import fcntl
import os
from pathlib import Path
import pty
import shlex
import signal
import subprocess
import sys
import termios

import cv2
import numpy as np
import pytest
from support.ros_domain import free_domain
from support.waiting import PATIENCE
from support.waiting import wait_until

from colortrack_ros.tools.color_options import color_option
import colortrack_ros.tools.demo as demo_module

SOURCE = 'scene:single?width=160&height=120'

ALL = """/**:
  ros__parameters:
    max_lag: 60.0
    queue_depth: 1000
    image_queue_depth: 1000
    qos_overrides./camera/image_raw.subscription.reliability: reliable
"""
"""Parameters with which nothing is skipped, however busy the machine is."""


def children(pid):
    """The processes that one has started."""
    found = Path(f'/proc/{pid}/task/{pid}/children').read_text().split()
    return [int(child) for child in found]


def command(pid):
    return Path(f'/proc/{pid}/cmdline').read_text()


@pytest.fixture
def demo(tmp_path):
    """Starts the demo; gives the process, with its errors in a file."""
    domain, lock = free_domain()
    started = []

    def start(limit='', *options, **streams):
        code = f'{limit}\nfrom colortrack_ros.tools.demo import main\nraise SystemExit(main())'
        given = ['--source', SOURCE, '--out', str(tmp_path / 'out'), *options]
        with (tmp_path / 'errors').open('w') as errors:
            process = subprocess.Popen(
                [sys.executable, '-c', code, *given],
                env=dict(os.environ, ROS_DOMAIN_ID=str(domain)),
                **({'stdout': subprocess.DEVNULL, 'stderr': errors} | streams),
            )
        started.append(process)
        return process

    yield start
    for process in started:
        process.kill()
        process.wait()
    lock.close()


def test_a_signal_ends_the_demo_and_all_its_nodes(demo):
    process = demo()
    wait_until(lambda: len(children(process.pid)) == 4)
    nodes = children(process.pid)
    process.send_signal(signal.SIGTERM)
    process.wait(PATIENCE)
    assert not any(Path(f'/proc/{node}').exists() for node in nodes)


def test_ctrl_c_before_the_first_picture_ends_the_demo_and_its_nodes_without_a_word(demo, tmp_path):
    """Tracebacks of nodes that were being imported, an empty table, and status 1."""
    process = demo(start_new_session=True, stdout=subprocess.PIPE)
    wait_until(lambda: len(children(process.pid)) == 3)
    nodes = children(process.pid)
    os.killpg(process.pid, signal.SIGINT)
    assert process.communicate(timeout=PATIENCE)[0] == b''
    assert (process.returncode, (tmp_path / 'errors').read_text()) == (130, '')
    assert not any(Path(f'/proc/{node}').exists() for node in nodes)
    assert os.listdir(tmp_path / 'out') == []


def test_a_terminal_that_is_closed_ends_the_demo_and_all_its_nodes(demo):
    try:
        ours, terminal = pty.openpty()
    except OSError as error:
        pytest.skip(f'no pseudo-terminal can be had here: {error}')

    def of_terminal() -> None:
        os.setsid()
        fcntl.ioctl(terminal, termios.TIOCSCTTY, 0)

    streams = dict.fromkeys(('stdin', 'stdout', 'stderr'), terminal)
    process = demo(preexec_fn=of_terminal, **streams)
    os.close(terminal)
    os.set_blocking(ours, False)

    def all_there() -> bool:
        with contextlib.suppress(BlockingIOError):
            os.read(ours, 1 << 16)
        return len(children(process.pid)) == 4

    wait_until(all_there)
    nodes = children(process.pid)
    os.close(ours)
    assert process.wait(PATIENCE) >= 0, 'it has not ended by itself'
    wait_until(lambda: not any(Path(f'/proc/{node}').exists() for node in nodes))


def test_a_demo_that_is_killed_leaves_no_node_behind(demo):
    process = demo()
    wait_until(lambda: len(children(process.pid)) == 4)
    nodes = children(process.pid)
    process.kill()
    process.wait()
    wait_until(lambda: not any(Path(f'/proc/{node}').exists() for node in nodes))


@pytest.mark.parametrize('count', [3, 4], ids=['before the camera', 'while it plays'])
def test_a_node_that_dies_ends_the_demo_with_its_name(demo, tmp_path, count):
    process = demo()
    wait_until(lambda: len(children(process.pid)) >= count)
    nodes = children(process.pid)
    (victim,) = (node for node in nodes if 'nodes.detector' in command(node))
    os.kill(victim, signal.SIGKILL)
    assert process.wait(PATIENCE) == 1
    assert 'the node detector has ended with status -9' in (tmp_path / 'errors').read_text()
    assert not any(Path(f'/proc/{node}').exists() for node in nodes)


def test_a_color_that_is_not_there_is_told_with_the_nearest_that_is(demo, tmp_path):
    process = demo('', '--color', '20,40,250')
    text = 'object has not been seen yet; if it is in view, '
    wait_until(lambda: text in (tmp_path / 'errors').read_text())
    process.send_signal(signal.SIGTERM)
    process.wait(PATIENCE)


def film_of_a_ball(folder, count, rate, width, height):
    """A film of so many pictures in which a red ball passes; its path."""
    film = str(folder / 'film.mp4')
    writer = cv2.VideoWriter(film, cv2.VideoWriter.fourcc(*'mp4v'), rate, (width, height))
    for k in range(count):
        image = np.full((height, width, 3), 90, np.uint8)
        at = width // 5 + k * width // (2 * count), height // 2
        writer.write(cv2.circle(image, at, height // 10, (30, 20, 220), cv2.FILLED))
    writer.release()
    return film


def test_a_film_is_shown_once(demo, tmp_path):
    film = film_of_a_ball(tmp_path, 45, 30, 160, 120)
    (tmp_path / 'all.yaml').write_text(ALL)
    params = str(tmp_path / 'all.yaml')
    given = '--source', film, '--color', '220,20,30', '--seconds', '15', '--params', params
    process = demo('', *given, stdout=subprocess.PIPE, text=True)
    told, _ = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0
    assert '45 frames tracked, 1 objects' in told


def test_a_film_too_fast_for_the_machine_is_told_with_the_command_that_takes_all_of_it(
    demo, tmp_path
):
    """43 of the 187 pictures of a telephone's film were tracked, without a word."""
    film = film_of_a_ball(tmp_path, 100, 1000, 1280, 960)
    given = '--source', film, '--color', '220,20,30', '--seconds', '15'
    told, _ = demo('', *given, stdout=subprocess.PIPE, text=True).communicate(timeout=PATIENCE)
    assert 'of 100 pictures were skipped' in told
    command = told.partition('To take each: ')[2].splitlines()[0]
    table = tmp_path / 'tracks.csv'
    subprocess.run([*shlex.split(command), '--csv', str(table)], check=True)
    last = table.read_text().splitlines()[-1]
    assert last.startswith('99000000,'), 'the last picture, at 0.099 s'


def test_a_command_has_its_words_quoted_and_a_device_has_none(tmp_path, monkeypatch):
    program = tmp_path / 'my robot' / 'replay'
    program.parent.mkdir()
    program.touch()
    monkeypatch.setattr(sys, 'executable', str(program.with_name('python')))
    given = argparse.Namespace(
        source=str(tmp_path), params='', color='', tolerance='', out=tmp_path
    )
    words = shlex.split(demo_module.replay_command(given))
    assert Path(words[0]).resolve() == program.resolve()
    assert words[1] == str(tmp_path)
    given.source = os.devnull
    assert not demo_module.replay_command(given)


@pytest.mark.parametrize(
    ('color', 'parameter'),
    [
        ('200,20,60', 'rgb:=[200, 20, 60]'),
        ('200, 20, 60', 'rgb:=[200, 20, 60]'),
        ('#C8143C', 'rgb:=[200, 20, 60]'),
        ('red', 'preset:=red'),
        ('Red ', 'preset:=red'),
    ],
)
def test_a_color_is_given_by_r_g_b_or_by_its_name(color, parameter):
    given = argparse.Namespace(color=color_option(color), tolerance='')
    assert demo_module._detector_parameters(given) == ['colors:=[object]', f'object.{parameter}']


@pytest.mark.parametrize(
    ('given', 'reason'),
    [
        (['--color=300,0,0'], 'expected r,g,b of 0..255 each'),
        (['--color=rot'], 'such as 220,60,40, #rrggbb, or one of red, orange'),
        (['--color=#c814'], 'such as 220,60,40, #rrggbb, or one of red, orange'),
        (['--tolerance=-3'], 'expected 0..200'),
        (['--tolerance=nan'], 'expected 0..200'),
        (['--seconds=nan'], 'expected a positive number'),
        (['--params=none.yaml'], 'No such file or directory: none.yaml'),
        (['--out=/dev/null'], '/dev/null: File exists'),
    ],
)
def test_what_the_demo_cannot_do_is_told_before_it_starts(
    tmp_path, monkeypatch, capsys, given, reason
):
    """It went on with the default color, for ever, or ended with tracebacks of its nodes."""
    monkeypatch.setattr(demo_module, 'NodeGroup', lambda *_, **__: pytest.fail('it starts'))
    with contextlib.suppress(SystemExit):
        assert demo_module.main(['--out', str(tmp_path), *given]) == 1
    assert reason in capsys.readouterr().err


def test_a_film_of_one_picture_leaves_it_as_video_and_as_picture(demo, tmp_path):
    film = tmp_path / 'film'
    film.mkdir()
    cv2.imwrite(str(film / '0.png'), np.full((120, 160, 3), 90, np.uint8))
    assert demo('', '--source', str(film), '--seconds', '15').wait(PATIENCE) == 0
    assert cv2.imread(str(tmp_path / 'out' / 'demo.png')).shape == (120, 160, 3)
    video = cv2.VideoCapture(str(tmp_path / 'out' / 'demo.mp4'))
    assert video.get(cv2.CAP_PROP_FRAME_COUNT) == 1
