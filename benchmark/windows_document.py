"""Figures and tables as of Vidal 2009: ``python benchmark/windows_document.py``.

What window matching (WM), the Kalman filter (K) and the swarm (PSO) measure, side by side; the cost
functions of table 3.1; with ``--pictures``, drawings of both, and the map of reliability (3.2.3):
the distance of the template from each window of the search region, a valley where they are alike.
"""

import argparse
from pathlib import Path
import time

import cv2
import numpy as np
from windows import boxes_of
from windows import NEAR
from windows import played
from windows import SCENES

from colortrack_ros.data import Frame
from colortrack_ros.windows import WindowConfig
from colortrack_ros.windows import WindowTracker
from colortrack_ros.windows.config import WINDOW_METHODS
from colortrack_ros.windows.costs import COSTS
from colortrack_ros.windows.costs import distances

COLORS = {'truth': (0, 0, 0), 'WM': (0, 0, 255), 'WM+K': (0, 160, 0), 'WM+K+PSO': (255, 0, 0)}
HALF = 15
REACH = 20


def trace(scene, **settings):
    """Error of the first object (frames, 2) [px], NaN where its track has gone; ms a frame."""
    frames, stamps, center, radius = scene
    tracker = WindowTracker(WindowConfig(**settings), boxes_of(center[0], radius)[:1])
    error, times = np.full((len(frames), 2), np.nan), []
    for k, (image, stamp) in enumerate(zip(frames, stamps, strict=True)):
        begin = time.process_time()
        rows = tracker.update(Frame(image, 'bgr8', stamp)).rows
        times.append((time.process_time() - begin) * 1e3)
        if len(rows):
            error[k] = rows['u'][0] - center[k, 0, 0], rows['v'][0] - center[k, 0, 1]
    return error, float(np.median(times))


def summary(error, ms):
    """RMSE [px] of the frames within NEAR px, their share, and ms, as a cell of a table."""
    distance = np.hypot(*error.T)
    near = distance < NEAR
    rmse = np.sqrt((distance[near] ** 2).mean()) if near.any() else np.nan
    return f'{rmse:.2f} px, {100 * near.mean():.0f} %, {ms:.2f} ms'


def methods(folder):
    """WM, K and PSO on every scene, as the document has them: by the template alone."""
    print('| scene | ' + ' | '.join(WINDOW_METHODS) + ' |\n|---|' + '---|' * len(WINDOW_METHODS))
    for name in SCENES:
        scene = played(name)
        runs = {m: trace(scene, method=m, appearance=False) for m in WINDOW_METHODS}
        print(f'| `{name}` | ' + ' | '.join(summary(*r) for r in runs.values()) + ' |', flush=True)
        if folder:
            lines = {m: error[:, 0] for m, (error, _) in runs.items()}
            cv2.imwrite(str(folder / f'{name}.png'), plot({'truth': 0 * lines['WM'], **lines}))


def costs():
    """Each cost function: what it finds on a scene, and the time of a search for 31x31 px."""
    scene = played('texture')
    picture = cv2.cvtColor(scene[0][0], cv2.COLOR_BGR2GRAY).astype(np.float32)
    region = picture[
        200 - REACH - HALF : 201 + REACH + HALF, 300 - REACH - HALF : 301 + REACH + HALF
    ]
    template = np.ascontiguousarray(region[REACH:-REACH, REACH:-REACH])
    print('\n| cost | `texture` with WM+K | a search |\n|---|---|---|')
    for name in COSTS:
        times = []
        for _ in range(5):
            begin = time.process_time()
            distances(name, template, region)
            times.append((time.process_time() - begin) * 1e3)
        cell = summary(*trace(scene, method='WM+K', appearance=False, cost=name))
        print(f'| `{name}` | {cell} | {min(times):.2f} ms |', flush=True)


def plot(lines):
    """Errors in u of each frame, 10 px up and down, as a picture."""
    canvas = np.full((240, 900, 3), 255, np.uint8)
    for row, (name, values) in enumerate(lines.items()):
        cv2.putText(canvas, name, (10, 20 + 18 * row), cv2.FONT_HERSHEY_SIMPLEX, 0.5, COLORS[name])
        known = np.flatnonzero(~np.isnan(values))
        points = np.stack([known * 900 / len(values), 120 - 12 * np.clip(values[known], -10, 10)])
        cv2.polylines(canvas, [np.rint(points.T).astype(np.int32)], False, COLORS[name])
    return canvas


def reliability(folder):
    """The map of reliability of the first object of each scene, beside its region."""
    for name in SCENES:
        frames, _, center, _ = played(name)
        first, second = (cv2.cvtColor(f, cv2.COLOR_BGR2GRAY).astype(np.float32) for f in frames[:2])
        u, v = np.rint(center[0, 0]).astype(int).tolist()
        template = first[v - HALF : v + HALF + 1, u - HALF : u + HALF + 1].copy()
        rim = REACH + HALF
        region = second[v - rim : v + rim + 1, u - rim : u + rim + 1].copy()
        matrix = cv2.normalize(distances('ssd', template, region), None, 0, 255, cv2.NORM_MINMAX)
        colored = cv2.applyColorMap(matrix.astype(np.uint8), cv2.COLORMAP_VIRIDIS)
        sides = [cv2.merge([p.astype(np.uint8)] * 3) for p in (template, region)] + [colored]
        tall = [cv2.resize(p, (300, 300), interpolation=cv2.INTER_NEAREST) for p in sides]
        cv2.imwrite(str(folder / f'{name}_reliability.png'), np.hstack(tall))


if __name__ == '__main__':
    cv2.setNumThreads(1)
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--pictures', type=Path, metavar='FOLDER')
    given = parser.parse_args()
    methods(given.pictures)
    costs()
    if given.pictures:
        reliability(given.pictures)
