"""Issue points 2 and 8, with boxes: discs behind a cover that cuts and hides them."""

from functools import partial

import numpy as np

from colortrack_ros.data import DETECTION
from colortrack_ros.data import Detections
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.ellipses import ELLIPSE_95
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig
from worlds.identities import ends
from worlds.identities import own
from worlds.motions import lanes
from worlds.motions import times
from worlds.world import Figure
from worlds.world import play
from worlds.world import RATE
from worlds.world import SIZE
from worlds.world import World

MIDDLE = SIZE[0] / 2
"""Of the cover [px]."""

LEAST_AREA = 20
"""Of a blob [px]."""

RATIOS = np.array([0.33, 0.5, 0.67, 1.5])
"""Of the sizes of two that meet."""

PASSES = 20
"""Discs for each seed, one after the other."""

HIGHER, DARKER = 1.15, 0.88
"""How much larger a disc looks with something of its color behind it, and smaller in a shade."""

GRID = (np.arange(160) + 0.5) / 80 - 1
"""Where a disc is looked at, in radii."""


def blobs(center, radius, cover, noise, rng):
    """Rows of the visible parts of a disc, in boxes of whole pixels."""
    u, v = center[0] + radius * GRID, center[1] + radius * GRID
    disc = np.hypot(GRID, GRID[:, None]) <= 1
    rows = []
    for part in (disc & (u <= cover[0]), disc & (u >= cover[1])):
        area = part.sum() * (2 * radius / len(GRID)) ** 2
        if area < LEAST_AREA:
            continue
        down, across = np.nonzero(part)
        row = np.zeros(1, DETECTION)
        row['u'], row['v'] = np.array([u[across].mean(), v[down].mean()]) + rng.normal(0, noise, 2)
        row['cov_uu'] = row['cov_vv'] = noise**2
        row['area'], row['score'] = area, 1.0
        row['box_u'], row['box_v'] = np.rint([u[across].min(), v[down].min()])
        row['box_w'] = np.rint(u[across].max()) - row['box_u'] + 1
        row['box_h'] = np.rint(v[down].max()) - row['box_v'] + 1
        rows.append(row)
    return np.concatenate(rows) if rows else np.zeros(0, DETECTION)


def passage(rng, kind):
    """Radius, cover, and for each frame the center and the radius that the disc seems to have."""
    radius = rng.uniform(8, 55)
    way = rng.choice([-1, 1])
    u_step = way * rng.uniform(3, 14 if radius < 20 else 22)
    half = rng.uniform(0.6, 4) * radius
    faster = rng.normal(0, 0.025) if kind != 'steady' else 0.0
    before, v_step = int(rng.uniform(15, 40)), rng.normal(0, 0.5)
    u, v = MIDDLE - way * (abs(u_step) * before + radius + half), rng.uniform(150, 550)
    path, turned = [], False
    for k in range(140):
        looks = radius
        if kind == 'larger' and before - 12 < k < before - 3:
            looks = HIGHER * radius
        if kind == 'smaller' and k >= before - 3:
            looks = DARKER * radius
        if kind == 'back' and not turned and abs(u - MIDDLE) < half and rng.random() < 0.3:
            u_step, turned = -u_step, True
        path.append((u, v, looks))
        u, v, u_step = u + u_step, v + v_step, u_step + way * faster
        if not radius < u < SIZE[0] - radius:
            break
    return radius, (MIDDLE - half, MIDDLE + half), np.array(path)


def behind_covers(seed, _, kind):
    """While a part of the disc is visible, and while none is."""
    rng = np.random.default_rng(seed)
    squares, errors, ids = {True: [], False: []}, [], []
    for _ in range(PASSES):
        radius, cover, path = passage(rng, kind)
        tracker, met = Tracker(TrackerConfig(image_size=SIZE)), set()
        noise = max(0.15, 0.006 * radius)
        for k, (u, v, looks) in enumerate(path):
            found = blobs((u, v), looks, cover, noise, rng)
            rows = tracker.update(Detections(found, round(k * NANOSECONDS / RATE))).rows
            rows = rows[rows['state'] > 0]
            met |= set(rows['track_id'].tolist())
            if len(rows) and cover[0] < u + radius and u - radius < cover[1]:
                away = np.array([rows['u'] - u, rows['v'] - v]).T
                n = int(np.hypot(*away.T).argmin())
                P = rows['covariance'][n][:2, :2]
                squares[len(found) > 0].append(away[n] @ np.linalg.solve(P, away[n]))
                if len(found):
                    errors.append(np.hypot(*away[n]) / radius)
        ids.append(len(met) <= 1)
    for seen, name in ((True, 'cut'), (False, 'hidden')):
        held = 100 * np.mean(np.array(squares[seen]) < ELLIPSE_95)
        yield Figure(f'{name}: in 95 %', held, low=88.0)
    yield Figure('cut: error, % of the radius', 100 * np.sqrt(np.mean(np.square(errors))))
    yield Figure('one ID %', 100 * np.mean(ids), low=95.0)


def meeting(seed, _, frames=120):
    """Pairs of discs in four lanes that bounce off each other behind a post that cuts them."""
    rng, count = np.random.default_rng(seed), 4
    t = times(frames) - frames / 2 / RATE
    radius = rng.uniform(14, 24, count)
    radius = np.concatenate([radius, radius * rng.choice(RATIOS, count)])
    speed, half = rng.uniform(110, 250, 2 * count), rng.uniform(30, 55)
    side = np.repeat([-1, 1], count)
    u = MIDDLE + side * (radius + speed * np.abs(t))
    position = np.stack([u, np.tile(lanes(count), 2) + 0 * u], -1)
    seen = np.abs(u - MIDDLE) > half + radius
    cover = MIDDLE - half, MIDDLE + half
    messages = [
        Detections(
            np.concatenate(
                [blobs(z, r, cover, 0.5, rng) for z, r in zip(now, radius, strict=True)]
            ),
            round(k * NANOSECONDS / RATE),
        )
        for k, now in enumerate(position)
    ]
    z = np.where(seen[..., None], position, np.nan)
    world = World(
        position, np.gradient(position, 1 / RATE, axis=0), np.ones_like(seen), z, messages
    )
    start, end = ends(world, play(messages, image_size=SIZE))
    swapped = (start[:count] == end[count:]) | (start[count:] == end[:count])
    yield Figure('swapped %', 100 * swapped.mean(), high=5.0)
    yield Figure('own ID %', own((start, end), count), low=95.0)


WORLDS = {'8 behind a post that cuts': meeting} | {
    f'2 behind covers, {kind}': partial(behind_covers, kind=kind)
    for kind in ('steady', 'faster', 'larger', 'smaller', 'back')
}
