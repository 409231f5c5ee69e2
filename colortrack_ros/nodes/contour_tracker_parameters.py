"""The parameters of the contour tracker node."""

from collections.abc import Mapping
from typing import Any

from colortrack_ros.contours import ContourConfig
from colortrack_ros.node_kit.image_tracker import IMAGE_TRACKER
from colortrack_ros.node_kit.image_tracker import ImageTrackerSetup
from colortrack_ros.node_kit.live_parameters import own_values
from colortrack_ros.parameters import build as build_config
from colortrack_ros.parameters import ParameterTable
from colortrack_ros.parameters.config import specs_of

TABLE = ParameterTable([*specs_of(ContourConfig), *IMAGE_TRACKER])


def build(values: Mapping[str, Any]) -> ImageTrackerSetup:
    """The setup of a contour tracker.

    :raises ValueError: the values do not fit together; the reason names the parameter.
    """
    config = build_config(ContourConfig, values)
    return ImageTrackerSetup(config, **own_values(ImageTrackerSetup, values))
