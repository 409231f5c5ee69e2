"""Window tracker: time of a target, and how well it is held: ``python benchmark/windows.py``.

``--swarm`` compares the swarm with its mean and with WM+K, ``--constants template.STEPS ...``
constants of the room with half and twice their values. The peers KCF, MOSSE and CSRT take part
where opencv-contrib-python-headless is installed.
"""

import argparse
from collections.abc import Callable
import importlib
import time

import cv2
import numpy as np

from colortrack_ros.data import Frame
from colortrack_ros.scenes import open_scene
from colortrack_ros.windows import WindowConfig
from colortrack_ros.windows import WindowTracker
from colortrack_ros.windows.config import WINDOW_METHODS

SCENES = ('texture', 'clutter', 'partial', 'hidden', 'jump')
APPEARANCE = ('appearance', 'colors', 'correlation', 'features', 'scale', 'sighting')
ROOMS = (*APPEARANCE, 'matching', 'motion', 'template', 'tracker')
NEAR = 5.0
SIZE = 'width=640&height=480'
PLAIN = {'drift_compensation': False}


def played(name, seed=0):
    """Frames as BGR, their stamps [ns], and centers (frames, objects, 2) and radii of the truth."""
    scene = open_scene(f'window_{name}?{SIZE}&seed={seed}')
    truth = [scene.truth(k)[: 1 if name == 'clutter' else None] for k in range(len(scene))]
    frames = [scene.render(k) for k in range(len(scene))]
    stamps = [round(k * 1e9 / scene.rate) for k in range(len(scene))]
    return frames, stamps, np.stack([truth_uv(t) for t in truth]), truth[0]['radius'].astype(float)


def truth_uv(rows):
    return np.stack([rows['u'], rows['v']], axis=1)


def boxes_of(center, radius):
    side = 2 * np.stack([radius, radius], axis=1)
    return np.concatenate([center - (side - 1) / 2, side], axis=1)


def window_tracker(config) -> Callable:
    def start(boxes):
        tracker = WindowTracker(config, boxes)

        def step(image, stamp):
            rows = tracker.update(Frame(image, 'bgr8', stamp)).rows
            return {int(r['track_id']) - 1: (r['u'], r['v']) for r in rows}

        return step

    return start


def peer(make) -> Callable:
    """A tracker of OpenCV, one object of it for each target."""

    def start(boxes):
        trackers: list = []

        def step(image, stamp):
            if not trackers:
                for box in boxes:
                    trackers.append(make())
                    trackers[-1].init(image, tuple(np.rint(box).astype(int).tolist()))
                return {i: box[:2] + (box[2:] - 1) / 2 for i, box in enumerate(boxes)}
            found = {}
            for i, tracker in enumerate(trackers):
                good, (u, v, w, h) = tracker.update(image)
                if good:
                    found[i] = u + (w - 1) / 2, v + (h - 1) / 2
            return found

        return step

    return start


def full_frame(boxes):
    """cv2.matchTemplate with the first template in the whole picture."""
    templates: list = []

    def step(image, stamp):
        gray = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
        if not templates:
            for u, v, w, h in np.rint(boxes).astype(int).tolist():
                templates.append(gray[v : v + h, u : u + w].copy())
        found = {}
        for i, template in enumerate(templates):
            u, v = cv2.minMaxLoc(cv2.matchTemplate(gray, template, cv2.TM_SQDIFF))[2]
            found[i] = u + (template.shape[1] - 1) / 2, v + (template.shape[0] - 1) / 2
        return found

    return step


class Mean:
    """In the place of the swarm: what it searches, the mean of the velocities."""

    def search(self, velocity):
        """As Swarm.search."""
        return np.nanmean(velocity, axis=1)


def mean_tracker(boxes):
    tracker = WindowTracker(WindowConfig(method='WM+K+PSO'), boxes)
    tracker._swarm = Mean()
    return tracker


