"""Ellipses on real video: ``python benchmark/real_ellipses.py windows|contours FOLDER ...``.

FOLDER is one of ``real_windows.py`` or ``real_contours.py``. The table has, for each sequence, how
many boxes overlap a label by more than --iou of their union, and in which share of them the middle
of the label lies in the published 95 % ellipse: measured, and coasting. Labels are themselves off
by some hundredths of a side.
"""

import argparse
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
from real_contours import Clip
from real_contours import clips_of
from real_contours import overlaps
from real_windows import folders_of
from real_windows import RATE
from real_windows import sequence
from scipy.optimize import linear_sum_assignment

from colortrack_ros.contours import ContourTracker
from colortrack_ros.data import COASTING
from colortrack_ros.data import Frame
from colortrack_ros.data import TENTATIVE
from colortrack_ros.windows import WindowTracker

CHI2 = 5.99
"""95 % of squared distances, normalized by the covariance, are below."""

Pair = tuple[np.ndarray, np.ndarray, np.ndarray]
"""Rows as published, their boxes u, v, w, h, and labels, (N, 4) each."""


def by_windows(folder: Path, frames: int) -> Iterator[Pair]:
    """What the window tracker makes of the first box of a sequence, picture by picture."""
    pictures, truth = sequence(folder, frames)
    tracker = WindowTracker(targets=[truth[0]])
    for k, (path, label) in enumerate(zip(pictures, truth, strict=True)):
        rows = tracker.update(Frame(cv2.imread(str(path)), 'bgr8', round(k / RATE * 1e9))).rows
        if k and np.isfinite(label).all():
            boxes = np.column_stack([rows[name] for name in ('u', 'v', 'box_w', 'box_h')])
            middle = label[:2] + (label[2:] - 1) / 2
            yield rows, boxes.astype(float), np.array([[*middle, *label[2:]]])


def by_contours(clip: Clip, frames: int) -> Iterator[Pair]:
    """What the contour tracker makes of a clip, picture by picture."""
    tracker, rate, truth = ContourTracker(), clip.rate(), clip.truth()
    for k, image in enumerate(clip.pictures()):
        tracks = tracker.update(Frame(image, 'bgr8', round(k * 1e9 / rate)))
        live = tracks.rows['state'] != TENTATIVE
        low, high = (f(tracks.outlines[live], axis=1) for f in (np.min, np.max))
        if k in truth:
            boxes = np.column_stack([(low + high) / 2, high - low])
            yield tracks.rows[live], boxes, truth[k][:, 1:5]
        if k + 1 == frames:
            return


def squared_errors(pairs: Iterator[Pair], iou: float) -> np.ndarray:
    """Squared normalized errors of the boxes that overlap a label, and which coast, (N, 2)."""
    found: list[tuple[float, float]] = []
    for rows, boxes, labels in pairs:
        if not len(rows) or not len(labels):
            continue
        value = overlaps(labels, boxes)
        for i, j in zip(*linear_sum_assignment(-np.where(value > iou, value, 0.0)), strict=True):
            if value[i, j] > iou:
                e = np.array([rows['u'][j], rows['v'][j]]) - labels[i, :2]
                d2 = e @ np.linalg.solve(rows['covariance'][j, :2, :2], e)
                found.append((d2, float(rows['state'][j] == COASTING)))
    return np.array(found).reshape(-1, 2)


def cells(found: np.ndarray) -> str:
    """How many, and the share in the ellipse, measured and coasting."""
    parts = (found[found[:, 1] == coasts, 0] for coasts in (0.0, 1.0))
    return ' | '.join(
        f'{len(d2)} | {100 * np.mean(d2 < CHI2):.0f} %' if len(d2) else '0 | ' for d2 in parts
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('tracker', choices=('windows', 'contours'))
    parser.add_argument('folder', type=Path, nargs='+')
    parser.add_argument('--iou', type=float, help='default: 0.3 of windows, 0.5 of contours')
    parser.add_argument('--frames', type=int, default=10**6, help='of each sequence, at most')
    parser.add_argument('--only', nargs='+', metavar='NAME', help='sequences')
    given = parser.parse_args()
    cv2.setNumThreads(1)
    windows, every = given.tracker == 'windows', []
    find, play = (folders_of, by_windows) if windows else (clips_of, by_contours)
    print('| | measured | in the ellipse | coasting | in the ellipse |\n|---|---|---|---|---|')
    for one in (one for folder in given.folder for one in find(folder)):
        if not given.only or one.name in given.only:
            iou = given.iou if given.iou is not None else 0.3 if windows else 0.5
            every.append(squared_errors(play(one, given.frames), iou))
            print(f'| {one.name} | {cells(every[-1])} |', flush=True)
    if every:
        print(f'| **all** | {cells(np.concatenate(every))} |')


if __name__ == '__main__':
    main()
