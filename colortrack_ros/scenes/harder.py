"""Scenes on which trackers fail: merging, crowds, gravity, turns, gaps and broken blobs.

Points of a path are (x, y, radius): x in widths and y and radius in heights of the picture.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.scenes.curves import arcs
from colortrack_ros.scenes.curves import Curve
from colortrack_ros.scenes.curves import polyline
from colortrack_ros.scenes.curves import spline
from colortrack_ros.scenes.options import Options
from colortrack_ros.scenes.pegoretti import BAR_COLOR
from colortrack_ros.scenes.pegoretti import COLORS
from colortrack_ros.scenes.pegoretti import in_pixels
from colortrack_ros.scenes.pegoretti import RADIUS
from colortrack_ros.scenes.pegoretti import scene_of
from colortrack_ros.scenes.pegoretti import wall
from colortrack_ros.scenes.scene import Scene
from colortrack_ros.scenes.shapes import Ball
from colortrack_ros.scenes.shapes import Cover
from colortrack_ros.scenes.shapes import draw_ball
from colortrack_ros.scenes.shapes import draw_rectangle
from colortrack_ros.scenes.shapes import Prop
from colortrack_ros.scenes.texture import Color
from colortrack_ros.scenes.texture import plaster
from colortrack_ros.scenes.texture import uniform

SKIN: Color = (205, 160, 132)
SHIRT: Color = (62, 74, 96)
POLE: Color = (70, 72, 78)
"""Colors of a hand, a sleeve and a post; chosen."""

TOUCH = 10 / 24
"""How long two objects of `collision` touch [s]. Chosen: ten frames at 24 Hz."""


def through(
    options: Options, times: Sequence[float], points: Sequence[tuple[float, float]], radius: float
) -> Curve:
    """Return the path of a ball of fixed radius along straight lines between the points (x, y)."""
    return polyline(times, in_pixels(options, [(x, y, radius) for x, y in points]))


def collision(options: Options) -> Scene:
    """Return eight objects of one color that meet in pairs, each pair touching for 10 frames.

    Two meet head-on, rest against each other and bounce back (top). Two pass each other, one half
    covering the other (bottom). Two cross, and later two come side by side and bounce apart
    (middle): while they touch, both look the same.
    """
    wide = RADIUS * options.height / options.width  # a radius in widths of the picture
    rest = 0.5 - 0.97 * wide
    bounce = [(-0.05, 0.2), (rest, 0.2), (rest, 0.2), (-0.05, 0.2)]
    bounce_times = [0.5, 4.5, 4.5 + TOUCH, 8.5 + TOUCH]
    # Discs of radius r whose paths are 1.6 r apart touch over 2.4 r of the way.
    speed = 1.2 * wide / TOUCH
    wait = 0.55 / speed
    passing = [(0.5 - 0.55, 0.75 - 0.8 * RADIUS), (0.5 + 0.55, 0.75 - 0.8 * RADIUS)]
    fall = 1.2 * RADIUS / TOUCH
    crossing = [(-0.05, 0.45 - fall), (0.40, 0.45 - fall), (0.54, 0.45 + fall), (1.05, 0.45 + fall)]
    crossing_times = [1.0, 4.0, 6.0, 9.4]
    side = 0.45 - 0.97 * RADIUS
    beside = [(-0.05, 0.1), (0.45, side), (0.5, side), (1.05, 0.1)]
    beside_times = [9.4, 13.4, 13.4 + TOUCH, 17.4 + TOUCH]
    paths = [
        through(options, bounce_times, bounce, RADIUS),
        through(options, bounce_times, [(1 - x, y) for x, y in bounce], RADIUS),
        through(options, [8 - wait, 8 + wait], passing, RADIUS),
        through(options, [8 - wait, 8 + wait], [(1 - x, 1.5 - y) for x, y in passing], RADIUS),
        through(options, crossing_times, crossing, RADIUS),
        through(options, crossing_times, [(x - 1.6 * wide, 0.9 - y) for x, y in crossing], RADIUS),
        through(options, beside_times, beside, RADIUS),
        through(options, beside_times, [(x, 0.9 - y) for x, y in beside], RADIUS),
    ]
    return scene_of('collision', options, paths)


def swarm(options: Options) -> Scene:
    """Return 50 objects of one color that wander and often meet.

    They move 1 to 5 px a frame at 720 lines.
    """
    return scene_of('swarm', options, _wander(options, 50, 0.014, (1.0, 5.0)))


def blackout(options: Options) -> Scene:
    """Return 20 small objects that wander, 4 to 12 px a frame at 720 lines.

    The scene provides the motion; `detections_of` with BLACKOUT makes it hard.
    """
    return scene_of('blackout', options, _wander(options, 20, 0.012, (4.0, 12.0)))


def juggle(options: Options) -> Scene:
    """Return five balls in a cascade under gravity, hidden in a hand for 0.4 s after each catch.

    A ball is thrown every 0.28 s, by one hand after the other, flies 1.0 s, is caught on the
    outside, carried inwards and thrown again (Shannon's theorem: (1.0 + 0.4) 2 = 0.28 * 2 * 5).
    """
    beat, hold, flight = 0.28, 0.4, 1.0
    hand_y, top, dip = 0.74, 0.10, 0.05
    gravity = 8 * (hand_y - top) / (flight * flight)
    carry = [0.0, -8 * dip / (hold * hold), 0.0]
    fall = [0.0, gravity, 0.0]
    inside, outside = (0.44, 0.56), (0.32, 0.68)  # x of throw and catch: left, right hand

    def path(throws: range, radius: float, after: list[float]) -> Curve:
        times, points, accelerations = [], [], []
        for n in throws:
            throw = n * beat
            times += [throw - hold, throw]
            points += [(outside[n % 2], hand_y, radius), (inside[n % 2], hand_y, radius)]
            accelerations += [carry, after]
        return _scaled_arcs(options, times, points, accelerations[:-1])

    size, still = np.array([options.width, options.height]), np.zeros(2)
    background = wall(options).copy()
    half = options.height * np.array([0.12, 0.26])
    draw_rectangle(background, size * [0.5, 0.86], still, half, SHIRT[::-1])
    draw_ball(background, size * 0.5, still, 0.085 * options.height, SKIN[::-1])
    balls = [Ball(path(range(i - 10, 90, 5), 0.035, fall), 'red') for i in range(5)]
    paths = [path(range(hand - 10, 90, 2), 0.06, [0.0, 0.0, 0.0]) for hand in (0, 1)]
    hands = [Prop(each, SKIN, round=True) for each in paths]
    return Scene('juggle', options, background, COLORS, [*balls, *hands], exposure=0.25)


def turns(options: Options) -> Scene:
    """Return six objects that turn sharply, five of them while hidden behind two panels.

    Behind a panel an object turns by 90 or 180 degrees and emerges 0.6 to 0.8 s later where
    straight motion would never have taken it. The sixth zigzags in the open.
    """
    a, b, r = (0.3, 0.5), (0.7, 0.5), 0.04
    zigzag = [(-0.03 + 0.15 * i, 0.95 if i % 2 else 0.78) for i in range(8)]
    paths = [
        through(options, [0.5, 2.5, 4.5], [(-0.03, 0.5), a, (0.3, -0.06)], r),
        through(options, [1.5, 3.5, 5.5], [(0.7, -0.06), b, (1.03, 0.5)], r),
        through(options, [4.5, 6.5, 9.0, 11.0], [(0.3, 1.06), a, b, (0.7, 1.06)], r),
        through(options, [8.0, 10.0, 12.0], [(0.3, -0.06), a, (-0.03, 0.5)], r),
        through(options, [10.5, 12.6, 14.7], [(1.03, 0.5), b, (1.03, 0.5)], r),
        through(options, [11.5 + 1.15 * i for i in range(8)], zigzag, r),
    ]
    covers = [
        _cover(options, x - 0.075, 0.5 - 0.15, x + 0.075, 0.5 + 0.15, BAR_COLOR) for x in (0.3, 0.7)
    ]
    return scene_of('turns', options, paths, covers)


def flicker(options: Options) -> Scene:
    """Return five objects, moving left to right, whose brightness flickers and whose blobs break
    up.

    The brightness of each changes by half, several times a second. Behind three thin poles a disc
    is seen as two pieces for about 9 frames.
    """
    lanes = [0.14, 0.32, 0.50, 0.68, 0.86]
    balls = []
    for i, y in enumerate(lanes):
        start = 0.5 + 1.9 * ((3 * i) % 5)
        path = through(options, [start, start + 9.5], [(-0.03, y), (1.03, y)], RADIUS)
        times = np.arange(-0.5, 21.5, 0.15)
        gain = 0.55 + 0.5 * uniform((options.seed, 5, i), len(times), 1)
        balls.append(Ball(path, 'red', polyline(times, gain)))
    covers = [_cover(options, x - 0.003, 0, x + 0.003, 1, POLE) for x in (0.25, 0.5, 0.75)]
    return Scene('flicker', options, wall(options), COLORS, balls, covers)


def vanish(options: Options) -> Scene:
    """Return eleven objects; some disappear for good, others hide and come back.

    A bar hides three for a third of a second; a fourth waits there for 3 s. Three are taken away
    where they rest in the open; two fall into a box; two lamps go out, one of them for 3 s.
    """
    r = 0.035
    passing = [
        through(options, [start, start + 7.0], [(-0.03, y), (1.03, y)], r)
        for start, y in ((0.5, 0.10), (5.0, 0.22), (11.0, 0.10))
    ]
    waiting = [(-0.03, 0.34), (0.45, 0.34), (0.45, 0.34), (1.03, 0.34)]
    taken = [
        _ending(options, [start, start + 2.0, start + 4.01], [(-0.03, y), (x, y), (x, y)], r)
        for start, x, y in ((1.0, 0.15, 0.50), (4.0, 0.30, 0.62), (9.0, 0.20, 0.74))
    ]
    fall = np.array([0.0, 2.0, 2.25, 2.51])
    falling = [
        _ending(options, fall + start, [(1.03, 0.45), (x, 0.50), (x, 0.59), (x, 0.86)], r)
        for start, x in ((3.0, 0.78), (8.0, 0.84))
    ]
    lamps = [
        _ending(options, [-1.0, 6.01], [(0.15, 0.90)] * 2, r),
        _ending(options, [-1.0, 9.01], [(0.35, 0.90)] * 2, r, again=12.0),
    ]
    passing.append(through(options, [3.0, 6.2, 9.2, 13.0], waiting, r))
    covers = [
        _cover(options, 0.40, 0.0, 0.50, 0.42, BAR_COLOR),
        _cover(options, 0.72, 0.76, 0.90, 0.96, POLE),
    ]
    return scene_of('vanish', options, [*passing, *taken, *falling, *lamps], covers)


def _ending(
    options: Options,
    times: Sequence[float] | NDArray[np.float64],
    points: Sequence[tuple[float, float]],
    radius: float,
    again: float = 99.0,
) -> Curve:
    """Return a path like through() whose object vanishes at the end, and may reappear there.

    :param again: when it reappears [s]; by default later than any scene lasts.
    """
    blink, away = 1e-6, (-1.0, -1.0)
    after = [times[-1] + blink, again, again + blink, again + 99.0]
    return through(options, [*times, *after], [*points, away, away, points[-1], points[-1]], radius)


def _scaled_arcs(
    options: Options,
    times: Sequence[float],
    points: Sequence[tuple[float, float, float]],
    accelerations: Sequence[Sequence[float]],
) -> Curve:
    scale = [options.width, options.height, options.height]
    return arcs(times, in_pixels(options, points), np.array(accelerations) * scale)


def _cover(options: Options, x0: float, y0: float, x1: float, y1: float, color: Color) -> Cover:
    left, right = round(x0 * options.width), round(x1 * options.width)
    top, bottom = round(y0 * options.height), round(y1 * options.height)
    picture = plaster((options.seed, 3, left, top), bottom - top, right - left, color, 0.4)
    return Cover(top, left, picture)


def _wander(
    options: Options, count: int, radius: float, speeds: tuple[float, float]
) -> list[Curve]:
    """Return smooth random walks that turn back at the picture's edges.

    :param speeds: least and greatest, in 1/720 of the height per 1/24 s: px a frame at the default
        size and rate.
    """
    pace, seed, aspect = 0.5, options.seed, options.width / options.height
    places = _spread(seed, count, aspect)
    speed = speeds[0] + (speeds[1] - speeds[0]) * uniform((seed, 6), count, 1)
    stride = speed * (24 / 720) * pace
    low, high = 2.0 * radius, np.array([aspect, 1.0]) - 2.0 * radius
    way = _unit(uniform((seed, 7), count, 2) - 0.5)
    times = np.arange(-1.0, options.duration + 2 * pace, pace)
    bends = uniform((seed, 8), len(times), count, 2) - 0.5
    track = []
    for bend in bends:
        track.append(places)
        way = _unit(way + 0.5 * bend)
        step = places + stride * way
        way = np.where((step < low) | (step > high), -way, way)
        places = places + stride * way
    points = np.stack(track, axis=1) / [aspect, 1.0]
    sizes = np.full((*points.shape[:2], 1), radius)
    return [spline(times, in_pixels(options, p)) for p in np.concatenate([points, sizes], axis=2)]


def _spread(seed: int, count: int, aspect: float) -> NDArray[np.float64]:
    """Return (count, 2) separate places, in heights: a jittered grid."""
    columns = int(np.ceil(np.sqrt(count * aspect)))
    rows = -(-count // columns)
    index = np.arange(count)
    cells = np.stack([index % columns, index // columns], axis=1)
    shaken = cells + 0.25 + 0.5 * uniform((seed, 9), count, 2)
    return shaken * [aspect / columns, 1 / rows]


def _unit(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    x, y = vectors[:, :1], vectors[:, 1:]
    return vectors / np.sqrt(x * x + y * y + 1e-12)