def held(make, frames, stamps, center, radius):
    """Errors (frames, objects) [px], inf where the ID of the first frame is gone; ms a target."""
    tracker, times = make(boxes_of(center[0], radius)), []
    error = np.full(center.shape[:2], np.inf)
    for k, (image, stamp) in enumerate(zip(frames, stamps, strict=True)):
        begin = time.perf_counter()
        rows = tracker.update(Frame(image, 'bgr8', stamp)).rows
        times.append((time.perf_counter() - begin) * 1e3 / max(len(rows), 1))
        object_ = rows['track_id'].astype(int) - 1
        error[k, object_] = np.hypot(*(truth_uv(rows) - center[k, object_]).T)
    return error, float(np.median(times))


def of_seeds(name, ways, seeds):
    """By way: objects whose ID is on them in the last frame [%], RMSE [px] within NEAR, ms."""
    sums = {way: [] for way in ways}
    for seed in range(seeds):
        scene = played(name, seed)
        for way, make in ways.items():
            sums[way].append(held(make, *scene))
    result = {}
    for way, runs in sums.items():
        last = np.concatenate([error[-1] for error, _ in runs])
        near = np.concatenate([error[error < NEAR] for error, _ in runs])
        rmse, ms = np.sqrt((near**2).mean()), np.median([ms for _, ms in runs])
        result[way] = 100 * (last < NEAR).mean(), rmse, ms
    return result


def swarm(seeds):
    """What the swarm is worth against the mean that it searches, and against WM+K alone."""
    ways = {
        'WM+K': lambda boxes: WindowTracker(WindowConfig(method='WM+K'), boxes),
        'WM+K and the mean of the velocities': mean_tracker,
        'WM+K+PSO': lambda boxes: WindowTracker(WindowConfig(method='WM+K+PSO'), boxes),
    }
    table(
        ways,
        SCENES,
        seeds,
        'IDs held to the end, RMSE, ms a target',
        '{:.1f} %, {:.3f} px, {:.2f} ms',
    )


def constants(names, seeds):
    """What half and twice constants of the room, such as ``template.STEPS``, make of it.

    What a target looks like is learned if constants of that are among them.
    """
    learns = any(name.split('.')[0] in APPEARANCE for name in names)
    rooms = [importlib.import_module(f'colortrack_ros.windows.{r}') for r in ROOMS]
    owners = [importlib.import_module('colortrack_ros.windows.' + n.split('.')[0]) for n in names]
    names = [name.split('.')[1] for name in names]
    values = {n: getattr(owner, n) for n, owner in zip(names, owners, strict=True)}

    def make(changed):
        def start(boxes):
            for name, value in (values | changed).items():
                for room in (room for room in rooms if hasattr(room, name)):
                    setattr(room, name, value)
            return WindowTracker(WindowConfig(appearance=learns), boxes)

        return start

    ways = {'as they are': make({})}
    for name, value in values.items():
        for changed in (type(value)(value / 2), value * 2):
            ways[f'{name} {changed:g}, not {value:g}'] = make({name: changed})
    table(ways, SCENES, seeds, 'IDs held to the end, RMSE', '{:.1f} %, {:.3f} px')


def table(ways, scenes, seeds, title, cell):
    rows = {way: [] for way in ways}
    for scene in scenes:
        for way, values in of_seeds(scene, ways, seeds).items():
            rows[way].append(cell.format(*values))
    print(f'\n| {title} | ' + ' | '.join(scenes) + ' |\n|---|' + '---|' * len(scenes))
    for way, cells in rows.items():
        print(f'| {way} | ' + ' | '.join(cells) + ' |', flush=True)


def peers():
    places = (cv2, getattr(cv2, 'legacy', cv2))
    for name in ('KCF', 'MOSSE', 'CSRT'):
        for place in places:
            if hasattr(place, f'Tracker{name}_create'):
                yield name, peer(getattr(place, f'Tracker{name}_create'))
                break
        else:
            print(f'# {name}: not in this OpenCV; pip install opencv-contrib-python-headless')


