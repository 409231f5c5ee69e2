"""Time of a frame of the window tracker: ``python benchmark/windows_time.py FOLDER``.

FOLDER holds sequences (see real_windows.py), of which the first boxes are followed, and clips of
many objects (see real_contours.py), of which 5 and 10 are followed, from the first picture on that
shows as many. All pictures are scaled to 640x480. Beside ours, in the same run, CSRT of OpenCV and
matchTemplate in the whole picture, one of each for a target.

A line tells processor times for each target that is followed [ms]: mean, median, and 95th
percentile of the frames, and the longest one.
"""

from collections.abc import Callable
from collections.abc import Iterable
from collections.abc import Iterator
from itertools import islice
from pathlib import Path
import time

import cv2
import numpy as np
import real_contours
import real_windows
from windows import boxes_of
from windows import full_frame
from windows import peers
from windows import played
from windows import SCENES
from windows import window_tracker

from colortrack_ros.windows import WindowConfig

SIZE = 640, 480
COUNTS = 5, 10

Film = tuple[list[np.ndarray], np.ndarray]
"""Pictures of SIZE, and boxes to follow from the first of them on, (N, 4) [px]."""


def scaled(pictures: Iterable[np.ndarray], boxes: np.ndarray) -> Film:
    """Pictures and boxes at SIZE; what lies outside is cut off."""
    small, shape = [], SIZE
    for picture in pictures:
        shape = picture.shape[1::-1]
        small.append(cv2.resize(picture, SIZE, interpolation=cv2.INTER_AREA))
    boxes = np.atleast_2d(boxes) * np.tile(np.divide(SIZE, shape), 2)
    low = np.maximum(boxes[:, :2], 0)
    high = np.minimum(boxes[:, :2] + boxes[:, 2:], SIZE)
    return small, np.concatenate([low, high - low], axis=1)


def of_sequences(folder: Path, frames: int) -> Iterator[Film]:
    """The sequences of a folder."""
    for path in real_windows.folders_of(folder):
        paths, truth = real_windows.sequence(path, frames)
        yield scaled((cv2.imread(str(p)) for p in paths), truth[0])


def of_clips(folder: Path, count: int, frames: int) -> Iterator[Film]:
    """The clips of a folder that show so many objects."""
    for clip in real_contours.clips_of(folder):
        seen = {k: rows[rows[:, 5] >= real_contours.VISIBLE] for k, rows in clip.truth().items()}
        first = min((k for k, rows in seen.items() if len(rows) >= count), default=None)
        if first is not None:
            boxes = seen[first][:count, 1:5].copy()
            boxes[:, :2] -= boxes[:, 2:] / 2
            yield scaled(islice(clip.pictures(), first, first + frames), boxes)


def of_scenes(frames: int) -> Iterator[Film]:
    """The scenes, with all of their targets."""
    for name in SCENES:
        pictures, _, center, radius = played(name)
        yield pictures[:frames], boxes_of(center[0], radius)


def timed(start: Callable, film: Film) -> np.ndarray:
    """Processor time of each frame but the first, in which targets start, for a target [ms]."""
    pictures, boxes = film
    step, times = start(boxes), []
    for k, image in enumerate(pictures):
        begin = time.process_time()
        step(image, round(k / real_windows.RATE * 1e9))
        times.append((time.process_time() - begin) * 1e3 / len(boxes))
    return np.array(times[1:])


def main() -> None:
    given = real_windows.options_of(__doc__).parse_args()
    cv2.setNumThreads(1)
    sets = {'sequences, 1 target': of_sequences(given.folder, given.frames)}
    sets |= {f'clips, {n} targets': of_clips(given.folder, n, given.frames) for n in COUNTS}
    sets['scenes, 1 to 3 targets'] = of_scenes(given.frames)
    ways = {'window_tracker': window_tracker(WindowConfig())} | dict(peers())
    ways['matchTemplate, whole picture'] = full_frame
    for title, films in sets.items():
        times: dict[str, list[np.ndarray]] = {name: [] for name in ways}
        for film in films:
            for name, start in ways.items():
                times[name].append(timed(start, film))
        count = len(times['window_tracker'])
        print(f'\n| {title} ({count} films) | mean | median | 95 % | longest |')
        print('|---|---|---|---|---|')
        for name, each in times.items() if count else ():
            own = np.concatenate(each)
            figures = own.mean(), np.median(own), np.percentile(own, 95), own.max()
            print(f'| {name} | ' + ' | '.join(f'{ms:.2f}' for ms in figures) + ' |', flush=True)


if __name__ == '__main__':
    main()
