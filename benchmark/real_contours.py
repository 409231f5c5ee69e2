"""Contours on real video: ``python benchmark/real_contours.py FOLDER``, which prints a table.

FOLDER holds videos NAME.mp4, beside each a NAME.csv with the columns frame (from 0), id, u, v, w,
h (center and size of the box of the whole object [px]) and visible (0..1), and a NAME.frames with
the numbers of the frames that are judged, in which every object is labeled. It may also hold
folders of MOTChallenge (seqinfo.ini, img1, gt/gt.txt), of which every frame is judged, and of which
other things than people need not be found. Where such a folder has gt/label.txt, labels of KITTI's
tracking benchmark, boxes that lie in its DontCare regions for more than half are not judged, as
there. An object is found by a box that overlaps its own by ``--iou`` of their union; one visible by
less than VISIBLE need not be found. Told are confirmed targets alone, those that coast as well.

``--constants regions.SLACK ...`` compares constants of the room with half and twice their values.

Beside ours OpenCV's MOG2 with a morphological clean-up, whose boxes norfair tracks (pip install
norfair); both are given every frame, and areas of the same least size.
"""

import argparse
from collections.abc import Callable
from collections.abc import Iterator
import configparser
from dataclasses import dataclass
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

VISIBLE, IOU = 0.3, 0.3
FIGURES = ('idf1', 'mota', 'precision', 'recall', 'num_switches')
MIN_AREA = ContourConfig().min_area
NOWHERE = np.zeros((0, 4))

Boxes = np.ndarray
"""(N, 5): id, u, v, w, h."""


@dataclass(frozen=True)
class Clip:
    """A video, or a folder of MOTChallenge.

    :ivar path: of the video, or of the folder.
    """

    path: Path

    @property
    def name(self) -> str:
        """As the table has it."""
        return self.path.stem

    @property
    def is_folder(self) -> bool:
        """Whether it is one of MOTChallenge."""
        return self.path.is_dir()

    def rate(self) -> float:
        """Frames a second."""
        if self.is_folder:
            info = configparser.ConfigParser()
            info.read(self.path / 'seqinfo.ini')
            return info.getfloat('Sequence', 'frameRate')
        return float(cv2.VideoCapture(str(self.path)).get(cv2.CAP_PROP_FPS))

    def pictures(self) -> Iterator[np.ndarray]:
        """Its pictures, one after the other."""
        if self.is_folder:
            yield from (cv2.imread(str(p)) for p in sorted((self.path / 'img1').iterdir()))
            return
        capture = cv2.VideoCapture(str(self.path))
        while True:
            good, image = capture.read()
            if not good:
                return
            yield image

    def truth(self) -> dict[int, np.ndarray]:
        """Of each judged frame its objects, (N, 6): id, u, v, w, h, visible."""
        if self.is_folder:
            return self._truth_of_challenge()
        table = np.genfromtxt(self.path.with_suffix('.csv'), delimiter=',', names=True, ndmin=1)
        rows = np.stack([table[n] for n in ('id', 'u', 'v', 'w', 'h', 'visible')], axis=1)
        judged = np.loadtxt(self.path.with_suffix('.frames'), int, ndmin=1)
        return {int(k): rows[table['frame'] == k] for k in judged}

    def _truth_of_challenge(self) -> dict[int, np.ndarray]:
        table = np.loadtxt(self.path / 'gt' / 'gt.txt', delimiter=',', ndmin=2)
        rows = table[:, 1:7].copy()
        rows[:, 1:3] += table[:, 4:6] / 2 - 1  # left and top count from 1
        if table.shape[1] == 9:  # of 2016 and later: class, and what is seen of it
            rows[:, 5] = np.where(table[:, 6] > 0, table[:, 8], 0.0)
        else:  # of 2015: 0 for what does not count, -1 where nobody has said
            rows[:, 5] = table[:, 6] != 0
        count = len(list((self.path / 'img1').iterdir()))
        return {k: rows[table[:, 0] == k + 1] for k in range(count)}

    def ignored(self) -> dict[int, np.ndarray]:
        """Regions of each frame in which nothing is judged, (N, 4): left, top, right, bottom."""
        labels = self.path / 'gt' / 'label.txt'
        rows = [line.split() for line in labels.read_text().splitlines()] if labels.exists() else []
        regions: dict[int, list[list[float]]] = {}
        for row in rows:
            if row[2] == 'DontCare':
                regions.setdefault(int(row[0]), []).append([float(x) for x in row[6:10]])
        return {k: np.array(own) for k, own in regions.items()}


def clips_of(folder: Path) -> list[Clip]:
    """The clips of a folder."""
    found = [p for p in folder.glob('*.mp4') if p.with_suffix('.frames').exists()]
    found += [p.parent for p in folder.glob('*/seqinfo.ini') if (p.parent / 'gt').is_dir()]
    return [Clip(p) for p in sorted(found)]


