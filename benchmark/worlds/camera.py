"""Issue point 10: a camera that moves while ten objects do."""

from functools import partial

import numpy as np

from worlds.following import follow
from worlds.motions import in_a_box
from worlds.world import Figure
from worlds.world import judge
from worlds.world import observe
from worlds.world import places
from worlds.world import play
from worlds.world import RATE
from worlds.world import SIZE

PAN, JITTER = 20.0, 20.0
"""Of the picture [px/frame]; the width of the square in which it jumps about [px]."""

ROOM = (400.0, 300.0)
"""Where the objects are, so that they stay in the picture [px]."""


def still(rng, frames):
    """Turn [rad], zoom and shift (K, 2) [px] of the picture."""
    return np.zeros(frames), np.ones(frames), np.zeros((frames, 2))


def pan(rng, frames):
    """Half a second to the right, half at rest, half to the left, half at rest, and again."""
    step = PAN * np.array([1, 0, -1, 0])[np.arange(frames) // (RATE // 2) % 4]
    shift = np.stack([np.cumsum(step), np.zeros(frames)], -1)
    return np.zeros(frames), np.ones(frames), shift


def jitter(rng, frames):
    return np.zeros(frames), np.ones(frames), rng.uniform(-0.5, 0.5, (frames, 2)) * JITTER


def roll(rng, frames):
    """To and fro by 20 degrees and 20 % in a second."""
    phase = np.sin(2 * np.pi * np.arange(frames) / RATE)
    return np.radians(20) * phase, 1 + 0.2 * phase, np.zeros((frames, 2))


def through(path, moves):
    """What the camera makes of a path."""
    turn, zoom, shift = moves
    c, s = zoom * np.cos(turn), zoom * np.sin(turn)
    A = np.stack([np.stack([c, -s], -1), np.stack([s, c], -1)], -2)
    middle = np.array(SIZE) / 2
    position = np.einsum('kij,knj->kni', A, path[0] - middle) + middle + shift[:, None]
    return position, np.gradient(position, 1 / RATE, axis=0)


def moving(seed, rivals, moves, count=10, frames=300, stated=(np.nan, np.nan)):
    """Ten objects; beside the best peer, the same tracker without the camera's motion."""
    rng = np.random.default_rng(seed)
    path = in_a_box(rng, count, frames, (20.0, 80.0), ROOM)
    turned = through(path, moves(rng, frames))
    worlds = [observe(way, np.random.default_rng(seed), given=1.0) for way in (turned, path)]
    sequence, calm = (world.sequence() for world in worlds)
    theirs = [judge(sequence, rival(sequence)) for rival in rivals]
    theirs.append(judge(calm, places(play(calm.detections))))
    best = max(theirs, key=lambda score: score.idf1)
    for what, options in (('default', {}), ('ego_motion', {'ego_motion': 'detections'})):
        frames = play(sequence.detections, **options)
        ours = judge(sequence, places(frames))
        yield Figure(f'{what}: IDF1 %', 100 * ours.idf1, stated[0], 100 * best.idf1, low=94.0)
        yield Figure(f'{what}: switches', ours.switches, stated[1], best.switches, high=0.0)
        followed = follow(worlds[0], frames)
        yield Figure(f'{what}: RMSE px', followed.take(followed.unseen == 0).rmse(0))


WORLDS = {
    '10 camera pans': partial(moving, moves=pan, stated=(63.0, 25.0)),
    '10 camera jitters': partial(moving, moves=jitter, stated=(61.0, 103.0)),
    '10 camera rolls and zooms': partial(moving, moves=roll),
    '10 camera pans, one object': partial(moving, moves=pan, count=1),
    '10 camera stands': partial(moving, moves=still),
}
