"""Public detections of people through the tracker: ``python benchmark/pedestrians.py FOLDER``.

FOLDER holds folders of MOTChallenge (seqinfo.ini, det/det.txt, gt/gt.txt). The tracker gets all
boxes as they come, and the picture's size. A track is right whose box has its center in the ellipse
of a true box: the border of the picture cuts both. Told are all published rows and those that are
measured alone; beside them, where they are installed, SORT and ByteTrack of ``trackers``, which
publish no others.
"""

import argparse
from collections.abc import Iterator
import configparser
from importlib.util import find_spec
import itertools
from pathlib import Path
from typing import NamedTuple
import warnings

import motmetrics
import numpy as np

from colortrack_ros.data import COASTING
from colortrack_ros.data import DETECTION
from colortrack_ros.data import Detections
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import TENTATIVE
from colortrack_ros.estimation.boxes import overlaps
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig

FIGURES = ('idf1', 'mota', 'precision', 'num_switches')

PEERS = ('SORTTracker', 'ByteTrackTracker') if find_spec('trackers') else ()

DISTRACTORS = 2, 7, 8, 12
"""Classes of MOTChallenge that are not judged: riders, who stands still, the like, mirrored."""

OURS: dict[str, dict[str, object]] = {'ours': {}, 'without use_boxes': {'use_boxes': False}}

Rows = np.ndarray
"""(N, 7): frame, id, left, top, width, height [px], and 1 for what is measured."""


class Sequence(NamedTuple):
    """Detections, (N, 7), and truth, (N, 6); [1/s]; [px].

    Both are frame, id, left, top, width, height [px], and detections the score as well, 0 to 1.
    """

    detections: np.ndarray
    truth: np.ndarray
    rate: float
    size: tuple[int, int]

    @classmethod
    def of(cls, folder: Path, *, judged: bool = False) -> 'Sequence':
        """The one in a folder.

        :param judged: without detections of what MOTChallenge does not judge (Milan et al. 2016).
        """
        ini = configparser.ConfigParser()
        ini.read(folder / 'seqinfo.ini')
        about = ini['Sequence']
        size = about.getint('imWidth', 0), about.getint('imHeight', 0)
        truth = np.loadtxt(folder / 'gt/gt.txt', delimiter=',')
        people = truth[:, 6] != 0
        if truth.shape[1] == 9:  # of 2016 and later: the class follows, of which 1 is a pedestrian
            people &= truth[:, 7] == 1
        path = folder / 'det/det.txt'  # others recorded the truth alone (of_others.py)
        found = np.loadtxt(path, delimiter=',') if path.exists() else np.zeros((0, 7))
        box, score = found[:, :6], squashed(found[:, 6]) if found.shape[1] > 6 else 1.0
        scored = np.column_stack([box, np.broadcast_to(score, len(box))])
        if judged and truth.shape[1] == 9:
            scored = scored[~_on(scored, truth[np.isin(truth[:, 7], DISTRACTORS)], truth[people])]
        return cls(scored, truth[people, :6], about.getfloat('frameRate', 25.0), size)

    def frames(self) -> Iterator[tuple[int, np.ndarray]]:
        """Number, and boxes and scores, (N, 5), of each frame."""
        for k in range(1, int(max(self.detections[:, 0].max(), self.truth[:, 0].max())) + 1):
            yield k, self.detections[self.detections[:, 0] == k, 2:]


def _on(found: np.ndarray, ones: np.ndarray, others: np.ndarray) -> np.ndarray:
    """(N,) whether boxes of frames lie on ones, and not on others, by an overlap of a half."""
    on = np.zeros((2, len(found)), bool)
    for row, k in itertools.product((0, 1), np.unique(found[:, 0])):
        true, here = (ones, others)[row], found[:, 0] == k
        overlap = overlaps(*(_edges(boxes) for boxes in (found[here], true[true[:, 0] == k])))
        on[row, here] = (overlap >= 0.5).any(axis=1)
    return np.asarray(on[0] & ~on[1])


def _edges(rows: np.ndarray) -> np.ndarray:
    """(N, 4): left, top, right, bottom of the boxes of detections or truth."""
    return np.concatenate([rows[:, 2:4], rows[:, 2:4] + rows[:, 4:6] - 1], axis=1)


def squashed(score: np.ndarray) -> np.ndarray:
    """Scores, (N,), as probabilities; some detectors give the log odds, in a unit of their own."""
    if score.min(initial=0.0) >= 0 and score.max(initial=0.0) <= 1:
        return score
    return 1 / (1 + np.exp(-score / score.std()))


def message(sequence: Sequence, k: int, found: np.ndarray) -> Detections:
    """Of the boxes and scores of a frame, (N, 5); of points where they have no size."""
    rows, box = np.zeros(len(found), DETECTION), found[:, :4]
    rows['u'], rows['v'] = (box[:, :2] + box[:, 2:] / 2).T
    if box[:, 2:].any():
        rows['box_u'], rows['box_v'], rows['box_w'], rows['box_h'] = box.T
        rows['area'] = box[:, 2] * box[:, 3]
    rows['score'] = found[:, 4]
    return Detections(rows, round(k / sequence.rate * NANOSECONDS))


