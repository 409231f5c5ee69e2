"""What finding the tolerance of a color is worth, on real clips with their truth.

python benchmark/colors.py [FOLDER]: clips CLIP.mp4 with CLIP.csv (frame, id, u, v, w, h, visible)
and CLIP.frames, the frames that are judged. Each color is that of one pixel of its thing, or known
by its name alone: as what the pictures show of it, or as all that it may stand for. With
--constants it halves and doubles each constant that decides where a color ends, and those of
teaching, of which the color is that of a box in the middle of its thing.
"""

import argparse
from collections.abc import Iterator
from collections.abc import Sequence
import csv
from dataclasses import replace
from pathlib import Path

import numpy as np
from real_windows import overlap
from rich.console import Console
from rich.table import Table
from scipy.optimize import linear_sum_assignment

from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection import discriminate
from colortrack_ros.detection import extent
from colortrack_ros.detection import finder
from colortrack_ros.detection import growth
from colortrack_ros.detection import ReferenceColor
from colortrack_ros.detection import shades
from colortrack_ros.detection import sought_color
from colortrack_ros.detection import strangers
from colortrack_ros.detection import teach
from colortrack_ros.detection import usual_areas
from colortrack_ros.detection.presets import PRESETS
from colortrack_ros.sources import open_source

CLIPS = {
    'cups': ((200, 20, 60), 20.0, (1, 2, 3)),
    'caps': ((0, 19, 121), 20.0, (1, 2, 3)),
    'box': ((224, 162, 65), 40.0, (1,)),
    'greenball': ((71, 85, 57), 20.0, (1,)),
}
"""The color, the radius of a match [px], and the things."""

NAMES = {'cups': 'red', 'caps': 'blue', 'box': 'orange', 'greenball': 'green'}

REAL = Path(__file__).parents[2] / 'shared' / 'data' / 'real'
WAYS = {'tolerance 50': 50.0, 'tolerance 25': 25.0, 'found': 0.0}

CONSTANTS = (
    'LOOK_SECONDS', 'POOL_SECONDS', 'MOST_GROWTH', 'USUAL_SECONDS', 'LEAST_SHARE', 'PIECE_SHARE',
    'PIECE_REACH', 'FEWEST_LEFT', 'NEAR', 'FEWEST_PIXELS', 'LARGEST_SHARE', 'LEAST_SPREAD',
    'DEEPER', 'SHAPE_ROUNDS', 'OUTLINE_WIDTH', 'HALF_WAY', 'ELSEWHERE_SHARE',
    'SHADE_STEP', 'MOST_SHADES', 'SHADE_GAP', 'RISEN', 'OFF_LINE', 'AT_OBJECT', 'OTHER_HUE',
    'OWN_LEFT',
)  # fmt: skip
TAUGHT = ('SHADE_RADIUS', 'SHADES_SHARE', 'MOST_SHADES_TAUGHT')
"""Constants of what is taught by a box."""

SHOWN = 0.5
"""Side of the box over that of the thing."""


def sought(clip: str, tolerance: float) -> ReferenceColor:
    """The color of one pixel."""
    return ReferenceColor.from_rgb(clip, CLIPS[clip][0], tolerance)


def named(clip: str, is_fixed: bool) -> ReferenceColor:
    """The color of its name: all that it may stand for if it is fixed."""
    lab, axes = PRESETS[NAMES[clip]]
    fixed = ReferenceColor(clip, lab, tolerance_lab=axes)
    return fixed if is_fixed else ReferenceColor.from_preset(clip, NAMES[clip])


def taught(folder: Path, clip: str) -> ReferenceColor:
    """The color of a box in the middle of the first thing that is seen the most."""
    things = [row for row in truth_of(folder, clip) if row['id'] in CLIPS[clip][2]]
    row = max(things, key=lambda row: row['visible'])
    source = open_source(str(folder / f'{clip}.mp4'))
    frame = [source.read() for _ in range(int(row['frame']) + 1)][-1]
    source.close()
    width, height = (round(SHOWN * row[side]) for side in 'wh')
    box = round(row['u'] - width / 2), round(row['v'] - height / 2), width, height
    picked = teach.teach_color([teach.Example(frame, box)])
    return replace(picked.color, min_area=picked.limits['min_area'])


