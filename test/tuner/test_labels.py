"""Truth from a few clicks: what is proposed between them, and what is written."""

import numpy as np
import pytest

from colortrack_ros.evaluation import compare
from colortrack_ros.evaluation import read_record
from colortrack_ros.evaluation import record_of_scene
from colortrack_ros.scenes import open_scene
from colortrack_ros.sources import open_source
from colortrack_ros.tuner.folder import Folder
from colortrack_ros.tuner.footage import RecordedFootage
from colortrack_ros.tuner.labeling import Labeling
from colortrack_ros.tuner.labels import csv_of
from colortrack_ros.tuner.labels import GUESSED
from colortrack_ros.tuner.labels import Mark
from colortrack_ros.tuner.labels import MEASURED
from colortrack_ros.tuner.labels import mot_of
from colortrack_ros.tuner.labels import NONE
from colortrack_ros.tuner.labels import propose
from colortrack_ros.tuner.settings import Settings
from colortrack_ros.tuner.survey import SIGHTING
from colortrack_ros.tuner.survey import Survey


def frames_of(paths):
    """Frames of dtype SIGHTING from the path of each track, None where it is not measured."""
    frames = []
    for k in range(max(map(len, paths.values()))):
        seen = [
            (track, (*path[k], 10, 10), True, 1.0)
            for track, path in paths.items()
            if k < len(path) and path[k] is not None
        ]
        frames.append(np.array(seen, SIGHTING))
    return frames


def click(u, v):
    return Mark((u, v, 0, 0))


def test_one_click_labels_the_whole_track():
    labels = propose({5: click(5, 52)}, frames_of({1: [(k, 50) for k in range(9)]}))
    assert labels.state.tolist() == [MEASURED] * 9
    assert labels.box[:, 0].tolist() == list(range(9))
    assert labels.box[3].tolist() == [3, 50, 10, 10]


def test_a_gap_between_two_tracks_of_one_object_is_guessed():
    first, second = [(k, 0) for k in range(4)], [None] * 8 + [(k, 0) for k in range(8, 12)]
    labels = propose({0: click(0, 0), 11: click(11, 0)}, frames_of({1: first, 2: second}))
    assert labels.state.tolist() == [MEASURED] * 4 + [GUESSED] * 4 + [MEASURED] * 4
    assert labels.box[:, 0].tolist() == list(range(12))


def test_where_two_tracks_have_changed_places_the_object_is_followed_over_the_crossing():
    left = [(10 * k, 5 * abs(k - 5)) for k in range(11)]
    right = [(100 - 10 * k, -5 * abs(k - 5)) for k in range(11)]
    swapped = {1: left[:6] + right[6:], 2: right[:6] + left[6:]}
    marks = {0: click(*left[0]), 10: click(*left[10])}
    assert propose(marks, frames_of(swapped)).box[:, :2].tolist() == [list(at) for at in left]


def test_what_is_said_to_be_gone_has_no_label_until_it_is_marked_again():
    frames = frames_of({1: [(k, 0) for k in range(10)]})
    labels = propose({2: click(2, 0), 5: Mark(None), 8: click(8, 0)}, frames)
    assert labels.state[5] == NONE
    assert labels.box[8, 0] == 8
    only_before = propose({2: click(2, 0), 5: Mark(None)}, frames)
    assert (only_before.state[5:] == NONE).all()


def test_a_box_that_is_drawn_holds_and_gives_its_size_to_its_neighbors():
    labels = propose({0: Mark((5, 5, 8, 6)), 4: click(9, 9)}, frames_of({1: [(90, 90)] * 5}))
    assert labels.box.tolist() == [[5 + k, 5 + k, 8, 6] for k in range(5)]
    assert labels.state.tolist() == [MEASURED, GUESSED, GUESSED, GUESSED, MEASURED]


