"""replay over many recordings: the files are those of one by one, whatever is stopped or killed."""

import json
import os
from pathlib import Path
import subprocess
import sys
import threading
from types import ModuleType

import pytest
from support.recorded import frames
from support.recorded import write_bag
from support.waiting import wait_until

from colortrack_ros.replay.command import replay
from colortrack_ros.replay.inputs import recordings_in
from colortrack_ros.replay.setup import command_line

SCENES = [f'scene:{name}?width=160&height=120&rate=6&duration=2' for name in ('single', 'five')]
LONG = 'scene:five?width=640&height=480&rate=500&duration=20'


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(*arguments, stop=None):
    return replay([str(argument) for argument in arguments], stop or threading.Event())


def files(folder):
    paths = sorted(p for p in Path(folder).rglob('*') if p.is_file())
    return {str(p.relative_to(folder)): p.read_bytes() for p in paths}


def lines(report):
    return [json.loads(line) for line in Path(report).read_text().splitlines()]


def one_by_one(folder, *scenes):
    for scene in scenes:
        name = scene.partition(':')[2].partition('?')[0]
        Path(folder).mkdir(exist_ok=True)
        assert run(scene, '--output', f'{folder}/{name}', '--csv', f'{folder}/{name}.csv') == 0
    return files(folder)


MANY = ('--output', 'new/{}', '--csv', 'new/{}.csv', '--report', 'report.jsonl')


@pytest.mark.slow
def test_many_give_the_bytes_of_one_by_one_and_a_failure_is_in_the_same_report(capsys):
    wanted = one_by_one('single', *SCENES)
    Path('new').mkdir()
    arguments = [*SCENES, 'nothing.mp4', *MANY, '--jobs', '2']
    assert run(*arguments) == 1
    assert files('new') == wanted
    assert [line['name'] for line in lines('report.jsonl')] == ['single', 'five', 'nothing']
    assert [line['result'] is None for line in lines('report.jsonl')] == [False, False, True]
    printed = capsys.readouterr().out
    assert '3 recordings, 1 failed' in printed
    assert "nothing: source 'nothing.mp4'" in printed
    times = {path: path.stat().st_mtime_ns for path in Path('new').rglob('*')}
    assert run(*arguments) == 1
    assert {path: path.stat().st_mtime_ns for path in Path('new').rglob('*')} == times


@pytest.mark.slow
def test_other_parameters_are_another_result_and_overwrite_nothing_unless_asked_for(capsys):
    Path('new').mkdir()
    assert run(*SCENES, *MANY) == 0
    before = files('new')
    other = [*SCENES, *MANY, '-p', 'tracker:process_noise:=3000.0']
    assert run(*other) == 1
    assert 'new/single: is there already; --force overwrites it' in capsys.readouterr().out
    assert files('new') == before
    assert run(*other, '--force') == 0
    assert files('new') != before


@pytest.mark.slow
def test_a_replay_that_is_killed_goes_on_and_leaves_nothing_half_written():
    Path('new').mkdir()
    command = [sys.executable, '-c', 'from colortrack_ros.replay.main import main; main()']
    process = subprocess.Popen([*command, SCENES[0], LONG, *MANY])
    try:
        wait_until(lambda: list(Path('new').glob('.replay-*/five')))
    finally:
        process.kill()
        process.wait()
    # Its worker ends as well, and takes what it has half-written with it.
    wait_until(lambda: not list(Path('new').glob('.replay-*')))
    done = [line['name'] for line in lines('report.jsonl') if line.get('result')]
    assert done == ['single']
    before = Path('new/single/metadata.yaml').stat().st_mtime_ns
    assert run(*SCENES, *MANY) == 0
    assert Path('new/single/metadata.yaml').stat().st_mtime_ns == before
    assert files('new') == one_by_one('single', *SCENES)


