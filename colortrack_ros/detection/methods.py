"""The ways to tell objects from the rest, by name."""

from collections.abc import Callable
from typing import TYPE_CHECKING

from colortrack_ros.detection.background import Background
from colortrack_ros.detection.background_model import BackgroundModel
from colortrack_ros.detection.channel_difference import ChannelDifference
from colortrack_ros.detection.color import Color
from colortrack_ros.detection.method import Method

if TYPE_CHECKING:
    from colortrack_ros.detection.config import DetectorConfig

METHODS: dict[str, Callable[['DetectorConfig', BackgroundModel], Method]] = {
    'color': Color,
    'channel_difference': ChannelDifference,
    'background': Background,
}
"""Add one: a file with a class that is a Method, and a line here."""
