"""The parameters of the window tracker node."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from colortrack_ros.node_kit.image_tracker import IMAGE_TRACKER
from colortrack_ros.node_kit.image_tracker import ImageTrackerSetup
from colortrack_ros.node_kit.live_parameters import own_values
from colortrack_ros.node_kit.topics import topic
from colortrack_ros.parameters import build as build_config
from colortrack_ros.parameters import ParameterTable
from colortrack_ros.parameters import Spec
from colortrack_ros.parameters.config import specs_of
from colortrack_ros.windows import WindowConfig

TABLE = ParameterTable(
    [
        Spec(
            'targets',
            (float,),
            'Boxes in the first picture, u, v of the top left pixel, width, height, of one target '
            'after the other; set later, they start in the next picture.',
            unit='px',
            minimum=-1e5,
            maximum=1e5,
        ),
        *specs_of(WindowConfig),
        topic('detections_topic', '', 'detections that start targets; empty: none'),
        *IMAGE_TRACKER,
    ]
)


@dataclass(frozen=True)
class WindowTrackerSetup(ImageTrackerSetup):
    """What every image tracker has, and:

    :param targets: (u, v, w, h) of each [px].
    """

    targets: tuple[tuple[float, ...], ...]
    detections_topic: str


def build(values: Mapping[str, Any]) -> WindowTrackerSetup:
    """The setup of a window tracker.

    :raises ValueError: the values do not fit together; the reason names the parameter.
    """
    numbers = list(values.get('targets', ()))
    boxes = tuple(tuple(numbers[i : i + 4]) for i in range(0, len(numbers), 4))
    if any(len(box) != 4 or min(box[2:]) < 1 for box in boxes):
        raise ValueError(
            f'targets: expected u, v, width, height of each box, at least 1 px, got {numbers}'
        )
    own = own_values(WindowTrackerSetup, values) | {'targets': boxes}
    return WindowTrackerSetup(build_config(WindowConfig, values), **own)
