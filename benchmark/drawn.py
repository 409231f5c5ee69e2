"""The tracker beside others in worlds that are drawn at random, whatever comes out.

python benchmark/drawn.py [FIRST [COUNT]] prints the worlds of COUNT seeds, those first where the
best peer is furthest ahead. Nobody has chosen any of them: size of the picture, rate, number, kind
of motion, speed, noise and what is said of it, misses, clutter, boxes, and blobs that merge are
drawn. Objects bounce off the borders, or pass through. Peers are told the largest way from frame to
frame.
"""

import argparse
from dataclasses import replace
from functools import partial

import numpy as np
import peers
from points import Sequence
from scipy.sparse.csgraph import connected_components
from worlds.rivals import boxed
from worlds.rivals import run
from worlds.world import judge
from worlds.world import message
from worlds.world import places
from worlds.world import play

SIZES = ((320, 240), (640, 480), (1280, 720), (1920, 1080), (3840, 2160))
MOTIONS = ('straight', 'ballistic', 'drifting', 'stop and go', 'turning', 'weaving', 'passing')
RIVALS = {
    'filterpy': partial(run, peers.Filterpy),
    'norfair': partial(run, peers.Norfair),
    'SORT': boxed('SORTTracker'),
    'ByteTrack': boxed('ByteTrackTracker'),
}


def logarithmic(rng, low, high):
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def settings(rng):
    """What kind of world it is; lengths in px, times in s."""
    size = SIZES[rng.integers(len(SIZES))]
    count = round(logarithmic(rng, 1, 40))
    given = rng.choice(['none', 'right', 'wrong', 'wrong'])
    return {
        'size': size,
        'rate': float(rng.choice([8, 10, 15, 25, 30, 60, 120])),
        'count': count,
        'motion': str(rng.choice(MOTIONS)),
        'speed': size[0] * logarithmic(rng, 0.02, 0.5),
        'width': logarithmic(rng, size[0] / 120, size[0] / 20),
        'noise': logarithmic(rng, 0.2, 5),
        'heavy tails': rng.random() < 0.25,
        'given over true': {'none': 0.0, 'right': 1.0}.get(given, logarithmic(rng, 0.1, 10)),
        'missed': float(rng.choice([0, 0.02, 0.1, 0.3])),
        'out of sight': rng.random() < 0.3,
        'clutter': float(rng.choice([0, 0, 0.1, 0.5]) * count * rng.uniform(0.5, 1.5)),
        'in places': rng.random() < 0.4,
        'boxes': rng.random() < 0.5,
        'merging': rng.random() < 0.4,
        'jitter': float(rng.choice([0, 0.03, 0.1])),
    }


