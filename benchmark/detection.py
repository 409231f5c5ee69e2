"""How long the detector takes, beside the same job done the textbook way.

python benchmark/detection.py prints the tables and writes out/benchmark_detection.json.
"""

import argparse
from dataclasses import replace
import gc
import itertools
import json
from pathlib import Path
import platform
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
from colortrack_ros.detection.color_table import ColorTable
from colortrack_ros.scenes.shapes import draw_ball
from colortrack_ros.scenes.texture import plaster

try:
    from skimage import color as skimage_color
    from skimage import measure as skimage_measure
except ImportError:
    skimage_color = skimage_measure = None

SIZES = {'640x480': (480, 640), '1920x1080': (1080, 1920), '3840x2160': (2160, 3840)}
RGB = (
    (205, 58, 34), (40, 160, 60), (40, 70, 200), (220, 200, 40),
    (190, 40, 180), (20, 220, 230), (240, 150, 30), (20, 20, 20),
)  # fmt: skip
"""Reference colors: the balls have the first, the wall none of them."""

LIKE_WALL = (30, 180, 190)
"""A color whose sphere just touches those of the wall: one pixel in seven needs a closer look."""

OPTIONS = (
    {'closing_size': 9}, {'grow': 1.5}, {'moving_only': True}, {'white_balance': 'gray_world'},
    {'follow_light': 60.0}, {'split': True, 'min_aspect': 0.5, 'min_solidity': 0.5},
    {'method': 'channel_difference'}, {'method': 'background'},
)  # fmt: skip

TOLERANCE = 30.0
OUT = Path(__file__).parents[1] / 'out' / 'benchmark_detection.json'


def colors(count, last=()):
    rgbs = (*RGB[: count - len(last)], *last)
    return tuple(ReferenceColor.from_rgb(f'c{k}', rgb, TOLERANCE) for k, rgb in enumerate(rgbs))


