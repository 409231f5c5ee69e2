"""The ways to tell objects from the rest, one file each, by name."""

from collections.abc import Callable
from typing import Any

from colortrack_ros.detection.background_model import BackgroundModel
from colortrack_ros.detection.methods.background import BackgroundSubtraction
from colortrack_ros.detection.methods.base import Method
from colortrack_ros.detection.methods.channel_difference import ChannelDifference
from colortrack_ros.detection.methods.color import ColorDistance

METHODS: dict[str, Callable[[Any, BackgroundModel], Method]] = {
    'color': ColorDistance,
    'channel_difference': ChannelDifference,
    'background': BackgroundSubtraction,
}
"""Add one: a file with a class that is a Method, and a line here. Its parameters, if it has any of
its own, are a Config beside the class, and a base class of DetectorConfig."""
