"""Options that name a file, given what would be waited for, or must not be written to."""

import os
from pathlib import Path
import shutil
import socket
import subprocess
import sys
import threading

import pytest
from support.waiting import PATIENCE

from colortrack_ros.batch import FilesParser
from colortrack_ros.files import in_time
from colortrack_ros.replay.command import replay
from colortrack_ros.tools.evaluate import main as evaluate
from colortrack_ros.tools.pick_color import main as pick_color
from colortrack_ros.tools.tune import main as tune

SCENE = 'scene:single?width=64&height=48&duration=1'

COMMANDS = {
    'replay': lambda words: replay(words, threading.Event()),
    'evaluate': evaluate,
    'pick_color': pick_color,
    'tune': tune,
}

READ = (
    'replay ODD.mcap',
    'replay ODD.db3',
    'replay whole',
    f'replay {SCENE} --output new --params-file ODD',
    f'replay {SCENE} --output new --expect ODD',
    'evaluate ODD.csv',
    'evaluate ODD.txt',
    'evaluate ODD.mcap',
    'evaluate tracks.csv --truth ODD.csv',
    'evaluate tracks.csv --params-file ODD',
    f'tune {SCENE} --params-file ODD --trials 1',
)
WRITTEN = (
    f'replay {SCENE} {SCENE.replace("single", "five")} --output new/{{}} --report ODD',
    f'replay {SCENE} --output new --csv ODD --force',
    'evaluate tracks.csv --json ODD',
    'evaluate tracks.csv --html ODD',
    'evaluate tracks.csv --report ODD',
    f'pick_color {SCENE} 30 20 --output ODD.png',
    f'pick_color {SCENE} 30 20 --write ODD',
)


@pytest.fixture(params=['pipe', 'socket', 'device'])
def odd(request, tmp_path, monkeypatch):
    """Places something that is no file under each name; the working folder."""
    monkeypatch.chdir(tmp_path)
    Path('tracks.csv').write_text('frame,id,u,v\n0,1,2,3\n1,1,2,3\n')
    command = [SCENE, '--output', 'whole']
    assert replay(command, threading.Event()) == 0
    (recorded,) = Path('whole').glob('*.mcap')
    recorded.unlink()
    made = []
    for path in (
        recorded,
        *map(Path, ('ODD', 'ODD.mcap', 'ODD.db3', 'ODD.csv', 'ODD.txt', 'ODD.png')),
    ):
        if request.param == 'pipe':
            os.mkfifo(path)
        elif request.param == 'socket':
            made.append(socket.socket(socket.AF_UNIX))
            made[-1].bind(str(path))
        else:
            path.symlink_to('/dev/zero')
    yield tmp_path
    for one in made:
        one.close()


@pytest.mark.slow
def test_no_command_waits_for_what_is_no_file_or_writes_to_it(odd, capsys):
    kinds = {path: path.stat().st_mode for path in odd.rglob('*ODD*')}
    for line in (*READ, *WRITTEN):
        name, *words = line.split()
        status = in_time(lambda n=name, w=words: COMMANDS[n](w), PATIENCE)
        printed = capsys.readouterr()
        assert status == 1, line
        assert 'expected ' in printed.err, line
        assert len(printed.err.splitlines()) <= 2, line
    assert {path: path.stat().st_mode for path in odd.rglob('*ODD*')} == kinds


def test_a_list_of_arguments_that_is_no_file_is_an_error_of_the_command_line(odd, capsys):
    parser = FilesParser('any')
    parser.add_argument('words', nargs='*')
    Path('list').write_text('a\nb\n')
    assert parser.parse_args(['@list', 'c']).words == ['a', 'b', 'c']
    for path in ('ODD', 'missing', '/dev/zero'):
        with pytest.raises(SystemExit):
            parser.parse_args([f'@{path}'])
        assert f'@{path}: ' in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.parametrize('code', ['nodes.tracker', 'tuner.main'])