def ours(sequence: Sequence, **options: object) -> Rows:
    """What the tracker publishes."""
    tracker, found = Tracker(TrackerConfig(image_size=sequence.size, **options)), []
    for k, boxes in sequence.frames():
        tracks = tracker.update(message(sequence, k, boxes)).rows
        for row in tracks[tracks['state'] != TENTATIVE]:
            w, h = row['box_w'], row['box_h']
            corner = row['box_u'], row['box_v']  # u and v are the center of all of the object
            found.append((k, row['track_id'], *corner, w, h, row['state'] != COASTING))
    return np.array(found, float)


def theirs(sequence: Sequence, name: str, *, scored: bool = False) -> Rows:
    """What a peer publishes that takes boxes; without their scores, all have 0.9."""
    import supervision
    import trackers

    tracker, found = getattr(trackers, name)(frame_rate=sequence.rate), []
    for k, box in sequence.frames():
        corners = np.concatenate([box[:, :2], box[:, :2] + box[:, 2:4]], axis=1)
        sure = box[:, 4].astype(np.float32) if scored else np.full(len(box), 0.9, np.float32)
        kind = np.zeros(len(box), int)
        out = tracker.update(supervision.Detections(corners.astype(np.float32), None, sure, kind))
        for i, (left, top, right, bottom) in zip(out.tracker_id, out.xyxy, strict=True):
            if i is not None and i >= 0:
                found.append((k, i, left, top, right - left, bottom - top, 1))
    return np.array(found, float).reshape(-1, 7)


def events(truth: np.ndarray, rows: Rows) -> motmetrics.MOTAccumulator:
    """Which rows are right, and which are of whom."""
    tally = motmetrics.MOTAccumulator(auto_id=True)
    for k in range(1, int(truth[:, 0].max()) + 1):
        true, found = truth[truth[:, 0] == k], rows[rows[:, 0] == k]
        center, other = (a[:, 2:4] + a[:, 4:6] / 2 for a in (true, found))
        away = np.hypot(*((center[:, None] - other) / (true[:, None, 4:6] / 2)).T).T
        tally.update(
            true[:, 1].astype(int), found[:, 1].astype(int), np.where(away > 1, np.nan, away)
        )
    return tally


def score(truth: np.ndarray, rows: Rows) -> np.ndarray:
    """FIGURES of rows."""
    tally = events(truth, rows)
    return motmetrics.metrics.create().compute(tally, metrics=list(FIGURES)).to_numpy()[0]


def thinned(sequence: Sequence, seed: int) -> Sequence:
    """A sequence without 5 % of the detections."""
    kept = np.random.default_rng(seed).random(len(sequence.detections)) > 0.05
    return sequence._replace(detections=sequence.detections[kept])


def figures(sequences: list[Sequence]) -> dict[str, np.ndarray]:
    """The six figures, (6,), of us and of peers, see main()."""
    runs = {name: [ours(one, **options) for one in sequences] for name, options in OURS.items()}
    runs |= {name: [theirs(one, name) for one in sequences] for name in PEERS}
    tables = {}
    for name, every in runs.items():
        told = (('', 0), (', measured', 1)) if name in OURS else (('', 0),)
        for what, least in told:
            pairs = zip(sequences, every, strict=True)
            tallies = [events(one.truth, rows[rows[:, 6] >= least]) for one, rows in pairs]
            found = motmetrics.metrics.create().compute_many(
                tallies, metrics=list(FIGURES), generate_overall=True
            )
            *each, (all_idf1, all_mota, _, switches) = found.to_numpy()
            mean = np.mean(each, axis=0)[:3]
            tables[name + what] = np.array([*mean, switches, all_idf1, all_mota])
    return tables


def main() -> None:
    """Print IDF1, MOTA and precision, means over the sequences, and all switches.

    Behind them are IDF1 and MOTA over the rows of all sequences: where hardly anybody is, a few
    false rows make a MOTA far below 0, which the mean takes over. With few people, one ID moves
    IDF1 by several points: --runs gives means, and standard deviations of these.
    """
    parser = argparse.ArgumentParser('pedestrians', description=__doc__)
    parser.add_argument('folder', type=Path)
    parser.add_argument(
        '--judged', action='store_true', help='without detections of what is not judged'
    )
    parser.add_argument(
        '--runs', type=int, default=0, help='each without 5 %% of the detections, by chance'
    )
    args = parser.parse_args()
    folders = [path.parent for path in args.folder.glob('*/seqinfo.ini')]
    whole = [Sequence.of(folder, judged=args.judged) for folder in folders]
    thin = [[thinned(one, run) for one in whole] for run in range(args.runs)]
    every = [figures(sequences) for sequences in thin or [whole]]
    for name in every[0]:
        table = np.array([tables[name] for tables in every])
        idf1, mota, precision, switches, all_idf1, all_mota = table.mean(axis=0)
        sure = table.std(axis=0)[:2] / np.sqrt(len(table))
        print(
            f'{name:28s} {idf1:.3f} {mota:.3f} {precision:.3f} {switches:.0f} '
            f'{all_idf1:.3f} {all_mota:.3f}',
            *(f'+-{one:.3f}' for one in sure if args.runs),
        )


if __name__ == '__main__':
    warnings.filterwarnings('ignore', category=RuntimeWarning)
    main()
