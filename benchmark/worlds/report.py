"""The list of worlds, their figures over several seeds, and how they are written."""

from dataclasses import replace
import math

import numpy as np

from worlds import camera
from worlds import coasting
from worlds import covers
from worlds import ghosts
from worlds import hard
from worlds import identities
from worlds import noise
from worlds import own
from worlds import speed
from worlds import strange
from worlds import strangers
from worlds import variants

ROOMS = (
    noise, coasting, covers, ghosts, identities, camera, hard, speed, variants, strange,
    strangers, own,
)  # fmt: skip
WORLDS = dict(
    sorted(
        ((name, world) for room in ROOMS for name, world in room.WORLDS.items()),
        key=lambda item: int(item[0].split()[0]),
    )
)
"""Functions of (seed, rivals) that give figures, by the point of the issue and a name."""


def choose(names):
    """The worlds that any of the names means: a point's number, or a part of the name.

    :raises ValueError: for a name that means none.
    """
    if not names:
        return list(WORLDS)
    found = []
    for name in names:
        if name.isdigit():
            some = [world for world in WORLDS if world.split()[0] == name]
        else:
            some = [world for world in WORLDS if name in world]
        if not some:
            raise ValueError(f'unknown world {name!r}: there are {"; ".join(WORLDS)}')
        found += some
    return list(dict.fromkeys(found))


def mean(values):
    known = [value for value in values if not math.isnan(value)]
    return float(np.mean(known)) if known else math.nan


def measure(world, seeds, rivals):
    """The figures of a world, means over the seeds."""
    runs = [list(world(seed, rivals)) for seed in seeds]
    return [
        replace(
            some[0],
            **{
                key: mean([getattr(f, key) for f in some])
                for key in ('now', 'rival', 'low', 'high')
            },
        )
        for some in zip(*runs, strict=True)
    ]


def number(value):
    if math.isnan(value):
        return ''
    return f'{value:.0f}' if abs(value) >= 1000 else f'{value:.3g}'


def text(line):
    """Before, now, rival, what is to be reached, and whether it is."""
    low, high = (number(edge) if math.isfinite(edge) else '' for edge in (line.low, line.high))
    goal = f'{low} to {high}' if low and high else f'>= {low}' if low else f'<= {high}' * bool(high)
    reached = 'yes' if line.low - 1e-9 <= line.now <= line.high + 1e-9 else 'no'
    return [*map(number, (line.before, line.now, line.rival)), goal, reached if goal else '']
