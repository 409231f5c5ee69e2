"""What becomes of tracks when pictures are skipped, as on a machine that is too slow.

python benchmark/skipped.py [CLIP...] [--backwards] [--scale S] [--folder FOLDER]: clips, colors,
and truth as of colors.py, the color of one pixel and nothing else. Pictures are left out by chance,
or all but one in two or three. --backwards shows each clip from its end: another clip to a tracker;
--scale enlarges the pictures.
"""

import argparse
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from colors import CLIPS
from colors import REAL
from colors import sought
from colors import truth_of
import cv2
import numpy as np
from rich.console import Console
from rich.table import Table

from colortrack_ros.chain import ColorTracker
from colortrack_ros.data import Frame
from colortrack_ros.data import TENTATIVE
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.evaluation import Score
from colortrack_ros.evaluation import Tally
from colortrack_ros.sources import open_source
from colortrack_ros.tracking import TrackerConfig

SEEN = 0.3
"""Things of which less is in sight need not be found."""


def ways(count: int) -> Iterator[tuple[str, np.ndarray]]:
    """Which of so many pictures are shown, (count,), by the row of the table it counts for."""
    yield 'all', np.ones(count, bool)
    for share in (0.15, 0.3, 0.5):
        for seed in range(1, 5):
            shown = np.random.default_rng(seed).random(count) >= share
            yield f'{share:.0%} left out', shown
    for step in (2, 3):
        for first in range(step):
            yield f'one in {step}', np.arange(count) % step == first


def scaled(frame: Frame, scale: float) -> Frame:
    image = cv2.resize(frame.image, None, fx=scale, fy=scale, interpolation=cv2.INTER_LINEAR)
    return replace(frame, image=image)


def track(
    clip: str, frames: list[Frame], shown: np.ndarray, folder: Path, back: bool, scale: float
) -> Score:
    """How well the things of a clip are followed."""
    color, (_, radius, things) = sought(clip, 0.0), CLIPS[clip]
    truth: dict[int, list[dict[str, float]]] = {}
    for row in truth_of(folder, clip):
        truth.setdefault(int(row['frame']), []).append(row)
    judged = set(np.loadtxt(folder / f'{clip}.frames', int, ndmin=1).tolist())
    height, width = frames[0].image.shape[:2]
    chain = ColorTracker(DetectorConfig(colors=(color,)), TrackerConfig(image_size=(width, height)))
    tally = Tally(scale * radius)
    for time, place in enumerate(range(len(frames))[:: -1 if back else 1]):
        if not shown[place]:
            continue
        rows = chain(replace(frames[place], stamp=frames[time].stamp)).rows
        if place not in judged:
            continue
        rows = rows[rows['state'] != TENTATIVE]
        there = truth.get(place, [])
        due = [r for r in there if r['id'] in things and r['visible'] >= SEEN]
        objects = [(r['id'], *(scale * (r[name] + 0.5) - 0.5 for name in 'uv')) for r in due]
        tracks = np.stack([rows['track_id'], rows['u'], rows['v']], axis=1)
        tally.add(objects, tracks, hidden=len(there) - len(due))
    return tally.score()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('clips', nargs='*', default=['cups'])
    parser.add_argument('--backwards', action='store_true')
    parser.add_argument('--scale', type=float, default=1.0)
    parser.add_argument('--folder', type=Path, default=REAL)
    options = parser.parse_args()
    table = Table('clip', 'pictures', 'IDF1', 'switches', 'recall', 'precision')
    for clip in options.clips:
        film = open_source(str(options.folder / f'{clip}.mp4'))
        frames = [scaled(frame, options.scale) for frame in film]
        scores: dict[str, list[Score]] = {}
        for name, shown in ways(len(frames)):
            one = track(clip, frames, shown, options.folder, options.backwards, options.scale)
            scores.setdefault(name, []).append(one)
        for name, some in scores.items():
            means = np.mean([(s.idf1, s.switches, s.recall, s.precision) for s in some], axis=0)
            table.add_row(clip, name, *(f'{mean:.3f}' for mean in means))
    Console().print(table)


if __name__ == '__main__':
    main()
