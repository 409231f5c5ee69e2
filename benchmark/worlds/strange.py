"""Detectors and crowds that nothing was developed on: who is who, and what ellipses hold."""

from dataclasses import replace

import numpy as np

from colortrack_ros.data import NANOSECONDS
from worlds.following import follow
from worlds.motions import in_a_box
from worlds.motions import turning
from worlds.world import Figure
from worlds.world import identity
from worlds.world import message
from worlds.world import observe
from worlds.world import play
from worlds.world import RATE
from worlds.world import World

LEARNED = 30
"""Frames at the start whose ellipses are not judged."""


def figures(what, world, rivals, reach=20.0):
    yield from identity(what, world.sequence(reach), rivals, at_least=95.0)
    followed = follow(world, play(world.detections), reach)
    seen = followed.take((followed.unseen == 0) & (followed.frame >= LEARNED))
    yield Figure(f'{what}: in 95 % of position', seen.inside(0), low=90.0, high=99.0)


def uneven_noise(seed, rivals):
    """Things of 8 to 160 px, each with a noise of a twentieth of its size, that nobody tells."""
    rng = np.random.default_rng(seed)
    path = in_a_box(rng, 12, 300, (60.0, 200.0))
    size = np.geomspace(8, 160, 12)
    z = path[0] + rng.normal(0, 1, path[0].shape) * (size / 20)[:, None]
    boxes = np.repeat(size[:, None], 2, axis=1)
    detections = [message(z[k], k, 0.0, boxes) for k in range(len(z))]
    exists = np.ones(z.shape[:2], bool)
    yield from figures('noise by size', World(*path, exists, z, detections), rivals, 40.0)


def every_third(seed, rivals):
    """A detector that finds nothing in every third picture, and misses 5 % else."""
    rng = np.random.default_rng(seed)
    path = in_a_box(rng, 15, 300)
    seen = rng.random(path[0].shape[:2]) < 0.95
    seen[2::3] = False
    yield from figures('every third empty', observe(path, rng, 1.5, 0.0, seen), rivals)


def one_of_three(seed, rivals):
    """A detector that works on every third picture, and publishes nothing found for the others."""
    rng = np.random.default_rng(seed)
    path = in_a_box(rng, 15, 300)
    seen = rng.random(path[0].shape[:2]) < 0.95
    seen[1::3] = seen[2::3] = False
    yield from figures('two of three empty', observe(path, rng, 1.5, 0.0, seen), rivals)


def late_stamps(seed, rivals):
    """Stamps that are off by 8 ms (sigma), so that 200 px/s are 1.6 px."""
    rng = np.random.default_rng(seed)
    world = observe(in_a_box(rng, 15, 300), rng, 1.0, 0.0)
    k = np.arange(len(world.detections))
    stamps = np.sort(k / RATE + rng.normal(0, 0.008, len(k)) + 0.1)
    detections = [
        replace(one, stamp=round(stamp * NANOSECONDS))
        for one, stamp in zip(world.detections, stamps, strict=True)
    ]
    yield from figures('stamps off by 8 ms', replace(world, detections=detections), rivals)


def twice(seed, rivals):
    """One in ten is detected twice, the second time 12 px aside, with boxes and without."""
    rng = np.random.default_rng(seed)
    path, size = in_a_box(rng, 12, 300), np.full((12, 2), 40.0)
    world = observe(path, rng, 1.0, 0.0, size=size[:, 0])
    detections = []
    for one in world.detections:
        again = one.rows[rng.random(len(one.rows)) < 0.1].copy()
        angle = rng.uniform(0, 2 * np.pi, len(again))
        for u, way in (('u', np.cos(angle)), ('v', np.sin(angle))):
            again[u] += 12 * way
            again[f'box_{u}'] += 12 * way
        detections.append(replace(one, rows=np.concatenate([one.rows, again])))
    both = replace(world, detections=detections)
    yield from figures('found twice, boxes', both, rivals)
    bare = [
        message(np.column_stack([one.rows['u'], one.rows['v']]), k, 0.0)
        for k, one in enumerate(detections)
    ]
    yield from figures('found twice, points', replace(world, detections=bare), rivals)


def again(seed, rivals):
    """A fifth, half and all points are found twice, 0.3 or 1.4 px apart (sigma)."""
    for share, aside in ((0.2, 0.3), (0.5, 1.4), (1.0, 0.3)):
        rng = np.random.default_rng(seed)
        world = observe(in_a_box(rng, 12, 300), rng, 1.0, 0.0)
        detections = []
        for k, one in enumerate(world.detections):
            z = np.column_stack([one.rows['u'], one.rows['v']])
            second = z[rng.random(len(z)) < share]
            second += rng.normal(0, aside, second.shape)
            detections.append(message(rng.permutation(np.concatenate([z, second])), k, 0.0))
        twice = replace(world, detections=detections)
        yield from figures(f'{share:.0%} again, {aside} px', twice, rivals)


def slow_camera(seed, rivals):
    """Ten pictures a second of things that turn often, at 150 px/s."""
    rng = np.random.default_rng(seed)
    position, velocity = turning(rng, 8, 900, rate=1.0)
    world = observe((position[::3], velocity[::3]), rng, 1.0, 0.0)
    detections = [
        replace(one, stamp=round(k * NANOSECONDS / 10)) for k, one in enumerate(world.detections)
    ]
    yield from figures('10 Hz', replace(world, detections=detections), rivals)


def come_and_go(seed, rivals):
    """From none to forty and back, in two waves of six seconds, of others each time."""
    rng = np.random.default_rng(seed)
    path, frames = in_a_box(rng, 80, 360), np.arange(360)[:, None]
    many = 20 * (1 - np.cos(2 * np.pi * frames / (6 * RATE)))
    exists = (np.arange(80) % 40 < many) & (np.arange(80) // 40 == frames // (6 * RATE))
    world = observe(path, rng, 1.0, 0.0, rng.random(exists.shape) < 0.95, exists=exists)
    yield from figures('0 to 40', world, rivals)


WORLDS = {
    '16 noise by size': uneven_noise,
    '16 every third picture empty': every_third,
    '16 every third picture alone': one_of_three,
    '16 stamps that jitter': late_stamps,
    '16 found twice': twice,
    '16 points found again': again,
    '16 slow camera, fast turns': slow_camera,
    '16 come and go': come_and_go,
}
