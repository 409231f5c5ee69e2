"""Drawn targets that come near or go away: ``python benchmark/windows_growing.py``.

Squares and discs with details of all sizes, and discs of one color, grow or shrink by half to four
percent a frame, for 100 frames or while they are 12 to 335 px wide, and wander before a wall like
them (640x480, noise of 2 levels). Prints the share of the frames in which the box overlaps the
truth by more than half of their union, and the mean overlap.
"""

import argparse
from collections.abc import Iterator

import cv2
import numpy as np
from real_windows import ours
from real_windows import overlap
from real_windows import RATE
from real_windows import SUCCESS

RATES = (0.005, 0.01, 0.02, 0.03, 0.04)
KINDS = ('square', 'disc', 'plain disc')
WIDTH, HEIGHT, LOOK, FRAMES, FINER = 640, 480, 512, 100, 2
LEAST, MOST, NEAR, FAR = 12.0, 335.0, 40.0, 300.0
NOISE, PACE = 2.0, 0.7


def fractal(rng: np.random.Generator, width: int, height: int) -> np.ndarray:
    """Colors with details of all sizes, (height, width, 3), of mean 0 and standard deviation 1."""
    total = np.zeros((height, width, 3))
    for k in range(1, 9):
        noise = 0.8 * rng.normal(size=(2**k, 2**k, 1)) + 0.6 * rng.normal(size=(2**k, 2**k, 3))
        total += cv2.resize(noise, (width, height), interpolation=cv2.INTER_CUBIC) * 2 ** (-k / 2)
    return total / total.std()


def first_side(growth: float) -> float:
    """The side [px] from which a target stays as long as it can between the least and the most."""
    total = growth ** (FRAMES - 1)
    return (
        max(min(NEAR, FAR / total), LEAST + 2) if growth > 1 else min(max(FAR, LEAST / total), MOST)
    )


def frames_of(kind: str, growth: float, seed: int) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Pictures and boxes of a target."""
    rng = np.random.default_rng([seed, KINDS.index(kind), round(1000 * growth)])
    wall = np.clip(110 + 40 * fractal(rng, WIDTH, HEIGHT), 0, 255)
    look = np.clip(130 + 50 * fractal(rng, LOOK, LOOK), 0, 255)
    if kind == 'plain disc':
        look[:] = rng.uniform(0, 255, 3)
    v, u = np.mgrid[:LOOK, :LOOK] - (LOOK - 1) / 2
    inside = (kind == 'square') | (np.hypot(u, v) < LOOK / 2)
    look = np.dstack([look, inside]).astype(np.float32)
    center, side = np.array([WIDTH, HEIGHT]) / 2, first_side(growth)
    pace = rng.normal(0, PACE, 2)
    for _ in range(FRAMES):
        center, side = center + pace, side * growth
        if not LEAST <= side <= MOST:
            return
        count = LOOK // max(int(LOOK / side / FINER), 1)
        small = cv2.resize(look, (count, count), interpolation=cv2.INTER_AREA)
        step, corner = FINER * side / count, FINER * (center - side / 2 + 0.5)
        matrix = np.array([[step, 0, corner[0]], [0, step, corner[1]]])
        large = cv2.warpAffine(small, matrix, (FINER * WIDTH, FINER * HEIGHT))
        large = cv2.resize(large, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA)
        share = large[..., 3:]
        picture = wall * (1 - share) + large[..., :3] * share
        picture += rng.normal(0, NOISE, (HEIGHT, WIDTH, 1))
        box = np.array([*(center - side / 2 + 0.5), side, side])
        yield np.clip(picture, 0, 255).astype(np.uint8), box


def judged(kind: str, growth: float, seed: int) -> np.ndarray:
    """Overlap of each frame but the first."""
    step, overlaps = None, []
    for k, (picture, box) in enumerate(frames_of(kind, growth, seed)):
        if step is None:
            step = ours()(picture, box)
            continue
        answer = step(picture, round(k / RATE * 1e9))
        overlaps.append(overlap(answer[0], box) if answer else 0.0)
    return np.array(overlaps)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--seed', type=int, default=0)
    given = parser.parse_args()
    cv2.setNumThreads(1)
    print('| a frame | ' + ' | '.join(KINDS) + ' |')
    print('|---|---|---|---|')
    for growth in [*(1 + np.array(RATES)), *(1 - np.array(RATES))]:
        found = [judged(kind, growth, given.seed) for kind in KINDS]
        cells = [f'{100 * np.mean(x > SUCCESS):.0f} %, {np.mean(x):.2f}' for x in found]
        print(f'| {100 * (growth - 1):+.1f} % | ' + ' | '.join(cells) + ' |', flush=True)


if __name__ == '__main__':
    main()
