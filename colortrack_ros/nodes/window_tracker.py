"""The window tracker node: tracks targets by their appearance."""

from dataclasses import dataclass
from typing import Any

from sensor_msgs.msg import Image

from colortrack_ros.data import Frame
from colortrack_ros.data import Tracks
from colortrack_ros.flow.pairing import Pair
from colortrack_ros.messages import image_of_frame
from colortrack_ros.node_kit.runtime import run
from colortrack_ros.node_kit.target_tracker import TargetTrackerNode
from colortrack_ros.node_kit.target_tracker import TargetTrackerSetup
from colortrack_ros.node_kit.topics import publish_on
from colortrack_ros.node_kit.topics import topic_name
from colortrack_ros.parameters import part
from colortrack_ros.windows import WindowConfig
from colortrack_ros.windows import WindowTracker
from colortrack_ros.windows.matching import reliability_map


@dataclass(frozen=True)
class WindowTrackerSetup(TargetTrackerSetup):
    """The parameters of the window tracker node."""

    config: WindowConfig = part(WindowConfig)
    reliability_topic: str = topic_name(
        'tracks/reliability', 'where windows are like the templates, for whoever subscribes'
    )


class WindowTrackerNode(TargetTrackerNode[WindowTrackerSetup]):
    """Tracks the windows of targets that a user or node names."""

    tracker: WindowTracker

    def __init__(self, **options: Any) -> None:
        super().__init__('window_tracker', WindowTrackerSetup, **options)

    def configure(self) -> None:
        """Create what every target tracker has, and the publisher of the reliability map."""
        super().configure()
        self._reliability = publish_on(self, Image, self.setup.reliability_topic)

    def make(self, setup: WindowTrackerSetup) -> WindowTracker:
        """Return a window tracker."""
        return WindowTracker(setup.config, setup.targets)

    def _track(self, pair: Pair) -> Tracks:
        tracks = super()._track(pair)
        if self._reliability.get_subscription_count() > 0:
            picture = reliability_map(self.tracker.surfaces, pair.frame.image.shape[:2])
            frame = Frame(picture, 'mono8', tracks.stamp, tracks.frame_id)
            self._reliability.publish(image_of_frame(frame))
        return tracks


def main() -> int:
    """Run the node."""
    return run(lambda _: [WindowTrackerNode()])