def test_no_params_file_is_waited_for_at_the_start(tmp_path, code):
    os.mkfifo(tmp_path / 'pipe')
    large = tmp_path / 'large'
    large.write_bytes(b'# comment\n' * 200_000)
    call = f'import sys; from colortrack_ros.{code} import main; sys.exit(main())'
    for path in (tmp_path / 'pipe', large):
        ros = ['--ros-args', '--params-file', str(path)]
        command = [
            sys.executable,
            '-c',
            call,
            *(['/eye', '--port', '0'] if 'tuner' in code else []),
            *ros,
        ]
        done = subprocess.run(
            command, capture_output=True, text=True, timeout=PATIENCE, check=False
        )
        assert done.returncode == 1
        assert 'expected a file' in done.stderr
        assert len(done.stderr.splitlines()) == 1


@pytest.mark.slow
def test_the_commands_work_with_files(tmp_path, monkeypatch):
    """What the tests above refuse for the file's sake, and for that alone."""
    monkeypatch.chdir(tmp_path)
    shutil.copy(Path(__file__).parents[1] / 'params/colortrack.yaml', 'any.yaml')
    assert (
        COMMANDS['replay']([SCENE, '--output', 'b', '--csv', 't.csv', '--params-file', 'any.yaml'])
        == 0
    )
    assert (
        COMMANDS['replay'](
            [SCENE, '--output', 'c', '--expect', 't.csv', '--params-file', 'any.yaml']
        )
        == 0
    )
    assert (
        evaluate(['t.csv', '--json', 'o.json', '--html', 'o.html', '--params-file', 'any.yaml'])
        == 0
    )
    assert pick_color([SCENE, '30', '20', '--write', 'any.yaml', '--output', 'o.jpg']) == 0
    assert {'o.json', 'o.html', 'o.jpg'} <= set(os.listdir())


@pytest.mark.slow
@pytest.mark.parametrize(
    'words', [['replay', 'NAME.mp4', '--output', 'new'], ['replay', SCENE, '--video', 'NAME.mp4']]
)
def test_a_name_that_is_not_utf8_is_refused_where_opencv_would_crash(tmp_path, words):
    name = os.fsdecode(b'ball\xff')
    (tmp_path / f'{name}.mp4').touch()
    given = [word.replace('NAME', name) for word in words]
    code = 'import sys; from colortrack_ros.replay.main import main; sys.exit(main())'
    command = [sys.executable, '-c', code, *given[1:], '--force']
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert 'expected a name in UTF-8' in done.stderr


@pytest.mark.parametrize(
    'words', ['replay EMPTY', 'evaluate EMPTY', f'evaluate {SCENE} --truth EMPTY', 'tune EMPTY']
)
def test_an_empty_name_is_an_error_and_not_the_current_folder(tmp_path, monkeypatch, capsys, words):
    """As of a variable of the shell that is not set: everything in the folder was replayed."""
    monkeypatch.chdir(tmp_path)
    command, *given = ['' if word == 'EMPTY' else word for word in words.split()]
    with pytest.raises(SystemExit) as ended:
        COMMANDS[command](given)
    assert ended.value.code == 2
    assert 'got an empty name; is a variable of the shell not set?' in capsys.readouterr().err


def test_empty_lines_in_a_file_of_arguments_are_no_arguments(tmp_path):
    parser = FilesParser('any')
    parser.add_argument('words', nargs='+')
    (tmp_path / 'list').write_bytes(b'one two\r\n\r\n  \nthree\n')
    assert parser.parse_args([f'@{tmp_path}/list']).words == ['one two', 'three']


def test_expected_tracks_may_have_passed_through_a_spreadsheet(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    run = COMMANDS['replay']
    assert run([SCENE, '--output', 'b', '--csv', 't.csv']) == 0
    text = Path('t.csv').read_text().replace('\n', '\r\n')
    Path('t.csv').write_bytes(text.encode('utf-8-sig'))
    assert run([SCENE, '--output', 'c', '--expect', 't.csv']) == 0
