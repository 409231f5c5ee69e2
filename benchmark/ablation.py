"""What each mechanism of the tracker is worth: the tracker without it, on scenes and juggled balls.

python benchmark/ablation.py prints the table for benchmark/README.md and writes out/ablation.json
after each scene; parts of the names of rows, or --scenes and parts of those of scenes, run these
alone. A mechanism is switched off by one value of the configuration, or by replacing one function.
Beside the scenes, where an ideal detector gives boxes, there are points without boxes.
--constants adaptation.SLOW ... shows half and twice the value of constants of tracking/ instead.
"""

import argparse
from contextlib import ExitStack
import importlib
import json
from pathlib import Path
import statistics
import sys
from unittest import mock

import numpy as np
from points import cruise
from points import JUGGLING
from points import labels
from points import of_scene

sys.path.insert(0, str(Path(__file__).parents[1] / 'test'))

from worlds.hard import merging

from colortrack_ros.estimation.existence import HIDDEN_SHARE
from colortrack_ros.evaluation import Tally
from colortrack_ros.scenes import BLACKOUT
from colortrack_ros.tracking import adaptation
from colortrack_ros.tracking import disappearances
from colortrack_ros.tracking import extents
from colortrack_ros.tracking import merge_split
from colortrack_ros.tracking import noise
from colortrack_ros.tracking import prediction
from colortrack_ros.tracking import process_noise
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import tracker
from colortrack_ros.tracking import TrackerConfig
from colortrack_ros.tracking import turns
from colortrack_ros.tracking import update

OUT = Path(__file__).parents[1] / 'out' / 'ablation.json'
SCENES = (
    'single', 'enter_exit', 'five', 'crossing', 'occlusion', 'collision', 'swarm', 'juggle',
    'turns', 'flicker', 'vanish', 'clutter', 'fast',
)  # fmt: skip
FIRST_DENSITY = (adaptation.FIRST_FALSE + adaptation.LEAST_NEW) / adaptation.FIRST_AREA


def always_there(visible, *_):
    """Existence that nothing changes."""
    return np.full_like(visible, 0.95), np.full_like(visible, 0.05)


def no_stitches(*_):
    none = np.zeros(0, np.intp)
    return none, none


def same_everywhere(learned, z):
    """New objects are as likely inside the picture as at its border."""
    return np.full(len(z), 1 / learned.area)


def as_given(_, colors, variance):
    """Covariances that nothing corrects, and of which no usual one is known."""
    return np.ones((len(colors), 2)), np.zeros((len(colors), 2))


def hidden_as_assumed(_, place, *__):
    """What is lost is hidden as often in all places."""
    return np.full(len(place), HIDDEN_SHARE)


def replaced(owner, name, function):
    return lambda: mock.patch.object(owner, name, function)


WITHOUT = {
    'nothing switched off': ({}, []),
    'learned process noise': ({'process_noise': process_noise.FIRST_NOISE}, []),
    'learned speed': ({'initial_speed': adaptation.FIRST_SPEED}, []),
    'maneuvers': ({'maneuvers': False}, []),
    'learned clutter': ({'clutter_density': FIRST_DENSITY}, []),
    'existence': (
        {},
        [
            replaced(prediction, 'predict_existence', always_there),
            replaced(update, 'update_existence', always_there),
        ],
    ),
    'merge and split': ({}, [replaced(tracker, 'merge_split', lambda *given: given[1:3])]),
    'shared detections': (
        {},
        [replaced(tracker, 'share_centroids', lambda *given: (given[2], None))],
    ),
    'learned noise': (
        {},
        [replaced(noise.MeasurementNoise, 'factors', as_given)],
    ),
    'strays': ({}, [replaced(tracker, 'take_strays', lambda *given: given[2])]),
    'doubted turns': ({}, [replaced(tracker, 'doubt', lambda *_: None)]),
    'undecided turns': ({}, [replaced(turns, 'WIDER', np.inf)]),
    'duplicates': (
        {},
        [replaced(merge_split, 'leave_out_duplicates', lambda *given: given[2:0:-1])],
    ),
    'crossings': ({}, [replaced(tracker, 'defer', lambda *_: None)]),
    'fast starts': ({}, [replaced(tracker, 'start_fast', lambda *given: given[3])]),
    'learned disappearances': (
        {},
        [replaced(disappearances.Disappearances, 'share', hidden_as_assumed)],
    ),
    'camera motion': ({'ego_motion': 'none'}, []),
    'stitching': ({}, [replaced(tracker, 'find_stitches', no_stitches)]),
    'memory': ({'max_hidden': 0.0}, []),
    'learned sizes': (
        {},
        [
            replaced(extents, 'FOLLOWING_SHARE', 0.0),
            replaced(extents, '_learn_unlike', lambda *given: given[4]),
        ],
    ),
    'growth': ({}, [replaced(extents, 'learn_growth', lambda *_: None)]),
    'boxes': ({'use_boxes': False}, []),
    'births at the border': (
        {},
        [replaced(adaptation.Adaptation, 'birth_places', same_everywhere)],
    ),
    'centroid bias': ({'centroid_bias': 0.0}, []),
    'gating': ({'gating': False}, []),
    'associator nearest': ({'associator': 'nearest'}, []),
    'associator jpda': ({'associator': 'jpda'}, []),
    'model constant_acceleration': ({'motion_model': 'constant_acceleration'}, []),
    'model imm': ({'motion_model': 'imm'}, []),
    'model switched_pair': ({'motion_model': 'switched_pair'}, []),
}


