"""Contour tracker: how well outlines are followed, and how long it takes.

python benchmark/contours.py prints the tables and writes out/benchmark_contours.json;
``--constants tracker.GROWN ...`` compares constants of the room with half and twice their values.
"""

import argparse
from dataclasses import replace
import importlib
import json
import os
from pathlib import Path
import platform
import time

import cv2
import numpy as np
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from colortrack_ros.contours import ContourConfig
from colortrack_ros.contours import ContourTracker
from colortrack_ros.data import Frame
from colortrack_ros.scenes import open_scene
from colortrack_ros.scenes.outlines import QUADRILATERAL
from colortrack_ros.scenes.silhouettes import draw_polygon
from colortrack_ros.scenes.silhouettes import normalized
from colortrack_ros.scenes.silhouettes import placed

OUT = Path(__file__).parents[1] / 'out' / 'benchmark_contours.json'
SIZES = {'320x240': 'width=320&height=240', '640x480': 'width=640&height=480'}
FRAMES = 300
ROOMS = (
    'agreement', 'areas', 'background', 'boxes', 'changes', 'displaced', 'filters', 'foreground',
    'gating', 'initiation', 'lines', 'placing', 'publishing', 'records', 'regions', 'scene_change',
    'shadows', 'spline', 'told', 'tracker', 'usual', 'weak',
)  # fmt: skip
EMPTY, INSIDE = 24, {'silhouette': 65, 'approach': 85}
"""Frames of the background alone, and the first one in which all have come in."""

REPORTED = {'silhouette': (8.99, 3.73), 'approach': (4.65, 1.52, 7.65, 8.60)}
"""Mean squared errors in the document [px^2]."""

DOCUMENT = ContourConfig(
    follow_foreground=False, outline='box', interpolating=False, filters='two',
    edge_variance=0.4, motion_noise=0.001, scale_noise=1e-8, shape_noise=0.001, no_edge=0.0,
    inside_deviation=0.0, outside_deviation=0.0, outlier=0.0, min_found=0.0, start_found=0.0,
)  # fmt: skip
WAYS = {
    'as in the document': DOCUMENT,
    'the same, points on the area': replace(DOCUMENT, outline='area'),
    'defaults': ContourConfig(),
    'defaults, 24 points': ContourConfig(points=24),
}


def overlap(one, other, shape):
    """Intersection over union of two polygons (P, 2)."""
    masks = np.zeros((2, *shape), np.uint8)
    for mask, polygon in zip(masks, (one, other), strict=True):
        cv2.fillPoly(mask, [np.rint(polygon * 16).astype(np.int32)], 1, shift=4)
    return (masks[0] & masks[1]).sum() / max((masks[0] | masks[1]).sum(), 1)


def quality(name, size, config):
    """For each object squared errors, normalized ones, overlaps and the track, of FRAMES frames.

    The background is shown, and then, as in the document, all objects at once. Counted is from when
    all have been confirmed; an object belongs to the nearest track.
    """
    scene = open_scene(f'{name}?{size}')
    if config.outline == 'box' or not config.interpolating:
        config = replace(config, line_length=20 if name == 'approach' else 60)
    tracker, count, rows = ContourTracker(config), len(REPORTED[name]), []
    for i, k in enumerate([*range(EMPTY), *range(INSIDE[name], len(scene))]):
        image = scene.render(k)
        tracks = tracker.update(Frame(image, 'bgr8', round(i * 1e9 / scene.rate)))
        live = np.flatnonzero(tracks.rows['state'] > 0)
        if len(live) < count and not rows:
            continue
        outlines, own = scene.outlines(k), []
        for truth in scene.truth(k):
            e = np.stack([tracks.rows[x][live] - truth[x] for x in 'uv'], axis=1)
            j = np.hypot(*e.T).argmin()
            row, shape = tracks.rows[live[j]], tracks.outlines[live[j]]
            nees = e[j] @ np.linalg.solve(row['covariance'][:2, :2], e[j])
            alike = overlap(shape, outlines[int(truth['id'])], image.shape[:2])
            own.append((e[j] @ e[j], nees, alike, row['track_id']))
        rows.append(own)
        if len(rows) == FRAMES:
            break
    return np.array(rows)


def measure_quality():
    result = {}
    for name in REPORTED:
        for label, size in SIZES.items():
            for way, config in WAYS.items():
                seen = quality(name, size, config)
                result[f'{name}, {label}, {way}'] = {
                    'mean squared error [px^2]': seen[..., 0].mean(axis=0).round(3).tolist(),
                    'normalized, 2 is right': seen[..., 1].mean(axis=0).round(2).tolist(),
                    'intersection over union': seen[..., 2].mean(axis=0).round(3).tolist(),
                    'switches': int((np.diff(seen[..., 3], axis=0) != 0).sum()),
                    'frames': len(seen),
                }
        result[f'{name}, in the document'] = {'mean squared error [px^2]': list(REPORTED[name])}
    return result


def panned(k, scene):
    """Frame k as a camera sees it that pans and tilts by up to 3 px a frame, and where it looks."""
    left, top = 20 + 20 * np.sin(k / 7), 15 + 15 * np.sin(k / 8)
    look = np.array([round(left), round(top)])
    height, width = scene.height - 30, scene.width - 40
    return scene.render(k)[look[1] : look[1] + height, look[0] : look[0] + width], look