@pytest.mark.slow
def test_a_batch_that_is_stopped_keeps_what_is_whole_and_says_how_to_go_on(capsys):
    Path('new').mkdir()
    stop = threading.Event()

    def stop_when_one_is_done():
        wait_until(lambda: list(Path('new').glob('.replay-*/five')))
        stop.set()

    thread = threading.Thread(target=stop_when_one_is_done, daemon=True)
    thread.start()
    assert run(SCENES[0], LONG, *MANY, stop=stop) == 1
    assert 'stopped: 1 of 2 are done; the same command goes on' in capsys.readouterr().out
    assert sorted(os.listdir('new')) == ['single', 'single.csv']


@pytest.mark.parametrize(
    ('options', 'reason'),
    [
        (['--output', 'new'], 'new: 2 recordings would be written to it; put {} in the name'),
        (['--csv', 'all.csv'], 'all.csv: 2 recordings would be written to it'),
        (['-p', 'tracker:max_hidden:=-1.0'], 'max_hidden: expected'),
        (['--report', 'none/report'], 'none/report: No such file'),
    ],
)
def test_what_would_fail_for_all_is_told_before_anything_begins(options, reason, capsys):
    assert run(*SCENES, *options) == 1
    assert reason in capsys.readouterr().err
    assert os.listdir('.') == []


def test_a_recording_that_is_named_in_two_ways_is_told_before_it_is_written_twice(capsys):
    """As by its whole name, too: it was replayed twice, to one place, at once with --jobs."""
    Path('a.mp4').touch()
    Path('b.mp4').symlink_to('a.mp4')
    assert run('a.mp4', 'b.mp4', os.path.abspath('a.mp4')) == 1
    said = capsys.readouterr().err
    assert 'a_tracks: 2 recordings would be written to it' in said
    assert sorted(os.listdir('.')) == ['a.mp4', 'b.mp4']


@pytest.mark.parametrize('broken', [None, ModuleType('of another version')])
@pytest.mark.parametrize('scenes', [SCENES, SCENES[:1]])
def test_a_cluster_without_dask_is_told_in_a_line(scenes, broken, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, 'distributed', broken)
    assert run(*scenes, '--scheduler', 'tcp://127.0.0.1:1') == 1
    told = capsys.readouterr().err
    assert told.startswith('replay: --scheduler: ')
    assert told.endswith('; needs Dask: pip install distributed\n')


@pytest.mark.slow
def test_a_folder_stands_for_its_recordings_and_a_file_for_its_lines():
    images = frames(SCENES[0], 10**9)[:3]
    for name in ('b2', 'b10'):
        metadata = write_bag(Path('in', name), {'/camera/image_raw': images}) / 'metadata.yaml'
        metadata.write_text(metadata.read_text().replace('written_by', 'recorded_by'))
    for name in ('a.MP4', 'notes.txt', 'shots/1.png', 'empty/x.txt'):
        Path('in', name).parent.mkdir(exist_ok=True)
        Path('in', name).touch()
    assert run('in/b2', '--output', 'in/b2_tracks') == 0
    assert recordings_in(['in']) == ['in/a.MP4', 'in/b2', 'in/b10', 'in/shots']
    assert recordings_in(['in/b2', 'in/shots']) == ['in/b2', 'in/shots']
    Path('list').write_text('in/b2\nin/b10\n')
    assert command_line().parse_args(['@list', '--jobs', '3']).inputs == ['in/b2', 'in/b10']
    assert run('@list') == 1  # in/b2_tracks is there
    assert Path('in/b10_tracks').is_dir()


def test_the_name_stands_in_its_place_for_one_recording_too(folder):
    """A pattern of the shell may match one alone: files called {} were written."""
    scene = 'scene:single?width=64&height=48&duration=0.2'
    assert run(scene, '--output', 'new_{}', '--csv', '{}.csv') == 0
    assert sorted(path.name for path in folder.iterdir()) == ['new_single', 'single.csv']
    assert run(scene, '--output', 'other_{}', '--expect', '{}.csv') == 0
