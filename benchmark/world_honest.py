"""How often a whole locator tells of a robot that is set up rightly that it is not.

python benchmark/world_honest.py [--runs N] [--seed N] prints for other cameras and places, and for
odometry that is poor and told to be (5 % of the way and of turns, 5 Hz, stamps off by 10 ms), the
runs that are. In each a robot drives and swings for 12 s before balls that roll slowly or fast, or
are said to stand, by the ground or by their size, with errors of the camera as expected.
"""

import argparse
from dataclasses import dataclass
from dataclasses import replace

import numpy as np
from world_right import KINDS
from world_right import swinging
from world_scene import as_seen
from world_scene import config_of
from world_scene import ELSEWHERE
from world_scene import HERE
from world_scene import measure
from world_scene import move
from world_scene import Scene
from world_scene import SPEED
from world_scene import truths
from world_scene import WANDER

from colortrack_ros.world import Locator
from colortrack_ros.world.camera import CameraModel
from colortrack_ros.world.poses import Pose
from colortrack_ros.world.state import CameraErrors
from colortrack_ros.world.state import Kinds
from colortrack_ros.world.view import View

SMALL = CameraModel.of(320, 240, (260, 0, 160, 0, 260, 120, 0, 0, 1))
SCENES = {
    **ELSEWHERE,
    'here': HERE,
    'upside down': Scene(mount=Pose.of_rpy((0.1, 0, 0.5), (np.pi, 0.25, 0))),
    '320x240': Scene(SMALL),
}
MOVING = 'roll slowly', 'roll fast', 'stand'


def by_speed(bases, way):
    """Poses whose ways and turns are multiplied."""
    yaws = np.array([np.arctan2(base.R[1, 0], base.R[0, 0]) for base in bases])
    steps = np.diff([base.t[:2] for base in bases], axis=0, prepend=[bases[0].t[:2]])
    turned = (way - 1) * yaws
    cos, sin = np.cos(turned), np.sin(turned)
    steps = way * np.stack(
        [cos * steps[:, 0] - sin * steps[:, 1], sin * steps[:, 0] + cos * steps[:, 1]], axis=1
    )
    places = np.cumsum(steps, axis=0)
    return [Pose.of_rpy((*p, 0), (0, 0, way * yaw)) for p, yaw in zip(places, yaws, strict=True)]


def at_times(bases, known, at):
    """Poses at some times, interpolated between those that are known, at others."""
    x, y, yaw = np.array([(*b.t[:2], np.arctan2(b.R[1, 0], b.R[0, 0])) for b in bases]).T
    columns = x[known], y[known], np.unwrap(yaw)[known]
    each = zip(*(np.interp(at, known, one) for one in columns), strict=True)
    return [Pose.of_rpy((px, py, 0), (0, 0, angle)) for px, py, angle in each]


def slow(bases, rate):
    """Known five times a second, and interpolated."""
    pictures = np.arange(len(bases))
    return at_times(
        bases, np.unique(np.append(pictures[:: round(rate / 5)], pictures[-1])), pictures
    )


def shaken(bases, rate, rng):
    """With stamps that are off by 10 ms."""
    pictures = np.arange(len(bases))
    return at_times(bases, pictures, pictures + 0.01 * rate * rng.normal(size=len(bases)))


ODOMETRY = {
    'right': lambda bases, rate, rng: bases,
    'drifts by 5 %': lambda bases, rate, rng: by_speed(bases, 1 + 0.05 * rng.choice([-1, 1])),
    '5 Hz': lambda bases, rate, rng: slow(bases, rate),
    'stamps off by 10 ms': shaken,
}
TOLD = {'drifts by 5 %': (0.05, 0.05), '5 Hz': (0.02, 0.02), 'stamps off by 10 ms': (0.02, 0.02)}


@dataclass
class Run:
    """A run of a seed, and what is told in it; empty: nothing."""

    scene: Scene
    odometry: str
    seed: int

    def told(self):
        """What is told."""
        rng, scene = np.random.default_rng(self.seed), self.scene
        kind, method = MOVING[self.seed % 3], ('ground', 'size')[self.seed % 2]
        count, speed, WANDER['rolls'] = KINDS[kind]
        SPEED['rolls'], motion = (speed, speed, 0), 'stands' if kind == 'stand' else 'rolls'
        config = config_of(method, motion)
        sigma = TOLD.get(self.odometry, config.odometry_sigma)
        config = replace(config, odometry_sigma=sigma)
        kinds, errors = Kinds.of(config).take(np.zeros(count, int)), CameraErrors.of(config)
        truth = truths(scene, motion, 1, count, kinds, errors, rng)
        truth[:, 3:5] = speed * rng.normal(size=(count, 2))
        lines, bases = [], list(swinging(rng, scene))
        locator = Locator(config, lines.append)
        poses = ODOMETRY[self.odometry](bases, scene.rate, rng)
        for k, (base, pose) in enumerate(zip(bases, poses, strict=True)):
            if k:
                move(truth, scene.dt, motion, rng)
            there = View(scene.camera, base, scene.mount)
            measured, seen = measure(there, truth, kinds, 'fused', motion, rng)
            view = View(scene.camera, pose, scene.mount)
            locator.update(
                *as_seen(measured.z, seen, config, round((k + 1) * 1e9 * scene.dt)), view
            )
            if locator.doubt:
                return f'{kind}, {method}: {[*lines, locator.doubt][-1]}'
        return ''


def main():
    parser = argparse.ArgumentParser('world_honest', description=__doc__)
    parser.add_argument('--runs', type=int, default=12)
    parser.add_argument('--seed', type=int, default=0)
    a = parser.parse_args()
    cases = [(name, 'right') for name in SCENES] + [('here', odometry) for odometry in TOLD]
    for name, odometry in cases:
        lines = [Run(SCENES[name], odometry, a.seed + k).told() for k in range(a.runs)]
        lines = [line for line in lines if line]
        print(f'{name}, odometry {odometry}: {len(lines)} of {a.runs}', *lines, sep='\n  ')


if __name__ == '__main__':
    main()
