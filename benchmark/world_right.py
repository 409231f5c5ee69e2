"""How often a robot that is set up rightly is told that it is not.

python benchmark/world_right.py [--runs N] [--seed N] prints the runs that are. Each is 12 s of a
robot that drives and swings, each as fast as the seed says, with errors of the camera's place as
expected. What it sees are three balls that roll slowly, two that roll fast, three that stand before
a camera that is off by half as much again, three that roll in about the same direction, or three
of which one stands; none is said to stand.
"""

import argparse

import numpy as np
from world_scene import config_of
from world_scene import HERE
from world_scene import measure
from world_scene import move
from world_scene import truths
from world_scene import WANDER

from colortrack_ros.world.mistakes import Mistakes
from colortrack_ros.world.poses import Pose
from colortrack_ros.world.state import CameraErrors
from colortrack_ros.world.state import Kinds
from colortrack_ros.world.view import View

SECONDS = 12.0
KINDS = {
    'roll slowly': (3, 0.15, 0.1), 'roll fast': (2, 0.5, 0.1), 'stand': (3, 0.0, 0.0),
    'roll alike': (3, 0.4, 0.1), 'one stands': (3, 0.3, 0.0),
}  # fmt: skip
"""How many balls, their speed on each axis (sigma), and by what it changes within 1 s [m/s]."""


def swinging(rng, scene=HERE):
    """Where the robot is in each picture."""
    x = y = yaw = 0.0
    period, turn, speed = rng.uniform(2, 5), rng.uniform(0.3, 1.05), rng.uniform(0.1, 0.6)
    for k in range(round(SECONDS * scene.rate)):
        yield Pose.of_rpy((x, y, 0), (0, 0, yaw))
        yaw += scene.dt * turn * np.sin(2 * np.pi * k * scene.dt / period)
        x, y = x + speed * scene.dt * np.cos(yaw), y + speed * scene.dt * np.sin(yaw)


def told(seed):
    """What is rolling in the run of a seed, by which method, and what is told; none: nothing."""
    rng, name = np.random.default_rng(seed), list(KINDS)[seed % len(KINDS)]
    (count, speed, WANDER['rolls']), method = KINDS[name], ('ground', 'ground', 'size')[seed % 3]
    config = config_of(method, 'rolls')
    kinds, errors = Kinds.of(config).take(np.zeros(count, int)), CameraErrors.of(config)
    truth = truths(HERE, 'rolls', 1, count, kinds, errors, rng)
    truth[:, 3:5] = speed * rng.normal(size=(count, 2))
    if name == 'stand':
        truth[:, 8:] *= 1.5
    if name == 'roll alike':
        truth[:, 3:5] = speed * rng.normal(size=2) + 0.05 * rng.normal(size=(count, 2))
    if name == 'one stands':
        truth[0, 3:5] = 0.0
    mistakes = Mistakes(config.camera_pose_sigma)
    for k, base in enumerate(swinging(rng)):
        if k:
            move(truth, HERE.dt, 'rolls', rng)
        view = View(HERE.camera, base, HERE.mount)
        measured, _ = measure(view, truth, kinds, method, 'rolls', rng)
        ids = np.arange(1, count + 1, dtype=np.uint32)
        mistakes.see(round((k + 1) * 1e9 * HERE.dt), view, ids, measured, kinds, 0.0)
        if mistakes.made:
            break
    return name, method, mistakes.made


def main():
    parser = argparse.ArgumentParser('world_right', description=__doc__)
    parser.add_argument('--runs', type=int, default=120)
    parser.add_argument('--seed', type=int, default=500)
    a = parser.parse_args()
    count = 0
    for seed in range(a.seed, a.seed + a.runs):
        name, method, line = told(seed)
        if line:
            print(f'{seed}: {name}, {method}: {line}')
            count += 1
    print(f'{count} of {a.runs} are told to be wrong')


if __name__ == '__main__':
    main()