def sequences():
    """Names of columns, and what makes their sequences; juggling only where its data is."""
    found = {name: (lambda name=name: [of_scene(name)]) for name in SCENES}
    found['blackout'] = lambda: [of_scene('blackout', **BLACKOUT)]
    found['points that merge'] = lambda: [merging(np.random.default_rng(0))]
    found['points in clutter'] = lambda: [cruise(30, clutter=1.0)]
    found['points that turn'] = lambda: [cruise(30, turns=0.02)]
    if JUGGLING.is_dir():
        files = sorted(JUGGLING.glob('*.csv'))
        found['juggling'] = lambda: [labels(file) for file in files]
        found['juggling, 90 %'] = lambda: [labels(file, drop=0.1) for file in files]
    return found


def measure(changes, patches, several):
    """IDF1 [%], mean over the sequences, and ID switches, their sum."""
    scores = []
    with ExitStack() as stack:
        for patch in patches:
            stack.enter_context(patch())
        for sequence in several:
            tally = Tally(sequence.max_distance)
            ours = Tracker(TrackerConfig(image_size=sequence.size, **changes))
            frames = zip(sequence.truth, sequence.hidden, sequence.detections, strict=True)
            for truth, hidden, detections in frames:
                rows = ours.update(detections).rows
                rows = rows[rows['state'] > 0]
                found = np.stack([rows['track_id'], rows['u'], rows['v']], axis=1)
                tally.add(truth, found, hidden)
            scores.append(tally.score())
    idf1 = 100 * statistics.mean(score.idf1 for score in scores)
    return idf1, sum(score.switches for score in scores)


def show(results):
    """Print the table in Markdown: IDF1 and switches, and how much IDF1 moved at most."""
    names = list(next(iter(results.values())))
    base = results.get('nothing switched off')
    print('| without | ' + ' | '.join(names) + ' | worst | best |')
    print('|---' * (len(names) + 3) + '|')
    for row, line in results.items():
        cells = [f'{idf1:.1f}, {switches}' for idf1, switches in line.values()]
        change = [line[name][0] - base[name][0] for name in names] if base else [0.0]
        cells += [f'{min(change):+.2f}', f'{max(change):+.2f}']
        print(f'| {row} | ' + ' | '.join(cells) + ' |')


def halved_and_doubled(constants):
    """Rows as those of WITHOUT, for names like adaptation.SLOW."""
    rows = {'nothing switched off': ({}, [])}
    for constant in constants:
        file, name = constant.split('.')
        module = importlib.import_module(f'colortrack_ros.tracking.{file}')
        for factor in (0.5, 2.0):
            value = np.multiply(getattr(module, name), factor)
            value = tuple(value) if value.ndim else float(value)
            rows[f'{constant} = {value}'] = ({}, [replaced(module, name, value)])
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('rows', nargs='*')
    parser.add_argument('--scenes', nargs='*', default=[])
    parser.add_argument('--constants', nargs='+', default=[])
    chosen = parser.parse_args()
    rows = {k: v for k, v in WITHOUT.items() if not chosen.rows or any(p in k for p in chosen.rows)}
    rows = halved_and_doubled(chosen.constants) if chosen.constants else rows
    results = {row: {} for row in rows}
    for name, make in sequences().items():
        if chosen.scenes and not any(part in name for part in chosen.scenes):
            continue
        several = make()
        for row, (changes, patches) in rows.items():
            results[row][name] = measure(changes, patches, several)
        OUT.parent.mkdir(exist_ok=True)
        OUT.write_text(json.dumps(results, indent=1))
        print(name, file=sys.stderr, flush=True)
    show(results)


if __name__ == '__main__':
    main()
