"""Contours on real video: ``python benchmark/real_contours.py FOLDER``, which prints a table.

FOLDER holds videos NAME.mp4, beside each a NAME.csv with the columns frame (from 0), id, u, v, w,
h (center and size of the box of the whole object [px]) and visible (0..1), and a NAME.frames with
the numbers of the frames that are judged, in which every object is labeled. An object is found by
a box that overlaps its own by ``--iou`` of their union; one visible by less than VISIBLE need not
be found. Told are confirmed targets alone, those that coast as well.

``--constants regions.SLACK ...`` compares constants of the room with half and twice their values.

Beside ours OpenCV's MOG2 with a morphological clean-up, whose boxes norfair tracks (pip install
norfair); both are given every frame, and areas of the same least size.
"""

import argparse
from collections.abc import Callable
from collections.abc import Iterator
from pathlib import Path
import time

from contours import ways_of
import cv2
import motmetrics
import numpy as np

from colortrack_ros.contours import ContourConfig
from colortrack_ros.contours import ContourTracker
from colortrack_ros.data import Frame
from colortrack_ros.data import TENTATIVE

VISIBLE = 0.3
FIGURES = ('idf1', 'mota', 'precision', 'recall', 'num_switches')
MIN_AREA = ContourConfig().min_area

Boxes = np.ndarray
"""(N, 5): id, u, v, w, h."""


def pictures(video: Path) -> Iterator[np.ndarray]:
    capture = cv2.VideoCapture(str(video))
    while True:
        good, image = capture.read()
        if not good:
            return
        yield image


def truth_of(video: Path) -> dict[int, np.ndarray]:
    """Of each judged frame its objects, (N, 6): id, u, v, w, h, visible."""
    table = np.genfromtxt(video.with_suffix('.csv'), delimiter=',', names=True, ndmin=1)
    rows = np.stack([table[n] for n in ('id', 'u', 'v', 'w', 'h', 'visible')], axis=1)
    judged = np.loadtxt(video.with_suffix('.frames'), int, ndmin=1)
    return {int(k): rows[table['frame'] == k] for k in judged}


def overlaps(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Intersection over union of boxes u, v, w, h, (N, M)."""
    low = np.maximum(*((b[..., :2] - b[..., 2:] / 2) for b in (one[:, None], other[None])))
    high = np.minimum(*((b[..., :2] + b[..., 2:] / 2) for b in (one[:, None], other[None])))
    common = np.clip(high - low, 0, None).prod(axis=-1)
    areas = one[:, None, 2:].prod(axis=-1) + other[None, :, 2:].prod(axis=-1)
    return common / np.maximum(areas - common, 1e-9)


def ours(rate: float, shape: tuple[int, ...], **settings) -> Callable:
    tracker = ContourTracker(ContourConfig(**settings))

    def step(image: np.ndarray, k: int) -> Boxes:
        tracks = tracker.update(Frame(image, 'bgr8', round(k * 1e9 / rate)))
        live = tracks.rows['state'] != TENTATIVE
        low, high = (f(tracks.outlines[live], axis=1) for f in (np.min, np.max))
        return np.column_stack([tracks.rows['track_id'][live], (low + high) / 2, high - low])

    return step


def mog2_with_norfair(rate: float, shape: tuple[int, ...]) -> Callable:
    import norfair

    model = cv2.createBackgroundSubtractorMOG2(detectShadows=True)
    tracker = norfair.Tracker('iou', distance_threshold=0.7)

    def step(image: np.ndarray, k: int) -> Boxes:
        mask = (model.apply(image) == 255).astype(np.uint8)
        mask = cv2.morphologyEx(mask, cv2.MORPH_OPEN, np.ones((3, 3)))
        mask = cv2.morphologyEx(mask, cv2.MORPH_CLOSE, np.ones((9, 9)))
        stats = cv2.connectedComponentsWithStats(mask)[2][1:]
        stats = stats[stats[:, 4] >= MIN_AREA]
        corners = np.stack([stats[:, :2], stats[:, :2] + stats[:, 2:4] - 1], axis=1)
        if stats[:, 4].sum() > 0.5 * mask.size:
            corners = corners[:0]
        live = tracker.update([norfair.Detection(c) for c in corners])
        rows = [(t.id, *t.estimate.mean(axis=0), *np.ptp(t.estimate, axis=0)) for t in live]
        return np.array(rows, float).reshape(-1, 5)

    return step


def judge(step: Callable, video: Path, iou: float) -> tuple[motmetrics.MOTAccumulator, np.ndarray]:
    """What a tracker finds on a video, and its times [ms]."""
    truth, times = truth_of(video), []
    book = motmetrics.MOTAccumulator(auto_id=True)
    for k, image in enumerate(pictures(video)):
        begin = time.perf_counter()
        boxes = step(image, k)
        times.append((time.perf_counter() - begin) * 1e3)
        if k in truth:
            own = truth[k]
            value = overlaps(own[:, 1:5], boxes[:, 1:])
            free = own[:, 5] < VISIBLE
            bound = (value[~free] >= iou).any(axis=0)
            kept = bound | ~(value[free] >= iou).any(axis=0)
            value = np.where(value >= iou, 1 - value, np.nan)[~free][:, kept]
            book.update(own[~free, 0].astype(int), boxes[kept, 0].astype(int), value)
    return book, np.array(times)


def constants(names: list[str], videos: list[Path], iou: float) -> None:
    """Print IDF1 and precision with half and twice the value of constants."""
    print('| | ' + ' | '.join(v.stem for v in videos) + ' |\n|---|' + '---|' * len(videos))
    for way in ways_of(names):
        cells = []
        for video in videos:
            rate = cv2.VideoCapture(str(video)).get(cv2.CAP_PROP_FPS)
            book, _ = judge(ours(rate, ()), video, iou)
            row = motmetrics.metrics.create().compute(book, metrics=FIGURES).iloc[0]
            cells.append(f'{row["idf1"]:.2f}, {row["precision"]:.2f}')
        print(f'| {way} | ' + ' | '.join(cells) + ' |', flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('folder', type=Path, nargs='+')
    parser.add_argument('--iou', type=float, default=0.3)
    parser.add_argument('--only', nargs='+', metavar='NAME', help='trackers, or videos')
    parser.add_argument('--constants', nargs='+', metavar='FILE.NAME')
    given = parser.parse_args()
    cv2.setNumThreads(1)
    ways = {'contour_tracker': ours, 'MOG2, norfair': mog2_with_norfair}
    videos = sorted(p for f in given.folder for p in f.glob('*.mp4'))
    if given.only:
        ways = {n: w for n, w in ways.items() if n in given.only} or ways
        videos = [v for v in videos if v.stem in given.only] or videos
    if given.constants:
        constants(given.constants, videos, given.iou)
        return
    print('| | | IDF1 | MOTA | precision | recall | switches | median, max ms |')
    print('|---|---|---|---|---|---|---|---|')
    for video in videos:
        capture = cv2.VideoCapture(str(video))
        rate = capture.get(cv2.CAP_PROP_FPS)
        for name, start in ways.items():
            book, times = judge(start(rate, ()), video, given.iou)
            row = motmetrics.metrics.create().compute(book, metrics=FIGURES).iloc[0]
            cells = ' | '.join(f'{row[n]:.2f}' for n in FIGURES[:-1])
            print(f'| {video.stem} | {name} | {cells} | {row["num_switches"]:.0f} '
                  f'| {np.median(times):.1f}, {times.max():.0f} |', flush=True)  # fmt: skip


if __name__ == '__main__':
    main()
