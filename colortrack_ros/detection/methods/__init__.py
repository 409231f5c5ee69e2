"""The detection methods by name, one file each."""

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
"""To add a method, write a file with a subclass of Method, and add a line here. Its own
parameters, if any, go into a Config next to the class, which becomes a base of DetectorConfig."""
