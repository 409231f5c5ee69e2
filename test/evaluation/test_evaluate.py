from dataclasses import replace
import json

import numpy as np
import pytest
from support.paths import DATA

from colortrack_ros.bags import BagError
from colortrack_ros.bags import Topic
from colortrack_ros.evaluation import compare
from colortrack_ros.evaluation import read_record
from colortrack_ros.evaluation import Record
from colortrack_ros.evaluation import RecordError
from colortrack_ros.evaluation import statistics
from colortrack_ros.evaluation.per_second import per_second
from colortrack_ros.evaluation.record import empty_rows
from colortrack_ros.node_kit.detections_intake import CLOUD
from colortrack_ros.tools.evaluate import main
from colortrack_ros.tools.tracks_of_bag import tracks_of_bag


def lines(names, count=40, start=0):
    """Objects 100 px apart that move to the right, (frame, id, u, v, 20, 20)."""
    rows = empty_rows(count * len(names))
    k = np.repeat(np.arange(count), len(names)) + start
    i = np.tile(np.arange(len(names)), count)
    rows['frame'], rows['id'] = k, np.array(names)[i]
    rows['u'], rows['v'], rows['w'], rows['h'] = 2.0 * k, 100.0 * i, 20.0, 20.0
    return rows


def record(rows, count=40):
    return Record.of(rows, range(count))


def write_truth(path, rows):
    names = ['frame', 'id', 'u', 'v', 'w', 'h']
    text = '\n'.join(','.join(f'{row[name]:g}' for name in names) for row in rows)
    path.write_text(','.join(names) + '\n' + text + '\n')
    return str(path)


def write_mot(path, rows):
    path.write_text(
        ''.join(
            f'{r["frame"] + 1},{r["id"]},{r["u"] - 9.5 + 1},{r["v"] - 9.5 + 1},20,20,1,-1,-1,-1\n'
            for r in rows
        )
    )
    return str(path)


def test_the_truth_itself_is_perfect_in_every_measure():
    rows = lines([3, 5])
    for options in ({'radius': 10.0}, {'iou': 0.5}):
        result = compare(record(rows), record(rows), **options)
        good = {n: result.measures[n] for n in ('hota', 'deta', 'assa', 'idf1', 'mota', 'recall')}
        assert set(good.values()) == {1.0}
        assert result.switches == []
        assert len(result.matches) == 80


def test_a_switch_is_told_with_its_frame_object_and_place():
    tracks = lines([3, 5])
    late = tracks['frame'] >= 25
    tracks['id'][late] = np.where(tracks['id'][late] == 3, 5, 3)
    result = compare(record(lines([1, 2])), record(tracks), radius=10.0)
    assert [e[:4] for e in result.switches] == [(25, 1, 3, 5), (25, 2, 5, 3)]
    assert result.switches[0][4:] == (50.0, 0.0)
    assert result.measures['switches'] == 2
    assert result.objects[1]['tracks'] == [3, 5]


def test_a_gap_is_a_fragment_and_a_stray_track_is_false():
    tracks = lines([3])
    tracks = tracks[(tracks['frame'] < 10) | (tracks['frame'] > 14)]
    stray = lines([9], 5)
    stray['v'] = 500.0
    result = compare(record(lines([1])), record(np.concatenate([tracks, stray])), radius=10.0)
    wanted = {'fragments': 1, 'misses': 5, 'false': 5, 'false_tracks': 1, 'switches': 0}
    assert {name: result.measures[name] for name in wanted} == wanted


def test_tracks_in_frames_without_objects_are_false():
    result = compare(record(lines([1], 10), 40), record(lines([1])), radius=10.0)
    assert result.measures['false'] == 30


def test_what_is_hidden_need_not_be_found_and_a_track_on_it_is_not_false():
    truth = lines([1, 2])
    truth['visible'][(truth['id'] == 2) & (truth['frame'] < 20)] = 0.1
    both = compare(record(truth), record(lines([3, 5])), radius=10.0)
    assert (both.measures['false'], both.measures['misses']) == (0, 0)
    one = lines([3, 5])
    one = one[(one['id'] == 3) | (one['frame'] >= 20)]
    assert compare(record(truth), record(one), radius=10.0).measures['misses'] == 0


@pytest.mark.slow
def test_covariances_that_are_right_cover_95_percent():
    rng = np.random.default_rng(0)
    truth = lines([1, 2], 2000)
    tracks = truth.copy()
    P = np.array([[4.0, 1.0], [1.0, 2.0]])
    e = rng.multivariate_normal([0, 0], P, len(tracks))
    tracks['u'] += e[:, 0]
    tracks['v'] += e[:, 1]
    tracks['covariance'] = np.eye(4)
    tracks['covariance'][:, :2, :2] = P
    measures = compare(record(truth, 2000), record(tracks, 2000), radius=20.0).measures
    assert measures['nees'] == pytest.approx(1.0, abs=0.05)
    assert measures['coverage'] == pytest.approx(0.95, abs=0.015)
    assert measures['rmse'] == pytest.approx(np.sqrt(6), rel=0.03)