def picture(shape, count=5, covered=0.022, seed=0):
    """Shaded balls of one color on an uneven wall with sensor noise, bgr8.

    :param covered: the share of the picture that they cover, together.
    """
    height, width = shape
    image = plaster((seed, 0), height, width, (128, 134, 142))
    columns = int(np.ceil(np.sqrt(count * width / height)))
    rows = -(-count // columns)
    radius = np.sqrt(covered * height * width / count / np.pi)
    brightness = np.array(RGB[0][::-1], np.float32)
    for k in range(count):
        row, column = divmod(k, columns)
        center = np.array([(column + 0.5) * width / columns, (row + 0.5) * height / rows])
        draw_ball(image, center + 0.3 * k % 1, np.zeros(2), radius, brightness)
    noise = np.random.default_rng(seed).normal(0, 2.5, image.shape)
    return np.clip(image + noise, 0, 255).astype(np.uint8)


def milliseconds(call, seconds=1.5, least=5):
    """Median time of a call, after two to warm up."""
    call(), call()
    gc.collect()
    gc.disable()
    times, end = [], time.perf_counter() + seconds
    while len(times) < least or time.perf_counter() < end:
        start = time.perf_counter()
        call()
        times.append(time.perf_counter() - start)
    gc.enable()
    return 1e3 * float(np.median(times))


def opencv_textbook(image, color, min_area=20):
    """Float CIELAB, distance, threshold, erosion, components of the whole picture: OpenCV."""
    lab = cv2.cvtColor(image.astype(np.float32) / 255, cv2.COLOR_BGR2Lab)
    distance = np.sqrt(((lab - np.float32(color.lab)) ** 2).sum(axis=2))
    mask = cv2.erode((distance < color.tolerance).astype(np.uint8), np.ones((3, 3), np.uint8))
    count, _, stats, centroids = cv2.connectedComponentsWithStats(mask, connectivity=8)
    return [(stats[k], centroids[k]) for k in range(1, count) if stats[k, 4] >= min_area]


def skimage_textbook(image, color, min_area=20):
    """rgb2lab, deltaE and regionprops: scikit-image."""
    lab = skimage_color.rgb2lab(image[..., ::-1])
    mask = skimage_color.deltaE_cie76(lab, np.array(color.lab)) < color.tolerance
    mask = cv2.erode(mask.astype(np.uint8), np.ones((3, 3), np.uint8))
    regions = skimage_measure.regionprops(skimage_measure.label(mask, connectivity=2))
    return [(r.bbox, r.centroid) for r in regions if r.area >= min_area]


def detector_time(image, count=1, last=(), **options):
    detector = Detector(DetectorConfig(colors=colors(count, last), **options))
    frames = (Frame(image, stamp=k * NANOSECONDS // 30) for k in itertools.count())
    return milliseconds(lambda: detector.detect(next(frames)))


def measure_sizes():
    return {name: measure_size(picture(shape)) for name, shape in SIZES.items()}


def measure_size(image):
    """Each way to do the same job: milliseconds."""
    (color,) = colors(1)
    copy = np.empty_like(image)
    result = {
        'copy': milliseconds(lambda: np.copyto(copy, image)),
        'detector': detector_time(image),
        'two threads': detector_time(image, threads=2),
        'opencv': milliseconds(lambda: opencv_textbook(image, color), 0.5, 3),
    }
    found = len(Detector(DetectorConfig(colors=(color,))).detect(Frame(image)).rows)
    assert found == len(opencv_textbook(image, color)) == 5
    if skimage_color:
        result['skimage'] = milliseconds(lambda: skimage_textbook(image, color), 0.5, 1)
        assert found == len(skimage_textbook(image, color))
    return result


def measure_variants():
    """The same size, other contents: milliseconds."""
    result = {}
    for name in ('640x480', '1920x1080'):
        shape = SIZES[name]
        usual = picture(shape)
        result[name] = {
            '5 balls': detector_time(usual),
            'eight colors': detector_time(usual, count=8),
            'one of them like the wall': detector_time(usual, count=8, last=[LIKE_WALL]),
            '50 balls': detector_time(picture(shape, 50)),
            'half the picture': detector_time(picture(shape, 5, covered=0.5)),
            'half of it, moving only': detector_time(
                picture(shape, 5, covered=0.5), moving_only=True
            ),
        }
    return result


def measure_options():
    """Five balls at 1920x1080 with one option each: milliseconds."""
    image = picture(SIZES['1920x1080'])
    return {
        ', '.join(f'{k}: {v}' for k, v in options.items()): detector_time(image, **options)
        for options in OPTIONS
    }


def encoded(image):
    """The picture as frames in encodings of cameras, by name."""
    height, width = image.shape[:2]
    planes = cv2.cvtColor(image, cv2.COLOR_BGR2YUV_I420).reshape(-1)
    luma = planes[: height * width].reshape(height, width)
    chroma = planes[height * width :].reshape(2, height // 2, width // 2).transpose(1, 2, 0)
    mosaic = image[..., 1].copy()
    mosaic[::2, ::2], mosaic[1::2, 1::2] = image[::2, ::2, 2], image[1::2, 1::2, 0]
    beside = chroma.repeat(2, axis=0).reshape(height, width)
    return {
        'bgr8': Frame(image),
        'yuyv': Frame(np.dstack([luma, beside]), 'yuyv'),
        'nv12': Frame(np.concatenate([luma, chroma.reshape(height // 2, width)]), 'nv12'),
        'bayer_rggb8': Frame(mosaic, 'bayer_rggb8'),
    }


def measure_encodings(rounds=40):
    """Least time of each encoding over that of bgr8, taken in turns."""
    result = {}
    for name in ('640x480', '1920x1080'):
        frames = encoded(picture(SIZES[name]))
        detectors = {e: Detector(DetectorConfig(colors=colors(1))) for e in frames}
        times = {encoding: [] for encoding in frames}
        for number in range(rounds):
            for encoding, frame in frames.items():
                frame = replace(frame, stamp=number * NANOSECONDS // 30)
                start = time.perf_counter()
                detectors[encoding].detect(frame)
                times[encoding].append(time.perf_counter() - start)
        least = min(times['bgr8'])
        result[name] = {encoding: round(min(t) / least, 2) for encoding, t in times.items()}
    return result


def measure_tables():
    """Building the tables: milliseconds."""
    return {
        f'{count} colors': milliseconds(lambda count=count: ColorTable(colors(count)), 0.5)
        for count in (1, 8)
    }


def show(console, title, rows, ratio_to):
    """One line for each way, one column for each size, with the ratio to one of the ways."""
    table = Table('', *rows, title=title)
    for way in next(iter(rows.values())):
        cells = [f'{row[way]:.2f} ms  {row[way] / row[ratio_to]:6.2f}' for row in rows.values()]
        table.add_row(way, *cells)
    console.print(table)


def main():
    cv2.setNumThreads(1)
    console = Console()
    result = {
        'versions': {'opencv': cv2.__version__, 'numpy': np.__version__},
        'python': platform.python_version(),
        'sizes': measure_sizes(),
        'contents': measure_variants(),
        'encodings': measure_encodings(),
        'options': measure_options(),
        'tables': measure_tables(),
    }
    show(console, 'One frame, and its ratio to the detector', result['sizes'], 'detector')
    show(console, 'Other contents, and the ratio to 5 balls', result['contents'], '5 balls')
    console.print('Encodings, times of bgr8:', result['encodings'])
    console.print('Five balls at 1920x1080 with an option (ms):', result['options'])
    console.print('Building the tables (ms):', result['tables'])
    OUT.parent.mkdir(exist_ok=True)
    OUT.write_text(json.dumps(result, indent=2) + '\n')


if __name__ == '__main__':
    argparse.ArgumentParser(description=__doc__).parse_args()
    main()
