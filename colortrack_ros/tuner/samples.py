"""Colors taught by clicks: what was shown of each, and what follows from it."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection.pick import pick_color
from colortrack_ros.detection.pick import PickedColor
from colortrack_ros.detection.teach import Example
from colortrack_ros.detection.teach import teach_color
from colortrack_ros.tools.color_params import color_values

MOST_SAMPLES = 64
"""Clicks for one color that are remembered, each with its picture. Assumed: as many pictures of
1920x1080 are 0.4 GB."""


@dataclass(frozen=True)
class Sample:
    """A click, or a box that was drawn.

    :param color: name of the color.
    :param example: where, in which picture.
    :param is_it: whether that has the color, or is something else.
    """

    color: str
    example: Example
    is_it: bool


def taught(samples: tuple[Sample, ...], name: str, config: DetectorConfig) -> PickedColor:
    """The color that the samples of a name show.

    :raises ValueError: none of them says what it is, one is not inside of its picture, or the color
        does not end anywhere.
    """
    mine = [sample.example for sample in samples if sample.color == name and sample.is_it]
    others = [sample.example for sample in samples if sample.color == name and not sample.is_it]
    if not mine:
        raise ValueError(f'{name}: click on it first, then on what it is not')
    if len(mine) + len(others) > MOST_SAMPLES:
        raise ValueError(f'{name}: expected at most {MOST_SAMPLES} samples; undo some')
    if len(mine) == 1 and mine[0].is_pixel and not others:
        u, v = mine[0].box[:2]
        return pick_color(mine[0].frame, u, v, name, config)
    return teach_color(mine, others, name, config)


def values_of(given: Mapping[str, Any], picked: PickedColor) -> dict[str, Any]:
    """What a picked color changes in the detector's values, None for what goes."""
    return color_values(dict(given), picked.color, picked.limits)
