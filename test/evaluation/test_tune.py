"""tune: what is found is better also where it was not searched, or is not written."""

import numpy as np
import pytest
import yaml

from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection import ReferenceColor
from colortrack_ros.evaluation import Record
from colortrack_ros.evaluation.record import empty_rows
from colortrack_ros.tools.tune import doubts
from colortrack_ros.tools.tune import main
from colortrack_ros.tools.tune_search import pruned
from colortrack_ros.tools.tune_search import search
from colortrack_ros.tools.tune_search import Slider
from colortrack_ros.tools.tune_search import sliders_of
from colortrack_ros.tools.tune_trial import halves
from colortrack_ros.tools.tune_trial import Labeled
from colortrack_ros.tools.tune_trial import split
from colortrack_ros.tools.tune_trial import Trial
from colortrack_ros.tracking import TrackerConfig

SLIDERS = [
    Slider('detector', 'min_area', 4, 4000, 20),
    Slider('tracker', 'process_noise', 100.0, 1e5, 0.0, learned=True),
    Slider('detector', 'closing_size', 1, 21, 1, odd=True),
    Slider('tracker', 'min_score', 0.0, 0.95, 0.5),
]
AREA, NOISE, CLOSING, SCORE = ((slider.node, slider.name) for slider in SLIDERS)
FILE = """# where the robot plays
/**/detector:
  ros__parameters:
    colors: [red]
    red: {rgb: [205, 58, 34], tolerance: 6.0}  # by eye
    min_area: 20
"""
SCENES = [f'scene:single?width=160&height=120&rate=6&duration=2&seed={k}' for k in (1, 2, 3)]


def test_sliders_stand_for_values_that_the_nodes_accept_and_begin_where_they_are():
    colors = (
        ReferenceColor('a', (50.0, 60.0, 40.0), 25.0),
        ReferenceColor('b', (50.0, 60.0, 40.0), tolerance_lab=(30.0, 8.0, 7.0)),
        ReferenceColor('c', (50.0, 60.0, 40.0), 0.0),
    )
    for slider in sliders_of(DetectorConfig(colors=colors), TrackerConfig()):
        now = slider.value(slider.place)
        assert now == pytest.approx(
            list(slider.start) if isinstance(slider.start, tuple) else slider.start, rel=0.05
        )
        assert slider.is_at_bound(slider.value(1.0))
        for place in np.linspace(0, 1, 9):
            value = slider.value(place)
            if slider.odd:
                assert value % 2 == 1
            if slider.learned:
                assert (value == 0) == (place < 0.15)


def test_the_search_finds_what_is_good_and_leaves_what_does_not_matter():
    def judge(candidates):
        return [
            1.0
            - 0.1 * abs(np.log(v.get(AREA, 20) / 300))
            - 0.02 * abs(v.get(CLOSING, 1) - 7)
            - (0.1 if v.get(NOISE, 0.0) > 0 else 0)
            for v in candidates
        ]

    found = search(SLIDERS, judge, 120, seed=0)
    kept, worth = pruned(found, judge)
    assert set(kept) == {AREA, CLOSING}
    assert judge([kept])[0] > 0.85 > judge([{}])[0] + 0.2
    assert worth[AREA] > worth[CLOSING] > 0
    assert search(SLIDERS, judge, 24, seed=0) == search(SLIDERS, judge, 24, seed=0)


def test_what_is_searched_and_what_is_held_out_share_no_frame_and_leave_none():
    truth = read_truth(60)
    searched, held_out = halves(truth)
    assert sorted([*searched.frames, *held_out.frames]) == truth.frames.tolist()
    assert len(held_out.frames) == 20
    assert np.count_nonzero(np.diff(held_out.frames) > 1) == 1  # two stretches


def test_of_three_recordings_or_more_every_third_is_held_out_whole():
    truths = [read_truth(60 + k) for k in range(7)]
    lengths = [tuple(len(part.frames) for part in parts) for parts in split(truths)]
    assert lengths == [(60, 0), (61, 0), (0, 62), (63, 0), (64, 0), (0, 65), (66, 0)]
    assert [[len(part.frames) for part in parts] for parts in split(truths[:1])] == [[40, 20]]


def read_truth(count):
    rows = empty_rows(count)
    rows['frame'], rows['id'] = np.arange(count), 1
    return Record.of(rows, range(count))


def said(*, searched=(0.5, 0.6), held_out=(0.5, 0.6), frames=120, count=3, at_bound=()):
    parts = split([read_truth(frames) for _ in range(count)])
    labeled = [Labeled(f'r{k}', '', part) for k, part in enumerate(parts)]
    before, after = (
        Trial(
            *(
                [value[k] if len(part.frames) else np.nan for part in some]
                for value, some in zip((searched, held_out), zip(*parts, strict=True), strict=True)
            )
        )
        for k in range(2)
    )
    return ' '.join(doubts(labeled, before, after, at_bound))


def test_doubts_are_told_where_there_is_reason_and_only_there():
    assert said() == ''
    assert 'one recording' in said(count=1)
    assert 'two recordings' in said(count=2)
    assert '20 labeled frames' in said(frames=20)
    assert 'r2 is worse where it was held out: 0.700 -> 0.600' in said(held_out=(0.7, 0.6))
    assert 'fitted to the frames' in said(held_out=(0.5, 0.51))
    assert 'min_area is at the end' in said(at_bound=SLIDERS[:1])


@pytest.mark.slow
def test_a_bad_tolerance_is_mended_and_the_rest_of_the_file_stays(tmp_path, capsys):
    given, tuned = tmp_path / 'mine.yaml', tmp_path / 'tuned.yaml'
    given.write_text(FILE)
    arguments = [*SCENES, '--params-file', str(given), '--radius', '6', '--trials', '12']
    assert main([*arguments, '--write', str(tuned)]) == 0
    printed = capsys.readouterr().out
    assert 'detector red.tolerance' in printed
    text = tuned.read_text()
    assert text.startswith('# where the robot plays')
    assert '# by eye' in text
    detector = yaml.safe_load(text)['/**/detector']['ros__parameters']
    assert detector['red']['tolerance'] != 6.0
    assert detector['red']['rgb'] == [205, 58, 34]
    assert given.read_text() == FILE


@pytest.mark.slow
def test_what_is_no_better_where_it_was_held_out_is_not_written(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr('colortrack_ros.tools.tune.search', lambda *_: {SCORE: 0.99})
    tuned = tmp_path / 'tuned.yaml'
    assert main([SCENES[0], '--radius', '6', '--write', str(tuned)]) == 3
    assert 'nothing is written' in capsys.readouterr().err
    assert not tuned.exists()


@pytest.mark.parametrize(
    ('arguments', 'reason'),
    [
        (['video.mp4'], 'video.mp4: its truth is not known; expected --truth'),
        (['video.mp4', '--truth', 'none.csv'], 'none.csv: cannot be read'),
        (['scene:nothing'], 'unknown scene'),
        ([SCENES[0], '-p', 'tracker:max_hidden:=-1.0'], 'max_hidden: expected'),
        ([SCENES[0], '--params-file', 'none.yaml'], 'none.yaml'),
    ],
)
def test_what_cannot_be_tuned_is_told_in_one_line(arguments, reason, capsys):
    assert main(arguments) == 1
    errors = capsys.readouterr().err
    assert errors.startswith('tune: ')
    assert reason in errors
    assert errors.count('\n') == 1
