"""How well the window tracker tells sizes: ``python benchmark/windows_sizes.py FOLDER``.

FOLDER is as of real_windows.py. A filter over sizes begins with the first box of each sequence, and
is told where the middle of the truth is in every second picture, 3 % of its size beside it. Prints
by how much its sizes are off, root mean square of their logarithms; with
``--constants COUNT=33 SCALE_STEP=1.02``, with other constants of windows/scale.py.
"""

import argparse
from contextlib import ExitStack
from pathlib import Path
import time
from unittest.mock import patch

import cv2
import numpy as np
from real_windows import sequence

from colortrack_ros.data import Frame
from colortrack_ros.windows.scale import ScaleFilter

ROOM = 'colortrack_ros.windows.scale.'
JITTER = 0.03
EVERY = 2


def error(folder: Path, frames: int) -> tuple[float, float]:
    """Root mean square of the logarithms of size over truth, and median time of a size [ms]."""
    sizes, errors, times, rng = None, [], [], np.random.default_rng(0)
    for k, (path, box) in list(enumerate(zip(*sequence(folder, frames), strict=True)))[::EVERY]:
        if not np.isfinite(box).all() or (box[2:] <= 0).any():
            continue
        frame = Frame(cv2.imread(str(path)), 'bgr8', k)
        center, side = box[:2] + (box[2:] - 1) / 2, np.sqrt(box[2:].prod())
        if sizes is None:
            sizes, first = ScaleFilter(frame, center, box[2:]), side
            continue
        begin = time.thread_time()
        sizes.update(frame, center + JITTER * box[2:] * rng.normal(size=2))
        times.append(1e3 * (time.thread_time() - begin))
        errors.append(np.log(sizes.scale * first / side))
    return float(np.sqrt(np.mean(np.square(errors)))), float(np.median(times))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('folder', type=Path)
    parser.add_argument('--frames', type=int, default=200, help='of each sequence, at most')
    parser.add_argument('--constants', nargs='*', default=[], metavar='NAME=VALUE')
    given = parser.parse_args()
    cv2.setNumThreads(1)
    with ExitStack() as changed:
        for constant in given.constants:
            name, value = constant.split('=')
            changed.enter_context(patch(ROOM + name, float(value) if '.' in value else int(value)))
        folders = sorted(p.parent for p in given.folder.glob('*/groundtruth*.txt'))
        found = [error(folder, given.frames) for folder in folders]
    print('| | size off by | ms |\n|---|---|---|')
    for folder, (off, ms) in zip(folders, found, strict=True):
        print(f'| {folder.name} | {100 * off:.0f} % | {ms:.1f} |')
    off, ms = np.mean(found, axis=0)
    print(f'| **mean** | {100 * off:.1f} % | {ms:.1f} |')


if __name__ == '__main__':
    main()