def test_without_truth_gaps_and_jumps_are_found():
    tracks = lines([1, 2])
    tracks['stamp'] = tracks['frame'] * 10**9
    tracks['du'], tracks['dv'] = 2.0, 0.0
    tracks['covariance'] = 0.01 * np.eye(4)
    assert statistics(record(tracks))['jumps'] == 0
    tracks['v'][tracks['frame'] == 20] += 50
    values = statistics(record(tracks[tracks['frame'] != 5]))
    assert values['gaps'] == 2
    assert values['jumps'] == pytest.approx(4 / 76)


def test_csv_and_motchallenge_of_the_same_tracks_are_the_same(tmp_path):
    rows = lines([3, 5])
    csv = read_record(tmp_path / write_truth(tmp_path / 'a.csv', rows))
    mot = read_record(tmp_path / write_mot(tmp_path / 'a.txt', rows))
    for name in ('frame', 'id', 'u', 'v', 'w', 'h'):
        assert np.array_equal(csv.rows[name], mot.rows[name])


@pytest.mark.parametrize(
    'text',
    ['', 'frame,id\n1,2\n', 'frame,id,u,v\n1,2,x,4\n', 'frame,id,u,v\n1,2\n', '\0\0', 'a,b\n"'],
)
def test_a_file_that_is_no_table_is_refused_with_its_name(tmp_path, text):
    for name in ('odd.csv', 'odd.txt'):
        (tmp_path / name).write_text(text or 'x')
        with pytest.raises(RecordError, match=name):
            read_record(tmp_path / name)


def test_thresholds_decide_the_exit_status(tmp_path, capsys):
    truth = write_truth(tmp_path / 'truth.csv', lines([1, 2]))
    tracks = write_mot(tmp_path / 'tracks.txt', lines([3]))
    arguments = [tracks, '--truth', truth, '--radius', '10']
    assert main([*arguments, '--min', 'recall=0.5', '--max', 'switches=0']) == 0
    assert main([*arguments, '--min', 'recall=0.9']) == 3
    assert 'recall is 0.5, expected at least 0.9' in capsys.readouterr().err
    assert main([*arguments, '--max', 'speling=0']) == 3
    assert 'speling is not known' in capsys.readouterr().err
    assert main([str(tmp_path / 'none.csv'), '--truth', truth]) == 1
    with pytest.raises(SystemExit):
        main([*arguments, '--min', 'idf1'])


def test_all_figures_are_in_the_json(tmp_path):
    truth = write_truth(tmp_path / 'truth.csv', lines([1, 2]))
    tracks = write_mot(tmp_path / 'tracks.txt', lines([3, 5]))
    out = tmp_path / 'out.json'
    assert main([tracks, '--truth', truth, '--json', str(out)]) == 0
    (result,) = json.loads(out.read_text())
    assert result['measures']['hota'] == 1.0
    assert result['objects']['1']['found'] == 1.0


@pytest.mark.skipif(not DATA.is_dir(), reason=f'needs the recordings in {DATA}')
def test_real_truth_is_read_with_the_frames_that_are_labeled():
    truth = read_record(DATA / 'real' / 'cups.csv')
    assert len(truth.frames) < truth.frames[-1]
    assert compare(truth, truth, radius=30.0).measures['idf1'] == 1.0


def test_the_page_stands_alone_and_shows_each_switch(tmp_path):
    tracks = lines([3])
    tracks['id'][25:] = 4
    truth = write_truth(tmp_path / 'truth.csv', lines([1]))
    page = tmp_path / 'report.html'
    run = write_mot(tmp_path / '<b>.txt', tracks)
    arguments = [run, '--truth', truth, '--html', str(page), '--pictures', 'scene:single']
    assert main(arguments) == 0
    text = page.read_text()
    assert '<b>' not in text
    assert 'http' not in text
    assert 'track 3, frames 0 to 24' in text
    assert 'track 4, frames 25 to 39' in text
    assert text.count('<img') == 1
    assert main([run, '--html', str(page)]) == 0
    assert main([*arguments[:-1], 'nothing.mp4']) == 1
    assert main([run, '--html', str(tmp_path / 'none' / 'page.html')]) == 1


