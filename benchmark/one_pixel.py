"""Balls of many colors: what the color of one pixel of a ball, and the name of its color, find.

python benchmark/one_pixel.py [FOLDER]: wheels of 8 to 16 hues, three pixels of each ball, and
pictures in the folder with the balls of discs.csv, five pixels each, and each name of a color once.
Right is what finds more than half of the ball, at most a fifth of any ball of another color, and of
all else less than half a ball.
"""

import argparse
import csv
from pathlib import Path
import sys

import cv2
import numpy as np
from rich.console import Console
from rich.table import Table

from colortrack_ros.data import Frame
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection import ReferenceColor
from colortrack_ros.detection.presets import PRESETS

sys.path.insert(0, str(Path(__file__).parents[1] / 'test'))

from support.lit_balls import hues
from support.lit_balls import wheel

WHEELS = ((8, 0.6), (8, 0.8), (10, 0.6), (10, 0.8), (12, 0.8), (16, 0.8))
"""Number of hues, and the light at the bottom of each ball."""

ALIKE = (
    {'red', 'pink'},
    {'orange', 'redorange'},
    {'blue', 'sky'},
    {'violet', 'magenta'},
    {'violet', 'purple'},
)
"""Colors that one may take for each other."""

CROWDS = ('EqZotiQQQ', 'CapedCrusader03', 'jagdesh', 'DanielFrauAlfaro')
"""Pictures with more balls than are listed: what else is found is not judged."""

STEPS = ((0.0, 0.0), (0.4, 0.0), (-0.4, 0.0), (0.0, 0.4), (0.0, -0.4))
"""Pixels of a ball, in radii from its center."""


def pixel_of(image: np.ndarray, disc: tuple, step: tuple) -> ReferenceColor:
    """The color of one pixel of a ball."""
    _, u, v, radius = disc
    blue, green, red = image[int(v + step[1] * radius), int(u + step[0] * radius)].tolist()
    return ReferenceColor.from_rgb('ball', (red, green, blue))


def is_right(
    image: np.ndarray, discs: list[tuple], k: int, color: ReferenceColor, crowd: bool
) -> bool:
    """Whether a color finds a ball and nothing of another color."""
    v, u = np.mgrid[: image.shape[0], : image.shape[1]]
    name, x, y, radius = discs[k]
    detector = Detector(DetectorConfig(colors=(color,)))
    detector.detect(Frame(image))
    mask, rest, right = detector.mask > 0, np.ones(image.shape[:2], bool), True
    for other, at_u, at_v, r in discs:
        away = np.hypot(u - at_u, v - at_v)
        rest &= away > 1.15 * r
        found = mask[away < 0.85 * r].mean()
        if (other, at_u, at_v) == (name, x, y):
            right &= found > 0.5
        elif other != name and {name, other} not in ALIKE:
            right &= found <= 0.2
    return right and (crowd or mask[rest].sum() < 0.5 * np.pi * radius**2)


def share(image: np.ndarray, discs: list[tuple], steps: tuple, crowd: bool = False) -> str:
    """Number of pixels that are right, of all."""
    each = [
        is_right(image, discs, k, pixel_of(image, disc, step), crowd)
        for k, disc in enumerate(discs)
        for step in steps
    ]
    return f'{sum(each)} of {len(each)}'


def named_share(image: np.ndarray, discs: list[tuple], crowd: bool) -> str:
    """Number of names that find a ball of theirs, of all."""
    names = [disc[0] for disc in discs]
    each = [
        is_right(image, discs, names.index(name), ReferenceColor.from_preset('ball', name), crowd)
        for name in dict.fromkeys(names)
        if name in PRESETS
    ]
    return f'{sum(each)} of {len(each)}'


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument('folder', type=Path, nargs='?')
    folder = parser.parse_args().folder
    table = Table('picture', 'pixels', 'names')
    for count, least in WHEELS:
        up_and_down = ((0.0, 0.0), (0.0, 0.5), (0.0, -0.5))
        image, places = wheel(hues(count), least)
        discs = [(f'hue {k}', u, v, 28) for k, (u, v) in enumerate(places)]
        table.add_row(f'{count} hues, {least:g}', share(image, discs, up_and_down))
    rows = list(csv.DictReader((Path(__file__).parent / 'discs.csv').open()))
    for name in dict.fromkeys(row['picture'] for row in rows) if folder else ():
        if (image := cv2.imread(str(folder / name))) is None:
            table.add_row(name, 'not there')
            continue
        discs = [
            (row['color'], *(float(row[key]) for key in ('u', 'v', 'radius')))
            for row in rows
            if row['picture'] == name
        ]
        crowd = name.startswith(CROWDS)
        table.add_row(name, share(image, discs, STEPS, crowd), named_share(image, discs, crowd))
    Console().print(table)


if __name__ == '__main__':
    main()
