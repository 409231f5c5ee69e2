"""Window tracker on real video: ``python benchmark/real_windows.py FOLDER``, which prints a table.

FOLDER holds a folder for each sequence: its pictures (``*.jpg`` or ``*.png``, in the folder or in
one of its own), and a ``groundtruth*.txt`` with a line for each picture, of the left, top, width
and height of the target, or of its four corners [px, from 1], as the sequences of OTB, UAV123 and
VOT have it. Each tracker is told the first box and nothing else. OpenCV's trackers take part where
opencv-contrib-python-headless is installed.

Success: share of the frames in which the box overlaps the truth by more than half of their union.
On nothing: share of the frames with a box said to be the target now, not a prediction of where it
might be, that overlaps the truth by less than a tenth. Means of the sequences.
"""

import argparse
from collections.abc import Callable
from collections.abc import Iterator
from pathlib import Path
import time

import cv2
import numpy as np

from colortrack_ros.data import CONFIRMED
from colortrack_ros.data import Frame
from colortrack_ros.windows import WindowConfig
from colortrack_ros.windows import WindowTracker

SUCCESS, NOTHING = 0.5, 0.1
"""Intersection over union: half, as the first of OTB's two scores has it, and hardly any."""

RATE = 30.0
"""Frames a second, where the files of a sequence say nothing of their time."""

PEERS = ('KCF', 'MOSSE', 'MedianFlow', 'MIL', 'CSRT')


def sequence(folder: Path, frames: int) -> tuple[list[Path], np.ndarray]:
    """Pictures of a sequence, and its boxes (N, 4) of left, top, width, height [px, from 0]."""
    pictures = sorted(p for p in folder.rglob('*') if p.suffix in ('.jpg', '.png'))
    lines = next(folder.glob('groundtruth*.txt')).read_text().replace(',', ' ').splitlines()
    values = np.array([[float(x) for x in line.split()] for line in lines if line.strip()])
    if values.shape[1] == 8:
        corners = values.reshape(-1, 4, 2)
        low, high = corners.min(axis=1), corners.max(axis=1)
        values = np.concatenate([low, high - low], axis=1)
    values[:, :2] -= 1
    count = min(len(pictures), len(values), frames)
    return pictures[:count], values[:count]


def overlap(box, truth) -> float:
    """Intersection over union of two boxes."""
    low = np.maximum(box[:2], truth[:2])
    high = np.minimum(np.add(box[:2], box[2:]), truth[:2] + truth[2:])
    common = float(np.prod(np.clip(high - low, 0, None)))
    return common / (box[2] * box[3] + truth[2] * truth[3] - common)


def ours(**settings) -> Callable:
    def start(image, box):
        tracker = WindowTracker(WindowConfig(**settings), [box])
        tracker.update(Frame(image, 'bgr8', 0))

        def step(image, stamp):
            rows = tracker.update(Frame(image, 'bgr8', stamp)).rows
            if not len(rows):
                return None
            u, v, w, h = (float(rows[name][0]) for name in ('u', 'v', 'box_w', 'box_h'))
            return (u - (w - 1) / 2, v - (h - 1) / 2, w, h), rows['state'][0] == CONFIRMED

        return step

    return start


def first_template(reach: int | None) -> Callable:
    """cv2.matchTemplate with the first template, within reach [px] of the last place if given."""

    def start(image, box):
        u, v, w, h = np.maximum(np.rint(box).astype(int), 0).tolist()
        template, last = image[v : v + h, u : u + w].copy(), [u, v]

        def step(image, stamp):
            low = np.zeros(2, int) if reach is None else np.maximum(np.subtract(last, reach), 0)
            part = image[low[1] :, low[0] :]
            if reach is not None:
                part = part[: h + 2 * reach, : w + 2 * reach]
            surface = cv2.matchTemplate(part, template, cv2.TM_CCOEFF_NORMED)
            last[:] = (np.array(cv2.minMaxLoc(surface)[3]) + low).tolist()
            return (*last, w, h), True

        return step

    return start


def peer(make: Callable) -> Callable:
    """A tracker of OpenCV."""

    def start(image, box):
        tracker = make()
        tracker.init(image, tuple(np.rint(box).astype(int).tolist()))

        def step(image, stamp):
            good, found = tracker.update(image)
            return (found, True) if good else None

        return step

    return start


def peers() -> Iterator[tuple[str, Callable]]:
    for name in PEERS:
        for place in (cv2, getattr(cv2, 'legacy', cv2)):
            if hasattr(place, f'Tracker{name}_create'):
                yield name, peer(getattr(place, f'Tracker{name}_create'))
                break
        else:
            print(f'# {name}: not in this OpenCV; pip install opencv-contrib-python-headless')


