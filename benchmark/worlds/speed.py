"""Issue points 12, 13: time a frame, and what too many detections do."""

from functools import partial
import time

import numpy as np

from worlds.motions import in_a_box
from worlds.textbook import Textbook
from worlds.world import Figure
from worlds.world import message
from worlds.world import observe
from worlds.world import SIZE
from worlds.world import tracker

WARM, CHUNK = 30, 5
"""Frames before the clock runs, and frames of one tracker before it is the other's turn."""

STATED = {1: (0.95, 0.11), 10: (1.6, 0.16), 50: (1.6, 0.32), 1000: (np.nan, np.nan)}
"""Milliseconds of ours and of the textbook."""


def clock(update, message):
    start = time.perf_counter()
    update(message)
    return 1e3 * (time.perf_counter() - start)


def in_turns(updates, messages):
    """Median ms a frame of each, A B A B in one process."""
    took = [[] for _ in updates]
    for first in range(0, len(messages), CHUNK):
        for i, update in enumerate(updates):
            took[i] += [clock(update, one) for one in messages[first : first + CHUNK]]
    return [float(np.median(some[WARM:])) for some in took]


def of_points(make, sequence):
    """A tracker of centroids as one of messages."""
    other = make(sequence.step)
    return lambda one: other.update(np.stack([one.rows['u'], one.rows['v']], axis=1))


def frame(seed, rivals, count):
    """N objects with boxes, default parameters."""
    rng = np.random.default_rng(seed)
    size = rng.uniform(8, 20, count) if count > 50 else rng.uniform(20, 60, count)
    world = observe(in_a_box(rng, count, 60 if count > 50 else 150), rng, size=size)
    updates = [tracker().update, of_points(lambda step: Textbook(), world.sequence())]
    if len(rivals) > 1 and count <= 50:
        import peers

        updates.append(of_points(peers.Filterpy, world.sequence()))
    ours, book, *filterpy = in_turns(updates, world.detections)
    stated = STATED[count]
    yield Figure('ms a frame', ours, stated[0], book, high=4.0 if count > 50 else np.inf)
    if count <= 50:
        yield Figure('/ textbook', ours / book, stated[0] / stated[1], 1.0, high=2.0)
    for other in filterpy:
        ahead = 1.0 if count >= 10 else np.inf
        yield Figure('/ filterpy as SORT', ours / other, rival=1.0, high=ahead)


def flood(seed, rivals, count, scatter, before):
    """So many detections in each of three frames; the slowest, or the first above five seconds."""
    rng, ours = np.random.default_rng(seed), tracker()
    middle = np.array(SIZE) / 2
    z = middle + rng.uniform(-0.5, 0.5, (count, 2)) * scatter
    slowest = 0.0
    for k in range(3):
        took = clock(ours.update, message(z + rng.normal(0, 0.1, z.shape), k)) / 1e3
        slowest = max(slowest, took)
        if slowest > 5.0:
            break
    yield Figure('s a frame', slowest, before, high=1.0)


WORLDS = {f'12 time, N = {count}': partial(frame, count=count) for count in STATED} | {
    '13 load, 3,000 on one point': partial(flood, count=3000, scatter=0.0, before=6.0),
    '13 load, 100,000 rows': partial(flood, count=100_000, scatter=np.array(SIZE), before=30.0),
}
