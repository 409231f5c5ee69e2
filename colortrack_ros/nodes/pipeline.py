"""Camera, detector and tracker in one process: frames are passed on in memory."""

from collections.abc import Callable
from collections.abc import Sequence

from rclpy.node import Node

from colortrack_ros.chain import ColorChain
from colortrack_ros.node_kit.runtime import run
from colortrack_ros.nodes.camera import CameraNode
from colortrack_ros.nodes.camera_setup import CameraSetup
from colortrack_ros.nodes.detector import DetectorNode
from colortrack_ros.nodes.detector import DetectorSetup
from colortrack_ros.nodes.tracker import TrackerNode
from colortrack_ros.nodes.tracker import TrackerSetup

UNUSED = (
    'image_transport is compressed, which has no effect in the pipeline: frames pass in memory. '
    'Leave it out, or start the three nodes apart.'
)


def _nodes(stop: Callable[[int], None]) -> Sequence[Node]:
    tracker = TrackerNode(subscribe=False, beside=(CameraSetup, DetectorSetup))
    detector = DetectorNode(subscribe=False, beside=(CameraSetup, TrackerSetup))
    if detector.get_parameter('image_transport').value != 'raw':
        detector.get_logger().warning(UNUSED)
    chain = ColorChain(detector.stage, tracker.intake)
    return tracker, detector, CameraNode(chain, stop, beside=(DetectorSetup, TrackerSetup))


def main() -> int:
    """Run the three nodes."""
    return run(_nodes)
