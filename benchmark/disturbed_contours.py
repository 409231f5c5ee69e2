"""Contours when the camera is bumped, covered, or shows another scene.

python benchmark/disturbed_contours.py CLIP OTHER prints a table; clips are videos or folders as
real_contours.py has them. CLIP is disturbed after ``--after`` seconds, and what is told in the 12 s
from then on is compared with the truth, which moves with the picture. OTHER is the clip that a cut
goes to, with its own truth, and ``--only`` names disturbances. ``--constants scene_change.ALIKE
...`` compares constants of the room with half and twice their values.
"""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from contours import ways_of
import cv2
import motmetrics
import numpy as np
from real_contours import Clip
from real_contours import compare
from real_contours import FIGURES
from real_contours import IOU
from real_contours import ours

JUDGED = 12.0
"""Time from the disturbance on that is judged [s]."""

Disturbance = Callable[[np.ndarray, float], tuple[np.ndarray, np.ndarray | None]]
"""Picture and time since the disturbance began [s] to the picture, and the affine map (2, 3) of the
truth; None where nothing is to be seen."""

Way = tuple[Clip | None, Disturbance]
"""The clip that a cut goes to, if any, and what else happens."""

STILL = np.eye(2, 3)


class Seen(NamedTuple):
    """Of one run: summary of motmetrics, and time without a target found [s]."""

    row: dict
    blind: float


