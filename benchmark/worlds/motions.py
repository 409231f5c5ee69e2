"""Ways to move, each a function of (rng, count, frames) -> position, velocity, (K, N, 2).

Positions in px, velocities in px/s, 30 frames/s. Where nothing else is said objects keep to lanes
of their own, so that who is who is never the question.
"""

import numpy as np

from worlds.world import RATE
from worlds.world import SIZE

GRAVITY = 1500.0
"""Of what falls, as in pictures of juggling [px/s^2]."""


DRIFT = 4.0**2
"""Density of the acceleration of what only drifts [px^2/s^3]."""


def times(frames):
    return np.arange(frames)[:, None] / RATE


def lanes(count):
    """Heights, a lane for each [px]."""
    return (np.arange(count) + 0.5) * SIZE[1] / count


def straight(rng, count, frames, speed=(40.0, 200.0)):
    """Straight on, a little slanted."""
    t = times(frames)
    du = rng.uniform(*speed, count) * rng.choice([-1, 1], count)
    dv = rng.uniform(-20, 20, count) * RATE / frames
    middle = t[len(t) // 2]
    u, v = SIZE[0] / 2 + du * (t - middle), lanes(count) + dv * (t - middle)
    return np.stack([u, v], -1), np.stack(np.broadcast_arrays(du, dv * np.ones_like(u)), -1) * 1.0


def drifting(rng, count, frames):
    """Straight on, but for a white-noise acceleration of density DRIFT."""
    position, velocity = straight(rng, count, frames)
    push = np.cumsum(rng.normal(0, (DRIFT / RATE) ** 0.5, velocity.shape), axis=0)
    return stepped(position[0], velocity + push)


def standing(rng, count, frames):
    """At rest, on a line at the top."""
    place = np.stack([np.linspace(80, SIZE[0] - 80, count), np.full(count, 60.0)], -1)
    position = np.broadcast_to(place + rng.normal(0, 5, (count, 2)), (frames, count, 2))
    return position.copy(), np.zeros_like(position)


def weaving(rng, count, frames, amplitude=25.0, period=1.0):
    """Forward, swaying to and fro across the way."""
    position, velocity = straight(rng, count, frames)
    w = 2 * np.pi / period
    phase = w * times(frames) + rng.uniform(0, 2 * np.pi, count)
    position[..., 1] += amplitude * np.sin(phase)
    velocity[..., 1] += amplitude * w * np.cos(phase)
    return position, velocity


def bouncing(rng, count, frames):
    """Ballistic, thrown up again wherever it meets the floor, in columns."""
    speed = rng.uniform(600, 1000, count)
    s = (times(frames) + rng.uniform(0, 1, count)) % (2 * speed / GRAVITY)
    u = (np.arange(count) + 0.5) * SIZE[0] / count + np.zeros_like(s)
    v = SIZE[1] - 40 - speed * s + GRAVITY / 2 * s**2
    dv = -speed + GRAVITY * s
    return np.stack([u, v], -1), np.stack([np.zeros_like(s), dv], -1)


def stepped(start, velocity):
    """Positions of velocities that change from frame to frame."""
    way = np.cumsum(velocity[:-1], axis=0) / RATE
    return start + np.concatenate([np.zeros_like(start)[None], way]), velocity


def stop_and_go(rng, count, frames):
    """At 150 px/s to and fro, at rest in between, each for half a second to one and a half."""
    velocity = np.zeros((frames, count, 2))
    for n in range(count):
        k, sign, goes = 0, rng.choice([-1, 1]), rng.random() < 0.5
        while k < frames:
            last = k + rng.integers(RATE // 2, 3 * RATE // 2)
            velocity[k:last, n, 0] = goes * sign * 150.0
            k, sign, goes = last, (-sign if goes else sign), not goes
    return stepped(np.stack([np.full(count, SIZE[0] / 2), lanes(count)], -1), velocity)


def turning(rng, count, frames, speed=150.0, rate=0.7, steps=1):
    """Abrupt turns to the left or right by 30 to 120 degrees, ``rate`` a second.

    :param steps: times in a frame at which they may come; 1: all turn just as the picture is taken.
    """
    shape = (frames * steps, count)
    turn = rng.choice([-1, 1], shape) * np.radians(rng.uniform(30, 120, shape))
    turn *= rng.random(shape) < rate / RATE / steps
    angle = rng.uniform(0, 2 * np.pi, count) + np.cumsum(turn, axis=0)
    start = rng.uniform((200, 150), (SIZE[0] - 200, SIZE[1] - 150), (count, 2))
    velocity = speed * np.stack([np.cos(angle), np.sin(angle)], -1)
    way = np.cumsum(velocity[:-1], axis=0) / RATE / steps
    position = start + np.concatenate([np.zeros((1, count, 2)), way])
    return position[::steps], velocity[::steps]


def turning_anytime(rng, count, frames):
    """Turns that come between the pictures."""
    return turning(rng, count, frames, steps=20)


def in_a_box(rng, count, frames, speed=(100.0, 300.0), size=SIZE):
    """Straight on until the border of a room, and back from there; the ways cross."""
    angle = rng.uniform(0, 2 * np.pi, count)
    velocity = rng.uniform(*speed, count)[:, None] * np.stack([np.cos(angle), np.sin(angle)], -1)
    size = np.array(size, float)
    way = rng.uniform(0, size, (count, 2)) + times(frames)[..., None] * velocity
    back = (way // size) % 2 != 0
    return np.where(back, size - way % size, way % size), np.where(back, -velocity, velocity)


def join(one, other):
    """Both crowds in one picture."""
    return tuple(np.concatenate(pair, axis=1) for pair in zip(one, other, strict=True))