def quality():
    """RMSE [px] of the frames within NEAR px, and their share [%]."""
    ways = {f'{m}, every window a template': window_tracker(WindowConfig(method=m, **PLAIN))
            for m in WINDOW_METHODS}  # fmt: skip
    ways['WM+K, rule of 4.3.1'] = window_tracker(WindowConfig(supervision='discrepancy'))
    ways |= {m: window_tracker(WindowConfig(method=m)) for m in WINDOW_METHODS}
    ways |= dict(peers()) | {'matchTemplate, whole frame': full_frame}
    table: dict[str, list[str]] = {name: [] for name in ways}
    for scene in SCENES:
        frames, stamps, center, radius = played(scene)
        for name, start in ways.items():
            step = start(boxes_of(center[0], radius))
            error = np.full(center.shape[:2], np.inf)
            for k, (image, stamp) in enumerate(zip(frames, stamps, strict=True)):
                for i, place in step(image, stamp).items():
                    error[k, i] = np.hypot(*(np.array(place) - center[k, i]))
            near = error < NEAR
            rmse = np.sqrt((error[near] ** 2).mean()) if near.any() else np.nan
            table[name].append(f'{rmse:.2f} {100 * near.mean():3.0f} %')
    print(f'\n| RMSE of frames within {NEAR:g} px, their share | ' + ' | '.join(SCENES) + ' |')
    print('|---|' + '---|' * len(SCENES))
    for name, cells in table.items():
        print(f'| {name} | ' + ' | '.join(cells) + ' |')


def moving_picture(count, size, frames=60):
    """A textured picture that moves 3 px a frame: every window of it is a target."""
    rng = np.random.default_rng(0)
    noise = cv2.GaussianBlur(rng.normal(size=(480, 640 + 3 * frames)), (0, 0), 2.5)
    wide = np.clip(128 + 40 * noise / noise.std(), 0, 255).astype(np.uint8)
    wide = cv2.merge([wide] * 3)
    pictures = [np.ascontiguousarray(wide[:, 3 * k : 3 * k + 640]) for k in range(frames)]
    u, v = rng.uniform(240, 540, count), rng.uniform(130, 350, count)
    return pictures, np.stack([u - size // 2, v - size // 2, *np.full((2, count), size)], axis=1)


def speed():
    """Median ms of a target."""
    print('| ms a target, 640x480, one thread | 1 target | 20 targets |\n|---|---|---|')
    for size, search in ((15, 40), (81, 121)):
        ways = {
            f'{m}, N = {size}, search {search}': window_tracker(
                WindowConfig(method=m, window=size, search_width=search, search_height=search)
            )
            for m in WINDOW_METHODS
        }
        ways |= {f'{name}, {size} px': start for name, start in peers()}
        ways[f'matchTemplate, whole frame, {size} px'] = full_frame
        for name, start in ways.items():
            cells = []
            for count in (1, 20):
                frames, boxes = moving_picture(count, size)
                step, times = start(boxes), []
                for k, image in enumerate(frames[: 60 if count == 1 else 25]):
                    begin = time.perf_counter()
                    found = step(image, k * 33_333_333)
                    times.append((time.perf_counter() - begin) * 1e3 / count)
                cells.append(f'{np.median(times[2:]):.3f}' + f' ({len(found)} kept)')
            print(f'| {name} | ' + ' | '.join(cells) + ' |', flush=True)


if __name__ == '__main__':
    cv2.setNumThreads(1)
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--swarm', action='store_true')
    parser.add_argument('--constants', metavar='FILE.NAME', nargs='+')
    parser.add_argument('--seeds', type=int, default=8, help='how often each scene is rendered')
    given = parser.parse_args()
    if given.swarm:
        swarm(given.seeds)
    elif given.constants:
        constants(given.constants, given.seeds)
    else:
        speed()
        quality()
