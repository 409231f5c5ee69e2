"""Colors taught by clicks: the samples of each, and the color that they give."""

from dataclasses import dataclass

from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection.pick import pick_color
from colortrack_ros.detection.pick import PickedColor
from colortrack_ros.detection.teach import Example
from colortrack_ros.detection.teach import teach_color

MOST_SAMPLES = 64
"""How many clicks are kept for one color, each with its picture. Assumed: that many pictures of
1920x1080 take 0.4 GB."""


@dataclass(frozen=True)
class Sample:
    """A click, or a box that was drawn.

    :param color: name of the color.
    :param example: its place and picture.
    :param is_it: whether it has the color, or is something else.
    """

    color: str
    example: Example
    is_it: bool


def taught(samples: tuple[Sample, ...], name: str, config: DetectorConfig) -> PickedColor:
    """The color that the samples of a name give.

    :raises ValueError: no sample has the color, one is outside its picture, or the color does not
        end anywhere.
    """
    mine = [sample.example for sample in samples if sample.color == name and sample.is_it]
    others = [sample.example for sample in samples if sample.color == name and not sample.is_it]
    if not mine:
        raise ValueError(f'{name}: click on it first, then on what it is not')
    if len(mine) + len(others) > MOST_SAMPLES:
        raise ValueError(f'{name}: expected at most {MOST_SAMPLES} samples; undo some')
    if len(mine) == 1 and mine[0].is_pixel and not others:
        u, v = mine[0].box[:2]
        # The page shows one picture, and sliders for what is found in it.
        return pick_color(mine[0].frame, u, v, name, config, fixed=True)
    return teach_color(mine, others, name, config)
