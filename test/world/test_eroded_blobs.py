"""The sizes of blobs that the detector gives are those of what the camera shows."""

import functools

import numpy as np
import pytest

from colortrack_ros.data import Frame
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection import ReferenceColor
from colortrack_ros.simulation import Simulation
from colortrack_ros.simulation import SimulationConfig
from colortrack_ros.simulation import Thing
from colortrack_ros.simulation import ThingConfig
from colortrack_ros.world import LocatorConfig
from colortrack_ros.world.matching import seen_sizes
from colortrack_ros.world.measurement import BLOB
from colortrack_ros.world.measurement import expected

RGB = (205.0, 58.0, 34.0)


@functools.cache
def pictures(away, diameter):
    """Return the frames of a ball, and the simulation."""
    ball = Thing('ball', ThingConfig(rgb=RGB, diameter=diameter, path=(away, 0.1)))
    simulation, frames = Simulation(SimulationConfig(room='empty', objects=(ball,))), []
    for _ in range(12):
        simulation.advance(33_000_000)
        frames.append(Frame(simulation.look().image, 'bgr8', simulation.time, 'camera'))
    return frames, simulation


@pytest.mark.slow
@pytest.mark.parametrize(('away', 'diameter'), [(1.7, 0.12), (2.3, 0.3), (3.6, 0.2), (4.4, 0.16)])
@pytest.mark.parametrize('erosion', [1, 3, 5])
def test_a_ball_is_seen_as_large_as_it_is_whatever_the_detector_takes_off(away, diameter, erosion):
    """Within a pixel: a blob has edges on both sides."""
    frames, simulation = pictures(away, diameter)
    color = ReferenceColor.from_rgb('ball', RGB, 0.0)
    detector = Detector(DetectorConfig(colors=(color,), min_area=20, erosion_size=erosion))
    rows = [detector.detect(frame) for frame in frames][-1].rows
    state = np.zeros((1, 16))
    state[0, :3] = away, 0.1, diameter / 2
    z, _ = expected(simulation.view, state, np.array([diameter]), np.zeros(1))
    config = LocatorConfig(eroded=4 / np.pi * (erosion - 1))
    assert seen_sizes(rows, config) == pytest.approx([z[0, BLOB]], abs=1.0)
