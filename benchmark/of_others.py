"""What others recorded, through tracker and peers: ``python benchmark/of_others.py FOLDER``.

FOLDER holds folders of MOTChallenge (seqinfo.ini, gt/gt.txt, and det/det.txt where a detector made
detections). Where there are none, they are made of the truth, three times: 10 % are missed, the
others are off by a pixel or a twentieth of the size (sigma), and a tenth as many are false,
anywhere in the picture. They are points: no boxes, no covariances. A row is right whose center is
in the ellipse of a true box. All get the same, ours also the size of the picture.
"""

import argparse
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import NamedTuple
import warnings

import numpy as np
from pedestrians import message
from pedestrians import Rows
from pedestrians import score
from pedestrians import Sequence
from pedestrians import theirs as of_boxes
import peers
from scipy.optimize import linear_sum_assignment

from colortrack_ros.data import COASTING
from colortrack_ros.data import TENTATIVE
from colortrack_ros.ellipses import ELLIPSE_95
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig

MISSED, FALSE = 0.1, 0.1
"""Shares of the true, in detections that are made of the truth."""

NOISES = {'1 px': lambda size: 1.0 + 0 * size, 'size / 20': lambda size: size / 20}
"""Standard deviation [px] by the size of the object [px]."""

BOXED = ('SORTTracker', 'ByteTrackTracker', 'OCSORTTracker')
"""Of the package `trackers`, which take boxes."""


class Ours(NamedTuple):
    """Rows, and share of the true in the ellipse of 95 %: of those measured, of those coasting."""

    rows: Rows
    inside: tuple[float, float]


def observed(sequence: Sequence, noise: str, seed: int) -> Sequence:
    """The sequence with points made of its truth."""
    rng = np.random.default_rng(seed)
    truth = sequence.truth[rng.random(len(sequence.truth)) >= MISSED]
    sigma = NOISES[noise](truth[:, 4:6].mean(axis=1))
    center = truth[:, 2:4] + truth[:, 4:6] / 2 + rng.normal(size=(len(truth), 2)) * sigma[:, None]
    count = rng.binomial(len(sequence.truth), FALSE)
    frames = np.concatenate([truth[:, 0], rng.choice(sequence.truth[:, 0], count)])
    center = np.concatenate([center, rng.uniform((0, 0), sequence.size, (count, 2))])
    order = rng.permutation(len(frames))
    found = np.zeros((len(frames), 7))
    found[:, 0], found[:, 2:4], found[:, 6] = frames[order], center[order], 1.0
    return sequence._replace(detections=found)


def step(sequence: Sequence) -> float:
    """How far an object goes from frame to frame, at most but for one way in a thousand [px]."""
    truth = sequence.truth[np.lexsort(sequence.truth[:, :2].T)]
    next_one = (np.diff(truth[:, 1]) == 0) & (np.diff(truth[:, 0]) == 1)
    way = np.diff(truth[:, 2:4] + truth[:, 4:6] / 2, axis=0)[next_one]
    return float(np.quantile(np.hypot(*way.T), 0.999))


def squared_distances(true: np.ndarray, tracks: np.ndarray) -> np.ndarray:
    """Of the right ones, (M, 2): error over the covariance, squared, and whether it coasts."""
    center, half = true[:, 2:4] + true[:, 4:6] / 2, true[:, 4:6] / 2
    error = np.stack([tracks['u'], tracks['v']], axis=1) - center[:, None]
    away = np.hypot(*(error / half[:, None]).T).T
    i, j = linear_sum_assignment(np.minimum(away, 2.0))
    i, j = i[away[i, j] < 1], j[away[i, j] < 1]
    e, P = error[i, j], tracks['covariance'][j, :2, :2]
    d2 = np.einsum('si,si->s', e, np.linalg.solve(P, e[..., None])[..., 0])
    return np.column_stack([d2, tracks['state'][j] == COASTING])


