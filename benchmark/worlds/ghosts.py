"""Issue points 5, 6: what is gone, what hides, and where the picture ends."""

import numpy as np
from points import cruise

from worlds.following import kept
from worlds.motions import in_a_box
from worlds.world import Figure
from worlds.world import identity
from worlds.world import judge
from worlds.world import observe
from worlds.world import places
from worlds.world import play
from worlds.world import RATE

COVERS = ((300.0, 390.0), (850.0, 910.0))
"""Upright strips that hide what is behind them, from u to u [px]."""

SPEED = (120.0, 220.0)
"""Of the objects [px/s]: behind a cover for 0.3 to 1.0 s, unless they go steeply."""

REACH = 60.0
"""How far a track that coasts behind a cover may be from its object [px]."""


def behind(position):
    """(K, N)."""
    u = position[..., 0]
    return np.any([(u > low) & (u < high) for low, high in COVERS], axis=0)


def upright(path):
    """The same with the slow motion along u, so that nobody stays behind a cover, left out."""
    position, velocity = path
    quick = np.abs(velocity[0, :, 0]) > 90.0
    return position[:, quick], velocity[:, quick]


def vanishing(rng, count=36, frames=450):
    """Some things are taken away in the open for good; all others hide behind covers."""
    position, velocity = upright(in_a_box(rng, count, frames, SPEED))
    begin = np.where(
        rng.random(position.shape[1]) < 0.4, 0, rng.integers(0, frames, position.shape[1])
    )
    end = begin + rng.integers(3 * RATE, 8 * RATE, position.shape[1])
    covered, k = behind(position), np.arange(frames)[:, None]
    for n in np.flatnonzero(end < frames):
        open_air = np.flatnonzero(~covered[end[n] :, n])
        end[n] += open_air[0] if len(open_air) else frames
    exists = (k >= begin) & (k < end)
    return observe((position, velocity), rng, seen=~covered, exists=exists)


def vanish(seed, rivals):
    """False rows a true row, and who keeps the ID behind a cover."""
    world = vanishing(np.random.default_rng(seed))
    sequence, true = world.sequence(REACH), world.exists.sum()
    frames = play(world.detections)
    sure = [rows[(rows['state'] != 2) | (rows['score'] >= 0.9)] for rows in frames]
    theirs = [judge(sequence, rival(sequence)) for rival in rivals]
    least = min(score.false for score in theirs)
    for what, rows, high in (
        ('as published', frames, 5.0),
        ('coasting at score >= 0.9', sure, np.inf),
    ):
        score = judge(sequence, places(rows))
        share = 100 * score.false / true
        yield Figure(f'{what}: false rows %', share, rival=100 * least / true, high=high)
        yield Figure(f'{what}: IDF1 %', 100 * score.idf1, rival=100 * max(s.idf1 for s in theirs))
    same = kept(world, frames)
    yield Figure('hidden ones with their ID %', 100 * same.mean(), low=95.0)


def image_size(seed, rivals):
    """Points that leave the picture, 50 at a time; the size typed in and not."""
    for what, stated, sequence in (
        ('cruise', (98.9, 91.6), cruise(50, seed=seed)),
        ('blackout', (95.9, 78.9), cruise(
            50, speed=(4.0, 12.0), detected=0.85, clutter=0.2, blackout=0.02, seed=seed)),
    ):  # fmt: skip
        known = identity(f'{what}, known', sequence, rivals, stated[0], image_size=sequence.size)
        yield next(known)
        yield next(identity(f'{what}, not known', sequence, rivals, stated[1], at_least=stated[0]))


WORLDS = {'5 vanish': vanish, '6 image_size': image_size}
