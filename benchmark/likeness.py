"""How like a target other places are: ``python benchmark/likeness.py FOLDER`` prints a table.

FOLDER is as of real_windows.py. A target is looked for beside where the truth has it, and around
places anywhere else in the picture; it is learned where it is found. What the thresholds NEARBY,
LEARNED and RARER of the window tracker let through, and what they refuse, is to be read off.
"""

import argparse
from pathlib import Path

import cv2
import numpy as np
from real_windows import sequence

from colortrack_ros.data import Frame
from colortrack_ros.windows.appearance import Appearance

NEAR = 0.35
"""What is found is the target within this share of its size."""

JITTER = 0.15
"""Standard deviation of where it is looked for, as a share of its size."""

ELSEWHERE = 2
"""Other places that are looked around in each picture."""

THRESHOLDS = (0.45, 0.5, 0.55, 0.6, 0.65, 0.7, 0.75, 0.8, 0.85, 0.9)


def likenesses(folder, frames, gray):
    """Likeness of the target, and of other places, in all frames of a sequence but the first."""
    target, other, appearance = [], [], None
    rng = np.random.default_rng(0)
    for k, (path, box) in enumerate(zip(*sequence(folder, frames), strict=True)):
        image = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE if gray else cv2.IMREAD_COLOR)
        if not np.isfinite(box).all() or (box[2:] <= 1).any():
            continue
        frame = Frame(image, 'mono8' if gray else 'bgr8', k)
        center, size = box[:2] + (box[2:] - 1) / 2, box[2:]
        if appearance is None:
            appearance = Appearance(frame, center, size)
            continue
        seen = appearance.look(frame, center + JITTER * size * rng.normal(size=2))
        if (np.abs(seen.z - center) < NEAR * size).all():
            target.append(appearance.likeness(seen))
            appearance.resize(frame, seen.z)
            appearance.learn(frame, seen.z, seen)
        for place in rng.uniform(0, image.shape[1::-1], (ELSEWHERE, 2)):
            seen = appearance.look(frame, place)
            if (np.abs(seen.z - center) > 2 * NEAR * size).any():
                other.append(appearance.likeness(seen))
    return target, other


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('folder', type=Path)
    parser.add_argument('--frames', type=int, default=150, help='of each sequence, at most')
    parser.add_argument('--gray', action='store_true', help='without colors')
    given = parser.parse_args()
    cv2.setNumThreads(1)
    folders = sorted(p.parent for p in given.folder.glob('*/groundtruth*.txt'))
    pairs = [likenesses(folder, given.frames, given.gray) for folder in folders]
    target, other = (np.concatenate(values) for values in zip(*pairs, strict=True))
    print(f'{len(target)} looks at targets, {len(other)} at other places\n')
    print('| likeness | of the target less | of other places more |\n|---|---|---|')
    for least in THRESHOLDS:
        missed, taken = 100 * np.mean(target < least), 100 * np.mean(other >= least)
        print(f'| {least:.2f} | {missed:.1f} % | {taken:.2f} % |')


if __name__ == '__main__':
    main()