def test_without_marks_or_frames_there_are_no_labels():
    assert propose({}, []).state.tolist() == []
    assert propose({3: click(1, 1)}, []).state.tolist() == [NONE, NONE, NONE, MEASURED]
    assert propose({0: Mark(None)}, frames_of({1: [(0, 0)]})).state.tolist() == [NONE]


@pytest.mark.slow
@pytest.mark.parametrize('suffix', ['csv', 'txt'])
def test_five_clicks_on_five_balls_are_the_truth_of_the_scene(tmp_path, suffix):
    spec = 'five?width=320&height=180&duration=8'
    scene = open_scene(spec)
    survey = Survey(open_source(f'scene:{spec}'), Settings())
    while survey.work():
        pass
    labels = {}
    for k in range(len(scene)):
        for ball in scene.truth(k)[scene.truth(k)['visible'] == 1]:
            if ball['id'] not in labels:
                mark = click(float(ball['u']), float(ball['v']))
                labels[int(ball['id'])] = propose({k: mark}, survey.frames)
    path = tmp_path / f'truth.{suffix}'
    path.write_text({'csv': csv_of, 'txt': mot_of}[suffix](labels))
    found = compare(read_record(path), record_of_scene(scene), radius=10.0, visible=0.5)
    assert found.measures['idf1'] > 0.95
    assert found.measures['rmse'] < 1.0


@pytest.mark.parametrize('suffix', ['csv', 'txt'])
def test_a_truth_that_is_there_is_loaded_and_mended_by_a_click_where_it_is_wrong(tmp_path, suffix):
    spec = 'scene:five?width=64&height=48&duration=1'
    labeling = Labeling(RecordedFootage(spec, lambda: open_source(spec)))
    labeling._footage.frame(20)  # so that it knows of so many
    path = (
        [(10.0 + k, 20.0, 4.0, 4.0) for k in range(20)],
        [(50.0 - k, 30.0, 4.0, 4.0) for k in range(20)],
    )
    lines = [
        f'{k},{1 + (which ^ (k >= 8))},{u},{v},{w},{h},{0.5 if k == 3 else 1}'
        for k in range(20)
        for which, (u, v, w, h) in enumerate(one[k] for one in path)
    ]
    (tmp_path / 'wrong.csv').write_text('\n'.join(['frame,id,u,v,w,h,visible', *lines]) + '\n')
    folder = Folder(tmp_path)
    labeling.load(folder, 'wrong.csv')
    assert labeling.state()['done']
    assert [one['labeled'] for one in labeling.state()['labels']] == [20, 20]
    labeling.save(folder, 'same.csv', overwrite=False)
    same, wrong = (
        np.sort(read_record(tmp_path / name).rows, order=('frame', 'id'))
        for name in ('same.csv', 'wrong.csv')
    )
    for name in ('frame', 'id', 'u', 'v', 'w', 'h', 'visible'):
        assert np.array_equal(same[name], wrong[name])
    for one in (1, 2):
        for frame in (7, 8):  # where it changes over
            labeling.mark(one, frame, click(*path[one - 1][frame][:2]))
    labeling.save(folder, f'right.{suffix}', overwrite=False)
    right = read_record(tmp_path / f'right.{suffix}').rows
    for one in (1, 2):
        mine = right[right['id'] == one]
        assert np.allclose(mine['u'], [at[0] for at in path[one - 1]])


@pytest.mark.parametrize(
    'text', ['frame,id\n', 'frame,id,u,v\n', 'frame,id,u,v\n0,9999,1,1\n', '\0']
)
def test_what_is_no_truth_is_not_loaded(tmp_path, text):
    spec = 'scene:five?width=64&height=48&duration=1'
    labeling = Labeling(RecordedFootage(spec, lambda: open_source(spec)))
    (tmp_path / 'none.csv').write_text(text)
    with pytest.raises(ValueError, match=r'none\.csv'):
        labeling.load(Folder(tmp_path), 'none.csv')
    assert labeling.state()['labels'] == []