def move(world, rng):
    """Positions, (K, N, 2), and which are in the picture, (K, N)."""
    count, dt, speed, motion = world['count'], 1 / world['rate'], world['speed'], world['motion']
    frames, size = int(np.clip(8 / dt, 120, 400)), np.array(world['size'], float)
    z, angle = rng.uniform(0.1, 0.9, (count, 2)) * size, rng.uniform(0, 2 * np.pi, count)
    v = speed * rng.uniform(0.3, 1, (count, 1)) * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    begin, stands = np.zeros(count), np.zeros(count, bool)
    frequency, phase = rng.uniform(1, 6, count), rng.uniform(0, 2 * np.pi, count)
    if motion == 'passing':
        begin = rng.integers(0, frames, count) * (np.arange(count) > count // 3)
        z[:, 0], v = np.where(v[:, 0] > 0, 0, size[0]), v * [1, 0.3]
    path = np.empty((frames, count, 2))
    for k in range(frames):
        step = v
        if motion == 'ballistic':
            v = v + np.array([0, 1.5 * speed * dt])
        elif motion == 'drifting':
            v = v * np.exp(-2 * dt) + rng.normal(0, speed * np.sqrt(dt), v.shape)
        elif motion == 'stop and go':
            stands ^= rng.random(count) < dt
            step = v * ~stands[:, None]
        elif motion == 'turning':
            turn = np.exp(1j * rng.normal(0, 2.5 * np.sqrt(dt), count)) * (v @ [1, 1j])
            v = step = np.stack([turn.real, turn.imag], axis=1)
        elif motion == 'weaving':
            across = np.sin(frequency * k * dt + phase)[:, None]
            step = v + 0.7 * across * np.stack([-v[:, 1], v[:, 0]], axis=1)
        z = z + step * dt * (k >= begin)[:, None]
        if motion != 'passing':
            v = np.where(z < 0, np.abs(v), np.where(z > size, -np.abs(v), v))
            z = z.clip(0, size)
        path[k] = z
    return path, ((path >= 0) & (path <= size)).all(axis=2) & (np.arange(frames)[:, None] >= begin)


def look(path, exists, world, rng):
    """Which are seen, (K, N), and errors of their positions, (K, N, 2)."""
    seen = exists & (rng.random(exists.shape) >= world['missed'])
    if world['out of sight']:
        for i in range(world['count']):
            for first in rng.integers(0, len(path), rng.integers(0, 3)):
                seen[first : first + int(world['rate'] * rng.uniform(0.1, 0.6)), i] = False
    error = rng.normal(0, world['noise'], path.shape)
    if world['heavy tails']:
        error *= rng.standard_t(3, (*exists.shape, 1)).clip(-10, 10)
    return seen, error


def merge(z, box):
    """Boxes that overlap become one, with the centroid of all."""
    low, high = z - box / 2, z + box / 2
    touch = ((low[:, None] < high) & (low < high[:, None])).all(axis=2)
    count, label = connected_components(touch)
    area = box.prod(axis=1)[:, None]
    groups = [label == i for i in range(count)]
    centers = [(z[g] * area[g]).sum(axis=0) / area[g].sum() for g in groups]
    sizes = [high[g].max(axis=0) - low[g].min(axis=0) for g in groups]
    return np.reshape(centers, (-1, 2)), np.reshape(sizes, (-1, 2))


def draw(seed):
    """A world by its seed: its settings, and the sequence."""
    rng = np.random.default_rng(seed)
    world = settings(rng)
    path, exists = move(world, rng)
    seen, error = look(path, exists, world, rng)
    width = world['width'] * np.exp(rng.normal(0, 0.3, world['count']) * rng.integers(0, 2))
    spots = rng.uniform((0, 0), world['size'], (max(1, int(4 * world['clutter'])), 2))
    sigma = world['noise'] * world['given over true']
    detections = []
    for k, ids in enumerate(map(np.flatnonzero, seen)):
        z = path[k, ids] + error[k, ids]
        box = width[ids, None] * np.exp(rng.normal(0, world['jitter'], z.shape))
        if world['boxes'] and world['merging']:
            z, box = merge(z, box)
        false = rng.uniform((0, 0), world['size'], (rng.poisson(world['clutter']), 2))
        if world['in places']:
            false = rng.choice(spots, len(false)) + rng.normal(0, world['noise'], false.shape)
        other = world['width'] * np.exp(rng.normal(0, 0.3, false.shape))
        order = rng.permutation(len(z) + len(false))
        z, box = np.concatenate([z, false])[order], np.concatenate([box, other])[order]
        box = box if world['boxes'] else None
        told = message(z, k, sigma, box, world['rate'])
        detections.append(replace(told, image_size=world['size']))
    names = np.arange(world['count'])
    truth = [np.column_stack([names, z])[s] for z, s in zip(path, seen, strict=True)]
    way = np.hypot(*np.diff(path, axis=0).T).T[exists[1:]]
    hidden = (exists & ~seen).sum(axis=1).tolist()
    reach = max(10.0, 4 * world['noise'])
    step = float(way.max(initial=0.0))
    return world, Sequence(truth, hidden, detections, world['size'], step, reach)


def main(first, count):
    """Print a line for each world, and the means."""
    lines = []
    for seed in range(first, first + count):
        world, sequence = draw(seed)
        frames = {name: rival(sequence) for name, rival in RIVALS.items()}
        frames['ours'] = places(play(sequence.detections))
        score = {name: judge(sequence, rows) for name, rows in frames.items()}
        lines.append((seed, world, {name: 100 * one.idf1 for name, one in score.items()}))
    lead = [idf1['ours'] - max(idf1[name] for name in RIVALS) for *_, idf1 in lines]
    for i in np.argsort(lead):
        seed, world, idf1 = lines[i]
        told = ', '.join(
            f'{k} {v:.3g}' if isinstance(v, float) else f'{k} {v}' for k, v in world.items()
        )
        print(
            f'{seed:4d} {lead[i]:+6.1f} ', ' '.join(f'{k} {v:.1f}' for k, v in idf1.items()), told
        )
    means = {name: np.mean([idf1[name] for *_, idf1 in lines]) for name in lines[0][2]}
    print('mean IDF1 %:', ' '.join(f'{name} {mean:.1f}' for name, mean in means.items()))
    print(f'ahead of the best peer, or within a point, in {np.mean(np.array(lead) > -1):.0%}')


if __name__ == '__main__':
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('first', nargs='?', type=int, default=0)
    parser.add_argument('count', nargs='?', type=int, default=80)
    main(**vars(parser.parse_args()))
