"""Issue points 2, 3, 4: what is published while nothing is measured, and at any rate."""

from functools import partial

import numpy as np

from worlds import motions
from worlds.following import follow
from worlds.following import known
from worlds.textbook import matched
from worlds.world import Figure
from worlds.world import message
from worlds.world import observe
from worlds.world import play
from worlds.world import RATE
from worlds.world import tracker

HIDDEN, EVERY = 16, 60
"""Each object is unseen for so many frames on end, once in so many."""

STATED = {'weaving': 68.0, 'bouncing': 32.0, 'stop_and_go': 67.0, 'turning': 86.0}


def in_turns(frames, count):
    """(K, N) who is seen: after two seconds each is hidden again and again, in turns."""
    k = np.arange(frames)[:, None] - 2 * RATE - np.arange(count) * (EVERY // count)
    return (k < 0) | (k % EVERY >= HIDDEN)


def hide(path, rng):
    return observe(path, rng, seen=in_turns(*path[0].shape[:2]))


def is_coasting(followed):
    return (followed.unseen >= 6) & (followed.unseen <= 15)


def coasting(seed, rivals, motion):
    """Eight objects of one kind, 6 to 15 frames after the last detection.

    The textbook is matched to what drifts.
    """
    rng = np.random.default_rng(seed)
    world = hide(getattr(motions, motion)(rng, 8, 300), rng)
    followed = follow(world, play(world.detections))
    held = followed.take(is_coasting(followed))
    book = known(world, *matched(world, 1.0, motions.DRIFT))
    book = book.take(is_coasting(book))
    most = 99.0 if motion != 'straight' else np.inf  # no noise at all: a right filter holds 99.8 %
    yield Figure('in 95 %', held.inside(0), STATED.get(motion, np.nan), book.inside(0), 88, most)
    limit = 3.0 if motion in ('straight', 'drifting') else np.inf
    yield Figure('area / matched filter', held.area() / book.area(), rival=1.0, high=limit)


def seen(seed, rivals, motion):
    """Mean squared normalized error of what is measured in every frame: 4 states have 4."""
    rng = np.random.default_rng(seed)
    world = observe(getattr(motions, motion)(rng, 8, 300), rng)
    followed = follow(world, play(world.detections))
    late = followed.take(followed.frame >= RATE)
    yield Figure('NEES', late.nees(), rival=4.0, low=2.0, high=5.0)
    yield Figure('in 95 % of velocity', late.inside(2), low=90.0)


def mixed(seed, rivals):
    """Eight that stand and four that bounce, in one picture."""
    rng = np.random.default_rng(seed)
    world = hide(motions.join(motions.standing(rng, 8, 300), motions.bouncing(rng, 4, 300)), rng)
    followed = follow(world, play(world.detections))
    seen = followed.take((followed.unseen == 0) & (followed.frame >= RATE))
    coasts = followed.take(is_coasting(followed))
    for kind, first, last, velocity, position in (
        ('standing', 0, 8, np.nan, np.nan), ('bouncing', 8, 12, 80.0, 17.0),
    ):  # fmt: skip
        now = [f.take((f.object >= first) & (f.object < last)) for f in (seen, coasts)]
        yield Figure(f'{kind}: velocity in 95 %', now[0].inside(2), velocity, low=90.0)
        yield Figure(f'{kind}: coasting in 95 %', now[1].inside(0), position, low=88.0)


def sigma_after(seed, measured, empties):
    """Sigma of a straight track after 3 s of detections and 1 s without [px].

    :param measured: rate of the detections [Hz].
    :param empties: how many empty messages there are in that second.
    """
    rng, ours = np.random.default_rng(seed), tracker()
    for k in range(3 * measured + 1):
        z = np.array([[100 + 150 * k / measured, 300.0]]) + rng.normal(0, 1, (1, 2))
        ours.update(message(z, k, rate=measured))
    none = np.zeros((0, 2))
    for k in range(1, empties + 1):
        tracks = ours.update(message(none, 3 * empties + k, rate=empties))
    return float(np.sqrt(tracks.rows['covariance'][0, 0, 0])) if len(tracks.rows) else np.nan


def time(seed, rivals):
    """One second of coasting, told in 1, 30 or 200 messages; the same within 5 %."""
    usual = sigma_after(seed, 30, 30)
    yield Figure('30 empty messages: sigma px', usual, 35.0)
    for what, rates, stated in (
        ('no message', (30, 1), 151.0),
        ('200 empty messages', (30, 200), np.nan),
        ('200 Hz before and after', (200, 200), 14.0),
        ('15 Hz before and after', (15, 15), np.nan),
    ):
        now = sigma_after(seed, *rates)
        yield Figure(f'{what}: sigma px', now, stated)
        yield Figure(f'{what}: / 30 messages', now / usual, stated / 35, 1.0, 0.95, 1.05)


MEASURED = (
    'straight',
    'drifting',
    'weaving',
    'bouncing',
    'stop_and_go',
    'turning',
    'turning_anytime',
)

WORLDS = (
    {f'2 measured, {motion}': partial(seen, motion=motion) for motion in MEASURED}
    | {
        f'2 coasting, {motion}': partial(coasting, motion=motion)
        for motion in ('weaving', 'bouncing', 'stop_and_go', 'turning', 'drifting', 'straight')
    }
    | {'3 time': time, '4 mixed crowd': mixed}
)
