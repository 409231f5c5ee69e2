"""What is kept of the colors of one pixel when the light changes.

python benchmark/changing_light.py FOLDER: the clips of colors.py, and balls of many hues. Pictures
get darker, lighter, or colder. Judged from the change on: recall of the clips; of the balls, those
that are found, and those that another color takes.
"""

import argparse
from collections.abc import Callable
from pathlib import Path
import sys

from colors import CLIPS
from colors import REAL
from colors import sought
from colors import truth_of
import numpy as np
from rich.console import Console
from rich.table import Table

from colortrack_ros.data import Frame
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection import ReferenceColor
from colortrack_ros.sources import open_source

sys.path.insert(0, str(Path(__file__).parents[1] / 'test'))

from support.lit_balls import hues
from support.lit_balls import wheel

CHANGE, END = 4.0, 10.0
"""When the light changes, and when judging ends [s]."""

Light = Callable[[float], np.ndarray]


def faded(seconds: float, *last: float) -> Light:
    """From 1 to last, b, g, r, within so many seconds."""
    return lambda t: 1 + np.clip((t - CHANGE) / (seconds + 1e-9), 0, 1) * (np.array(last) - 1)


LIGHTS: dict[str, Light] = {
    'as it is': faded(0, 1, 1, 1),
    'half at once': faded(0, 0.5, 0.5, 0.5),
    'half in 1 s': faded(1, 0.5, 0.5, 0.5),
    'half in 4 s': faded(4, 0.5, 0.5, 0.5),
    '0.7 at once': faded(0, 0.7, 0.7, 0.7),
    'from 0.6 at once': lambda t: np.full(3, 0.6 if t < CHANGE else 1.0),
    'warmer in 4 s': faded(4, 0.7, 0.95, 1.1),
    'colder at once': faded(0, 1.0, 0.85, 0.7),
    'flickers': lambda t: np.full(3, 1.0 if int(t) % 3 else 0.7),
}
"""The factors of b, g, r at a time [s]."""

HUES, NOISE, RADIUS = ((9, 0.7), (11, 0.8), (14, 0.8)), 1.5, 28


def lit(image: np.ndarray, light: np.ndarray) -> np.ndarray:
    """A picture in another light."""
    return np.clip(image * light, 0, 255).astype(np.uint8)


def judge_clip(folder: Path, clip: str, light: Light) -> float:
    """Recall of what is at least half visible."""
    _, radius, things = CLIPS[clip]
    truth = [row for row in truth_of(folder, clip) if row['id'] in things]
    detector = Detector(DetectorConfig(colors=(sought(clip, 0.0),)))
    source, hits, due = open_source(str(folder / f'{clip}.mp4')), 0, 0
    for number in range(int(truth[-1]['frame']) + 1):
        frame = source.read()
        seconds = frame.stamp / NANOSECONDS
        if seconds > END:
            break
        rows = detector.detect(
            Frame(lit(frame.image, light(seconds)), frame.encoding, stamp=frame.stamp)
        ).rows
        for row in truth if seconds >= CHANGE else ():
            if row['frame'] == number and row['visible'] >= 0.5:
                away = np.hypot(rows['u'] - row['u'], rows['v'] - row['v'])
                hits, due = hits + int(away.min(initial=np.inf) < radius), due + 1
    source.close()
    return hits / max(due, 1)


def judge_hues(count: int, least: float, light: Light) -> np.ndarray:
    """(3,) balls found, taken by other colors, and all of them, four times a second."""
    image, places = wheel(hues(count), least)
    v, u = np.mgrid[: image.shape[0], : image.shape[1]]
    first, noise, total = lit(image, light(0)), np.random.default_rng(count), np.zeros(3, int)
    picked = [first[y, x, ::-1].tolist() for x, y in places]
    colors = [ReferenceColor.from_rgb(f'hue{k}', (r, g, b)) for k, (r, g, b) in enumerate(picked)]
    detector = Detector(DetectorConfig(colors=tuple(colors)))
    for k in range(int(4 * END)):
        seen = lit(image + noise.normal(0, NOISE, image.shape), light(k / 4))
        detector.detect(Frame(seen, stamp=k * NANOSECONDS // 4))
        for number, (x, y) in enumerate(places, 1) if k / 4 >= CHANGE else ():
            ball = detector.labels[np.hypot(u - x, v - y) < 0.85 * RADIUS]
            other = np.mean((ball != 0) & (ball != number))
            total += [(ball == number).mean() > 0.5, other > 0.2, 1]
    return total


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('folder', type=Path, nargs='?', default=REAL)
    folder = parser.parse_args().folder
    table = Table('light', *CLIPS, 'hues found, taken by others', title='recall')
    for name, light in LIGHTS.items():
        found, taken, all_ = sum(judge_hues(*each, light) for each in HUES)
        clips = [f'{judge_clip(folder, clip, light):.1%}' for clip in CLIPS]
        table.add_row(name, *clips, f'{found / all_:.1%}, {taken / all_:.1%}')
    Console().print(table)


if __name__ == '__main__':
    main()