def overlaps(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Intersection over union of boxes u, v, w, h, (N, M)."""
    low = np.maximum(*((b[..., :2] - b[..., 2:] / 2) for b in (one[:, None], other[None])))
    high = np.minimum(*((b[..., :2] + b[..., 2:] / 2) for b in (one[:, None], other[None])))
    common = np.clip(high - low, 0, None).prod(axis=-1)
    areas = one[:, None, 2:].prod(axis=-1) + other[None, :, 2:].prod(axis=-1)
    return common / np.maximum(areas - common, 1e-9)


def ours(rate: float, **settings) -> Callable:
    tracker = ContourTracker(ContourConfig(**settings))

    def step(image: np.ndarray, k: int) -> Boxes:
        tracks = tracker.update(Frame(image, 'bgr8', round(k * 1e9 / rate)))
        live = tracks.rows['state'] != TENTATIVE
        low, high = (f(tracks.outlines[live], axis=1) for f in (np.min, np.max))
        return np.column_stack([tracks.rows['track_id'][live], (low + high) / 2, high - low])

    return step


def mog2_with_norfair(rate: float) -> Callable:
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


def share_in(boxes: np.ndarray, regions: np.ndarray) -> np.ndarray:
    """Largest share of each box u, v, w, h that lies in one of regions, (N,)."""
    low = np.maximum((boxes[:, :2] - boxes[:, 2:] / 2)[:, None], regions[:, :2])
    high = np.minimum((boxes[:, :2] + boxes[:, 2:] / 2)[:, None], regions[:, 2:])
    common = np.clip(high - low, 0, None).prod(axis=-1).max(axis=1, initial=0.0)
    return common / np.maximum(boxes[:, 2:].prod(axis=1), 1e-9)


def compare(
    book: motmetrics.MOTAccumulator,
    truth: np.ndarray,
    boxes: np.ndarray,
    iou: float,
    ignored: np.ndarray = NOWHERE,
) -> bool:
    """Add a picture: its truth, and rows of ID and box that were told; whether any is found."""
    value = overlaps(truth[:, 1:5], boxes[:, 1:])
    free = truth[:, 5] < VISIBLE
    bound = (value[~free] >= iou).any(axis=0)
    kept = bound | ~(value[free] >= iou).any(axis=0) & (share_in(boxes[:, 1:], ignored) <= 0.5)
    value = np.where(value >= iou, 1 - value, np.nan)[~free][:, kept]
    book.update(truth[~free, 0].astype(int), boxes[kept, 0].astype(int), value)
    return bool(np.isfinite(value).any())


def judge(step: Callable, clip: Clip, iou: float) -> tuple[motmetrics.MOTAccumulator, np.ndarray]:
    """What a tracker finds on a clip, and its times [ms]."""
    truth, ignored, times = clip.truth(), clip.ignored(), []
    book = motmetrics.MOTAccumulator(auto_id=True)
    for k, image in enumerate(clip.pictures()):
        begin = time.perf_counter()
        boxes = step(image, k)
        times.append((time.perf_counter() - begin) * 1e3)
        if k in truth:
            compare(book, truth[k], boxes, iou, ignored.get(k, NOWHERE))
    return book, np.array(times)


def constants(names: list[str], clips: list[Clip], iou: float) -> None:
    """Print IDF1 and precision with half and twice the value of constants."""
    print('| | ' + ' | '.join(c.name for c in clips) + ' |\n|---|' + '---|' * len(clips))
    for way in ways_of(names):
        cells = []
        for clip in clips:
            book, _ = judge(ours(clip.rate()), clip, iou)
            row = motmetrics.metrics.create().compute(book, metrics=FIGURES).iloc[0]
            cells.append(f'{row["idf1"]:.2f}, {row["precision"]:.2f}')
        print(f'| {way} | ' + ' | '.join(cells) + ' |', flush=True)


def table(clips: list[Clip], iou: float, only: list[str] | None) -> None:
    """Print the table of clips.

    :param only: names of trackers, or of clips.
    """
    ways = {'contour_tracker': ours, 'MOG2, norfair': mog2_with_norfair}
    if only:
        ways = {n: w for n, w in ways.items() if n in only} or ways
        clips = [c for c in clips if c.name in only] or clips
    print('| | | IDF1 | MOTA | precision | recall | switches | median, max ms |')
    print('|---|---|---|---|---|---|---|---|')
    for clip in clips:
        for name, start in ways.items():
            book, times = judge(start(clip.rate()), clip, iou)
            row = motmetrics.metrics.create().compute(book, metrics=FIGURES).iloc[0]
            cells = ' | '.join(f'{row[n]:.2f}' for n in FIGURES[:-1])
            print(f'| {clip.name} | {name} | {cells} | {row["num_switches"]:.0f} '
                  f'| {np.median(times):.1f}, {times.max():.0f} |', flush=True)  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('folder', type=Path, nargs='+')
    parser.add_argument('--iou', type=float, default=IOU)
    parser.add_argument('--only', nargs='+', metavar='NAME', help='trackers, or clips')
    parser.add_argument('--constants', nargs='+', metavar='FILE.NAME')
    given = parser.parse_args()
    cv2.setNumThreads(1)
    clips = [clip for folder in given.folder for clip in clips_of(folder)]
    if given.constants:
        constants(given.constants, clips, given.iou)
    else:
        table(clips, given.iou, given.only)


if __name__ == '__main__':
    main()
