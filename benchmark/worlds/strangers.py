"""Detectors of strangers: errors, stamps, gaps and speeds as none of ours has them."""

from dataclasses import replace

import numpy as np

from colortrack_ros.data import NANOSECONDS
from worlds.motions import in_a_box
from worlds.motions import lanes
from worlds.motions import stepped
from worlds.strange import figures
from worlds.world import lasting
from worlds.world import message
from worlds.world import RATE
from worlds.world import World


def detected(rng, path, z, seen, size=None, sigma=0.0):
    """The world of detections at z, in any order.

    :param size: (K, N, 2) of the boxes [px], None for points.
    """
    z, detections = np.where(seen[..., None], z, np.nan), []
    for k in range(len(z)):
        order = rng.permutation(np.flatnonzero(seen[k]))
        box = None if size is None else size[k, order]
        detections.append(message(z[k, order], k, sigma, box))
    return World(*path, np.ones(seen.shape, bool), z, detections)


def strays(seed, rivals):
    """5 and 10 % of the detections are off by 20 standard deviations."""
    for share in (0.05, 0.1):
        rng = np.random.default_rng(seed)
        path = in_a_box(rng, 12, 300)
        z = path[0] + rng.normal(0, 1, path[0].shape)
        off = rng.random(z.shape[:2]) < share
        z[off] += rng.normal(0, 20, (off.sum(), 2))
        seen = rng.random(z.shape[:2]) < 0.97
        world = detected(rng, path, z, seen, np.full(z.shape, 40.0), 1.0)
        yield from figures(f'{share:.0%} stray', world, rivals)


def dashes(seed, rivals):
    """Things that stand and are at 40 px a frame four frames later, for about ten frames."""
    rng = np.random.default_rng(seed)
    velocity = np.zeros((300, 8, 2))
    start = np.stack([rng.uniform(200, 1000, 8), lanes(8)], axis=1)
    for n, sign in enumerate(np.where(start[:, 0] < 640, 1, -1)):
        k = rng.integers(30, 60)
        while k < 260:
            way = [10, 20, 30, *[40] * rng.integers(9, 15), 30, 20, 10]
            velocity[k : k + len(way), n, 0] = sign * RATE * np.array(way)[: 300 - k]
            sign, k = -sign, k + len(way) + rng.integers(25, 60)
    path = stepped(start, velocity)
    z, seen = path[0] + rng.normal(0, 1, path[0].shape), rng.random((300, 8)) < 0.97
    yield from figures('dashes, boxes', detected(rng, path, z, seen, 0 * z + 40, 1.0), rivals)
    yield from figures('dashes, points', detected(rng, path, z, seen, None, 1.0), rivals)


def loose_corners(seed, rivals):
    """Corners of boxes that are off by 2 px each and rounded to 8 px."""
    rng = np.random.default_rng(seed)
    path, half = in_a_box(rng, 14, 300), rng.uniform(10, 35, (14, 2))
    low, high = (
        np.round((path[0] + side * half + rng.normal(0, 2, path[0].shape)) / 8) * 8
        for side in (-1, 1)
    )
    high, seen = np.maximum(high, low + 8), rng.random(path[0].shape[:2]) < 0.92
    world = detected(rng, path, (low + high) / 2, seen, high - low)
    yield from figures('corners of 8 px', world, rivals)


def lost_frames(seed, rivals):
    """A quarter of the frames, and some runs, never come; stamps are off by 10 ms (sigma)."""
    rng = np.random.default_rng(seed)
    path = in_a_box(rng, 15, 400)
    z = path[0] + rng.normal(0, 1.5, path[0].shape)
    world = detected(rng, path, z, rng.random(z.shape[:2]) < 0.95)
    stamps = np.sort(np.arange(400) / RATE + rng.normal(0, 0.01, 400) + 0.1)
    came, k = rng.random(400) < 0.75, 0
    while k < 400:
        k += rng.integers(20, 60)
        came[k : k + rng.integers(2, 8)] = False
    detections = [
        replace(one, stamp=round(stamp * NANOSECONDS) + k)
        for k, (one, stamp) in enumerate(zip(world.detections, stamps, strict=True))
        if came[k]
    ]
    parts = (world.position, world.velocity, world.exists, world.z)
    yield from figures('lost frames', World(*(x[came] for x in parts), detections), rivals)


def unsure(seed, rivals):
    """What is less sure than a threshold is left out: gaps for all, for one, false ones in runs."""
    rng = np.random.default_rng(seed)
    path = in_a_box(rng, 15, 400, (60.0, 250.0))
    sure = lasting(rng.normal(0, 0.6, (400, 1)), 0.95)
    sure = sure + lasting(rng.normal(0, 1, (400, 15)), 0.92)
    noise = 1.5 * (1 + np.exp(-sure)).clip(1, 3)[..., None]
    z = path[0] + noise * rng.normal(0, 1, path[0].shape)
    size = rng.uniform(25, 50, (15, 2)) * (1 + 0.06 * rng.normal(0, 1, z.shape))
    world = detected(rng, path, z, sure > -0.7, size)
    places = rng.uniform((100, 100), (1180, 620), (4, 2))
    on = lasting(rng.normal(0, 1, (400, 4)), 0.9) > 1
    detections = []
    for k, one in enumerate(world.detections):
        false = places[on[k]] + rng.normal(0, 2, (on[k].sum(), 2))
        rows = message(false, k, 0.0, np.full(false.shape, 35.0)).rows
        detections.append(replace(one, rows=np.concatenate([one.rows, rows])))
    yield from figures('in bursts', replace(world, detections=detections), rivals)


def in_turns(seed, rivals):
    """Two detectors by turns, the second noisier, with larger boxes, and 5 and 4 px aside."""
    rng = np.random.default_rng(seed)
    path = in_a_box(rng, 12, 300)
    z, size = path[0].copy(), np.repeat(rng.uniform(25, 60, (1, 12, 2)), 300, axis=0)
    z[::2] += rng.normal(0, 1, z[::2].shape)
    z[1::2] += rng.normal(0, 3, z[1::2].shape) + np.array([5.0, 4.0])
    size[1::2] *= 1.25
    world = detected(rng, path, z, rng.random(z.shape[:2]) < 0.95, size)
    yield from figures('two detectors', world, rivals)


WORLDS = {
    '17 strays of 20 sigma': strays,
    '17 stand, then dash': dashes,
    '17 loose corners': loose_corners,
    '17 stamps jitter, frames lost': lost_frames,
    '17 unsure ones left out': unsure,
    '17 two detectors by turns': in_turns,
}
