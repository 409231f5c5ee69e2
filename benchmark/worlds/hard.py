"""Issue point 11: hard worlds in which others led."""

from dataclasses import replace

import numpy as np
from points import cruise

from worlds.identities import groups
from worlds.motions import in_a_box
from worlds.world import identity
from worlds.world import message
from worlds.world import observe
from worlds.world import RATE
from worlds.world import SIZE


def clutter(seed, rivals):
    """A hundred points, and as many false detections."""
    sequence = cruise(100, clutter=1.0, picture=SIZE, seed=seed)
    yield from identity('clutter', sequence, rivals, 74.0, peer=89.0)


def bursts(seed, rivals):
    """Nothing at all in 5 to 15 frames on end, about once in two seconds."""
    sequence, rng = cruise(20, picture=SIZE, seed=seed), np.random.default_rng(seed)
    detections, k = list(sequence.detections), 0
    while k < len(detections):
        first = k + rng.integers(RATE, 3 * RATE)
        k = first + rng.integers(5, 16)
        for i in range(first, min(k, len(detections))):
            detections[i] = replace(detections[i], rows=detections[i].rows[:0])
    yield from identity('bursts', replace(sequence, detections=detections), rivals, 82.0, peer=92.0)


def lost(seed, rivals):
    """30 % of the messages never arrive; what is judged is the rest."""
    sequence, rng = cruise(20, picture=SIZE, seed=seed), np.random.default_rng(seed)
    arrived = np.flatnonzero(rng.random(len(sequence.truth)) < 0.7)
    some = {key: [getattr(sequence, key)[k] for k in arrived] for key in ('truth', 'hidden')}
    detections = [sequence.detections[k] for k in arrived]
    yield from identity(
        'lost', replace(sequence, detections=detections, **some), rivals, 82.0, peer=91.0
    )


def merging(rng, count=30, frames=300, touch=40.0):
    """Objects that touch are one detection, at their mean, without a box."""
    world = observe(in_a_box(rng, count, frames), rng)
    detections = []
    for k, z in enumerate(world.z):
        name = groups(np.hypot(*(z[:, None] - z).T) < touch)
        means = np.array([z[name == n].mean(axis=0) for n in np.unique(name)])
        detections.append(message(means, k))
    return replace(world, detections=detections).sequence(30.0)


def centroids(seed, rivals):
    """As merging()."""
    sequence = merging(np.random.default_rng(seed))
    yield from identity('merge and split', sequence, rivals, 47.0, peer=91.0)


WORLDS = {
    '11 as many false as true': clutter,
    '11 bursts of empty frames': bursts,
    '11 30 % of the messages lost': lost,
    '11 merge and split by centroids': centroids,
}
