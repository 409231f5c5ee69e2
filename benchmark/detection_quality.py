"""What each way to reject clutter, to bear changing light and to part blobs is worth.

python benchmark/detection_quality.py prints the table and writes
out/benchmark_detection_quality.json. The scenes bring their own truth.
With --constants it halves and doubles each constant of the detector that was fitted, in a scene
that it matters in, and writes out/benchmark_detection_constants.json.
"""

import argparse
from importlib import import_module
import json
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from colortrack_ros.data import Frame
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection import ReferenceColor
from colortrack_ros.scenes import open_scene

AREA = {'min_area': 200, 'max_area': 4000}
SHAPE = {'min_circularity': 0.8, 'min_solidity': 0.9}
MOVING = {'moving_only': True}

RUNS = [
    ('clutter', 25.0, 'color alone', {}),
    ('clutter', 25.0, 'area', AREA),
    ('clutter', 25.0, 'shape', SHAPE),
    ('clutter', 25.0, 'moving only', MOVING),
    ('clutter', 25.0, 'area and shape', {**AREA, **SHAPE}),
    ('clutter', 25.0, 'moving only, area', {**AREA, **MOVING}),
    ('clutter', 25.0, 'moving only, area, aspect', {**AREA, **MOVING, 'min_aspect': 0.3}),
    ('clutter', 25.0, 'moving only, area, shape', {**AREA, **MOVING, **SHAPE}),
    ('light', 25.0, 'color alone', {}),
    ('light', 25.0, 'gray world', {'white_balance': 'gray_world'}),
    ('light', 25.0, 'colors follow', {'follow_light': 60.0}),
    ('light', 35.0, 'colors follow, wider tolerance', {'follow_light': 60.0}),
    ('light', 50.0, 'color alone, wide tolerance', {}),
    ('light', 50.0, 'gray world, wide tolerance', {'white_balance': 'gray_world'}),
    ('light', 50.0, 'colors follow, wide tolerance', {'follow_light': 60.0}),
    ('collision', 50.0, 'whole blobs', {}),
    ('collision', 50.0, 'split', {'split': True}),
    ('swarm?duration=5', 50.0, 'whole blobs', {}),
    ('swarm?duration=5', 50.0, 'split', {'split': True}),
    ('swarm?duration=5', 50.0, 'closing', {'closing_size': 5}),
    ('juggle?duration=5', 50.0, 'color alone', {}),
    ('juggle?duration=5', 50.0, 'that grows by a third', {'grow': 1.3}),
    ('fast', 50.0, 'color alone', {}),
    ('single', 50.0, 'color alone', {}),
    ('single', 35.0, 'a tighter tolerance', {}),
    ('single', 35.0, 'that grows by half', {'grow': 1.5}),
    ('occlusion', 50.0, 'color alone', {}),
]
OUT = Path(__file__).parents[1] / 'out'

BALL = ('single', 50.0, {})
SMEARED = ('fast', 50.0, {})
JUGGLED = ('juggle?duration=5', 50.0, {})
ROOM = ('clutter', 25.0, {**AREA, **MOVING})
FOLLOWED = ('light', 25.0, {'follow_light': 60.0})
BALANCED = ('light', 50.0, {'white_balance': 'gray_world'})
TOUCHING = ('swarm?duration=2', 50.0, {'split': True})

CONSTANTS = {
    'covariance': {
        'OUTLINE_VARIANCE': BALL,
        'SEEN_AT_LIMB': BALL,
        'SEEN_DEEPER': JUGGLED,
        'MOST_SEEN': JUGGLED,
        'SHADED_VARIANCE': BALL,
        'UNSEEN_CHANCE': BALL,
        'CHORD_VARIANCE': JUGGLED,
        'CHORD_ERROR': JUGGLED,
        'CUT_SHIFT': JUGGLED,
        'HIDDEN_REACH': ROOM,
    },
    'blur': {
        'PROFILES': JUGGLED,
        'OFF_MIDDLE': JUGGLED,
        'CLOSE': BALL,
        'REACH_SHARE': JUGGLED,
        'UNSURE': BALL,
        'MOST_FARTHER': SMEARED,
    },
    'chords': {
        'NO_HUE': JUGGLED,
        'MIXED': SMEARED,
    },
    'skewness': {
        'CHANCES': JUGGLED,
        'LEARN_RATE': JUGGLED,
        'SPREADS': JUGGLED,
        'USUAL_SHARE': JUGGLED,
    },
    'background_model': {
        'FOLLOW_RATES': ROOM,
        'HELD_SLOWDOWN': ROOM,
        'OBJECT_MARGIN': ROOM,
        'OUTLINE_REACH': ROOM,
        'GHOST_CONTRAST': ROOM,
        'STILL_SECONDS': ROOM,
        'STILL_CHANGE': ROOM,
        'STILL_PIXELS': ROOM,
        'STRIPS': ROOM,
        'RELIGHT_PIXELS': ROOM,
        'LIGHT_DEAD_BAND': ROOM,
    },
    'light': {
        'BALANCE_PIXELS': BALANCED,
        'FOLLOW_SECONDS': FOLLOWED,
        'FOLLOW_STEP': FOLLOWED,
    },
    'methods.color': {'FOLLOW_PIXELS': FOLLOWED},
    'detector': {'SCORE_PIXELS': BALL},
    'split': {'PROMINENCE': TOUCHING, 'MOST_TOUCHING': TOUCHING},
}
"""By file of the detector and by name: the scene, tolerance and parameters that it is seen in."""


