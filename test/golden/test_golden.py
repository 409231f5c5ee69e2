"""The golden recording gives its tracks, and a difference says where it is."""

import csv
from pathlib import Path
import signal

import cv2
from golden.make import CONTOURS
import pytest

from colortrack_ros.node_kit.runtime import StartError
from colortrack_ros.replay.expected import ExpectedOutput
from colortrack_ros.replay.main import main
from colortrack_ros.signals import ending_signals

HERE = Path(__file__).parent


@pytest.fixture
def replay(tmp_path, capsys):
    handlers = {number: signal.getsignal(number) for number in ending_signals()}

    def run(*options, source=(str(HERE / 'bag'),)):
        status = main([*source, '--output', str(tmp_path / 'new'), '--force', *options])
        return status, capsys.readouterr().out

    yield run
    for number, handler in handlers.items():
        signal.signal(number, handler)


@pytest.mark.slow
def test_the_tracks_of_the_recording_are_the_expected_ones(replay):
    status, printed = replay('--expect', str(HERE / 'tracks.csv'))
    assert status == 0, printed


@pytest.mark.slow
def test_contours_are_the_expected_ones_with_any_version_of_the_libraries(replay):
    status, printed = replay('--expect', str(HERE / 'contours.csv'), source=CONTOURS)
    assert status == 0, printed


def test_the_recording_is_small_and_shows_five_balls_behind_a_bar(replay):
    files = [file for file in HERE.rglob('*') if file.is_file() and file.suffix != '.pyc']
    assert sum(file.stat().st_size for file in files) < 300_000
    with (HERE / 'tracks.csv').open() as file:
        lines = list(csv.DictReader(file))
    assert {int(line['track_id']) for line in lines} == {1, 2, 3, 4, 5}
    assert any(line['state'] == '2' for line in lines)


@pytest.mark.slow
@pytest.mark.parametrize(
    ('change', 'differences'),
    [
        ({'u': '100.0'}, ['frame {frame}, track {track_id}: u is ']),
        ({'hits': '7000'}, ['frame {frame}, track {track_id}: hits is {hits}, expected 7000']),
        (
            {'track_id': '77'},
            [
                'frame {frame}, track {track_id}: is not expected',
                'frame {frame}, track 77: is missing',
            ],
        ),
        ({'stamp': '5'}, ['frame {frame}, track {track_id}: no frame with the stamp of this one']),
    ],
)
def test_a_difference_names_the_frame_the_track_and_the_amount(
    replay, tmp_path, change, differences
):
    with (HERE / 'tracks.csv').open() as file:
        lines = list(csv.DictReader(file))
    true = dict(lines[100])
    lines[100].update(change)
    path = tmp_path / 'tracks.csv'
    with path.open('w', newline='') as file:
        table = csv.DictWriter(file, lines[0])
        table.writeheader()
        table.writerows(lines)
    status, printed = replay('--expect', str(path))
    assert status == 1
    for difference in differences:
        assert difference.format(**true) in printed
    assert f'OpenCV {cv2.__version__}' in printed


@pytest.mark.slow
def test_other_settings_of_the_tracker_are_noticed(replay):
    status, printed = replay('--expect', str(HERE / 'tracks.csv'), '-p', 'process_noise:=100.0')
    assert status == 1
    assert 'a difference of' in printed
    assert printed.count('\n') < 40


@pytest.mark.parametrize('text', ['', 'stamp,track_id\n', 'stamp\n1\n', '\0'])
def test_what_is_no_table_is_an_error(tmp_path, replay, text):
    path = tmp_path / 'other.csv'
    path.write_text(text)
    assert replay('--expect', str(path))[0] == 1
    with pytest.raises(StartError, match='expected a table that --csv wrote'):
        ExpectedOutput(path)
