"""The method of the document Red object: what it finds, and what its two filters are worth.

python benchmark/red_object.py [--clip cups.mp4 --truth cups.csv] prints the tables and writes
out/benchmark_red_object.json; the clip is a real one with three red objects of one size.
"""

import argparse
import csv
from dataclasses import replace
import json
from pathlib import Path

import cv2
import numpy as np
import yaml

from colortrack_ros.data import COASTING
from colortrack_ros.data import Frame
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.scenes import open_scene
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig

ROOT = Path(__file__).parents[1]
OUT = ROOT / 'out' / 'benchmark_red_object.json'
PARAMS = yaml.safe_load((ROOT / 'params' / 'red_object.yaml').read_text())
SIZE = 'width=640&height=480'
SCENES = ('red_object', 'red_pair', 'red_hidden', 'red_throw', 'red_curve')
MOVING = ('red_object', 'red_hidden', 'red_throw', 'red_curve')
SETTLED = 24
"""Frames after which filters have begun."""

DETECTOR = DetectorConfig(**PARAMS['/**/detector']['ros__parameters'])
DOCUMENT = TrackerConfig(**PARAMS['/**/tracker']['ros__parameters'])
LEARNED = TrackerConfig(motion_model='known_acceleration', acceleration_span=0.12)
WAYS = {
    '`params/red_object.yaml`': DOCUMENT,
    'the same, no acceleration': replace(DOCUMENT, acceleration_span=0.0),
    'the same, consecutive positions': replace(DOCUMENT, acceleration_span=0.01),
    'the same, `trust: [100.0, 0.01]`': replace(DOCUMENT, trust=(100.0, 0.01)),
    'the same, `trust: [1.0, 1.0]`': replace(DOCUMENT, trust=(1.0, 1.0)),
    'the same, `constant_velocity`': replace(DOCUMENT, motion_model='constant_velocity'),
    'defaults': TrackerConfig(),
    'defaults, learned acceleration': LEARNED,
    'the same, positions 0.24 s apart': replace(LEARNED, acceleration_span=0.24),
    'defaults, `use_boxes: false`': TrackerConfig(use_boxes=False),
}


def frames_of(scene):
    """Pictures and, of the first object, u, v, visible part and visible area [px]."""
    for k in range(len(scene)):
        row = scene.truth(k)[0]
        image = scene.render(k)
        stamp = round(k * NANOSECONDS / scene.rate)
        area = np.pi * row['radius'] ** 2 * row['visible']
        yield Frame(image, stamp=stamp), row['u'], row['v'], row['visible'], area


def found(name, config):
    """Share of the frames with a detection near the largest object, errors [px], areas."""
    detector, hit, error, area = Detector(config), [], [], []
    for frame, u, v, visible, true in frames_of(open_scene(f'{name}?{SIZE}')):
        rows = detector.detect(frame).rows
        if visible < 1:
            continue
        away = np.hypot(rows['u'] - u, rows['v'] - v)
        hit.append(len(rows) > 0 and away[0] < np.sqrt(true / np.pi))
        if hit[-1]:
            error.append(away[0])
            area.append(rows['area'][0] / true)
    return summary(hit, error, area)