def evaluate(scene, config, visible=0.5):
    """Share of the balls found, false blobs a frame, RMSE [px], mean normalized squared error."""
    detector = Detector(config)
    sought, false, errors, squared = 0, 0, [], []
    for k in range(len(scene)):
        frame = Frame(scene.render(k), stamp=round(k * NANOSECONDS / scene.rate))
        rows = detector.detect(frame).rows
        is_false = np.ones(len(rows), bool)
        for ball in scene.truth(k):
            error = np.array([rows['u'] - ball['u'], rows['v'] - ball['v']]).T
            distance = np.where(rows['color'] == ball['color'], np.linalg.norm(error, axis=1), 1e9)
            is_false &= distance > 1.5 * ball['radius']
            if ball['visible'] < visible:
                continue
            sought += 1
            if distance.min(initial=1e9) < ball['radius']:
                row, error = rows[distance.argmin()], error[distance.argmin()]
                errors.append(distance.min())
                covariance = [[row['cov_uu'], row['cov_uv']], [row['cov_uv'], row['cov_vv']]]
                if ball['visible'] == 1:
                    squared.append(error @ np.linalg.solve(covariance, error) / 2)
        false += int(is_false.sum())
    rmse = float(np.sqrt(np.mean(np.square(errors))))
    return len(errors) / sought, false / len(scene), rmse, float(np.mean(squared))


def measure(spec, tolerance, parameters):
    """What :func:`evaluate` says of a scene with a tolerance for all of its colors."""
    scene = open_scene(spec)
    colors = [ReferenceColor.from_rgb(*color, tolerance) for color in scene.colors.items()]
    return evaluate(scene, DetectorConfig(colors=tuple(colors), **parameters))


def scaled(value, factor):
    """A constant, or each of several, times a factor; whole numbers stay whole, at least 1."""
    if isinstance(value, tuple):
        return tuple(scaled(item, factor) for item in value)
    return max(round(value * factor), 1) if isinstance(value, int) else value * factor


def ablation():
    """The rows of what each way is worth."""
    for spec, tolerance, what, parameters in RUNS:
        yield spec, what, *measure(spec, tolerance, parameters)


def sensitivity():
    """The rows of what becomes of the detections when a constant is another."""
    for file, names in CONSTANTS.items():
        module = import_module(f'colortrack_ros.detection.{file}')
        for name, run in names.items():
            value = getattr(module, name)
            for factor in (0.5, 1, 2):
                setattr(module, name, scaled(value, factor))
                yield run[0], f'{name} = {getattr(module, name)}', *measure(*run)
            setattr(module, name, value)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--constants', action='store_true', help='halve and double constants')
    constants = parser.parse_args().constants
    table = Table('scene', 'with', 'found', 'false a frame', 'RMSE [px]', 'NSE')
    rows = list(sensitivity() if constants else ablation())
    for spec, what, found, false, rmse, nse in rows:
        table.add_row(spec, what, f'{found:.1%}', f'{false:.2f}', f'{rmse:.2f}', f'{nse:.2f}')
    Console(width=100).print(table)
    OUT.mkdir(exist_ok=True)
    name = 'constants' if constants else 'quality'
    (OUT / f'benchmark_detection_{name}.json').write_text(json.dumps(rows, indent=2) + '\n')


if __name__ == '__main__':
    main()
