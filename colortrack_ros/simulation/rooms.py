"""Rooms: their size, their pillars, and their initial things."""

from dataclasses import dataclass

from colortrack_ros.simulation.config import Thing
from colortrack_ros.simulation.config import ThingConfig

RED, BLUE = (205.0, 58.0, 34.0), (38.0, 84.0, 176.0)
YELLOW, GREEN = (224.0, 178.0, 30.0), (44.0, 150.0, 62.0)
STONE = (150.0, 146.0, 140.0)
"""Chosen to be at least 60 CIELAB units apart from each other and from the pillars."""


@dataclass(frozen=True)
class Room:
    """A room from -x to x and from -y to y.

    :param half_size: x, y [m].
    :param height: of its walls [m].
    :param things: reported in the truth.
    :param pillars: hide things, and are not in the truth.
    """

    half_size: tuple[float, float]
    height: float
    things: tuple[Thing, ...]
    pillars: tuple[Thing, ...]


def _pillar(x: float, y: float) -> Thing:
    config = ThingConfig(shape='cylinder', rgb=STONE, diameter=0.35, height=1.6, path=(x, y))
    return Thing('pillar', config)


BALLS = (
    Thing(
        'ball',
        ThingConfig(rgb=RED, path=(1.2, 0.0, 3.0, 0.0, 3.0, 2.4, -1.5, 2.4, -1.5, -0.2), speed=0.4),
    ),
    Thing('standing', ThingConfig(rgb=BLUE, diameter=0.24, path=(4.2, -1.2))),
    Thing(
        'post',
        ThingConfig(shape='cylinder', rgb=YELLOW, diameter=0.2, height=0.5, path=(1.6, -2.4)),
    ),
    Thing(
        'bouncing',
        ThingConfig(rgb=GREEN, path=(4.4, 0.6, 4.4, 2.6), speed=0.3, bounce_height=0.8),
    ),
)

ROOMS = {
    'balls': Room(
        (6.0, 4.5), 2.4, BALLS, (_pillar(2.2, 0.9), _pillar(0.4, 1.3), _pillar(3.6, -0.7))
    ),
    'empty': Room((6.0, 4.5), 2.4, (), ()),
}
"""Rooms by the value of the parameter ``room``."""