def found_in(clip, truth, config):
    """The same in a clip: a detection is right within the box of an object wholly in sight."""
    detector, hit, error, area = Detector(config), [], [], []
    boxes = {}
    for row in csv.DictReader(truth.open(newline='')):
        if int(row['labelled']) and float(row['visible']) > 0.9 and int(row['id']) <= 3:
            box = [float(row[k]) for k in ('u', 'v', 'w', 'h')]
            boxes.setdefault(int(row['frame']), []).append(box)
    video = cv2.VideoCapture(str(clip))
    for k in range(int(video.get(cv2.CAP_PROP_FRAME_COUNT))):
        ok, image = video.read()
        if not ok or k not in boxes:
            continue
        rows = detector.detect(Frame(image, stamp=k * NANOSECONDS // 30)).rows
        u, v, w, h = np.array(boxes[k]).T
        if not len(rows):
            hit.append(False)
            continue
        inside = (abs(rows['u'][0] - u) < w / 2) & (abs(rows['v'][0] - v) < h / 2)
        hit.append(inside.any())
        if hit[-1]:
            i = inside.argmax()
            error.append(np.hypot(rows['u'][0] - u[i], rows['v'][0] - v[i]))
            area.append(rows['area'][0] / (w[i] * h[i]))
    return summary(hit, error, area)


def summary(hit, error, area):
    """Share of frames with the object found; medians and worst of error and area."""
    return {
        'found': float(np.mean(hit)),
        'error': [float(x) for x in np.percentile(error, (50, 100))] if error else None,
        'area': [float(x) for x in np.percentile(area, (50, 0))] if area else None,
    }


def detections(name):
    """Detections and u, v, visible part of each frame, those of the largest blob."""
    detector = Detector(replace(DETECTOR, largest_object='blob', min_area=50))
    scene = open_scene(f'{name}?{SIZE}')
    return [(detector.detect(frame), *rest) for frame, *rest in frames_of(scene)]


def followed(played, config):
    """RMSE in sight, RMSE and worst error hidden [px], share of hidden frames tracked, IDs."""
    tracker, sight, hidden, missing, ids = Tracker(config), [], [], 0, set()
    for k, (seen, u, v, visible, _) in enumerate(played):
        rows = tracker.update(seen).rows
        rows = rows[rows['state'] > 0]
        ids |= set(rows['track_id'].tolist())
        if k < SETTLED:
            continue
        error = np.hypot(rows['u'] - u, rows['v'] - v)
        if visible == 1 and len(rows):
            sight.append(error.min())
        elif visible == 0:
            missing += not len(rows)
            if (rows['state'] == COASTING).any():
                hidden.append(error.min())
    return {
        'sight': float(np.sqrt(np.mean(np.square(sight)))),
        'hidden': [float(np.sqrt(np.mean(np.square(hidden)))), max(hidden)] if hidden else None,
        'missing': missing,
        'ids': len(ids),
    }


def show(result):
    """Two tables, as Markdown."""
    print('| found, error median / most [px], area median / least | region | blob |\n|---|---|---|')
    for name, ways in result['found'].items():
        cells = []
        for way in ways.values():
            cell = f'{100 * way["found"]:.0f} %'
            if way['error']:
                cell += ', {:.1f} / {:.0f}, {:.2f} / {:.2f}'.format(*way['error'], *way['area'])
            cells.append(cell)
        print(f'| `{name}` | {" | ".join(cells)} |')
    print(f'\n| | {" | ".join(f"`{name}`" for name in MOVING)} |\n|---|{"---|" * len(MOVING)}')
    for way, scenes in result['followed'].items():
        cells = []
        for score in scenes.values():
            cell = f'{score["sight"]:.2f}'
            if score['hidden']:
                cell += ', {:.1f} / {:.0f}'.format(*score['hidden'])
            if score['missing']:
                cell += f', none in {score["missing"]}'
            cells.append(cell + (f', {score["ids"]} IDs' if score['ids'] > 1 else ''))
        print(f'| {way} | {" | ".join(cells)} |')


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--clip', type=Path, help='a video with red objects')
    parser.add_argument('--truth', type=Path, help='CSV: frame,id,u,v,w,h,visible,labelled')
    arguments = parser.parse_args()
    ways = {way: replace(DETECTOR, largest_object=way) for way in ('region', 'blob')}
    result = {'found': {n: {w: found(n, c) for w, c in ways.items()} for n in SCENES}}
    if arguments.clip:
        result['found'][arguments.clip.name] = {
            way: found_in(arguments.clip, arguments.truth, replace(c, channel_threshold=80))
            for way, c in ways.items()
        }
    played = {name: detections(name) for name in MOVING}
    result['followed'] = {
        way: {name: followed(played[name], config) for name in MOVING}
        for way, config in WAYS.items()
    }
    show(result)
    OUT.parent.mkdir(exist_ok=True)
    OUT.write_text(json.dumps(result, indent=1))


if __name__ == '__main__':
    main()