def shown(path: Path, shrink: float, gray: bool) -> np.ndarray:
    """A picture as it is, or so many times smaller, or without its colors."""
    image = cv2.imread(str(path))
    if shrink != 1:
        factor = 1 / shrink
        image = cv2.resize(image, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA)
    return (
        cv2.cvtColor(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY), cv2.COLOR_GRAY2BGR) if gray else image
    )


def judged(
    start: Callable, pictures: list[Path], truth: np.ndarray, every: int = 1, shrink: float = 1.0,
    gray: bool = False,
) -> tuple[float, ...]:  # fmt: skip
    """Success and on nothing [%] of a tracker on a sequence, and its median time [ms].

    :param every: pictures from one that is shown to the next; shrink, gray: see shown.
    """
    step, overlaps, nothing, times = None, [], [], []
    corner = np.array([0.5, 0.5, 0, 0])
    truth = (truth + corner) / shrink - corner
    pairs = zip(pictures, truth, strict=True)
    for k, (path, box) in list(enumerate(pairs))[::every]:
        image = shown(path, shrink, gray)
        if step is None:
            step = start(image, box)
            continue
        begin = time.perf_counter()
        answer = step(image, round(k / RATE * 1e9))
        times.append((time.perf_counter() - begin) * 1e3)
        if np.isfinite(box).all() and (box[2:] > 0).all():
            found = overlap(answer[0], box) if answer else 0.0
            overlaps.append(found)
            nothing.append(answer is not None and answer[1] and found < NOTHING)
    success = 100 * np.mean(np.array(overlaps) > SUCCESS)
    return float(success), 100 * float(np.mean(nothing)), float(np.median(times))


def folders_of(folder: Path) -> list[Path]:
    """The sequences of a folder."""
    return sorted(p.parent for p in folder.glob('*/groundtruth*.txt'))


def ways_to_track() -> dict[str, Callable]:
    """What makes each tracker, by its name in the table."""
    ways = {f'window_tracker, {m}': ours(method=m) for m in ('WM', 'WM+K', 'WM+K+PSO')}
    ways['window_tracker, no appearance'] = ours(appearance=False)
    ways['window_tracker, no drift_compensation'] = ours(drift_compensation=False)
    ways['matchTemplate, first template, 20 px'] = first_template(20)
    ways['matchTemplate, first template, whole picture'] = first_template(None)
    return ways | dict(peers())


def table(folders: list[Path], given: argparse.Namespace) -> None:
    """Print the table of sequences.

    :param given: with each, frames, every, shrink, gray and only of the command line.
    """
    ways = ways_to_track()
    if given.only:
        ways = {n: w for n, w in ways.items() if n in given.only} or ways
        folders = [f for f in folders if f.name in given.only] or folders
    print('| | success | on nothing | ms |\n|---|---|---|---|')
    for name, start in ways.items():
        results = []
        for folder in folders:
            found = sequence(folder, given.frames)
            results.append(judged(start, *found, given.every, given.shrink, given.gray))
            if given.each:
                print('| {} | {:.0f} % | {:.0f} % | {:.1f} |'.format(folder.name, *results[-1]))
        mean = np.mean(results, axis=0)
        print('| **{}** | {:.0f} % | {:.0f} % | {:.1f} |'.format(name, *mean), flush=True)


def options_of(what: str | None) -> argparse.ArgumentParser:
    """The options of everything that goes through a folder of sequences."""
    parser = argparse.ArgumentParser(description=what)
    parser.add_argument('folder', type=Path)
    parser.add_argument('--frames', type=int, default=10**6, help='of each sequence, at most')
    return parser


def parser_of(what: str | None) -> argparse.ArgumentParser:
    """The options of the table."""
    parser = options_of(what)
    parser.add_argument('--each', action='store_true', help='a line for each sequence as well')
    parser.add_argument('--every', type=int, default=1, help='pictures from one to the next')
    parser.add_argument('--shrink', type=float, default=1.0, help='times smaller pictures')
    parser.add_argument('--gray', action='store_true', help='without colors')
    parser.add_argument('--only', nargs='+', metavar='NAME', help='trackers, or sequences')
    return parser


def main() -> None:
    given = parser_of(__doc__).parse_args()
    cv2.setNumThreads(1)
    table(folders_of(given.folder), given)


if __name__ == '__main__':
    main()
