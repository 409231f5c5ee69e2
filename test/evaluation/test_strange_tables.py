"""Tables that others write: read as they are meant, or refused; never scored wrongly."""

import json

import numpy as np
import pytest

from colortrack_ros.evaluation import compare
from colortrack_ros.evaluation import read_record
from colortrack_ros.evaluation import Record
from colortrack_ros.evaluation import RecordError
from colortrack_ros.evaluation.record import empty_rows
from colortrack_ros.tools.evaluate import main

HEAD = 'frame,id,u,v,w,h\n'
LINES = ''.join(f'{k},{i},{2 * k},{50 * i},20,20\n' for k in range(20) for i in (1, 2))
NAMED = (HEAD + LINES).replace('\n', ',ball\n').replace('ball', 'kind', 1)
MOT = ''.join(f'{k + 1},{i},{2 * k - 8.5},{50 * i - 8.5},20,20,1,-1,-1,-1\n'
              for k in range(20) for i in (1, 2))  # fmt: skip


def write(path, text, encoding='utf-8'):
    path.write_bytes(text.encode(encoding))
    return str(path)


@pytest.mark.parametrize(
    ('name', 'text', 'encoding'),
    [
        ('of a spreadsheet.csv', (HEAD + LINES).replace('\n', '\r\n'), 'utf-8-sig'),
        ('with spaces.csv', (HEAD + LINES).replace(',', ', '), 'utf-8'),
        ('with names.csv', NAMED, 'utf-8'),
        ('from DOS.CSV', HEAD + LINES, 'utf-8'),
        ('of a spreadsheet.txt', MOT.replace('\n', '\r\n'), 'utf-8-sig'),
        ('backward.txt', ''.join(MOT.splitlines(keepends=True)[::-1]), 'utf-8'),
        ('from DOS.TXT', '# by hand\n\n' + MOT, 'utf-8'),
    ],
)  # fmt: skip
def test_tables_of_other_programs_are_read_as_they_are_meant(tmp_path, name, text, encoding):
    write(tmp_path / name, text, encoding)
    plain = read_record(tmp_path / write(tmp_path / 'plain.csv', HEAD + LINES))
    found = read_record(tmp_path / name)
    assert compare(plain, found, radius=1.0).measures['hota'] == 1.0
    assert np.array_equal(found.frames, plain.frames)


@pytest.mark.parametrize(
    ('name', 'text', 'reason'),
    [
        ('a.csv', HEAD + LINES + LINES[: len('0,1,0,50,20,20\n')], 'ID 1 twice in frame 0'),
        ('a.txt', MOT + '7,2,0,0,9,9,1,-1,-1,-1\n', 'ID 2 twice in frame 6'),
        ('a.txt', MOT.replace('1,1,-8.5', '0,1,-8.5', 1), 'frames from 1'),
        ('a.csv', HEAD + '-3,1,5,5,9,9\n', 'frames from 0'),
        ('a.csv', HEAD + 'nan,1,5,5,9,9\n', 'whole numbers for frames, got nan'),
        ('a.csv', HEAD + '0.5,1,5,5,9,9\n', 'whole numbers for frames, got 0.5'),
        ('a.csv', HEAD + '0,1.5,5,5,9,9\n', 'whole numbers for IDs, got 1.5'),
        ('a.csv', HEAD + '1700000000,1,5,5,9,9\n', 'frames from 0 to 10000000, got 1700000000'),
        ('a.csv', HEAD + '0,1,inf,5,9,9\n', 'finite'),
        ('a.csv', HEAD + '0,1,5,5,9,9\n1,1,5,,9,9\n', "line 3: expected a number for v, got ''"),
        ('a.csv', (HEAD + LINES).replace(',', ';'), 'with commas between'),
        ('a.csv', 'u,' + HEAD + '4,0,1,5,5,9,9\n', 'each column once, got u 2 times'),
    ],
)
def test_what_has_no_right_score_is_refused_with_the_reason(tmp_path, name, text, reason):
    with pytest.raises(RecordError, match=reason):
        read_record(tmp_path / write(tmp_path / name, text))


def test_a_truth_without_frames_is_refused_since_anything_would_be_perfect(tmp_path, capsys):
    tracks = write(tmp_path / 'tracks.txt', MOT)
    for truth in (write(tmp_path / 'a.csv', HEAD), write(tmp_path / 'b.txt', '')):
        assert main([tracks, '--truth', truth, '--min', 'mota=0.9']) == 1
        assert 'expected a truth of at least one frame' in capsys.readouterr().err


def test_tracks_without_rows_are_scored_and_the_json_is_json(tmp_path, capsys):
    truth, out = write(tmp_path / 'a.csv', HEAD + LINES), tmp_path / 'out.json'
    report = str(tmp_path / 'report')
    given = [write(tmp_path / 'b.txt', ''), '--truth', truth, '--json', str(out)]
    for _ in 'the first run', 'one that goes on from the report':
        assert main([*given, '--report', report, '--min', 'mota=0']) == 0
        assert capsys.readouterr().err == ''
        (result,) = json.loads(out.read_text(), parse_constant=pytest.fail)
        assert result['measures']['misses'] == 40
        assert 'rmse' not in result['measures']
        json.loads((tmp_path / 'report').read_text(), parse_constant=pytest.fail)


def test_centers_without_boxes_ask_for_a_radius(tmp_path, capsys):
    tracks = write(tmp_path / 'tracks.txt', MOT)
    truth = write(tmp_path / 'a.csv', 'frame,id,u,v\n0,1,5,5\n')
    assert main([tracks, '--truth', truth]) == 1
    assert 'expected boxes (w, h) in both, or --radius' in capsys.readouterr().err
    assert main([tracks, '--truth', truth, '--radius', '9']) == 0


def test_what_a_truth_of_motchallenge_does_not_count_need_not_be_found(tmp_path):
    """Its columns are frame, id, box, whether it counts, class, visibility."""
    lines = [','.join(line.split(',')[:6]) for line in MOT.splitlines()]
    text = ''.join(f'{line},{k % 2},{7 * (k % 2)},1\n' for k, line in enumerate(lines))
    truth = read_record(tmp_path / write(tmp_path / 'gt.txt', text))
    tracks = read_record(tmp_path / write(tmp_path / 'tracks.txt', MOT))
    both = compare(truth, tracks).measures
    assert (both['misses'], both['false'], both['mota']) == (0, 0, 1.0)
    one = Record.of(tracks.rows[tracks.rows['id'] == 2], tracks.frames)
    assert compare(truth, one).measures['misses'] == 0
    assert compare(truth, Record.of(empty_rows(0), [])).measures['misses'] == 20


@pytest.mark.parametrize('option', ['--iou=50', '--iou=nan', '--visible=nan', '--visible=30'])
def test_shares_are_shares(tmp_path, capsys, option):
    """With an overlap of 50 nothing matched, in silence."""
    tracks = write(tmp_path / 'tracks.txt', MOT)
    with pytest.raises(SystemExit):
        main([tracks, '--truth', tracks, option])
    assert f'argument {option.partition("=")[0]}: expected' in capsys.readouterr().err


def test_runs_of_one_name_are_told_apart_in_the_table(tmp_path, capsys, monkeypatch):
    monkeypatch.setenv('COLUMNS', '200')
    monkeypatch.chdir(tmp_path)
    for folder in ('old', 'new'):
        (tmp_path / folder).mkdir()
        write(tmp_path / folder / 'run.txt', MOT)
    assert main(['old/run.txt', 'new/run.txt']) == 0
    assert 'old/run.txt' in (told := capsys.readouterr().out)
    assert 'new/run.txt' in told
