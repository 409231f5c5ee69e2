"""The node that turns detections into tracks."""

import threading
from typing import Any

from rclpy.node import Node
from sensor_msgs.msg import PointCloud2
from std_srvs.srv import Trigger

from colortrack_ros.data import Detections
from colortrack_ros.flow.order import IDLE
from colortrack_ros.flow.order import Order
from colortrack_ros.messages import detections_of_serialized_cloud
from colortrack_ros.messages import MessageError
from colortrack_ros.node_kit.clocks import lacks_clock
from colortrack_ros.node_kit.clocks import seconds_of
from colortrack_ros.node_kit.clocks import STEADY
from colortrack_ros.node_kit.diagnostics import Health
from colortrack_ros.node_kit.live_parameters import declare
from colortrack_ros.node_kit.runtime import run
from colortrack_ros.node_kit.topics import subscribe_to
from colortrack_ros.node_kit.tracks_output import TracksOutput
from colortrack_ros.nodes.tracker_parameters import build
from colortrack_ros.nodes.tracker_parameters import TABLE
from colortrack_ros.nodes.tracker_parameters import TrackerSetup
from colortrack_ros.tracking import Tracker


class TrackerNode(Node):
    """Detections in, one message of tracks and one of markers for each out.

    :param subscribe: whether detections come from ``detections_topic``, or by :meth:`process`
        alone.
    """

    def __init__(self, *, subscribe: bool = True, **options: Any) -> None:
        super().__init__('tracker', allow_undeclared_parameters=True, **options)
        self._lock = threading.Lock()  # in a pipeline, frames come from the camera's thread
        self._setup: TrackerSetup = declare(self, TABLE, build, self._apply)
        self._tracker = Tracker(self._setup.config)
        self._dropped = 0
        self.health = Health(self, tracks=lambda: self._output.alive)
        self._order: Order[Detections] = Order(self.process, self.health.refuse, seconds_of(self))
        self._apply(self._setup)
        self._output = TracksOutput(self, self._setup)
        self.create_service(Trigger, '~/reset', self._reset)
        if subscribe:
            subscribe_to(self, PointCloud2, self._setup.detections_topic, self._receive)
            self.create_timer(IDLE, self._look, clock=STEADY)

    def process(self, detections: Detections) -> None:
        """Track and publish."""
        self.health.took_in()
        with self._lock:
            tracks = self._tracker.update(detections)
            dropped = self._tracker.dropped
        if dropped > self._dropped:
            self.health.refuse(
                f'{dropped - self._dropped} of {len(detections.rows)} detections: expected '
                'positions within 1e6 px, and a covariance that is positive definite or all zero'
            )
            self._dropped = dropped
        self._output.publish(tracks, self._setup.marker_scale)
        self.health.gave_out(tracks.stamp)

    def _receive(self, cdr: bytes) -> None:
        try:
            detections = detections_of_serialized_cloud(cdr)
            self._order.push(detections.stamp, detections)
        except MessageError as error:
            self.health.refuse(str(error))

    def _look(self) -> None:
        self._order.look(lambda: lacks_clock(self))

    def _reset(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        with self._lock:
            self._tracker.reset('a call of ~/reset')
        response.success = True
        response.message = 'all tracks are dropped with the next frame'
        return response

    def _apply(self, setup: TrackerSetup) -> None:
        with self._lock:
            if setup.config != self._setup.config:
                self._tracker.configure(setup.config)
        self._setup = setup
        self._order.window, self._order.max_late = setup.reorder_window, setup.max_late


def main() -> int:
    """Run the node."""
    return run(lambda _: [TrackerNode()])
