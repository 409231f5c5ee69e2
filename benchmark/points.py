"""Scenes of points, made by hand: truth and detections, frame by frame."""

from dataclasses import dataclass
import os
from pathlib import Path

import numpy as np

from colortrack_ros.data import Detections
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.scenes import detections_of as detections_of_scene
from colortrack_ros.scenes import open_scene

ROOT = Path(__file__).parents[1]
DATA = Path(os.environ.get('COLORTRACK_DATA', ROOT.parent / 'shared' / 'data'))
JUGGLING = DATA / 'juggling_centroids'
RATE = 30
WIDTH, HEIGHT = 1920.0, 1080.0
SEEN = 0.25
"""An object of which no such part is visible is hidden."""


@dataclass(frozen=True)
class Sequence:
    """What a tracker is given and what it should find.

    truth: for each frame rows of (object, u, v); hidden: for each frame how many more there are
    that cannot be seen; detections: of the same frames; size: of the picture [px]; step: the
    largest way of an object from frame to frame [px]; max_distance: of a track from its object
    [px].
    """

    truth: list[np.ndarray]
    hidden: list[int]
    detections: list[Detections]
    size: tuple[int, int]
    step: float
    max_distance: float


def detections_of(z, k, rate=RATE, noise=1.0):
    """Detections without boxes at z, (M, 2), in frame k."""
    return Detections.from_points(z, k * NANOSECONDS // rate, sigma=noise)


def _velocities(rng, count, speed):
    angle, length = rng.uniform(0, 2 * np.pi, count), rng.uniform(*speed, count)
    return np.stack([np.cos(angle), np.sin(angle)], axis=1) * length[:, None]


def cruise(
    count, frames=300, speed=(1.0, 5.0), detected=0.95, clutter=0.05, noise=1.0, turns=0.0,
    blackout=0.0, picture=(WIDTH, HEIGHT), seed=0,
):  # fmt: skip
    """Points that go straight on and, when they leave the picture, are followed by new ones.

    :param picture: width and height [px].
    :param count: objects; above 1,000 the picture grows with them, so that the density stays.
    :param speed: least and greatest [px/frame].
    :param detected: probability.
    :param clutter: false detections, a share of count.
    :param noise: standard deviation of a detection on each axis [px].
    :param turns: probability of an abrupt turn, for each object and frame.
    :param blackout: probability that an object vanishes for 10 frames, for each object and frame.
    """
    rng = np.random.default_rng(seed)
    grown = np.sqrt(max(count / 1000, 1.0))
    size = np.array(picture) * grown
    position, velocity = rng.uniform(0, size, (count, 2)), _velocities(rng, count, speed)
    names, next_name = np.arange(count), count
    dark = np.zeros(count, int)
    truth, detections = [], []
    for k in range(frames):
        turn = rng.random(count) < turns
        velocity[turn] = _velocities(rng, turn.sum(), speed)
        position += velocity
        out = ((position < 0) | (position >= size)).any(axis=1)
        position %= size
        names[out] = next_name + np.arange(out.sum())
        next_name += out.sum()
        dark = np.where(rng.random(count) < blackout, 10, dark - 1)
        seen = (rng.random(count) < detected) & (dark <= 0)
        real = position[seen] + rng.normal(0, noise, (seen.sum(), 2))
        false = rng.uniform(0, size, (rng.poisson(clutter * count), 2))
        truth.append(np.column_stack([names, position]))
        detections.append(detections_of(rng.permutation(np.concatenate([real, false])), k))
    picture = (int(size[0]), int(size[1]))
    return Sequence(truth, [0] * frames, detections, picture, speed[1], 10.0)


def labels(path, drop=0.0, seed=0):
    """The labelled positions of a csv file (frame, id, u, v) as detections.

    :param drop: share of them that is left out.
    """
    rng = np.random.default_rng(seed)
    table = np.loadtxt(path, delimiter=',', skiprows=1)
    truth, detections = [], []
    for k in range(int(table[0, 0]), int(table[-1, 0]) + 1):
        rows = table[table[:, 0] == k, 1:]
        truth.append(rows)
        seen = rng.permutation(rows[rng.random(len(rows)) >= drop, 1:])
        detections.append(detections_of(seen, k, noise=2.0))
    width, height = table[:, 2:].max(axis=0) + 1
    return Sequence(truth, [0] * len(truth), detections, (int(width), int(height)), 60.0, 30.0)


def of_scene(name, **worse):
    """A scene as a perfect detector sees it.

    :param worse: arguments of detections_of.
    """
    scene = open_scene(name)
    truth, hidden, step, last = [], [], 0.0, {}
    for k in range(len(scene)):
        rows = scene.truth(k)
        seen = rows[rows['visible'] >= SEEN]
        truth.append(np.column_stack([seen['id'], seen['u'], seen['v']]))
        hidden.append(len(rows) - len(seen))
        here = {int(row['id']): np.array([row['u'], row['v']]) for row in rows}
        ways = [np.hypot(*(here[i] - last[i])) for i in here.keys() & last.keys()]
        step, last = max([step, *ways]), here
    found = [detections_of_scene(scene, k, **worse) for k in range(len(scene))]
    return Sequence(truth, hidden, found, (scene.width, scene.height), step, 20.0)
