"""Camera, detector and tracker in one process: a frame passes from one to the next in memory."""

from collections.abc import Callable
from collections.abc import Sequence

from rclpy.node import Node

from colortrack_ros.node_kit.runtime import run
from colortrack_ros.nodes.camera import CameraNode
from colortrack_ros.nodes.detector import DetectorNode
from colortrack_ros.nodes.tracker import TrackerNode


def _nodes(stop: Callable[[], None]) -> Sequence[Node]:
    tracker = TrackerNode(subscribe=False)
    detector = DetectorNode(tracker.process, subscribe=False)
    return CameraNode(detector.process, stop), detector, tracker


def main() -> int:
    """Run the three nodes."""
    return run(_nodes)