def measure_moving_camera():
    """Boxes of a picture, followed by their edges alone; counted is what is wholly in view."""
    result = {}
    for name in REPORTED:
        scene, first = open_scene(f'{name}?width=360&height=270'), INSIDE[name] + 60
        tracker, seen, ids = ContourTracker(ContourConfig(start='targets')), [], set()
        for k in range(first, first + FRAMES):
            image, look = panned(k, scene)
            outlines = [scene.outlines(k)[i] - look for i in sorted(scene.outlines(k))]
            if k == first:
                tracker.start([[*p.min(axis=0), *np.ptp(p, axis=0)] for p in outlines])
            tracks = tracker.update(Frame(image, 'bgr8', round(k * 1e9 / scene.rate)))
            found = dict(zip(tracks.rows['track_id'].tolist(), tracks.outlines, strict=True))
            ids |= set(found)
            none, size = np.zeros((1, 2)), np.array(image.shape[1::-1]) - 1
            seen.append([
                overlap(found.get(i, none), p, image.shape[:2])
                if ((p > 0) & (p < size)).all() else np.nan
                for i, p in enumerate(outlines, 1)
            ])  # fmt: skip
        result[name] = {
            'intersection over union, mean': np.nanmean(seen, axis=0).round(2).tolist(),
            'least': np.nanmin(seen, axis=0).round(2).tolist(),
            'IDs': len(ids),
        }
    return result


def ways_of(names):
    """Set half and twice constants of the room, such as ``tracker.GROWN``, by turns.

    What is done is yielded; at last they are what they were.
    """
    rooms = [importlib.import_module(f'colortrack_ros.contours.{room}') for room in ROOMS]
    owners = [importlib.import_module('colortrack_ros.contours.' + n.split('.')[0]) for n in names]
    names = [name.split('.')[1] for name in names]
    values = {n: getattr(owner, n) for n, owner in zip(names, owners, strict=True)}
    ways = {'as they are': {}}
    for name, value in values.items():
        kind = np.asarray if isinstance(value, np.ndarray) else type(value)
        for changed in (kind(value / 2), kind(value * 2)):
            ways[f'{name} {changed}, not {value}'] = {name: changed}
    for way, changed in (ways | {'': {}}).items():
        for name, value in (values | changed).items():
            for room in (room for room in rooms if hasattr(room, name)):
                setattr(room, name, value)
        if way:
            yield way


def measure_constants(names):
    """What half and twice constants of the room make of the scenes."""
    result = {}
    for way in ways_of(names):
        result[way] = {}
        for scene in REPORTED:
            seen = quality(scene, SIZES['320x240'], ContourConfig())
            switches = int((np.diff(seen[..., 3], axis=0) != 0).sum()) if len(seen) else -1
            means = seen[..., :3].mean(axis=(0, 1)) if len(seen) else np.full(3, np.nan)
            result[way][f'{scene}: MSE [px^2], NSE, IoU, switches'] = [
                *means.round(3).tolist(), switches,
            ]  # fmt: skip
    return result


def moving(count, frames=120):
    """Pictures 640x480 of so many quadrilaterals that move, turn round and change their size."""
    rng = np.random.default_rng(0)
    wall = np.clip(200 + rng.normal(0, 2, (480, 640, 3)), 0, 255).astype(np.uint8)
    outline, columns = normalized(QUADRILATERAL)[0], -(-count // 2)
    for k in range(frames):
        image = wall.copy()
        for i in range(count if k > 8 else 0):
            u = 640 * (i % columns + 0.5) / columns + 15 * np.sin(k / 20 + i)
            v = 120 + 240 * (i // columns) + 25 * np.cos(k / 25 + i)
            radius = min(28, 200 / columns) + 3 * np.sin(k / 30 + i)
            draw_polygon(image, placed(outline, np.array([u, v]), radius, 0.0), (40, 50, 60))
        yield image


def measure_speed():
    """Median, mean and greatest time of a frame [ms], and the contours that it had."""
    result = {}
    for count, points in ((1, 12), (10, 12), (10, 24), (40, 12)):
        config = ContourConfig(points=points, min_motion=0.0)
        tracker, times, known = ContourTracker(config), [], []
        for k, image in enumerate(list(moving(count))):
            stamp = round(k * 1e9 / 24)
            begin = time.perf_counter()
            tracks = tracker.update(Frame(image, 'bgr8', stamp))
            spent = (time.perf_counter() - begin) * 1e3
            if k >= 50:
                times.append(spent)
                known.append(np.count_nonzero(tracks.rows['state']))
        result[f'{count} targets, {points} points'] = {
            'median [ms]': round(float(np.median(times)), 3),
            'mean [ms]': round(float(np.mean(times)), 3),
            'greatest [ms]': round(max(times), 3),
            'contours': round(float(np.mean(known)), 1),
        }
    return result


def show(console, title, rows):
    columns = list(next(iter(rows.values())))
    table = Table('', *map(escape, columns), title=title)
    for way, row in rows.items():
        cells = [row.get(column, '') for column in columns]
        texts = [', '.join(map(str, c)) if isinstance(c, list) else str(c) for c in cells]
        table.add_row(way, *texts)
    console.print(table)


def main():
    cv2.setNumThreads(1)
    console = Console(width=140)
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--constants', metavar='FILE.NAME', nargs='+')
    given = parser.parse_args()
    if given.constants:
        show(console, 'Constants', measure_constants(given.constants))
        return
    result = {
        'versions': {'opencv': cv2.__version__, 'numpy': np.__version__},
        'python': platform.python_version(),
        'load': os.getloadavg(),
        'speed': measure_speed(),
    }
    show(console, 'One frame of 640x480, one thread', result['speed'])
    result['quality'] = measure_quality()
    show(console, 'Followed against the truth', result['quality'])
    result['moving camera'] = measure_moving_camera()
    show(console, 'Before a camera that moves', result['moving camera'])
    OUT.parent.mkdir(exist_ok=True)
    OUT.write_text(json.dumps(result, indent=2) + '\n')


if __name__ == '__main__':
    main()
