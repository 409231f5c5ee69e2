"""When windows go onto nothing: ``python benchmark/windows_spells.py FOLDER``, a line a spell.

FOLDER is as of real_windows.py. A spell is a stretch of frames on nothing, as defined there, of the
tracker's defaults, until it is on the target again.
"""

from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
from real_windows import folders_of
from real_windows import NOTHING
from real_windows import options_of
from real_windows import ours
from real_windows import overlap
from real_windows import RATE
from real_windows import sequence
from real_windows import shown

AGAIN, LEAST_SPELL = 0.3, 3
"""Intersection over union at which a spell ends, and the fewest frames on nothing of one that is
listed. Assumed: they are for reading only."""


def answers(pictures: list[Path], truth: np.ndarray) -> Iterator[tuple[int, float, bool]]:
    """Frame, intersection over union, and whether the target is said to be seen, where known."""
    step = ours()(shown(pictures[0], 1.0, False), truth[0])
    for k, (path, box) in enumerate(zip(pictures[1:], truth[1:], strict=True), 1):
        answer = step(shown(path, 1.0, False), round(k / RATE * 1e9))
        if np.isfinite(box).all() and (box[2:] > 0).all():
            yield (k, overlap(answer[0], box), bool(answer[1])) if answer else (k, 0.0, False)


def spells(said: list[tuple[int, float, bool]]) -> Iterator[tuple[int, int, int, int]]:
    """The spells among answers.

    :return: first frame; number of frames on nothing; frames between this and the last one on the
        target, and in how many of them it coasted.
    """
    first = frames = since = coasted = 0
    for k, found, sure in [*said, (0, 1.0, False)]:
        if found >= AGAIN:
            if frames >= LEAST_SPELL:
                yield first, frames, since, coasted
            frames = since = coasted = 0
        elif sure and found < NOTHING:
            first, frames = first if frames else k, frames + 1
        elif not frames:
            since, coasted = since + 1, coasted + (not sure)


def main() -> None:
    given = options_of(__doc__).parse_args()
    cv2.setNumThreads(1)
    print('| sequence | from frame | frames on nothing | since on the target | coasted of these |')
    print('|---|---|---|---|---|')
    for folder in folders_of(given.folder):
        said = list(answers(*sequence(folder, given.frames)))
        for spell in spells(said):
            print(f'| {folder.name} |', ' | '.join(map(str, spell)), '|', flush=True)


if __name__ == '__main__':
    main()