def test_many_have_a_truth_each_and_a_failure_is_told_with_the_rest(tmp_path, capsys):
    for folder in ('truth', 'tracks'):
        (tmp_path / folder).mkdir()
    for number in range(6):
        rows = lines([1, 2], 10 + number)
        write_truth(tmp_path / 'truth' / f'run{number}.csv', rows)
        write_mot(tmp_path / 'tracks' / f'run{number}_tracks.txt', rows)
    (tmp_path / 'truth' / 'run3.csv').unlink()
    truth = str(tmp_path / 'truth' / '{}.csv')
    results = []
    for name, options in (('a', ['--jobs', '2', '--report', str(tmp_path / 'report')]), ('b', [])):
        json_path, page = tmp_path / f'{name}.json', tmp_path / f'{name}.html'
        out = ['--json', str(json_path), '--html', str(page)]
        assert main([str(tmp_path / 'tracks'), '--truth', truth, *options, *out]) == 1
        printed = capsys.readouterr()
        assert 'run3.csv: cannot be read' in printed.err
        assert 'all' in printed.out
        results.append((json.loads(json_path.read_text()), page.read_text()))
    assert results[0] == results[1]
    measures = [result['measures'] for result in results[0][0]]
    assert [m['idf1'] for m in measures] == [1.0] * 5
    report = [json.loads(line) for line in (tmp_path / 'report').read_text().splitlines()]
    assert [line['error'] == '' for line in report] == [n != 3 for n in range(6)]


def test_a_bag_is_closed_also_where_its_tracks_cannot_be_read(tmp_path, monkeypatch):
    closed = []

    class Broken:
        topics = (Topic('/tracks', CLOUD, 3),)

        def __init__(self, path):
            pass

        def messages(self, topic):
            raise BagError('ends early')

        def close(self):
            closed.append(True)

    monkeypatch.setattr('colortrack_ros.tools.tracks_of_bag.BagReader', Broken)
    with pytest.raises(RecordError, match='ends early'):
        tracks_of_bag(tmp_path / 'run', '')
    assert closed == [True]


def stray(first, count):
    rows = lines([9], count, first)
    rows['v'] = 500.0
    return rows


def test_a_false_track_is_told_with_its_first_place_and_shown(tmp_path):
    tracks = np.concatenate([lines([3]), stray(7, 5)])
    result = compare(record(lines([1])), record(tracks), radius=10.0)
    assert result.false_tracks == [(7, 9, 5, 14.0, 500.0)]
    assert result.counts[[6, 7, 11, 12]].tolist() == [
        [6, 1, 1, 0], [7, 1, 1, 1], [11, 1, 1, 1], [12, 1, 1, 0],
    ]  # fmt: skip
    page, run = tmp_path / 'page.html', write_mot(tmp_path / 'run.txt', tracks)
    truth = write_truth(tmp_path / 'truth.csv', lines([1]))
    out = ['--html', str(page), '--pictures', 'scene:single?width=640&height=480']
    assert main([run, '--truth', truth, '--radius', '10', *out]) == 0
    assert 'alt="frame 7: track 9, 5 frames"' in page.read_text()


def test_each_second_is_counted_also_those_without_tracks():
    tracks = np.concatenate([lines([3]), stray(25, 3)])
    tracks['stamp'] = tracks['frame'] * 10**8 + 5 * 10**9
    frame = tracks['frame']
    tracks = tracks[(frame < 10) | ((frame >= 20) & (frame < 35))]
    tracks['id'][(tracks['frame'] >= 30)] = 4
    tracks = record(tracks)
    result = compare(record(lines([1])), tracks, radius=10.0)
    wanted = [(0, 10, 10, 0, 0), (1, 10, 0, 0, 0), (2, 10, 10, 3, 0), (3, 10, 5, 0, 1)]
    assert per_second(tracks, result) == wanted
    tracks.rows['stamp'] = -1
    assert per_second(tracks, result) == []


def test_frames_that_are_missing_between_others_are_lost_and_a_new_start_is_not():
    stamps = np.delete(np.arange(100), [10, 50, 51]) * 33_333_333
    tracks = replace(record(lines([1])), stamps=np.concatenate([stamps, stamps]))
    assert statistics(tracks)['lost'] == pytest.approx(6 / 200)
    assert 'lost' not in statistics(record(lines([1])))


def test_the_parameters_that_differ_are_shown_beside_their_runs(tmp_path, capsys):
    files = []
    for name, area in (('a', 20), ('b', 90)):
        (tmp_path / f'{name}.yaml').write_text(
            f'detector:\n  ros__parameters: {{min_area: {area}, erosion_size: 3}}\n'
        )
        files += ['--params-file', str(tmp_path / f'{name}.yaml')]
    runs = [write_mot(tmp_path / f'{name}.txt', lines([1])) for name in ('one', 'two')]
    page = tmp_path / 'page.html'
    assert main([*runs, *files, '--html', str(page)]) == 0
    printed = capsys.readouterr().out
    assert 'detector min_area' in printed
    assert 'erosion_size' not in printed
    assert '<td>detector min_area</td><td>20</td><td>90</td>' in page.read_text()
    assert main([*runs, *files[:2]]) == 1
    assert 'expected 2, one for each run; got 1' in capsys.readouterr().err