def ours(sequence: Sequence, **options: object) -> Ours:
    """What the tracker publishes."""
    tracker, found, distances = Tracker(TrackerConfig(image_size=sequence.size, **options)), [], []
    for k, box in sequence.frames():
        tracks = tracker.update(message(sequence, k, box)).rows
        tracks = tracks[tracks['state'] != TENTATIVE]
        distances.append(squared_distances(sequence.truth[sequence.truth[:, 0] == k], tracks))
        at = tracks['track_id'], tracks['u'], tracks['v']
        frame, none = np.full(len(tracks), k), np.zeros(len(tracks))
        found.append(np.column_stack([frame, *at, none, none, tracks['state'] != COASTING]))
    d2, coasts = np.concatenate(distances).T
    inside = [100 * np.mean(d2[coasts == which] < ELLIPSE_95) for which in (0, 1)]
    return Ours(np.concatenate(found), (inside[0], inside[1]))


def theirs(sequence: Sequence, make: Callable) -> Rows:
    """What a peer of peers.py publishes, which takes centers."""
    peer, found = make(step(sequence)), []
    for k, box in sequence.frames():
        for i, u, v in peer.update(box[:, :2] + box[:, 2:4] / 2):
            found.append((k, i, u, v, 0, 0, 1))
    return np.array(found, float).reshape(-1, 7)


def boxed(sequence: Sequence, name: str, *, scored: bool = False) -> Rows:
    """What one of BOXED publishes; points become boxes as in peers.py."""
    found = sequence.detections
    if not found[:, 4:6].any():
        corners = peers.boxes_of(found[:, 2:4], step(sequence))
        box = np.hstack([corners[:, :2], corners[:, 2:] - corners[:, :2]])
        sequence = sequence._replace(detections=np.hstack([found[:, :2], box, found[:, 6:]]))
    return of_boxes(sequence, name, scored=scored)


def rivals() -> dict[str, Callable[[Sequence], Rows]]:
    """By name."""
    made = {make.name: partial(theirs, make=make) for make in peers.PEERS}
    made |= {name: partial(boxed, name=name) for name in BOXED}
    return made | {f'{name}, scores': partial(boxed, name=name, scored=True) for name in BOXED}


def judged(sequence: Sequence, rows: Rows) -> np.ndarray:
    """IDF1, MOTA [%], false rows over the true [%], switches."""
    idf1, mota, precision, switches = score(sequence.truth, rows)
    wrong = (1 - precision) * len(rows) / len(sequence.truth)
    return np.array([100 * idf1, 100 * mota, 100 * wrong, switches])


def report(name: str, runs: list[Sequence], others: dict[str, Callable]) -> None:
    """Print a line for each tracker: means over the runs."""
    made = [ours(one) for one in runs]
    lines = {'ours': [judged(one, it.rows) for one, it in zip(runs, made, strict=True)]}
    lines |= {who: [judged(one, play(one)) for one in runs] for who, play in others.items()}
    print(f'{name}: IDF1, MOTA, false [%], switches')
    for who, figures in lines.items():
        print(f'  {who:24s}', *(f'{figure:6.1f}' for figure in np.mean(figures, axis=0)))
    held = np.nanmean([it.inside for it in made], axis=0)
    print(f'  in the 95 % ellipse: measured {held[0]:.1f}, coasting {held[1]:.1f} %', flush=True)


def main() -> None:
    """Print the figures of each sequence, and of all with detections of others together."""
    parser = argparse.ArgumentParser('of_others', description=__doc__)
    parser.add_argument('folder', type=Path)
    parser.add_argument('--alone', action='store_true', help='no peers')
    parser.add_argument('--seeds', type=int, nargs='*', default=[0, 1, 2])
    args = parser.parse_args()
    others = {} if args.alone else rivals()
    detected = []
    for path in sorted(args.folder.glob('*/seqinfo.ini')):
        sequence = Sequence.of(path.parent)
        if len(sequence.detections):
            detected.append(sequence)
            continue
        for noise in NOISES:
            runs = [observed(sequence, noise, seed) for seed in args.seeds]
            report(f'{path.parent.name}, {noise}', runs, others)
    if detected:
        report(f'{len(detected)} with detections of others', detected, others)


if __name__ == '__main__':
    warnings.filterwarnings('ignore', category=RuntimeWarning)
    main()