def moved(image: np.ndarray, way: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The picture after a camera was moved; what comes in is what was near the border."""
    size = image.shape[1::-1]
    return cv2.warpAffine(image, way, size, borderMode=cv2.BORDER_REFLECT), way


def bump(*shift: float) -> Disturbance:
    way = np.column_stack([np.eye(2), shift])
    return lambda image, _: moved(image, way)


def turn(degrees: float) -> Disturbance:
    def disturb(image: np.ndarray, _: float) -> tuple[np.ndarray, np.ndarray]:
        center = image.shape[1] / 2, image.shape[0] / 2
        return moved(image, cv2.getRotationMatrix2D(center, degrees, 1.0))

    return disturb


def light(near: float, far: float, seconds: float = 0.0) -> Disturbance:
    """Gains at the left and at the right, reached after so many seconds."""

    def disturb(image: np.ndarray, t: float) -> tuple[np.ndarray, np.ndarray]:
        gain = np.linspace(near, far, image.shape[1])[:, None]
        gain = 1 + (gain - 1) * min(t / seconds if seconds else 1.0, 1.0)
        return np.clip(image * gain, 0, 255).astype(np.uint8), STILL

    return disturb


def black(seconds: float) -> Disturbance:
    return lambda image, t: (image, STILL) if t >= seconds else (np.zeros_like(image), None)


def thing(shape: tuple[int, ...], seed: int) -> np.ndarray:
    """The surface of a thing, with folds or windows."""
    coarse = np.random.default_rng(seed).integers(60, 200, (9, 12, 3)).astype(np.uint8)
    return cv2.resize(coarse, shape[1::-1], interpolation=cv2.INTER_CUBIC)


def hand(seconds: float) -> Disturbance:
    """Most of the picture is covered by what trembles by a pixel or two."""

    def disturb(image: np.ndarray, t: float) -> tuple[np.ndarray, np.ndarray | None]:
        if t >= seconds:
            return image, STILL
        shift = np.rint(2 * np.sin([9 * t, 7 * t])).astype(int)
        return np.roll(thing(image.shape, 1), shift, (0, 1)), None

    return disturb


def bus(stops: float) -> Disturbance:
    """Seven tenths of the picture wide, it crosses in 3 s, and stops in the middle."""

    def disturb(image: np.ndarray, t: float) -> tuple[np.ndarray, np.ndarray | None]:
        width, t = image.shape[1], t if t < 1.5 else max(1.5, t - stops)
        if t >= 3:
            return image, STILL
        left = round((1.7 * t / 3 - 0.7) * width)
        side = thing((image.shape[0], round(0.7 * width), 3), 2)
        image, low, high = image.copy(), max(left, 0), min(left + side.shape[1], width)
        top = image.shape[0] // 8
        image[top:, low:high] = side[top:, low - left : high - left]
        return image, None

    return disturb


def pan(pixels: float) -> Disturbance:
    """A camera that looks around by so many px/s, up to 60 px to each side."""
    return lambda image, t: moved(
        image, np.column_stack([np.eye(2), [60 * np.sin(t * pixels / 60), 0.0]])
    )


def shake(pixels: float) -> Disturbance:
    """A camera that trembles all the time."""
    rng = np.random.default_rng(0)
    return lambda image, _: moved(
        image, np.column_stack([np.eye(2), rng.uniform(-pixels, pixels, 2)])
    )


DISTURBANCES: dict[str, Disturbance] = {
    'none': bump(0, 0), 'bump 5 px': bump(4, 3), 'bump 30 px': bump(30, 0),
    'bump 100 px': bump(-80, 60), 'turn 3 degrees': turn(3.0), 'half the light': light(0.5, 0.5),
    'a lamp at the side': light(0.5, 1.5), 'auto exposure': light(1.6, 1.6, 2.0),
    'hand, 1 s': hand(1.0), 'hand, 3 s': hand(3.0), 'black, 1 s': black(1.0),
    'black, 3 s': black(3.0), 'bus': bus(0.0), 'bus, stops 4 s': bus(4.0), 'pan': pan(40.0),
    'shake 1 px': shake(1.0), 'shake 4 px': shake(4.0),
}  # fmt: skip


def mapped(truth: np.ndarray, way: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """Truth of a picture that was moved; what is outside is not visible."""
    truth = truth.copy()
    truth[:, 1:3] = truth[:, 1:3] @ way[:, :2].T + way[:, 2]
    inside = (truth[:, 1:3] >= 0) & (truth[:, 1:3] < np.array(shape[1::-1]))
    truth[~inside.all(axis=1), 5] = 0.0
    return truth


def frames(clip: Clip, other: Clip | None, after: float, disturb: Disturbance):
    """Pictures, and their truth from the disturbance on, None where it is not judged."""
    rate, first, size = clip.rate(), round(after * clip.rate()), None
    truth = clip.truth()
    for k, image in enumerate(clip.pictures()):
        size, t = image.shape, (k - first) / rate
        if k < first:
            yield image, None
            continue
        if other is not None or t >= JUDGED:
            break
        image, way = disturb(image, t)
        own = truth.get(k)
        yield image, None if way is None or own is None else mapped(own, way, size)
    if other is None:
        return
    truth, ratio = other.truth(), other.rate() / rate
    for k, image in enumerate(other.pictures()):
        if k / other.rate() >= JUDGED:
            return
        if round(round(k / ratio) * ratio) != k:
            continue  # it is shown at the rate of the first
        scale = np.diag([size[1] / image.shape[1], size[0] / image.shape[0]])
        own = truth.get(k)
        if own is not None:
            own = mapped(own, np.column_stack([scale, [0, 0]]), size)
            own[:, 3:5] *= scale.diagonal()
        yield cv2.resize(image, size[1::-1]), own


def run(clip: Clip, other: Clip | None, after: float, disturb: Disturbance) -> Seen:
    book, step, found = motmetrics.MOTAccumulator(auto_id=True), ours(clip.rate()), []
    for k, (image, truth) in enumerate(frames(clip, other, after, disturb)):
        boxes = step(image, k)
        if truth is not None:
            found.append(compare(book, truth, boxes, IOU))
    names = (*FIGURES, 'num_false_positives')
    row = motmetrics.metrics.create().compute(book, metrics=names).iloc[0]
    return Seen(row, float(np.argmax([*found, True])) / clip.rate())


def table(clip: Clip, ways: dict[str, Way], after: float) -> None:
    """Print the figures of each way to disturb a clip."""
    print(f'| {clip.name} | IDF1 | MOTA | precision | recall | false | blind [s] |')
    print('|---|---|---|---|---|---|---|')
    for name, (other, disturb) in ways.items():
        row, blind = run(clip, other, after, disturb)
        cells = ' | '.join(f'{row[n]:.2f}' for n in FIGURES[:-1])
        print(f'| {name} | {cells} | {row["num_false_positives"]:.0f} | {blind:.1f} |', flush=True)


def constants(names: list[str], clip: Clip, ways: dict[str, Way], after: float) -> None:
    """Print MOTA with half and twice the value of constants."""
    print(f'| {clip.name} | ' + ' | '.join(ways) + ' |\n|---|' + '---|' * len(ways))
    for label in ways_of(names):
        rows = [run(clip, other, after, disturb)[0] for other, disturb in ways.values()]
        print(f'| {label} | ' + ' | '.join(f'{r["mota"]:.2f}' for r in rows) + ' |', flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('clip', type=Path)
    parser.add_argument('other', type=Path)
    parser.add_argument('--after', type=float, default=5.0)
    parser.add_argument('--only', nargs='+', metavar='NAME', choices=[*DISTURBANCES, 'cut'])
    parser.add_argument('--constants', nargs='+', metavar='FILE.NAME')
    given = parser.parse_args()
    cv2.setNumThreads(1)
    ways: dict[str, Way] = {name: (None, disturb) for name, disturb in DISTURBANCES.items()}
    ways['cut'] = Clip(given.other), DISTURBANCES['none']
    ways = {name: ways[name] for name in given.only or ways}
    if given.constants:
        constants(given.constants, Clip(given.clip), ways, given.after)
    else:
        table(Clip(given.clip), ways, given.after)


if __name__ == '__main__':
    main()
