"""How long pictures take while colors without a tolerance are followed: the median, and the worst.

python benchmark/sought_time.py [VIDEO]: 1 to 8 names, and colors read off pixels, in 150 pictures
of the video or else of lit balls, at 30 Hz. Processor time [ms].
"""

import argparse
import itertools
from pathlib import Path
import sys
import time

import cv2
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

NAMES = ('red', 'orange', 'yellow', 'green', 'cyan', 'blue', 'magenta', 'purple')
SIZES = (640, 480), (1280, 720)
PICTURES = 150


def pictures(video: str | None, size: tuple[int, int]) -> list[np.ndarray]:
    """Pictures of a video, or of eight balls in changing noise."""
    if video:
        source = open_source(video)
        frames = itertools.islice(iter(source.read, None), PICTURES)
        images = [cv2.resize(frame.image, size) for frame in frames]
        source.close()
        return images
    image = cv2.resize(wheel(hues(8), 0.6)[0], size).astype(float)
    noise = (np.random.default_rng(k).normal(0, 3, image.shape) for k in range(4))
    images = [(image + each).clip(0, 255).astype(np.uint8) for each in noise]
    return [images[k % 4] for k in range(PICTURES)]


def read_off(image: np.ndarray) -> tuple[ReferenceColor, ...]:
    """The color of the most vivid pixel of each of eight ranges of hues."""
    hue, saturation, value = cv2.split(cv2.cvtColor(cv2.blur(image, (5, 5)), cv2.COLOR_BGR2HSV))
    vivid = saturation.astype(int) * value
    places = (np.where(hue // 22.5 == k, vivid, -1).argmax() for k in range(8))
    rgb = (image.reshape(-1, 3)[place][::-1].tolist() for place in places)
    return tuple(ReferenceColor.from_rgb(f'c{k}', each) for k, each in enumerate(rgb))


def times(images: list[np.ndarray], colors: tuple[ReferenceColor, ...]) -> np.ndarray:
    """Processor time of each picture [ms]."""
    detector, taken = Detector(DetectorConfig(colors=colors)), []
    for k, image in enumerate(images):
        start = time.process_time()
        detector.detect(Frame(image, stamp=k * NANOSECONDS // 30))
        taken.append(1e3 * (time.process_time() - start))
    return np.array(taken)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('video', nargs='?')
    video = parser.parse_args().video
    cv2.setNumThreads(1)
    table = Table('size', 'colors', 'first', 'median', 'mean', '99 %', 'worst but the first')
    named = tuple(ReferenceColor.from_preset(name, name) for name in NAMES)
    for size in SIZES:
        images = pictures(video, size)
        for kind, colors in (('names', named), ('read off', read_off(images[0]))):
            for count in (1, 2, 4, 8):
                first, *taken = times(images, colors[:count])
                shown = first, np.median(taken), np.mean(taken), np.quantile(taken, 0.99)
                row = (f'{value:.1f}' for value in (*shown, max(taken)))
                table.add_row('x'.join(map(str, size)), f'{count} {kind}', *row)
    Console().print(table)


if __name__ == '__main__':
    main()
