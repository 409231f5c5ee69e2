"""Balls of many colors: what the color of one pixel of a ball finds.

python benchmark/one_pixel.py [FOLDER]: wheels of 8 to 16 hues, three pixels of each ball, and
pictures in the folder with the balls of discs.csv, five pixels each. Right is a pixel whose color
finds more than half of its ball, at most a fifth of any ball of another color, and of all else less
than half a ball.
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

sys.path.insert(0, str(Path(__file__).parents[1] / 'test'))

from support.lit_balls import hues
from support.lit_balls import wheel

WHEELS = ((8, 0.6), (8, 0.8), (10, 0.6), (10, 0.8), (12, 0.8), (16, 0.8))
"""Number of hues, and the light at the bottom of each ball."""

ALIKE = ({'red', 'pink'}, {'orange', 'redorange'}, {'blue', 'sky'}, {'violet', 'magenta'})
"""Colors that one may take for each other."""

CROWDS = ('EqZotiQQQ', 'CapedCrusader03', 'jagdesh', 'DanielFrauAlfaro')
"""Pictures with more balls than are listed: what else is found is not judged."""

STEPS = ((0.0, 0.0), (0.4, 0.0), (-0.4, 0.0), (0.0, 0.4), (0.0, -0.4))
"""Pixels of a ball, in radii from its center."""


def is_right(image: np.ndarray, discs: list[tuple], k: int, step: tuple, crowd: bool) -> bool:
    """Whether one pixel of a ball finds the ball and nothing of another color."""
    v, u = np.mgrid[: image.shape[0], : image.shape[1]]
    name, x, y, radius = discs[k]
    blue, green, red = image[int(y + step[1] * radius), int(x + step[0] * radius)].tolist()
    color = ReferenceColor.from_rgb('ball', (red, green, blue))
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
    each = [is_right(image, discs, k, s, crowd) for k in range(len(discs)) for s in steps]
    return f'{sum(each)} of {len(each)}'


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument('folder', type=Path, nargs='?')
    folder = parser.parse_args().folder
    table = Table('picture', 'right')
    for count, least in WHEELS:
        up_and_down = ((0.0, 0.0), (0.0, 0.5), (0.0, -0.5))
        image, places = wheel(hues(count), least)
        discs = [(f'hue {k}', u, v, 28) for k, (u, v) in enumerate(places)]
        table.add_row(f'{count} hues, {least:g}', share(image, discs, up_and_down))
    rows = list(csv.DictReader((Path(__file__).parent / 'discs.csv').open()))
    for name in dict.fromkeys(row['picture'] for row in rows) if folder else ():
        image = cv2.imread(str(folder / name))
        discs = [
            (row['color'], *(float(row[key]) for key in ('u', 'v', 'radius')))
            for row in rows
            if row['picture'] == name
        ]
        table.add_row(name, share(image, discs, STEPS, name.startswith(CROWDS)))
    Console().print(table)


if __name__ == '__main__':
    main()