def truth_of(folder: Path, clip: str) -> list[dict[str, float]]:
    """The labeled boxes."""
    with (folder / f'{clip}.csv').open(newline='') as file:
        return [{k: float(v) for k, v in row.items()} for row in csv.DictReader(file)]


def judge(folder: Path, clip: str, color: ReferenceColor) -> tuple[float, float, float]:
    """Recall, false detections in a frame, and the median IoU of boxes of what is wholly seen."""
    _, radius, things = CLIPS[clip]
    truth = truth_of(folder, clip)
    judged = np.loadtxt(folder / f'{clip}.frames', int, ndmin=1)
    detector = Detector(DetectorConfig(colors=(color,)))
    source, hits, due, false = open_source(str(folder / f'{clip}.mp4')), 0, 0, 0
    overlaps = []
    for number in range(judged.max() + 1):
        rows = detector.detect(source.read()).rows
        if number not in judged:
            continue
        now = [row for row in truth if row['frame'] == number and row['id'] in things]
        away = np.array(
            [np.hypot(rows['u'] - row['u'], rows['v'] - row['v']) for row in now]
        ).reshape(len(now), len(rows))
        pairs = [
            (i, j) for i, j in zip(*linear_sum_assignment(away), strict=True) if away[i, j] < radius
        ]
        needed = [row['visible'] >= 0.3 for row in now]
        hits += sum(needed[i] for i, _ in pairs)
        due, false = due + sum(needed), false + len(rows) - len(pairs)
        overlaps += [
            overlap(*boxes_of(rows[j], now[i])) for i, j in pairs if now[i]['visible'] == 1
        ]
    source.close()
    return hits / max(due, 1), false / len(judged), float(np.median(overlaps or [np.nan]))


def boxes_of(row: np.void, label: dict[str, float]) -> tuple[np.ndarray, np.ndarray]:
    """Left, top, width, height of a detection and of a label, from one origin."""
    size = np.array([label['w'], label['h']])
    found = np.array(row[['box_u', 'box_v', 'box_w', 'box_h']].tolist())
    found[:2] -= 0.5  # a pixel reaches half a pixel beyond its center
    return found, np.concatenate([np.array([label['u'], label['v']]) - size / 2, size])


def sensitivity(folder: Path, names: Sequence[str]) -> Iterator[list[str]]:
    """A row for half and for twice of each constant."""
    for name in names:
        rooms = finder, sought_color, strangers, usual_areas, growth, extent, shades, discriminate
        modules = [module for module in rooms if hasattr(module, name)]
        value = getattr(modules[0], name)
        for factor in (0.5, 1, 2) if name in TAUGHT else (0.5, 2):
            changed = type(value)(factor * value)
            for module in modules:
                setattr(module, name, min(changed, 1.0) if name == 'SHADES_SHARE' else changed)
            yield [f'{name} {factor:g}', *(changed_cell(folder, clip, name) for clip in CLIPS)]
        for module in modules:
            setattr(module, name, value)


def changed_cell(folder: Path, clip: str, name: str) -> str:
    """What a table shows of a clip while a constant is changed."""
    try:
        color = taught(folder, clip) if name in TAUGHT else sought(clip, 0.0)
    except ValueError:
        return 'refused'
    return cell(*judge(folder, clip, color))


def cell(recall: float, false: float, boxes: float) -> str:
    """What a table shows of them."""
    return f'{recall:.1%} / {false:.2f} / {boxes:.2f}'


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('folder', type=Path, nargs='?', default=REAL)
    parser.add_argument('--constants', nargs='*', help='halve and double these, or all')
    arguments = parser.parse_args()
    folder = arguments.folder
    if not folder.is_dir():
        print(f'No clips at {folder}.')
        return
    table = Table(title='recall / false detections in a frame / IoU of boxes')
    ways = 'clip', *WAYS, 'name', 'all of the name'
    for column in ('constant', *CLIPS) if arguments.constants is not None else ways:
        table.add_column(column)
    if arguments.constants is not None:
        for row in sensitivity(folder, arguments.constants or (*CONSTANTS, *TAUGHT)):
            table.add_row(*row)
    else:
        for clip in CLIPS:
            colors = [sought(clip, value) for value in WAYS.values()]
            colors += [named(clip, is_fixed) for is_fixed in (False, True)]
            results = (judge(folder, clip, color) for color in colors)
            table.add_row(clip, *(cell(*result) for result in results))
    Console().print(table)


if __name__ == '__main__':
    main()
