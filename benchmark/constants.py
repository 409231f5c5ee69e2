"""What the tracker's assumed constants are worth: each halved and doubled, on a few worlds.

python benchmark/constants.py [NAME...] prints a row for each constant whose text says "assumed", or
for those of which a part of module.NAME is given. What was computed of one at import stays.
"""

import os

os.environ['OMP_NUM_THREADS'] = '1'
os.environ['OPENBLAS_NUM_THREADS'] = '1'

import argparse
import ast
from contextlib import ExitStack
from itertools import pairwise
from pathlib import Path
import sys
from unittest import mock

import numpy as np
from points import cruise
from points import of_scene

sys.path.insert(0, str(Path(__file__).parents[1] / 'test'))

from worlds.coasting import hide
from worlds.coasting import is_coasting
from worlds.following import follow
from worlds.ghosts import REACH
from worlds.ghosts import vanishing
from worlds.hard import merging
from worlds.identities import pedestrians
from worlds.motions import straight
from worlds.motions import turning
from worlds.noise import LEARNED
from worlds.world import judge
from worlds.world import lasting
from worlds.world import message
from worlds.world import observe
from worlds.world import places
from worlds.world import play
from worlds.world import World

import colortrack_ros.tracking

SIZES, CHANGED = ('EVERY', 'MOST_MERGED'), 0.05
"""Of tables made at import; and what is shown as nothing, if it changes by less [points]."""


def assumed(path):
    """Names and values of the numbers of a module whose text says that they are assumed."""
    module = sys.modules.get(f'colortrack_ros.tracking.{path.stem}')
    body = ast.parse(path.read_text()).body
    for statement, text in pairwise(body):
        told = isinstance(text, ast.Expr) and 'assumed' in ast.unparse(text).lower()
        if not isinstance(statement, ast.Assign) or not told or module is None:
            continue
        for target in ast.walk(statement.targets[0]):
            value = getattr(module, target.id) if isinstance(target, ast.Name) else None
            if isinstance(value, (int, float)) and target.id not in SIZES:
                yield f'{path.stem}.{target.id}', value


def others(value):
    """Half and twice; of probabilities that are nearly 1, with twice and half of what is left."""
    if isinstance(value, int):
        return max(1, value // 2), 2 * value
    return (value / 2, 2 * value) if not 0.5 < value < 1 else (2 * value - 1, (1 + value) / 2)


def replaced(name, value, other):
    """Patches of all modules of the package that have the constant."""
    stack = ExitStack()
    for key, module in list(sys.modules.items()):
        if key.startswith('colortrack_ros') and vars(module).get(name) is value:
            stack.enter_context(mock.patch.object(module, name, other))
    return stack


def worlds():
    """Sequences to be scored by IDF1, and worlds to be judged by their ellipses."""
    rng, other = np.random.default_rng(0), np.random.default_rng(1)
    sequences = {
        'collision': of_scene('collision'),
        'turns': cruise(20, frames=150, turns=0.02),
        'vanish': vanishing(rng, count=18, frames=300).sequence(REACH),
        'clutter': cruise(30, frames=150, clutter=1.0),
        'flicker': of_scene('flicker'),
        'blobs that overlap': pedestrians(other, 'blobs', count=8, frames=150),
        'points that merge': merging(other, count=15, frames=150),
    }
    noisy = observe(straight(rng, 8, 120), rng, 5.0, 0.0)
    return sequences, [noisy, loose(other)], hide(turning(rng, 8, 200), rng)


def loose(rng, rho=0.7):
    """Boxes of 40 px whose sides err by 2 px each; that share of it stays from frame to frame."""
    path = straight(rng, 8, 120)
    low, high = (lasting(rng.normal(0, 2, path[0].shape), rho) for _ in range(2))
    z, size = path[0] + (low + high) / 2, 40 + high - low
    seen = [message(z[k], k, 0.0, size[k]) for k in range(len(z))]
    return World(*path, np.ones(z.shape[:2], bool), z, seen)


def figures(sequences, measured, coasting):
    """By name: IDF1 [%] of the sequences, and what ellipses of 95 % hold [%]."""
    found = {}
    for name, one in sequences.items():
        rows = places(play(one.detections, image_size=one.size))
        found[name] = 100 * judge(one, rows).idf1
    for name, world in zip(('noise 5 px', 'loose boxes'), measured, strict=True):
        rows = follow(world, play(world.detections))
        rows = rows.take(rows.frame >= LEARNED)
        found[f'{name}: held'] = rows.inside(0)
        found[f'{name}: RMSE, 0.01 px'] = 100 * rows.rmse(0)
    unseen = follow(coasting, play(coasting.detections))
    found['coasting: held'] = unseen.take(is_coasting(unseen)).inside(0)
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('names', nargs='*', metavar='NAME')
    played, parts = worlds(), parser.parse_args().names or ['.']
    base = figures(*played)
    print('| constant | value | halved | doubled |\n|---|---|---|---|')
    print('| none | | ' + ', '.join(f'{k} {v:.1f}' for k, v in base.items()) + ' | |', flush=True)
    files = sorted(Path(colortrack_ros.tracking.__file__).parent.glob('*.py'))
    every = [pair for path in files for pair in assumed(path)]
    for label, value in [pair for pair in every if any(part in pair[0] for part in parts)]:
        cells = []
        for other in others(value):
            with replaced(label.split('.')[1], value, other):
                now = figures(*played)
            changes = {k: now[k] - base[k] for k in base if abs(now[k] - base[k]) > CHANGED}
            cells.append(', '.join(f'{k} {v:+.1f}' for k, v in changes.items()) or 'nothing')
        print(f'| {label} | {value:g} | {cells[0]} | {cells[1]} |', flush=True)


if __name__ == '__main__':
    main()
